"""Draw the singular curves of a slice, with the number of poses in each region of the free legs' lengths, and
the aspects. How the curves run between their special points is proved; samples keep the tolerance."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import rpr_solver
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, counted, rows_of, write_document
from service.schemas.lengths import LEGS
from service.schemas.poses import SingularCurvesRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps singular innocenti --l1 14.98
  rpr-cusps singular innocenti --l1 27 --tolerance 0.0001 --format csv
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_slice(parser, "the length of the fixed leg")
    parser.add_argument(
        "--tolerance",
        metavar="X",
        help="largest deviation of the drawn curves, relative to the size of the picture (default: 0.001)",
    )
    arguments.add_digits(parser, rpr_solver.MIN_DIGITS)
    arguments.add_format(parser, "csv")
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    question = _question(args)
    document = remote.answer_of(args.url, question)
    write_document(document, _page(document), args.format, csv=rpr_solver.singular_csv)
    return 0


def _question(args: argparse.Namespace) -> SingularCurvesRequest:
    leg = arguments.leg_of(args.lengths, args.fixed_leg, "lengths")
    members = {
        "fixed_leg": leg,
        **{option[2:]: text for option, text in args.lengths},
        "tolerance": args.tolerance,
        **remote.deadline_of(args),
    }
    names = {name: f"--{name}" for name in (*LEGS, "tolerance")}
    return arguments.ask(SingularCurvesRequest, args, members, arguments.source(names))


def _page(document: Mapping[str, Any]) -> Page:
    leg = f"l{document['fixed_leg']}"
    components = document["components"]
    vertices = [
        {
            "component": number,
            "kind": vertex["kind"] + (f" {vertex['cusp']}" if "cusp" in vertex else ""),
            **{key: value for key, value in vertex.items() if key not in ("index", "kind", "cusp")},
        }
        for number, component in enumerate(components, 1)
        for strand in component["strands"]
        for vertex in strand["vertices"]
    ]
    title = f"{leg.upper()} = {document[leg]}: {counted(len(components), 'component')}"
    regions = [{"poses": r["poses"], **r["point"]} for r in document["regions"]]
    notes = ["The number of poses is proved at the point beside it, and the same in the whole region."]
    if thin := document["thin_regions"]:
        notes.append(f"{counted(thin, 'face')} of the drawing too thin for its tolerance.")
    aspects = [
        {"sign of J": "+" if aspect["sign"] > 0 else "−", "share": f"{100 * aspect['share']:.1f} %"}
        for aspect in document["aspects"]
    ]
    return Page(
        about(document),
        [
            Section(title, rows_of(vertices)),
            Section(f"Joint space: {counted(len(regions), 'region')}", rows_of(regions), notes),
            Section(f"Poses: {counted(len(aspects), 'aspect')}", rows_of(aspects)),
        ],
        document["digits"],
    )


COMMANDS = {"singular": Command(DESCRIPTION, EXAMPLES, configure, run)}
