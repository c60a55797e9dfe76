"""Checks of requirements, and of the numbers of cusps of single slices, on the command line."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Annotated, TextIO

from rpr_solver import CHECK_DIGITS, Requirement
from rpr_solver.errors import InputError
from rpr_solver.transitions.requirement import ALLOWED, EXCLUDED, REFUSED, REQUIRED
from service.cli import arguments, asking, output, parsers
from service.cli.arguments import Found, find, read_option
from service.cli.check.ci_formats import github_annotations, junit_xml, sarif
from service.cli.check.reports import Outcome, document, page, summary
from service.cli.check.runs import Expectation, Task, check_all, check_by_service
from service.cli.pages import write_document
from service.cli.parsers import Command
from service.schemas.censuses import RequirementDocument
from service.schemas.document import read
from service.schemas.lengths import Tolerance, changes_json
from service.schemas.numbers import Digits, Length, whole_from
from worker.process import usable_cores

PASSED, FAILED, BAD_INPUT = 0, 1, 2
_Jobs = Annotated[int, whole_from(1, 1024)]
_Number = Annotated[int, whole_from(0)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Options:
        --ignore-others: ignore files without a geometry even if they are named, for pre-commit
        --max-cusps: maximum number of cusps in any slice; 0: none at all
        --min-cusps: minimum number of cusps in any slice
        --expect-cusps: number of cusps in each slice of --l1 (--l2, …), or in every slice of the range
        --ignore-windows: ignore (but list) windows with other numbers of cusps that are narrower than this
        --degenerate: allowed (and reported) or refused: degenerate poses in every slice, or along a whole
            curve in a slice
        --mode-change: required or excluded: a change of assembly mode without a singularity, in the range
        --clearance: with --mode-change: how far, in degrees, the change must keep from singular poses
        --tolerance: how far all lengths may be off, or single ones, as d1=0.01,a3x=0.002 (the others are
            exact then), within which the requirement must be met as well
        --junit: write JUnit XML, with a test case for each geometry
        --sarif: write SARIF, for code scanning
        --github: print GitHub annotations (default on GitHub Actions)
        --jobs: number of processes (default: one per core)
    """
    parsers.add_geometry(parser, "a JSON file, a folder", nargs="+")
    parser.add_argument("--ignore-others", action="store_true")
    parsers.add_ranges(parser, "the range of lengths to check; either end may be omitted")
    text = "a single slice to check, with --expect-cusps; repeatable"
    parsers.add_options(parser, "--l{}", "slices", "X", text)
    parser.add_argument("--max-cusps", metavar="N")
    parser.add_argument("--min-cusps", metavar="N")
    parser.add_argument("--expect-cusps", metavar="N")
    parsers.add_limits(parser)
    parser.add_argument("--ignore-windows", metavar="X")
    parser.add_argument("--degenerate", metavar="WORD", choices=(ALLOWED, REFUSED), default=ALLOWED)
    parser.add_argument("--mode-change", metavar="WORD", choices=(REQUIRED, EXCLUDED))
    parser.add_argument("--clearance", metavar="DEGREES")
    parser.add_argument("--tolerance", metavar="T")
    parsers.add_digits(parser, CHECK_DIGITS)
    parsers.add_format(parser)
    parser.add_argument("--junit", metavar="FILE")
    parser.add_argument("--sarif", metavar="FILE")
    parser.add_argument("--github", action="store_true")
    parser.add_argument("--jobs", metavar="N")
    parsers.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Prove or refute a requirement: a maximum or minimum number of cusps in every slice of a range of
    lengths, or the number of cusps in single slices.

    Several geometries are checked in parallel. A folder means the geometries in its *.json files and in those
    of its subfolders, except hidden ones; files without a geometry are listed and ignored. With limits on the
    other legs, only cusps strictly within them are counted. The absence of cusps does not prove that the
    assembly mode cannot change. With --ignore-windows, a geometry passes that violates the requirement only
    in windows narrower than the given width; these are listed.

    With --tolerance a geometry passes only if the requirement is proved for every geometry whose lengths
    differ from its own by at most the tolerance. Otherwise there is a counter-example, or the tolerance is
    open: neither proved nor refuted.

    Exit status: 0 all pass, 1 a requirement is violated, open, or could not be decided, 2 bad input.

    examples:
      rpr-cusps check innocenti --l1-range 28:31 --max-cusps 8
      rpr-cusps check innocenti --l1 14.98 --l1 27 --expect-cusps 6
      rpr-cusps check designs/ --l1-range 10:20 --max-cusps 0 --junit report.xml
      rpr-cusps check a.json b.json --l1-range 10: --min-cusps 1 --l2-limits 5:40
      rpr-cusps check innocenti --l1-range 21:26 --max-cusps 6 --tolerance 0.05
      rpr-cusps check innocenti --l1-range 0:20 --max-cusps 6 --ignore-windows 0.001
      rpr-cusps check robot.json --l1-range 20:30 --mode-change required --clearance 0.5 --tolerance 0.05
      rpr-cusps check robot.json --l1 28.1 --expect-cusps 10 --tolerance d1=0.0002,a3x=0.0001

    On GitHub Actions, each geometry that does not pass is annotated.
    """
    digits = read_option(Digits, arguments.computed_digits(args) or CHECK_DIGITS, "--digits")
    printed = arguments.printed_digits(args)
    task = Task(_demand(args), digits, printed, _tolerance(args.tolerance), asking.seconds_of(args))
    if args.jobs is not None and args.url is not None:
        raise InputError.of("--jobs", "is for checks that are computed here; leave it or --url out")
    jobs = usable_cores() if args.jobs is None else read_option(_Jobs, args.jobs, "--jobs")
    found = find(args.geometry, ignore_others=args.ignore_others)
    geometries = found.geometries
    with ExitStack() as stack:
        files = {
            form: stack.enter_context(_opened(f"--{form}", name))
            for form in _FILES
            if (name := getattr(args, form)) is not None
        }
        if args.url is None:
            outcomes = check_all(geometries, task, jobs)
        else:
            outcomes = check_by_service(args.url, geometries, task)
        for form, file in files.items():
            _write(file, _FILES[form](outcomes))
    _print(outcomes, task, found, args)
    if any(outcome.is_bad for outcome in outcomes):
        return BAD_INPUT
    return PASSED if all(outcome.passed for outcome in outcomes) else FAILED


def _demand(args: argparse.Namespace) -> Requirement | Expectation:
    if args.slices:
        return _expectation(args)
    if not args.ranges:
        hint = "give the lengths to check, for example --l1-range 10:20, or --l1 14.98 --expect-cusps 6"
        raise InputError.of("--l1-range", f"is missing; {hint}")
    members, names = arguments.requirement_of(args)
    counts, count = ("max_cusps", "min_cusps"), args.expect_cusps
    if count is not None:
        if not members.keys().isdisjoint(counts):
            raise InputError.of("--expect-cusps", "is a maximum and a minimum already; give no other")
        members |= dict.fromkeys(counts, count)
        names |= dict.fromkeys(counts, "--expect-cusps")
    elif members.keys().isdisjoint((*counts, "mode_change")):
        raise InputError.of("--max-cusps", "is missing; give --max-cusps, --min-cusps or --expect-cusps")
    return read(RequirementDocument, members, arguments.source(names)).to_requirement()


def _tolerance(text: str | None) -> dict[str, str] | None:
    if text is None:
        return None
    return changes_json(read_option(Tolerance, arguments.parts_of(text), "--tolerance"))


def _expectation(args: argparse.Namespace) -> Expectation:
    """Returns what `--expect-cusps` says about single slices."""
    leg = arguments.leg_of(args.slices, args.fixed_leg, "slices")
    others = {
        "--max-cusps": args.max_cusps,
        "--mode-change": args.mode_change,
        "--clearance": args.clearance,
        "--min-cusps": args.min_cusps,
        "--ignore-windows": args.ignore_windows,
        **dict(args.ranges),
        **dict(args.limits),
    }
    for option, value in others.items():
        if value is not None:
            raise InputError.of(option, f"does not go with single slices; give --l{leg} and --expect-cusps")
    if args.expect_cusps is None:
        raise InputError.of("--expect-cusps", f"is missing; it says how many cusps each --l{leg} has")
    count = read_option(_Number, args.expect_cusps, "--expect-cusps")
    lengths = [read_option(Length, text, option) for option, text in args.slices]
    return Expectation(leg, tuple(dict.fromkeys(lengths)), count, args.degenerate)


def _opened(option: str, name: str) -> TextIO:
    """Returns a file to write, opened before the work, so that a bad name is noticed at once."""
    if name == parsers.STANDARD_INPUT:
        raise InputError.of(option, "is -, which is no file; give the name of one")
    try:
        return Path(name).open("w", encoding="utf-8")
    except OSError as error:
        raise InputError.of(option, f"{name!r} cannot be written ({error.strerror})") from None


def _write(file: TextIO, text: str) -> None:
    try:
        file.write(text)
        file.flush()
    except OSError as error:
        with suppress(OSError):
            file.close()
        raise output.OutputError(f"cannot write to {file.name!r}: {error.strerror}") from None


def _print(outcomes: Sequence[Outcome], task: Task, found: Found, args: argparse.Namespace) -> None:
    requirement = task.to_json()
    write_document(document(outcomes, requirement, found), page(outcomes, requirement, found), args.format)
    is_json = args.format == "json"
    if is_json:
        for outcome in outcomes:
            if outcome.error is not None:
                where = f"rpr-cusps check: {outcome.name}"
                output.say(f"{where}: {outcome.verdict} ({outcome.error['type']}): {outcome.message}")
        output.say(summary(outcomes, found))
    if args.github or os.environ.get("GITHUB_ACTIONS") == "true":
        # GitHub reads both streams, and stdout must stay a single JSON document
        for line in github_annotations(outcomes):
            if is_json:
                output.say(line)
            else:
                output.write(line + "\n")


_FILES: Mapping[str, Callable[[Sequence[Outcome]], str]] = {"junit": junit_xml, "sarif": sarif}
COMMANDS = {"check": Command.of(run, configure)}
