"""Whether the assembly mode can change, and which poses are joined."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.contract import PATH_DIGITS, letter
from service.cli import arguments, output, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, all_legs, counted, nearby, rows_of, write_document
from service.schemas.answers import SVG
from service.schemas.document import named
from service.schemas.lengths import LEGS, split_ends
from service.schemas.modes import AssemblyModesRequest, PoseConnectionsRequest

_MODES = f"""\
Decide whether the assembly mode can change without a singularity: whether some joint vector of a slice, or
of a range of the fixed leg, has two poses that a path joins, within joint limits.

That it can is shown by such a path. That it cannot is proved for all joint vectors.

{arguments.GEOMETRY}

Exit status: 0 possible or impossible, 1 undecided, 2 bad input."""
_MODES_EXAMPLES = """\
examples:
  rpr-cusps modes innocenti --l1 27
  rpr-cusps modes innocenti --l1-range 0.05:0.1
  rpr-cusps modes robot.json --l1-range 20:30 --l2-limits 12:30 --l3-limits 12:30
"""

DECIDED, UNDECIDED = 0, 1


def _configure_modes(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_options(parser, "--l{}", "lengths", "X", "the length of the fixed leg in a slice")
    arguments.add_ranges(parser, "or the lengths between which it may vary")
    arguments.add_limits(parser)
    arguments.add_format(parser)
    remote.add_url(parser)


def _run_modes(args: argparse.Namespace) -> int:
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
    write_document(document, _modes_page(document), args.format)
    return UNDECIDED if document["change"] == "undecided" else DECIDED


def _modes_page(document: Mapping[str, Any]) -> Page:
    leg, asked = document["fixed_leg"], document["asked"]
    span = asked.get("range")
    where = f"L{leg} = {asked[f'l{leg}']}" if span is None else f"L{leg} from {span['from']} to {span['to']}"
    limited = "" if asked["limits"] is None else ", within the joint limits"
    title = f"{where}{limited}: a change of assembly mode is {document['change']}"
    sections = [Section(title, (), list(_modes_notes(document)))]
    if document["regions"] is not None:
        rows = [
            {**region["point"], "poses": str(region["poses"]), "joined": _groups(region["joined"])}
            for region in document["regions"]
        ]
        sections.append(Section("Regions, and which of their poses are joined", rows_of(rows)))
    return Page(about(document), sections, document["digits"])


def _modes_notes(document: Mapping[str, Any]) -> Iterator[str]:
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


_CONNECTIONS = f"""\
Find which poses of a joint vector, or of two, are joined by paths without a singularity: all pairs at
once, each with the proved reason if there is no path.

{arguments.GEOMETRY}"""
_CONNECTIONS_EXAMPLES = """\
examples:
  rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2
  rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2 --between 27:30
  rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits :22 --parts
  rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --to l1=30,l2=21,l3=19
  rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits 5:21 --format svg > matrix.svg
"""


def _configure_connections(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    for leg in LEGS:
        parser.add_argument(f"--{leg}", metavar="X", help=f"length of leg {leg[1]}", required=True)
    parser.add_argument("--fixed-leg", metavar="LEG", help="the fixed leg (default: 1)")
    parser.add_argument(
        "--to", metavar="LENGTHS", help="a second joint vector, whose poses are included: l1=30,l2=21,l3=19"
    )
    arguments.add_between(parser, "joint vectors")
    arguments.add_limits(parser, "a leg, along the whole paths")
    parser.add_argument(
        "--parts",
        action="store_true",
        help="count the parts of the allowed region, too, with the poses in each: of all poses that are not "
        "singular, in the slice or in the range, and keep the limits",
    )
    arguments.add_digits(parser, PATH_DIGITS)
    arguments.add_format(parser, "svg")
    remote.add_url(parser)


def _run_connections(args: argparse.Namespace) -> int:
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
        "parts": args.parts,
        **remote.deadline_of(args),
    }
    names |= {name: f"--{name}" for name in (*LEGS, "to", "between")}
    asked = arguments.ask(PoseConnectionsRequest, args, members, arguments.source(names))
    document = remote.answer_of(args.url, asked)
    if args.format == "svg":
        output.write(PoseConnectionsRequest.forms[SVG].encode(document).decode())
        return 0
    write_document(document, _connections_page(document), args.format)
    return 0


def _connections_page(document: Mapping[str, Any]) -> Page:
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
    sections = [
        Section(title, rows_of(rows)),
        Section("Which are joined", rows_of(joined), list(_connections_notes(document))),
        *_allowed(document),
    ]
    return Page(about(document), sections, document["digits"])


def _allowed(document: Mapping[str, Any]) -> Iterator[Section]:
    """The parts of the allowed region."""
    if (region := document.get("allowed")) is None:
        return
    rows = [
        {
            "": str(number),
            "sign of J": _SIGNS[part["sign"]],
            "poses": ", ".join(map(str, part["poses"])) or "none of these",
            "with": "" if part["pose"] is None else nearby(part["pose"]),
            "is one": "yes" if part["is_one"] else f"undecided near {nearby(part['near'])}",
        }
        for number, part in enumerate(region["parts"], 1)
    ]
    count = (
        "a number of parts that stays undecided" if region["count"] is None else f"{region['count']} parts"
    )
    yield Section(f"The allowed region: {count}", rows_of(rows))


_SIGNS = {1: "+", -1: "−", 0: "0", None: "?"}


def _connections_notes(document: Mapping[str, Any]) -> Iterator[str]:
    groups = ", ".join("-".join(map(str, group)) for group in document["groups"])
    yield f"Joined with each other: {groups or 'none'}."
    if size := document["resolution"]:
        length = "" if size["length"] is None else f" × {size['length']}"
        yield f"Poses were examined in boxes of {size['angle_deg']}° × {size['angle_deg']}°{length}."
    for pair in document.get("undecided", ()):
        yield f"{'-'.join(map(str, pair['poses']))} stays undecided near {nearby(pair['near'])}."


COMMANDS = {
    "modes": Command(_MODES, _MODES_EXAMPLES, _configure_modes, _run_modes),
    "connections": Command(_CONNECTIONS, _CONNECTIONS_EXAMPLES, _configure_connections, _run_connections),
}
