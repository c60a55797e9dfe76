"""Checks of many geometries: in this process, in several, or by a running service."""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections import Counter
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

import anyio

from rpr_solver import Manipulator, Requirement, exact_str
from rpr_solver.contract import Progress, silent
from rpr_solver.errors import InputError, SolverError
from rpr_solver.margins.options import OPEN, PROVED, REFUTED
from rpr_solver.transitions.requirement import ALLOWED, REFUSED
from service.cli.arguments import Geometry, source
from service.cli.check.reports import Outcome
from service.cli.digits import apart, are_alike, rounded
from service.cli.output import progress_bar
from service.errors import ServiceError
from service.schemas.censuses import CheckRequest
from service.schemas.curves import MarginRequest
from service.schemas.document import read
from service.schemas.questions import Question
from service.schemas.tables import CuspTableRequest
from worker.answers import Store, answer
from worker.answers.censuses import within_tolerance
from worker.process import stop_signals_held
from worker.process.executor import executor

if TYPE_CHECKING:
    from service.client import AsyncServiceClient


class Checked(NamedTuple):
    """What a check gives.

    Attributes:
        report: the report, if there is no error.
        error: what is in its place.
        shown: the report as a reader sees it, if that differs: ends of windows are not alike.
    """

    report: dict[str, Any] | None
    error: dict[str, str] | None = None
    shown: dict[str, Any] | None = None


_DIGITS_TO_TELL_APART = 100


@dataclass(frozen=True)
class Expectation:
    """A number of cusps in each of these slices.

    Attributes:
        fixed_leg: the leg whose length is fixed.
        lengths: its lengths.
        count: the number of cusps.
        degenerate: "refused" if the slices may have no degenerate points, else "allowed".
    """

    fixed_leg: int
    lengths: tuple[Fraction, ...]
    count: int
    degenerate: str = ALLOWED

    def to_json(self) -> dict[str, Any]:
        """Returns the expectation as the document of a check has it."""
        lengths = list(map(exact_str, self.lengths))
        slices = {"fixed_leg": self.fixed_leg, f"l{self.fixed_leg}": lengths}
        return {**slices, "expect_cusps": self.count, "degenerate": self.degenerate}

    def judge(self, table: Mapping[str, Any]) -> Checked:
        """Returns the report on the slices of a cusp table, or why one of them has no answer."""
        head = {name: value for name, value in table.items() if name != "slices"}
        tables = table["slices"]
        for part in tables:
            if "error" in part:
                return Checked(None, part["error"])
        leg = f"l{self.fixed_leg}"
        slices = [{leg: table[leg], "count": table["count"]} for table in tables]
        wrong = [
            {leg: table[leg], "count": table["count"], "example": {leg: table[leg], "cusps": table["cusps"]}}
            for table in tables
            if table["count"] != self.count
        ]
        counts = [table["count"] for table in tables]
        degenerate = [part for table in tables for part in _degenerate(table, table[leg])]
        report = {
            **head,
            "requirement": self.to_json(),
            "passed": not wrong and not (degenerate and self.degenerate == REFUSED),
            "max_cusps_found": max(counts),
            "min_cusps_found": min(counts),
            "slices": slices,
            "violations": wrong,
            "degenerate": degenerate,
        }
        return Checked(report)


def _degenerate(table: Mapping[str, Any], length: str) -> Iterator[dict[str, Any]]:
    """Yields the curves of degenerate poses of a slice, and the numbers of its other degenerate points."""
    ends, points = {"from": length, "to": length}, table["degenerate_points"]
    curves = [point for point in points if "equation" in point]
    yield from ({"kind": curve["kind"], **ends, "equation": curve["equation"]} for curve in curves)
    kinds = Counter(point["kind"] for point in points if "equation" not in point)
    yield from ({"kind": kind, **ends, "count": count} for kind, count in sorted(kinds.items()))


@dataclass(frozen=True)
class Task:
    """What is checked of each geometry.

    Attributes:
        demand: of its cusps.
        digits: significant digits of reports.
        printed: those of tables.
        tolerance: the greatest change of each length, in canonical text: the demand must hold for every
            geometry within it; None for the given geometry alone.
        deadline: in seconds, of each question to a service.
    """

    demand: Requirement | Expectation
    digits: int
    printed: int
    tolerance: Mapping[str, str] | None = None
    deadline: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Returns the demand as the document of checks has it."""
        tolerance = {} if self.tolerance is None else {"tolerance": dict(self.tolerance)}
        return {**self.demand.to_json(), **tolerance}

    def questions(self, manipulator: Manipulator) -> Generator[Question, Any, Checked]:
        """Yields the questions of a check, and is sent the answer to each."""
        demand, deadline = self.demand, None if self.deadline is None else str(self.deadline)

        def asked(question: type[Question], **members: object) -> Question:
            given = {"geometry": manipulator, "deadline_seconds": deadline, **members}
            return read(question, {k: x for k, x in given.items() if x is not None}, source())

        within: dict[str, Any] = {"tolerance": self.tolerance}
        if not isinstance(demand, Expectation):
            whole, digits = demand.to_json(), self.digits
            report = finer = yield asked(CheckRequest, digits=digits, requirement=whole, **within)
            while are_alike({"violations": finer["violations"]}) and digits < _DIGITS_TO_TELL_APART:
                digits = min(2 * digits, _DIGITS_TO_TELL_APART)
                finer = yield asked(CheckRequest, digits=digits, requirement=whole)
            return Checked(report, shown=apart(rounded(report, self.printed), finer))
        leg, own = f"l{demand.fixed_leg}", {"fixed_leg": demand.fixed_leg}
        lengths = list(map(exact_str, demand.lengths))
        table = yield asked(CuspTableRequest, **own, digits=self.digits, **{leg: lengths})
        judged = demand.judge(table)
        report = judged.report
        if report is None or self.tolerance is None:
            return judged
        margins = []
        for length in lengths if report["passed"] else ():
            margins.append((yield asked(MarginRequest, **own, **{leg: length}, **within)))
        severity = (REFUTED, OPEN, PROVED)
        decisive = min(margins, key=lambda found: severity.index(found["verdict"]), default=None)
        return Checked(within_tolerance(report, decisive, self.tolerance))


def check_all(geometries: Sequence[Geometry], task: Task, jobs: int) -> list[Outcome]:
    """Returns the outcomes in the order of the geometries; those that cannot be read are among them."""
    outcomes = unreadable(geometries)
    sound = {i: g.manipulator for i, g in enumerate(geometries) if g.manipulator is not None}
    single = len(geometries) == 1
    checks: Iterator[tuple[int, Outcome]]
    with progress_bar(1 if single else len(geometries), "steps" if single else "geometries") as progress:
        if min(jobs, len(sound)) <= 1:
            inside = progress if single else silent
            checks = ((i, _run(geometries[i], m, task, inside)) for i, m in sound.items())
        else:
            checks = _in_processes(geometries, sound, task, jobs)
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


def _run(geometry: Geometry, manipulator: Manipulator, task: Task, progress: Progress = silent) -> Outcome:
    begin = time.monotonic()
    questions, answered = task.questions(manipulator), None
    try:
        while True:
            answered = answer(questions.send(answered).job_request(), Store(), progress)
    except StopIteration as end:
        checked = end.value
    except (InputError, SolverError) as failure:
        kind = "input-error" if isinstance(failure, InputError) else "solver-error"
        checked = Checked(None, {"type": kind, "detail": str(failure)})
    return Outcome.of(geometry, *checked, seconds=time.monotonic() - begin)


def _in_processes(
    geometries: Sequence[Geometry], manipulators: Mapping[int, Manipulator], task: Task, jobs: int
) -> Iterator[tuple[int, Outcome]]:
    """Yields the outcomes in the order of completion."""
    with executor(min(jobs, len(manipulators))) as pool:
        futures: dict[Future[Outcome], int] = {}
        try:
            # Only this process handles Ctrl-C and ends the others, which inherit the blocked signal. Blocking
            # also keeps it from arriving while a process is half started.
            with stop_signals_held([signal.SIGINT]):
                for i, manipulator in manipulators.items():
                    futures[pool.submit(_run, geometries[i], manipulator, task)] = i
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


_AT_ONCE = 8
_OF_ONE_QUESTION = (409, 422, 500, 504)
"""Statuses of a response that say nothing about the other geometries."""
_BAD = ("invalid-request", "limit-exceeded", "job-input-error")


def check_by_service(url: str, geometries: Sequence[Geometry], task: Task) -> list[Outcome]:
    """Returns the outcomes in the order of the geometries.

    Raises:
        ServiceError: the service refused, failed, or cannot be reached.
    """
    return anyio.run(_check_all, url, geometries, task)


async def _check_all(url: str, geometries: Sequence[Geometry], task: Task) -> list[Outcome]:
    from service.client import AsyncServiceClient

    outcomes = unreadable(geometries)
    fatal: list[ServiceError] = []
    limiter = anyio.CapacityLimiter(_AT_ONCE)
    try:
        client = AsyncServiceClient(url)
    except ServiceError as error:
        raise InputError.of("--url", str(error)) from None

    async def check(i: int) -> None:
        async with limiter:
            try:
                checked = await _report(client, geometries[i], task)
            except ServiceError as failure:
                if failure.status not in _OF_ONE_QUESTION:
                    fatal.append(failure)
                    group.cancel_scope.cancel()
                    return
                checked = Checked(None, {"type": _kind(failure), "detail": str(failure)})
        outcomes[i] = Outcome.of(geometries[i], *checked)
        progress(len(outcomes), len(geometries))

    with progress_bar(len(geometries), "geometries") as progress:
        async with client, anyio.create_task_group() as group:
            for i, geometry in enumerate(geometries):
                if geometry.manipulator is not None:
                    group.start_soon(check, i)
    if fatal:
        raise fatal[0]
    return [outcomes[i] for i in range(len(geometries))]


def _kind(failure: ServiceError) -> str:
    return "input-error" if failure.problem in _BAD else failure.problem.removeprefix("job-") or "no-answer"


async def _report(client: AsyncServiceClient, geometry: Geometry, task: Task) -> Checked:
    from service.client import Asked

    assert geometry.manipulator is not None
    questions, answered = task.questions(geometry.manipulator), None
    try:
        while True:
            answered = (await client.ask(Asked.of(questions.send(answered)))).document
    except StopIteration as end:
        checked: Checked = end.value
        return checked
