"""Prove or refute a requirement: at most, or at least, so many cusps in every slice of a range of lengths.

Many geometries may be given and are checked in parallel; a folder stands for all *.json in it. With limits of
the other legs, only cusps strictly within them are counted."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

import rpr_solver
from rpr_solver import CHECK_DIGITS, Manipulator, Requirement
from rpr_solver import EXAMPLES as MANIPULATORS
from rpr_solver.errors import InputError, SolverError
from service.cli import arguments
from service.cli.check_reports import Outcome, document, github_annotations, junit_xml, page
from service.cli.pages import Progress, write_document
from service.schemas.checks import RequirementDocument
from service.schemas.document import named, part, read
from service.schemas.lengths import split_ends
from service.schemas.numbers import Digits, whole_number

DESCRIPTION = f"""{__doc__}

{arguments.GEOMETRY}

Exit status: 0 all pass, 1 some requirement is violated or could not be decided, 2 bad input."""
EXAMPLES = """\
examples:
  rpr-cusps check innocenti --l1-range 28:31 --max-cusps 8
  rpr-cusps check designs/ --l1-range 10:20 --max-cusps 0 --junit report.xml
  rpr-cusps check a.json b.json --l1-range 10: --min-cusps 1 --l2-limits 5:40 --format json

On GitHub Actions each geometry that does not pass is annotated.
"""

PASSED, FAILED, BAD_INPUT = 0, 1, 2
_MAX_JOBS = 1024

OnProgress = Callable[[int, int], None]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "geometry",
        metavar="GEOMETRY",
        nargs="+",
        help="a JSON file, a folder, -, or a built-in name",
    )
    arguments.add_ranges(parser, "the lengths to check; either end may be left out")
    parser.add_argument("--max-cusps", metavar="N", help="at most so many in every slice; 0: free of cusps")
    parser.add_argument("--min-cusps", metavar="N", help="at least so many in every slice")
    arguments.add_options(parser, "--l{}-limits", "limits", "A:B", "lengths that another leg can have")
    arguments.add_digits(parser, CHECK_DIGITS)
    arguments.add_format(parser)
    parser.add_argument("--junit", metavar="FILE", help="write JUnit XML, a test case for each geometry")
    parser.add_argument(
        "--github", action="store_true", help="print GitHub annotations (always done on GitHub Actions)"
    )
    parser.add_argument("--jobs", metavar="N", help="processes (default: one for each core)")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status. A geometry at fault is told among the outcomes."""
    digits = CHECK_DIGITS
    if args.digits is not None:
        with named("digits"):
            digits = part(TypeAdapter(Digits).validate_python, args.digits, arguments.source())
    requirement = _requirement(args)
    jobs = _jobs(args.jobs)
    sources = list(expand(args.geometry))
    outcomes = _check_all(sources, requirement, digits, jobs)
    _report(outcomes, requirement.to_json(), args)
    if any(o.error is not None and o.error["type"] == "input-error" for o in outcomes):
        return BAD_INPUT
    return PASSED if all(o.passed for o in outcomes) else FAILED


def _requirement(args: argparse.Namespace) -> Requirement:
    if not args.ranges:
        raise InputError.of(
            "--l1-range", "is missing; give the lengths to check, for example --l1-range 10:20"
        )
    leg, ends, option = arguments.leg_and_range(args)
    if args.max_cusps is None and args.min_cusps is None:
        raise InputError.of("--max-cusps", "is missing; give --max-cusps or --min-cusps")
    names = {"range": option, "max_cusps": "--max-cusps", "min_cusps": "--min-cusps"}
    limits: dict[str, object] = {}
    for option, text in args.limits:
        limited = option[2:4]
        if limited in limits:
            raise InputError.of(option, "is given twice")
        if limited == f"l{leg}":
            raise InputError.of(option, f"limits the fixed leg; its lengths are --l{leg}-range")
        names[f"limits.{limited}"] = option
        with named(option):
            limits[limited] = split_ends(text, ("min", "max"))
    members = {
        "fixed_leg": leg,
        "range": ends,
        "max_cusps": args.max_cusps,
        "min_cusps": args.min_cusps,
        "limits": limits,
    }
    return read(RequirementDocument, members, arguments.source(names)).to_requirement()


def _jobs(text: str | None) -> int:
    if text is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    expected = f"1 to {_MAX_JOBS}"
    with named("--jobs"):
        jobs = whole_number(text, expected, is_text=True)
        if not 1 <= jobs <= _MAX_JOBS:
            raise InputError.of("", f"is {jobs}; give {expected}")
    return jobs


def expand(sources: Sequence[str]) -> Iterator[str]:
    """The geometries that are named: a folder stands for its JSON files, in the order of their names.

    Raises:
        InputError: a folder without any, or standard input given twice.
    """
    if sources.count("-") > 1:
        raise InputError.of("arguments.GEOMETRY", "is - twice; standard input can be read once")
    for source in sources:
        folder = Path(source)
        if source in MANIPULATORS or source == "-" or not folder.is_dir():
            yield source
            continue
        files = sorted(path for path in folder.iterdir() if path.suffix == ".json" and path.is_file())
        if not files:
            raise InputError.of("arguments.GEOMETRY", f"the folder {source!r} has no *.json")
        yield from map(str, files)


def _check_all(sources: Sequence[str], requirement: Requirement, digits: int, jobs: int) -> list[Outcome]:
    outcomes: dict[int, Outcome] = {}
    manipulators: dict[int, Manipulator] = {}
    names = [os.fsencode(source).decode("utf-8", "replace") for source in sources]  # a file's may be anything
    for i, source in enumerate(sources):
        try:
            manipulators[i] = arguments.manipulator_of(source)
        except InputError as error:
            outcomes[i] = Outcome(names[i], error={"type": "input-error", "detail": str(error)})
    single = len(sources) == 1
    with Progress(1 if single else len(sources), "steps" if single else "geometries") as progress:

        def done(i: int, outcome: Outcome) -> None:
            outcomes[i] = outcome
            progress.update(len(outcomes), len(sources))

        if min(jobs, len(manipulators)) <= 1:
            inside = progress.update if single else None
            for i, manipulator in manipulators.items():
                done(i, run_check(names[i], manipulator, requirement, digits, inside))
        else:
            for i, outcome in _in_processes(names, manipulators, requirement, digits, jobs):
                done(i, outcome)
    return [outcomes[i] for i in range(len(sources))]


def run_check(
    source: str,
    manipulator: Manipulator,
    requirement: Requirement,
    digits: int,
    progress: OnProgress | None = None,
) -> Outcome:
    """Check one geometry."""
    begin = time.monotonic()
    try:
        report: dict[str, Any] | None = rpr_solver.check(
            manipulator, requirement, digits=digits, progress=progress
        ).to_json()
        error = None
    except InputError as failure:
        report, error = None, {"type": "input-error", "detail": str(failure)}
    except SolverError as failure:
        report, error = None, {"type": "solver-error", "detail": str(failure)}
    return Outcome(source, report, error, time.monotonic() - begin)


def _in_processes(
    sources: Sequence[str],
    manipulators: dict[int, Manipulator],
    requirement: Requirement,
    digits: int,
    jobs: int,
) -> Iterator[tuple[int, Outcome]]:
    """The outcomes as they come."""
    executor = ProcessPoolExecutor(min(jobs, len(manipulators)), multiprocessing.get_context("spawn"))
    futures: dict[Future[Outcome], int] = {}
    try:
        # A Ctrl-C is for the command, which ends its processes: they inherit the blocked signal. It must not
        # come while one is half started either.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            for i, manipulator in manipulators.items():
                futures[executor.submit(run_check, sources[i], manipulator, requirement, digits)] = i
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for future in as_completed(futures):
            i = futures[future]
            try:
                yield i, future.result()
            except BrokenProcessPool:
                detail = "a process ended unexpectedly; with fewer --jobs there is more memory for each"
                yield i, Outcome(sources[i], error={"type": "process-lost", "detail": detail})
    except BaseException:
        for child in multiprocessing.active_children():
            child.kill()
        raise
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def _report(outcomes: Sequence[Outcome], requirement: dict[str, Any], args: argparse.Namespace) -> None:
    write_document(document(outcomes, requirement), page(outcomes, requirement), args.format)
    for outcome in outcomes:
        if outcome.error is not None:
            print(
                f"rpr-cusps check: {outcome.source}: no answer ({outcome.error['type']}): {outcome.message}",
                file=sys.stderr,
            )
    if args.github or os.environ.get("GITHUB_ACTIONS") == "true":
        # GitHub reads both streams; a JSON document must stay one
        out = sys.stderr if args.format == "json" else sys.stdout
        out.writelines(line + "\n" for line in github_annotations(outcomes))
    if args.junit is not None:
        try:
            Path(args.junit).write_text(junit_xml(outcomes), encoding="utf-8")
        except OSError as error:
            raise InputError.of("--junit", f"{args.junit!r} cannot be written ({error.strerror})") from None
