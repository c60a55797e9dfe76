"""`rpr-cusps check`: many geometries against one requirement, in parallel."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rpr_solver
from rpr_solver import EXAMPLES, Manipulator, Requirement
from rpr_solver.errors import InputError, SolverError
from service.cli.analyse import digits_option, leg_and_range
from service.cli.check_reports import Outcome, document, github_annotations, junit_xml, page
from service.cli.pages import Progress, write_document
from service.cli.solve import read_geometry
from service.schemas.document_requests import CHECK_DIGITS
from service.schemas.exact_json import JsonNumber
from service.schemas.limits import Limits
from service.schemas.numbers import whole
from service.schemas.ranges import parse_open_range

PASSED, FAILED, BAD_INPUT = 0, 1, 2
_MAX_JOBS = 1024

OnProgress = Callable[[int, int], None]


@dataclass(frozen=True)
class CheckOptions:
    """The options of the command, as they were written."""

    sources: Sequence[str]
    ranges: Sequence[tuple[str, str]]
    limits: Sequence[tuple[str, str]]
    fixed_leg: str | None
    max_cusps: str | None
    min_cusps: str | None
    digits: str | None
    form: str
    junit: str | None
    github: bool
    jobs: str | None


def check(options: CheckOptions) -> int:
    """Run the command; returns the exit status.

    Raises:
        InputError: naming the option at fault; a geometry at fault is told among the outcomes.
    """
    limits = Limits()
    digits = digits_option(options.digits, limits, CHECK_DIGITS)
    requirement = _requirement(options, limits)
    jobs = _jobs(options.jobs)
    sources = list(expand(options.sources))
    outcomes = _check_all(sources, requirement, digits, jobs, limits)
    _report(outcomes, requirement.to_json(), options)
    if any(o.error is not None and o.error["type"] == "input-error" for o in outcomes):
        return BAD_INPUT
    return PASSED if all(o.passed for o in outcomes) else FAILED


def expand(sources: Sequence[str]) -> Iterator[str]:
    """The geometries that are named: a folder stands for its JSON files, in the order of their names.

    Raises:
        InputError: a folder without any, or standard input given twice.
    """
    if sources.count("-") > 1:
        raise InputError.of("GEOMETRY", "is - twice; standard input can be read once")
    for source in sources:
        folder = Path(source)
        if source in EXAMPLES or source == "-" or not folder.is_dir():
            yield source
            continue
        found = sorted(path for path in folder.iterdir() if path.suffix == ".json" and path.is_file())
        if not found:
            raise InputError.of("GEOMETRY", f"the folder {source!r} has no *.json")
        yield from map(str, found)


def _check_all(
    sources: Sequence[str], requirement: Requirement, digits: int, jobs: int, limits: Limits
) -> list[Outcome]:
    outcomes: dict[int, Outcome] = {}
    manipulators: dict[int, Manipulator] = {}
    names = [os.fsencode(source).decode("utf-8", "replace") for source in sources]  # a file's may be anything
    for i, source in enumerate(sources):
        try:
            manipulators[i] = read_geometry(source, limits)
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
    except InputError as found:
        report, error = None, {"type": "input-error", "detail": str(found)}
    except SolverError as found:
        report, error = None, {"type": "solver-error", "detail": str(found)}
    return Outcome(source, report, error, time.monotonic() - begin)


def _in_processes(
    sources: Sequence[str],
    manipulators: dict[int, Manipulator],
    requirement: Requirement,
    digits: int,
    jobs: int,
) -> Iterator[tuple[int, Outcome]]:
    """The outcomes as they come. Geometries are sent as JSON."""
    executor = ProcessPoolExecutor(min(jobs, len(manipulators)), multiprocessing.get_context("spawn"))
    futures: dict[Future[Outcome], int] = {}
    try:
        # A Ctrl-C is for the command, which ends its processes: they inherit the blocked signal. It must not
        # come while one is half started either.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            for i, manipulator in manipulators.items():
                sent = sources[i], manipulator.to_json(), requirement.to_json(), digits
                futures[executor.submit(_run_sent, *sent)] = i
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


def _run_sent(source: str, geometry: dict[str, str], requirement: dict[str, Any], digits: int) -> Outcome:
    manipulator = Manipulator.from_json(geometry)
    return run_check(source, manipulator, Requirement.from_json(requirement), digits)


def _requirement(options: CheckOptions, limits: Limits) -> Requirement:
    if not options.ranges:
        raise InputError.of(
            "--l1-range", "is missing; give the lengths to check, for example --l1-range 10:20"
        )
    leg, lengths = leg_and_range(options.ranges, options.fixed_leg, limits)
    if options.max_cusps is None and options.min_cusps is None:
        raise InputError.of("--max-cusps", "is missing; give --max-cusps or --min-cusps")
    bounds = {}
    for option, text in options.limits:
        if int(option[3]) in bounds:
            raise InputError.of(option, "is given twice")
        if int(option[3]) == leg:
            raise InputError.of(option, f"limits the fixed leg; its lengths are --l{leg}-range")
        bounds[int(option[3])] = parse_open_range(text, option, limits)
    return Requirement(
        leg,
        lengths.start,
        lengths.stop,
        _count(options.max_cusps, "--max-cusps"),
        _count(options.min_cusps, "--min-cusps"),
        bounds,
    )


def _count(text: str | None, option: str) -> int | None:
    if text is None:
        return None
    found = whole(JsonNumber(text), option, "of cusps, 0 or more")
    if found < 0:
        raise InputError.of(option, f"is {found}; a number of cusps is at least 0")
    return found


def _jobs(text: str | None) -> int:
    if text is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    found = whole(JsonNumber(text), "--jobs", f"1 to {_MAX_JOBS}")
    if not 1 <= found <= _MAX_JOBS:
        raise InputError.of("--jobs", f"is {found}; give 1 to {_MAX_JOBS}")
    return found


def _report(outcomes: Sequence[Outcome], requirement: dict[str, Any], options: CheckOptions) -> None:
    write_document(document(outcomes, requirement), page(outcomes, requirement), options.form)
    for outcome in outcomes:
        if outcome.error is not None:
            print(
                f"rpr-cusps check: {outcome.source}: no answer ({outcome.error['type']}): {outcome.message}",
                file=sys.stderr,
            )
    if options.github or os.environ.get("GITHUB_ACTIONS") == "true":
        # GitHub reads both streams; a JSON document must stay one
        out = sys.stderr if options.form == "json" else sys.stdout
        out.writelines(line + "\n" for line in github_annotations(outcomes))
    if options.junit is not None:
        try:
            Path(options.junit).write_text(junit_xml(outcomes), encoding="utf-8")
        except OSError as error:
            raise InputError.of(
                "--junit", f"{options.junit!r} cannot be written ({error.strerror})"
            ) from None
