"""Checks of many geometries, in this process or in several."""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

import rpr_solver
from rpr_solver import Manipulator, Requirement
from rpr_solver.errors import InputError, SolverError
from service.cli.check_reports import Outcome
from service.cli.check_sources import Geometry
from service.cli.expectation import Expectation
from service.cli.progress import progress_bar

Demand = Requirement | Expectation
"""What is checked."""


def check_all(geometries: Sequence[Geometry], demand: Demand, digits: int, jobs: int) -> list[Outcome]:
    """Returns the outcomes in the order of the geometries; those that cannot be read are among them."""
    outcomes = unreadable(geometries)
    sound = {i: g.manipulator for i, g in enumerate(geometries) if g.manipulator is not None}
    single = len(geometries) == 1
    checks: Iterator[tuple[int, Outcome]]
    with progress_bar(1 if single else len(geometries), "steps" if single else "geometries") as progress:
        if min(jobs, len(sound)) <= 1:
            inside = progress if single else None
            checks = ((i, _run(geometries[i], m, demand, digits, inside)) for i, m in sound.items())
        else:
            checks = _in_processes(geometries, sound, demand, digits, jobs)
        for i, outcome in checks:
            outcomes[i] = outcome
            if not single:
                progress(len(outcomes), len(geometries))
    return [outcomes[i] for i in range(len(geometries))]


def unreadable(geometries: Sequence[Geometry]) -> dict[int, Outcome]:
    """Returns the outcomes of geometries that cannot be read, by their position."""
    return {
        i: Outcome.of(g, error={"type": "input-error", "detail": g.fault})
        for i, g in enumerate(geometries)
        if g.manipulator is None
    }


def _run(
    geometry: Geometry,
    manipulator: Manipulator,
    demand: Demand,
    digits: int,
    progress: rpr_solver.Progress | None = None,
) -> Outcome:
    begin = time.monotonic()
    report = error = None
    try:
        if isinstance(demand, Expectation):
            report = demand.check(manipulator, digits, progress)
        else:
            report = rpr_solver.check(manipulator, demand, digits=digits, progress=progress).to_json()
    except (InputError, SolverError) as failure:
        kind = "input-error" if isinstance(failure, InputError) else "solver-error"
        error = {"type": kind, "detail": str(failure)}
    return Outcome.of(geometry, report, error, time.monotonic() - begin)


def _in_processes(
    geometries: Sequence[Geometry],
    manipulators: Mapping[int, Manipulator],
    demand: Demand,
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
                futures[executor.submit(_run, geometries[i], manipulator, demand, digits)] = i
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for future in as_completed(futures):
            i = futures[future]
            try:
                yield i, future.result()
            except BrokenProcessPool:
                detail = "a process ended unexpectedly; fewer --jobs leave more memory for each"
                error = {"type": "process-lost", "detail": detail}
                yield i, Outcome.of(geometries[i], error=error)
    except BaseException:
        for child in multiprocessing.active_children():
            child.kill()
        raise
    finally:
        executor.shutdown(cancel_futures=True)  # waits: a pool left to the exit may write to a closed pipe
