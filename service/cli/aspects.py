"""Find the aspects of a manipulator while the length of one leg varies within a range: the connected sets of
poses without a singularity. Their number is exact."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, counted, rows_of, write_document
from service.schemas.poses import RangeAspectsRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps aspects innocenti --l1-range 27:30
  rpr-cusps aspects robot.json --l2-range 10: --format json     leg 2 varies, without an upper end
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_ranges(parser, "the range of lengths; either end may be omitted (default: all)")
    arguments.add_digits(parser, 15)
    arguments.add_format(parser)
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    leg, ends, option = arguments.leg_and_range(args)
    members = {"fixed_leg": leg, "range": ends, **remote.deadline_of(args)}
    question = arguments.ask(RangeAspectsRequest, args, members, arguments.source({"range": option}))
    found = remote.answer_of(args.url, question)
    write_document(found, _page(found), args.format)
    return 0


def _page(document: Mapping[str, Any]) -> Page:
    leg, ends, found = document["fixed_leg"], document["range"], document["aspects"]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    rows = [
        {
            "sign of J": "+" if aspect["sign"] > 0 else "−",
            f"aspects at {ends['from']}": str(aspect["at_start"]),
            f"aspects at {ends['to'] or '∞'}": str(aspect["at_stop"]),
        }
        for aspect in found
    ]
    title = f"L{leg} from {ends['from']}{below}: {counted(len(found), 'aspect')}"
    return Page(about(document), [Section(title, rows_of(rows))], document["digits"])


COMMANDS = {"aspects": Command(DESCRIPTION, EXAMPLES, configure, run)}
