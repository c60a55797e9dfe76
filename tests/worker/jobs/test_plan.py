"""The plan of a job: pure arithmetic."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worker.answers.cost import Cost
from worker.jobs.plan import (
    BATCH_SECONDS,
    MAX_BATCH_CHUNKS,
    MAX_CHUNK_ITEMS,
    MAX_CHUNK_SLICES,
    plan,
    plan_batch,
)


@pytest.mark.parametrize(
    ("cost", "parts", "lane", "count"),
    [
        (Cost(0.0, 0.002, 1), 1, "small", 1),
        (Cost(0.1, 0.01, 130), 130, "small", 2),
        (Cost(0.1, 0.01, 1000), 1000, "heavy", 10),
        (Cost(0.0, 8.0, 4), 4, "heavy", 4),
    ],
)
def test_the_plan_of_a_question(cost: Cost, parts: int, lane: str, count: int) -> None:
    made = plan(cost, range(parts))
    assert (made.lane, len(made.chunks)) == (lane, count)
    assert made.seconds == pytest.approx(cost.of(parts))
    assert max(last - first + 1 for first, last in made.chunks) <= MAX_CHUNK_SLICES


def test_known_parts_are_in_no_chunk_or_between_its_ends() -> None:
    assert plan(Cost(0.0, 0.4, 6), [0, 2, 3, 7]).chunks == ((0, 2), (3, 7))
    assert plan(Cost(0.0, 0.4, 6), []).chunks == ()


@given(st.lists(st.floats(0, 30), min_size=1, max_size=300), st.integers(1, 9))
def test_each_item_is_in_one_chunk_of_about_equal_work(costs: list[float], workers: int) -> None:
    of = {2 * position: cost for position, cost in enumerate(costs)}
    made = plan_batch(of, workers)
    assert made.lane == "batch"
    chunks = [[x for x in of if first <= x <= last] for first, last in made.chunks]
    assert [x for chunk in chunks for x in chunk] == list(of)
    assert len(chunks) <= MAX_BATCH_CHUNKS + 1
    for chunk in chunks:
        assert 0 < len(chunk) <= MAX_CHUNK_ITEMS
        assert len(chunk) == 1 or sum(of[x] for x in chunk) <= 1.01 * BATCH_SECONDS


def test_short_batches_are_shared_by_the_workers() -> None:
    assert len(plan_batch(dict.fromkeys(range(100), 0.01), 4).chunks) == 4
    assert len(plan_batch(dict.fromkeys(range(10), 0.001), 4).chunks) == 1
    assert plan_batch({}).chunks == ()
