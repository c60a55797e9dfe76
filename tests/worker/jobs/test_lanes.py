from __future__ import annotations

import pytest

from worker.answers.cost import Cost
from worker.jobs.lanes import LANES, lanes_of, plan
from worker.settings import WorkerSettings

SETTINGS = WorkerSettings(chunk_size=40, chunk_seconds=1.0, heavy_seconds=1.5)


@pytest.mark.parametrize(
    ("cost", "parts", "lane", "size", "count"),
    [
        (Cost(0.1, 0.01), 1, "small", 1, 1),
        (Cost(0.1, 0.01), 40, "small", 40, 1),
        (Cost(0.1, 0.01), 41, "bulk", 21, 2),  # as many slices as may be, and chunks of equal size
        (Cost(0.1, 0.1), 30, "bulk", 10, 3),  # a second of work each
        (Cost(0.1, 0.6), 3, "bulk", 1, 3),
        (Cost(0.1, 2.0), 1, "heavy", 1, 1),  # a document, or a slice in long numbers
        (Cost(0.0, 900.0), 3, "heavy", 1, 3),
        (Cost(5.0, 0.01), 100, "heavy", 34, 3),  # a long elimination
        (Cost(0.1, 0.01), 0, "small", 1, 0),
    ],
)
def test_the_plan_of_a_job(cost: Cost, parts: int, lane: str, size: int, count: int) -> None:
    job = plan(cost, parts, SETTINGS)
    assert (job.lane, job.chunk_size, job.chunk_count) == (lane, size, count)
    assert job.seconds == (cost.of(parts) if parts else 0)


def test_duties() -> None:
    light = lanes_of("light")
    assert all(set(order) == {"small", "bulk", "batch"} for order in light)
    orders = lanes_of("all")
    assert all(set(order) == set(LANES) for order in orders)
    assert {order[0] for order in (*light, *orders)} == {"small"}
    assert {order[1] for order in orders} == set(LANES) - {"small"}  # they take turns
