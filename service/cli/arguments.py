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


_CENSUS = """\
Every length at which the number of cusps changes, with its kind and pose, and the number of cusps between:
all of them, by proof.

GEOMETRY is a JSON file, - for standard input, or a built-in manipulator: innocenti, zein-flat, twelve-cusps
or fourteen-cusps.
"""
_CENSUS_EXAMPLES = """\
examples:
  rpr-cusps census innocenti --digits 20
  rpr-cusps census innocenti --l1-range 28:31 --format json
  rpr-cusps census robot.json --l2-range :40 --format csv    slices of leg 2
"""


_CURVES = """\
The curves that cusps run along while one leg changes its length: each cusp followed, by proof, from the
transition where it is born to the one where it dies, and named. The names belong to the manipulator,
whatever range or points are asked for.

GEOMETRY is a JSON file, - for standard input, or a built-in manipulator: innocenti, zein-flat, twelve-cusps
or fourteen-cusps.
"""
_CURVES_EXAMPLES = """\
examples:
  rpr-cusps curves innocenti --digits 15
  rpr-cusps curves innocenti --l1-range 27:29:0.1 --format csv
  rpr-cusps curves robot.json --l2-range 10:40 --samples 20 --format json
"""


_CHECK = """\
Prove or refute a requirement: at most, or at least, so many cusps in every slice of a range of lengths.

GEOMETRY is a JSON file, a folder (all *.json in it), - for standard input, or a built-in manipulator; many
may be given and are checked in parallel. With limits of the other legs, only cusps strictly within them are
counted.

Exit status: 0 all pass, 1 some requirement is violated or could not be decided, 2 bad input.
"""
_CHECK_EXAMPLES = """\
examples:
  rpr-cusps check innocenti --l1-range 28:31 --max-cusps 8
  rpr-cusps check designs/ --l1-range 10:20 --max-cusps 0 --junit report.xml
  rpr-cusps check a.json b.json --l1-range 10: --min-cusps 1 --l2-limits 5:40 --format json

On GitHub Actions each geometry that does not pass is annotated.
"""


class Options(argparse.Action):
    """Collects options of several names, each with its name."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        """Keep one option."""
        del parser
        setattr(namespace, self.dest, [*(getattr(namespace, self.dest) or []), (option_string, str(values))])


def add_command(
    commands: _Commands, name: str, summary: str, description: str, examples: str | None = None
) -> argparse.ArgumentParser:
    """Add a command to the parser; its options are for the caller to add."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=description, epilog=examples, formatter_class=_FORMATTER
    )
    return parser


def add_geometry(parser: argparse.ArgumentParser) -> None:
    """Add the manipulator, of which there is one."""
    parser.add_argument("geometry", metavar="GEOMETRY", help="a JSON file, -, or a built-in name")


def add_format(parser: argparse.ArgumentParser, *, csv: bool = False) -> None:
    """Add `--format`."""
    forms = ("table", "json", "csv") if csv else ("table", "json")
    parser.add_argument("--format", choices=forms, default="table", help="default: table")


def add_analysis(commands: _Commands) -> None:
    """Add the commands to the parser."""
    _add_census(commands)
    _add_curves(commands)
    _add_check(commands)
    _add_poses(commands)


def _add_poses(commands: _Commands) -> None:
    poses = add_command(commands, "poses", "all poses of given leg lengths", _POSES, _POSES_EXAMPLES)
    add_geometry(poses)
    for leg in (1, 2, 3):
        poses.add_argument(f"--l{leg}", required=True, metavar="X", help=f"length of leg {leg}")
    _add_digits(poses, 90)
    add_format(poses)
    poses.set_defaults(run=_poses)


def _add_census(commands: _Commands) -> None:
    census = add_command(
        commands, "census", "every length at which the number of cusps changes", _CENSUS, _CENSUS_EXAMPLES
    )
    add_geometry(census)
    _add_ranges(census, "the lengths of interest; either end may be left out (default: all)")
    _add_digits(census, 90)
    add_format(census, csv=True)
    census.set_defaults(run=_census)


def _add_curves(commands: _Commands) -> None:
    curves = add_command(
        commands, "curves", "each cusp followed from its birth to its death", _CURVES, _CURVES_EXAMPLES
    )
    add_geometry(curves)
    _add_ranges(
        curves, "the lengths of interest (default: all); with a step, also those of points", "A:B[:STEP]"
    )
    names = (f"--l{leg}" for leg in (1, 2, 3))
    curves.add_argument(
        *names, dest="lengths", action=Options, metavar="X", help="a length of points; may be given often"
    )
    curves.add_argument(
        "--samples", metavar="N", help="N points of each curve in every interval between transitions"
    )
    _add_digits(curves, 90)
    add_format(curves, csv=True)
    curves.set_defaults(run=_curves)


def _add_check(commands: _Commands) -> None:
    check = add_command(
        commands, "check", "prove or refute a requirement on the number of cusps", _CHECK, _CHECK_EXAMPLES
    )
    check.add_argument(
        "geometry", metavar="GEOMETRY", nargs="+", help="a JSON file, a folder, -, or a built-in name"
    )
    _add_ranges(check, "the lengths to check; either end may be left out")
    check.add_argument("--max-cusps", metavar="N", help="at most so many in every slice; 0: free of cusps")
    check.add_argument("--min-cusps", metavar="N", help="at least so many in every slice")
    names = (f"--l{leg}-limits" for leg in (1, 2, 3))
    check.add_argument(
        *names, dest="limits", action=Options, metavar="A:B", help="lengths that another leg can have"
    )
    _add_digits(check, 30)
    add_format(check)
    check.add_argument("--junit", metavar="FILE", help="write JUnit XML, a test case for each geometry")
    check.add_argument(
        "--github", action="store_true", help="print GitHub annotations (always done on GitHub Actions)"
    )
    check.add_argument("--jobs", metavar="N", help="processes (default: one for each core)")
    check.set_defaults(run=_check)


def _add_ranges(parser: argparse.ArgumentParser, text: str, form: str = "A:B") -> None:
    names = (f"--l{leg}-range" for leg in (1, 2, 3))
    parser.add_argument(*names, dest="ranges", action=Options, metavar=form, help=text)
    parser.add_argument(
        "--fixed-leg", metavar="LEG", help="the leg with the fixed length (default: that of the range, or 1)"
    )


def _add_digits(parser: argparse.ArgumentParser, default: int) -> None:
    parser.add_argument("--digits", metavar="N", help=f"significant digits, 15 to 1000 (default: {default})")


def _poses(args: argparse.Namespace) -> int:
    from service.cli import analyse as analysing

    lengths = {f"l{leg}": getattr(args, f"l{leg}") for leg in (1, 2, 3)}
    try:
        return analysing.poses(args.geometry, lengths, args.digits, args.format)
    except SolverError as error:
        return _undecided("poses", error)


def _census(args: argparse.Namespace) -> int:
    from service.cli import analyse as analysing

    try:
        return analysing.census(args.geometry, args.ranges or [], args.fixed_leg, args.digits, args.format)
    except SolverError as error:
        return _undecided("census", error)


def _curves(args: argparse.Namespace) -> int:
    from service.cli import analyse as analysing

    try:
        return analysing.curves(
            args.geometry,
            args.ranges or [],
            args.lengths or [],
            args.samples,
            args.fixed_leg,
            args.digits,
            args.format,
        )
    except SolverError as error:
        return _undecided("curves", error)


def _check(args: argparse.Namespace) -> int:
    from service.cli.check import CheckOptions, check

    return check(
        CheckOptions(
            sources=args.geometry,
            ranges=args.ranges or [],
            limits=args.limits or [],
            fixed_leg=args.fixed_leg,
            max_cusps=args.max_cusps,
            min_cusps=args.min_cusps,
            digits=args.digits,
            form=args.format,
            junit=args.junit,
            github=args.github,
            jobs=args.jobs,
        )
    )


def _undecided(command: str, error: SolverError) -> int:
    print(f"rpr-cusps {command}: no answer (solver-error): {error}", file=sys.stderr)
    return NO_ANSWER
