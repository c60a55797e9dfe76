"""Prove or refute a requirement: a maximum or minimum number of cusps in every slice of a range of lengths.

Several geometries are checked in parallel; a folder stands for its *.json files. With limits on the other
legs, only cusps strictly within them are counted."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
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
from service.cli.pages import write_document
from service.cli.progress import progress_bar
from service.schemas.checks import RequirementDocument
from service.schemas.document import named, part, read
from service.schemas.lengths import split_ends
from service.schemas.numbers import Digits, whole_number
from worker.process.os_limits import usable_cores

DESCRIPTION = f"""{__doc__}

{arguments.GEOMETRY}

Exit status: 0 all pass, 1 a requirement is violated or could not be decided, 2 bad input."""
EXAMPLES = """\
examples:
  rpr-cusps check innocenti --l1-range 28:31 --max-cusps 8
  rpr-cusps check designs/ --l1-range 10:20 --max-cusps 0 --junit report.xml
  rpr-cusps check a.json b.json --l1-range 10: --min-cusps 1 --l2-limits 5:40 --format json

On GitHub Actions, each geometry that does not pass is annotated.
"""

PASSED, FAILED, BAD_INPUT = 0, 1, 2
_MAX_JOBS = 1024


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    text = "a JSON file, a folder, -, or a built-in name"
    parser.add_argument("geometry", metavar="GEOMETRY", nargs="+", help=text)
    arguments.add_ranges(parser, "the range of lengths to check; either end may be omitted")
    parser.add_argument(
        "--max-cusps", metavar="N", help="maximum number of cusps in any slice; 0 requires a cusp-free range"
    )
    parser.add_argument("--min-cusps", metavar="N", help="minimum number of cusps in any slice")
    arguments.add_options(parser, "--l{}-limits", "limits", "A:B", "joint limits of another leg")
    arguments.add_digits(parser, CHECK_DIGITS)
    arguments.add_format(parser)
    parser.add_argument("--junit", metavar="FILE", help="write JUnit XML, with a test case per geometry")
    parser.add_argument(
        "--github", action="store_true", help="print GitHub annotations (default on GitHub Actions)"
    )
    parser.add_argument("--jobs", metavar="N", help="number of processes (default: one per core)")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status. A faulty geometry is reported among the outcomes."""
    digits = CHECK_DIGITS if args.digits is None else args.digits
    with named("digits"):
        digits = part(TypeAdapter(Digits).validate_python, digits, arguments.source())
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
        hint = "give the lengths to check, for example --l1-range 10:20"
        raise InputError.of("--l1-range", f"is missing; {hint}")
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
    bounds = {"max_cusps": args.max_cusps, "min_cusps": args.min_cusps}
    members = {"fixed_leg": leg, "range": ends, "limits": limits, **bounds}
    return read(RequirementDocument, members, arguments.source(names)).to_requirement()


def _jobs(text: str | None) -> int:
    if text is None:
        return usable_cores()
    expected = f"1 to {_MAX_JOBS}"
    with named("--jobs"):
        jobs = whole_number(text, expected, is_text=True)
        if not 1 <= jobs <= _MAX_JOBS:
            raise InputError.of("", f"is {jobs}; give {expected}")
    return jobs


def expand(sources: Sequence[str]) -> Iterator[str]:
    """Yields the geometries; a folder stands for its JSON files, sorted by name.

    Raises:
        InputError: a folder without JSON files, or a second `-`.
    """
    if sources.count("-") > 1:
        raise InputError.of("GEOMETRY", "is - twice; standard input can be read only once")
    for source in sources:
        folder = Path(source)
        if source in MANIPULATORS or source == "-" or not folder.is_dir():
            yield source
            continue
        files = sorted(path for path in folder.iterdir() if path.suffix == ".json" and path.is_file())
        if not files:
            raise InputError.of("GEOMETRY", f"the folder {source!r} has no *.json files")
        yield from map(str, files)


def _check_all(sources: Sequence[str], requirement: Requirement, digits: int, jobs: int) -> list[Outcome]:
    outcomes: dict[int, Outcome] = {}
    checks: Iterator[tuple[int, Outcome]]
    manipulators: dict[int, Manipulator] = {}
    # file names are arbitrary bytes
    names = [os.fsencode(source).decode("utf-8", "replace") for source in sources]
    for i, source in enumerate(sources):
        try:
            manipulators[i] = arguments.manipulator_of(source)
        except InputError as error:
            outcomes[i] = Outcome(names[i], error={"type": "input-error", "detail": str(error)})
    single = len(sources) == 1
    with progress_bar(1 if single else len(sources), "steps" if single else "geometries") as progress:
        if min(jobs, len(manipulators)) <= 1:
            inside = progress if single else None
            checks = (
                (i, run_check(names[i], m, requirement, digits, inside)) for i, m in manipulators.items()
            )
        else:
            checks = _in_processes(names, manipulators, requirement, digits, jobs)
        for i, outcome in checks:
            outcomes[i] = outcome
            progress(len(outcomes), len(sources))
    return [outcomes[i] for i in range(len(sources))]


def run_check(
    source: str,
    manipulator: Manipulator,
    requirement: Requirement,
    digits: int,
    progress: rpr_solver.Progress | None = None,
) -> Outcome:
    """Check one geometry."""
    begin = time.monotonic()
    report = error = None
    try:
        report = rpr_solver.check(manipulator, requirement, digits=digits, progress=progress).to_json()
    except (InputError, SolverError) as failure:
        kind = "input-error" if isinstance(failure, InputError) else "solver-error"
        error = {"type": kind, "detail": str(failure)}
    return Outcome(source, report, error, time.monotonic() - begin)


def _in_processes(
    sources: Sequence[str],
    manipulators: dict[int, Manipulator],
    requirement: Requirement,
    digits: int,
    jobs: int,
) -> Iterator[tuple[int, Outcome]]:
    """Yields the outcomes in the order of completion."""
    executor = ProcessPoolExecutor(min(jobs, len(manipulators)), multiprocessing.get_context("spawn"))
    futures: dict[Future[Outcome], int] = {}
    try:
        # Only this process handles Ctrl-C and ends the others, which inherit the blocked signal. Blocking
        # also keeps it from arriving while a process is half started.
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
                detail = "a process ended unexpectedly; fewer --jobs leave more memory for each"
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
            where = f"rpr-cusps check: {outcome.source}"
            print(f"{where}: no answer ({outcome.error['type']}): {outcome.message}", file=sys.stderr)
    if args.github or os.environ.get("GITHUB_ACTIONS") == "true":
        # GitHub reads both streams, and stdout must stay a single JSON document
        out = sys.stderr if args.format == "json" else sys.stdout
        out.writelines(line + "\n" for line in github_annotations(outcomes))
    if args.junit is not None:
        try:
            Path(args.junit).write_text(junit_xml(outcomes), encoding="utf-8")
        except OSError as error:
            raise InputError.of("--junit", f"{args.junit!r} cannot be written ({error.strerror})") from None
