"""Compute all poses of the platform for given leg lengths (direct kinematics), with multiplicities. The list
is proved complete."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, all_legs, counted, rows_of, write_document
from service.schemas.lengths import LEGS
from service.schemas.numbers import FIXED_LEGS
from service.schemas.poses import PosesRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30
  rpr-cusps poses robot.json --l1 14.98 --l2 15 --l3 61/2 --digits 200 --format json
"""

_KEYS = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y", "multiplicity")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    for leg in FIXED_LEGS:
        parser.add_argument(f"--l{leg}", required=True, metavar="X", help=f"length of leg {leg}")
    arguments.add_digits(parser, 90)
    arguments.add_format(parser)
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    names = {name: f"--{name}" for name in LEGS}
    lengths = {name: getattr(args, name) for name in names}
    members = {**lengths, **remote.deadline_of(args)}
    question = arguments.ask(PosesRequest, args, members, arguments.source(names))
    table = remote.answer_of(args.url, question)
    write_document(table, _page(table), args.format)
    return 0


def _page(table: Mapping[str, Any]) -> Page:
    title = f"{all_legs(table)}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    return Page(about(table), [Section(title, rows_of(table["poses"], _KEYS), notes)], table["digits"])


COMMANDS = {"poses": Command(DESCRIPTION, EXAMPLES, configure, run)}
