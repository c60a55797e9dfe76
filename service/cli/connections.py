"""Find which poses of a joint vector, or of two, are joined by paths without a singularity: all pairs at
once, each with the proved reason if there is no path."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.contract import PATH_DIGITS
from service.cli import arguments, output, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, all_legs, counted, nearby, rows_of, write_document
from service.schemas.answers import SVG
from service.schemas.connections import PoseConnectionsRequest
from service.schemas.document import named
from service.schemas.lengths import LEGS, split_ends

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2
  rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2 --between 27:30
  rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --to l1=30,l2=21,l3=19
  rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits 5:21 --format svg > matrix.svg
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    for leg in LEGS:
        parser.add_argument(f"--{leg}", metavar="X", help=f"length of leg {leg[1]}", required=True)
    parser.add_argument("--fixed-leg", metavar="LEG", help="the fixed leg (default: 1)")
    parser.add_argument(
        "--to", metavar="LENGTHS", help="a second joint vector, whose poses are included: l1=30,l2=21,l3=19"
    )
    parser.add_argument(
        "--between",
        metavar="FROM:TO",
        help="lengths between which the fixed leg may vary (default: it is held, or varies between its "
        "lengths at both joint vectors)",
    )
    arguments.add_options(
        parser, "--l{}-limits", "limits", "MIN:MAX", "joint limits of a leg, along the whole paths"
    )
    arguments.add_digits(parser, PATH_DIGITS)
    arguments.add_format(parser, "svg")
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    with named("--between"):
        between = None if args.between is None else split_ends(args.between)
    limits, names = arguments.joint_limits(args.limits)
    members = {
        "fixed_leg": arguments.leg_of([], args.fixed_leg, "lengths"),
        **{leg: getattr(args, leg) for leg in LEGS},
        "to": None if args.to is None else arguments.changes_of(args.to),
        "between": between,
        "limits": limits or None,
        **remote.deadline_of(args),
    }
    names |= {name: f"--{name}" for name in (*LEGS, "to", "between")}
    asked = arguments.ask(PoseConnectionsRequest, args, members, arguments.source(names))
    document = remote.answer_of(args.url, asked)
    if args.format == "svg":
        output.write(PoseConnectionsRequest.forms[SVG].encode(document).decode())
        return 0
    write_document(document, _page(document), args.format)
    return 0


def _page(document: Mapping[str, Any]) -> Page:
    poses = document["poses"]
    of_two = LEGS[0] not in document
    vectors = dict.fromkeys(all_legs(part) for part in (poses if of_two else [document]))
    title = f"{' and '.join(vectors)}: {counted(len(poses), 'pose')}"
    columns = (
        [*(LEGS if of_two else ()), "pose", *(name for name in poses[0] if name.endswith("_deg"))]
        if poses
        else []
    )
    rows = [
        {"": str(place), **{name: str(pose[name]) for name in columns}, "sign of J": _SIGNS[pose["sign"]]}
        for place, pose in enumerate(poses, 1)
    ]
    joined = [
        {"": str(place), **{str(k): word for k, word in enumerate(row, 1)}}
        for place, row in enumerate(document["matrix"], 1)
    ]
    return Page(
        about(document),
        [Section(title, rows_of(rows)), Section("Which are joined", rows_of(joined), list(_notes(document)))],
        document["digits"],
    )


_SIGNS = {1: "+", -1: "−", 0: "0", None: "?"}


def _notes(document: Mapping[str, Any]) -> Iterator[str]:
    groups = ", ".join("-".join(map(str, group)) for group in document["groups"])
    yield f"Joined with each other: {groups or 'none'}."
    if size := document["resolution"]:
        length = "" if size["length"] is None else f" × {size['length']}"
        yield f"Poses were examined in boxes of {size['angle_deg']}° × {size['angle_deg']}°{length}."
    for pair in document.get("undecided", ()):
        yield f"{'-'.join(map(str, pair['poses']))} stays undecided near {nearby(pair['near'])}."


COMMANDS = {"connections": Command(DESCRIPTION, EXAMPLES, configure, run)}
"""The command."""
