"""The plan of a job: its lane and its chunks, by estimated cost. It is pure arithmetic."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from worker.answers.cost import Cost
from worker.settings import Duty, WorkerSettings

Lane = Literal["small", "heavy", "batch"]
"""`small`: questions that are short as a whole; `heavy`: longer ones; `batch`: all chunks of batches."""

LANES: tuple[Lane, ...] = get_args(Lane)

SMALL_SECONDS = 1.5
"""Estimated seconds of a whole question up to which it is small: fewer than it may take (`SMALL_LIMIT`)."""

SMALL_LIMIT = 2
"""Seconds that a chunk of the lane `small` may take; then its question is heavy. RQ counts whole seconds."""

CHUNK_SECONDS, MAX_CHUNK_SLICES = 1.0, 512
"""Estimated seconds, and slices, of a chunk of a table: enough that its start costs nothing, and little
enough that all workers share a table."""

BATCH_SECONDS, MAX_CHUNK_ITEMS = 2.0, 1000
"""The same of a batch: what heavier work waits for a worker that has begun with a batch."""

MAX_BATCH_CHUNKS = 1000
"""Chunks of a batch, so that its creation in one transaction does not delay others."""

WORTH_SECONDS = 0.05
"""Seconds of work for which one more worker begins a chunk."""


@dataclass(frozen=True)
class Plan:
    """How a job is computed.

    Attributes:
        lane: the lane of its chunks.
        chunks: the first and the last position of each chunk. What is between them and known already is done.
        seconds: the estimated work, in seconds of one core.
    """

    lane: Lane
    chunks: tuple[tuple[int, int], ...]
    seconds: float


class QueueFullError(Exception):
    """The lane of a new job holds too much work.

    Attributes:
        lane: the lane.
        seconds: the estimated time that its workers need for that work.
    """

    def __init__(self, lane: Lane, seconds: float) -> None:
        self.lane, self.seconds = lane, seconds
        super().__init__(f"the lane {lane} of the queue is full")


def plan(cost: Cost, positions: Sequence[int]) -> Plan:
    """Returns the plan of a question whose parts at these positions are to be computed.

    A chunk is about `CHUNK_SECONDS` of work, without what is computed once for all chunks.
    """
    most = max(1, min(MAX_CHUNK_SLICES, int(CHUNK_SECONDS / max(cost.each, 1e-9))))
    count = -(-len(positions) // most)
    size = -(-len(positions) // count) if count else 1
    groups = (positions[first : first + size] for first in range(0, len(positions), size))
    seconds = cost.of(len(positions)) if positions else 0.0
    lane: Lane = "small" if seconds <= SMALL_SECONDS else "heavy"
    return Plan(lane, tuple((group[0], group[-1]) for group in groups), seconds)


def plan_batch(costs: Mapping[int, float], workers: int = 1) -> Plan:
    """Returns the plan of a batch from the estimated seconds of each item, by position in ascending order.

    A chunk is about `BATCH_SECONDS` of work, or one item. Short work is shared by all workers.
    """
    total = sum(costs.values())
    shares = max(1, min(workers, int(total / WORTH_SECONDS), len(costs)))
    most = max(min(BATCH_SECONDS, total / shares), total / MAX_BATCH_CHUNKS)
    items = max(MAX_CHUNK_ITEMS, -(-len(costs) // MAX_BATCH_CHUNKS))
    return Plan("batch", tuple(_cut(costs, most, items)), total)


def _cut(costs: Mapping[int, float], seconds: float, items: int) -> Iterator[tuple[int, int]]:
    """Yields the ends of groups of neighbours, each of at most this work and number, or of one item.

    Invariant: all items before `first` are in a group that was yielded.
    """
    first, last, work, count = -1, -1, 0.0, 0
    for position, cost in costs.items():
        if count and (count == items or work + cost > seconds * 1.001):  # as if sums were exact
            yield first, last
            count = 0
        if not count:
            first, work = position, 0.0
        last, work, count = position, work + cost, count + 1
    if count:
        yield first, last


def queue_name(lane: Lane, settings: WorkerSettings) -> str:
    """Returns the name of a lane's RQ queue.

    Each version of the solver has its own, so a worker never takes a chunk of another version.
    """
    return f"{settings.key_prefix}-{settings.solver_version}-{lane}"


def lanes_of(duty: Duty) -> tuple[Lane, ...]:
    """Returns the lanes of a worker in their order: all of them, or with light duty only the first.

    So small questions go before all others, and of two or more workers one never does anything else.
    """
    return ("small",) if duty == "light" else LANES
