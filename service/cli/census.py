"""Find every length at which the number of cusps changes, with its kind and poses, and the number of cusps in
between. The list is proved complete."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import rpr_solver
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import (
    Page,
    Section,
    about,
    counted,
    counted_range,
    degenerate_notes,
    rows_of,
    write_document,
)
from service.schemas.censuses import CensusRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps census innocenti --digits 20
  rpr-cusps census innocenti --l1-range 28:31 --format json
  rpr-cusps census robot.json --l2-range :40 --format csv     leg 2 fixed
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_ranges(parser, "the range of lengths; either end may be omitted (default: all)")
    arguments.add_digits(parser, 90)
    arguments.add_format(parser, "csv")
    arguments.add_certificate(parser)
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    leg, ends, option = arguments.leg_and_range(args)
    origin = arguments.source({"range": option})
    members = {
        "fixed_leg": leg,
        "range": ends,
        "certificate": args.certificate,
        **remote.deadline_of(args),
    }
    question = arguments.ask(CensusRequest, args, members, origin)
    document = remote.answer_of(args.url, question, "steps")
    write_document(document, _page(document), args.format, csv=rpr_solver.census_csv)
    return 0


def _page(document: Mapping[str, Any]) -> Page:
    leg = f"l{document['fixed_leg']}"
    intervals, transitions = document["intervals"], document["transitions"]
    ends = document["range"]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    counts = [interval["count"] for interval in intervals]
    cusps = counted_range(min(counts), max(counts), "cusp")
    title = f"{leg.upper()} from {ends['from']}{below}: {cusps}, {counted(len(transitions), 'transition')}"
    rows = [["from", "to", "cusps", "aspects"]]
    rows += ([i["from"], i["to"] or "∞", str(i["count"]), str(i.get("aspects") or "")] for i in intervals)
    events = [
        {leg: t[leg], "cusps": f"{t['count_before']} → {t['count_after']}", **event}
        for t in transitions
        for event in t["events"]
    ]
    sections = [Section(title, rows, degenerate_notes(document))]
    if events:
        keys = [leg, "cusps", *(key for key in events[0] if key not in (leg, "cusps"))]
        sections.append(Section("Transitions", rows_of(events, keys)))
    return Page(about(document), sections, document["digits"])


COMMANDS = {"census": Command(DESCRIPTION, EXAMPLES, configure, run)}
