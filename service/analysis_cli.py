"""The commands that analyse one manipulator, or many, without a service: their options and help."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from rpr_solver.errors import SolverError

NO_ANSWER = 1

_FORMATTER = argparse.RawDescriptionHelpFormatter
_Commands = Any  # argparse keeps the type of its subparsers to itself

_POSES = """\
Direct kinematics: all poses of the platform with given leg lengths, proved to be all, with multiplicity.

GEOMETRY is a JSON file, - for standard input, or a built-in manipulator: innocenti, zein-flat, twelve-cusps
or fourteen-cusps. Numbers are exact: 17.04, 426/25.
"""
_POSES_EXAMPLES = """\
examples:
  rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30
  rpr-cusps poses robot.json --l1 14.98 --l2 15 --l3 61/2 --digits 200 --format json
"""


def add_analysis(commands: _Commands) -> None:
    """Add the commands to the parser."""
    _add_poses(commands)


def _add_poses(commands: _Commands) -> None:
    poses = commands.add_parser(
        "poses",
        help="all poses of given leg lengths",
        description=_POSES,
        epilog=_POSES_EXAMPLES,
        formatter_class=_FORMATTER,
    )
    poses.add_argument("geometry", metavar="GEOMETRY", help="a JSON file, -, or a built-in name")
    for leg in (1, 2, 3):
        poses.add_argument(f"--l{leg}", required=True, metavar="X", help=f"length of leg {leg}")
    _add_digits(poses, 90)
    poses.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    poses.set_defaults(run=_poses)


def _add_digits(parser: argparse.ArgumentParser, default: int) -> None:
    parser.add_argument("--digits", metavar="N", help=f"significant digits, 15 to 1000 (default: {default})")


def _poses(args: argparse.Namespace) -> int:
    from service import analysing

    lengths = {f"l{leg}": getattr(args, f"l{leg}") for leg in (1, 2, 3)}
    try:
        return analysing.poses(args.geometry, lengths, args.digits, args.format)
    except SolverError as error:
        return _undecided("poses", error)


def _undecided(command: str, error: SolverError) -> int:
    print(f"rpr-cusps {command}: no answer (solver-error): {error}", file=sys.stderr)
    return NO_ANSWER
