"""Decide whether the assembly mode can change without a singularity: whether some joint vector of a slice, or
of a range of the fixed leg, has two poses that a path joins, within joint limits.

That it can is shown by such a path. That it cannot is proved for all joint vectors."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.contract import letter
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, all_legs, rows_of, write_document
from service.schemas.modes import AssemblyModesRequest

DESCRIPTION = f"""{__doc__}

{arguments.GEOMETRY}

Exit status: 0 possible or impossible, 1 undecided, 2 bad input."""
EXAMPLES = """\
examples:
  rpr-cusps modes innocenti --l1 27
  rpr-cusps modes innocenti --l1-range 0.05:0.1
  rpr-cusps modes robot.json --l1-range 20:30 --l2-limits 12:30 --l3-limits 12:30
"""

DECIDED, UNDECIDED = 0, 1


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_options(parser, "--l{}", "lengths", "X", "the length of the fixed leg in a slice")
    arguments.add_ranges(parser, "or the lengths between which it may vary")
    arguments.add_options(parser, "--l{}-limits", "limits", "MIN:MAX", "joint limits of another leg")
    arguments.add_format(parser)
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    limits, names = arguments.joint_limits(args.limits)
    members: dict[str, object] = {"limits": limits or None, **remote.deadline_of(args)}
    if args.ranges:
        members["fixed_leg"], members["range"], names["range"] = arguments.leg_and_range(args)
    else:
        members["fixed_leg"] = arguments.leg_of(args.lengths, args.fixed_leg, "lengths")
    for option, text in args.lengths:
        members[option[2:]], names[option[2:]] = text, option
    asked = arguments.ask(AssemblyModesRequest, args, members, arguments.source(names))
    document = remote.answer_of(args.url, asked)
    write_document(document, _page(document), args.format)
    return UNDECIDED if document["change"] == "undecided" else DECIDED


def _page(document: Mapping[str, Any]) -> Page:
    leg, asked = document["fixed_leg"], document["asked"]
    span = asked.get("range")
    where = f"L{leg} = {asked[f'l{leg}']}" if span is None else f"L{leg} from {span['from']} to {span['to']}"
    limited = "" if asked["limits"] is None else ", within the joint limits"
    title = f"{where}{limited}: a change of assembly mode is {document['change']}"
    sections = [Section(title, (), list(_notes(document)))]
    if document["regions"] is not None:
        rows = [
            {**region["point"], "poses": str(region["poses"]), "joined": _groups(region["joined"])}
            for region in document["regions"]
        ]
        sections.append(Section("Regions, and which of their poses are joined", rows_of(rows)))
    return Page(about(document), sections, document["digits"])


def _notes(document: Mapping[str, Any]) -> Iterator[str]:
    witness = document["witness"]
    if witness is not None:
        cusp = witness["path"]["cusp"]
        kind = "a path" if cusp is None else f"a loop round cusp {letter(cusp)}"
        yield f"Proved by {kind} from pose {witness['from']} to pose {witness['to']} of {all_legs(witness)}."
    elif document["change"] == "impossible":
        pairs = document["certificate"]["pairs"]
        yield f"Proved by {pairs} pairs of boxes: every aspect maps one to one."
    else:
        yield f"Neither a path nor a proof was found: {document['reason']}."


def _groups(joined: list[list[int]] | None) -> str:
    if joined is None:
        return "not told"
    return ", ".join("-".join(map(str, group)) for group in joined) or "none"


COMMANDS = {"modes": Command(DESCRIPTION, EXAMPLES, configure, run)}
"""The command."""
