"""Prove how far the lengths of a manipulator may change before the number of cusps of a slice does, before a
requirement is violated, or before a window with a number of cusps vanishes. With --tolerance, decide whether
a tolerance is small enough.

What is proved holds for every geometry within the radius; a counter-example is exact, and can be posed again.
The first-order radius is an estimate, no bound."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from rpr_solver.errors import InputError
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, counted, rows_of, write_document
from service.schemas.margins import MarginRequest

DESCRIPTION = f"""{__doc__}

{arguments.GEOMETRY}

Exit status: 0 proved (without a tolerance: a radius > 0), 1 refuted or open, 2 bad input."""
EXAMPLES = """\
examples:
  rpr-cusps margin innocenti --l1 28.1
  rpr-cusps margin innocenti --l1 28.1 --tolerance 0.0005
  rpr-cusps margin innocenti --l1 28.1 --tolerance d1=0.004,a3x=0.0002
  rpr-cusps margin robot.json --l1-range 21:26 --max-cusps 6 --weights a2x=0
  rpr-cusps margin innocenti --window 28.1 --tolerance 0.01
"""

PROVED, NOT_PROVED = 0, 1


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_options(parser, "--l{}", "lengths", "X", "the slice whose number of cusps is to stay")
    arguments.add_requirement(parser, "or the range of a requirement; either end may be omitted")
    text = "or a length between two transitions: slices with the number of cusps there are to exist"
    parser.add_argument("--window", metavar="X", help=text)
    text = "a change of all lengths, or of single ones, as d1=0.01,a3x=0.002; the others are exact then"
    parser.add_argument("--tolerance", metavar="T", help=text)
    text = "how much lengths may change in comparison, as d1=2,a2x=0 (default: 1; 0: exact)"
    parser.add_argument("--weights", metavar="W", help=text)
    arguments.add_certificate(parser)
    arguments.add_format(parser)
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    names = {"window": "--window", "tolerance": "--tolerance", "weights": "--weights"}
    members: dict[str, object] = {"window": args.window, **remote.deadline_of(args)}
    members["certificate"] = args.certificate
    members["tolerance"] = arguments.tolerance_of(args.tolerance)
    members["weights"] = None if args.weights is None else arguments.changes_of(args.weights)
    if args.ranges:
        members["requirement"], places = arguments.requirement_of(args)
        names |= places
    elif args.limits or args.max_cusps is not None or args.min_cusps is not None:
        raise InputError.of("--l1-range", "is missing; a requirement needs the range of lengths")
    if args.lengths or not args.ranges:
        members["fixed_leg"] = arguments.leg_of(args.lengths, args.fixed_leg, "lengths")
    for option, text in args.lengths:
        members[option[2:]], names[option[2:]] = text, option
    asked = arguments.ask(MarginRequest, args, members, arguments.source(names))
    document = remote.answer_of(args.url, asked, "boxes")
    write_document(document, _page(document), args.format)
    if document["verdict"] is None:
        return PROVED if document["proved"] not in (None, "0") else NOT_PROVED
    return PROVED if document["verdict"] == "proved" else NOT_PROVED


def _page(document: Mapping[str, Any]) -> Page:
    asked, leg = document["asked"], f"l{document['fixed_leg']}"
    count = document["count"]
    cusps = "the requirement" if count is None else counted(count, "cusp")
    place = f" at {leg.upper()} = {asked[leg]}" if leg in asked else ""
    place = f" in the window at {asked['window']}" if "window" in asked else place
    values = [("verdict", document["verdict"]), ("proved within", document["proved"])]
    values += [("why not more", document["reason"]), ("flat, or no manipulator, from", document["validity"])]
    first, example = document["first_order"], document["counterexample"]
    if first is not None:
        movers = ", ".join(f"{mover['kind']} at {mover[leg]}" for mover in first["binding"])
        values.append(("first order (an estimate)", f"{first['radius']}: {movers}"))
    if example is not None:
        values.append(("refuted at", example["radius"]))
    title = f"Margin of {cusps}{place}"
    if document["verdict"] is not None:
        title += "; radii are multiples of the tolerance"
    sections = [Section(title, [["", ""], *([name, text] for name, text in values if text is not None)])]
    if first is not None:
        rows = [{"transition": mover[leg], **mover["sensitivity"]} for mover in first["binding"]]
        sections.append(Section("Sensitivities of the transitions that bind it", rows_of(rows)))
    if example is not None:
        found = (
            "no length has as many cusps" if example["count"] is None else counted(example["count"], "cusp")
        )
        at = "" if example[leg] is None else f" at {leg.upper()} = {example[leg]}"
        sections.append(Section(f"Counter-example: {found}{at}", rows_of([example["geometry"]])))
    return Page(about(document), sections, document["digits"])


COMMANDS = {"margin": Command(DESCRIPTION, EXAMPLES, configure, run)}
