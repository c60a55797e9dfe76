"""Checks of many geometries by a running service, several at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import anyio

from rpr_solver.errors import InputError
from service.cli.check_reports import Outcome
from service.cli.check_run import Demand, unreadable
from service.cli.check_sources import Geometry
from service.cli.expectation import Expectation
from service.cli.progress import progress_bar
from service.errors import ServiceError

if TYPE_CHECKING:  # httpx is slow to load
    from service.client import AsyncServiceClient

_AT_ONCE = 8
_OF_ONE_QUESTION = (409, 422, 500, 504)
"""Statuses of a response that say nothing about the other geometries."""
_BAD = ("invalid-request", "limit-exceeded", "job-input-error")


def check_by_service(
    url: str, geometries: Sequence[Geometry], demand: Demand, digits: int, deadline: float | None
) -> list[Outcome]:
    """Returns the outcomes in the order of the geometries.

    Raises:
        ServiceError: the service refused, failed, or cannot be reached.
    """
    return anyio.run(_check_all, url, geometries, demand, digits, deadline)


async def _check_all(
    url: str, geometries: Sequence[Geometry], demand: Demand, digits: int, deadline: float | None
) -> list[Outcome]:
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
                report, error = await _report(client, geometries[i], demand, digits, deadline), None
            except ServiceError as failure:
                if failure.status not in _OF_ONE_QUESTION:
                    fatal.append(failure)
                    group.cancel_scope.cancel()
                    return
                report, error = None, {"type": _kind(failure), "detail": str(failure)}
        outcomes[i] = Outcome.of(geometries[i], report, error)
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


async def _report(
    client: AsyncServiceClient, geometry: Geometry, demand: Demand, digits: int, deadline: float | None
) -> dict[str, Any]:
    from service.client import check, cusp_table

    manipulator = geometry.manipulator
    assert manipulator is not None
    if not isinstance(demand, Expectation):
        return (await client.ask(check(manipulator, demand, digits=digits, deadline=deadline))).document
    leg = demand.fixed_leg
    asked = cusp_table(manipulator, demand.lengths, fixed_leg=leg, digits=digits, deadline=deadline)
    table = (await client.ask(asked)).document
    for part in table["slices"]:
        if "error" in part:
            error = part["error"]
            raise ServiceError(error["detail"], status=422, problem=error["type"])
    slices = table.pop("slices")
    return demand.report(table, slices)
