"""A batch that is being received, with the test acting as the API and the worker."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from tests.support.jobs import a_request, depth
from worker.answers.kinds import Item, Outcome, new_batch
from worker.jobs.batches import INTAKE_TTL, Batches, ItemsLostError, Reception
from worker.jobs.chunks import ChunkRef
from worker.jobs.clients import ACTIVE, Bytes
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Sweeper

BAD = Item("bad", problem={"type": "/problems/invalid-request", "status": 422})
SIZE = Bytes(100, 50)


class Received(Reception):
    """A batch of equal items, each of the same cost."""

    def __init__(self, queue: JobQueue) -> None:
        super().__init__(queue.redis, queue.settings, new_batch())
        self.queue = queue
        self.count = 0
        self.costs: dict[int, float] = {}

    def take(self, count: int, seconds: float = 0.1, bad: Sequence[Item] = ()) -> Received:
        """Push items, the invalid ones last."""
        items = [*(Item(request=a_request(str(self.count + i + 1))) for i in range(count)), *bad]
        self.push([item.to_texts() for item in items])
        self.costs = {self.count + i: seconds for i in range(count)}
        self.count += len(items)
        return self

    def hand_on(self) -> bool:
        """Give them to the workers."""
        return self.give(self.count, self.costs, SIZE)

    def answer(self, refs: Sequence[ChunkRef]) -> None:
        """Answer all items of chunks."""
        batches = Batches(self.queue.redis, self.queue.settings)
        for ref in refs:
            chunk = self.queue.attempts.start(ref)
            assert chunk is not None
            assert len(batches.items_of(ref, chunk)) == len(chunk.parts)
            batches.put_items(ref, chunk, 0, [Outcome()] * len(chunk.parts))


def refs(queue: JobQueue) -> list[ChunkRef]:
    return sorted((entry.ref for entry in queue.records.open_chunks()), key=lambda ref: ref.index)


def backlog(queue: JobQueue, lane: str) -> int:
    added, done = queue.redis.hmget(queue.records.keys.work, [f"{lane}:added", f"{lane}:done"])  # type: ignore[misc]
    return int(added or 0) - int(done or 0)


def nothing_is_left(queue: JobQueue) -> bool:
    return (
        not queue.redis.keys("cusps:job*")
        and not queue.redis.zcard(queue.records.keys.active)
        and (not depth(queue) and not queue.redis.exists(queue.records.keys.work))
    )


def test_workers_begin_while_it_is_received(queue: JobQueue) -> None:
    """Whatever they do meanwhile, others see the batch once it is complete, and as one."""
    received = Received(queue).take(25)
    assert received.hand_on()
    first = refs(queue)
    assert depth(queue) == len(first) == 9
    received.answer(first)
    assert refs(queue) == []  # no chunk is open, and yet it is not over
    assert received.take(3, bad=[BAD]).hand_on()
    assert queue.get(received.job_id) is None
    for statuses in (ACTIVE, frozenset({"succeeded", "failed"})):
        assert not queue.listing.page("batches", None, statuses, "", 9).items  # type: ignore[arg-type]
    view = received.take(2, bad=[BAD, BAD]).begin(received.count, received.costs, SIZE)
    assert (view.status, view.done, view.total, view.failed, view.deadline_at) == ("running", 28, 33, 3, None)
    assert [x.view.id for x in queue.listing.page("batches", None, ACTIVE, "", 9).items] == [view.id]
    assert [ref.index for ref in refs(queue)] == [9, 10]
    assert queue.redis.ttl(queue.records.keys.job(view.id).items) == -1
    assert backlog(queue, "batch") == 500
    received.answer(refs(queue))
    done = queue.get(view.id)
    assert done is not None
    assert (done.status, done.done, done.failed) == ("succeeded", 33, 3)
    stored = Batches(queue.redis, queue.settings).read(view.id, range(33))
    assert [s.index for s in stored if s.state == "failed"] == [28, 31, 32]
    assert sum(s.state == "succeeded" for s in stored) == 30


def test_all_is_done_before_the_last_piece_comes(queue: JobQueue) -> None:
    received = Received(queue).take(4)
    assert received.hand_on()
    received.answer(refs(queue))
    view = received.begin(4, {})
    assert (view.status, view.done, view.total) == ("succeeded", 4, 4)


@pytest.mark.parametrize(("given_before", "chunks"), [(0, 3), (25, 4)])
def test_the_last_chunks_of_a_long_batch_are_short(queue: JobQueue, given_before: int, chunks: int) -> None:
    """Eight items of 0.1 s, at most three to a chunk: at the end of a long batch 0.25 s to a chunk."""
    received = Received(queue).take(given_before)
    assert received.hand_on() == bool(given_before)
    before = len(refs(queue))
    received.take(8).begin(received.count, received.costs)
    assert len(refs(queue)) - before == chunks


def lapse(queue: JobQueue, received: Received) -> None:
    """The process that received it is gone, and its time is over."""
    keys = queue.records.keys
    assert 0 < queue.redis.zscore(keys.deadlines, received.job_id) - queue.redis.time()[0] <= INTAKE_TTL + 1  # type: ignore[operator,index]
    queue.redis.zadd(keys.deadlines, {received.job_id: 1})
    queue.redis.hset(keys.job(received.job_id).record, "deadline", 1)
    queue.redis.delete(keys.sweep_lock)
    Sweeper(queue.redis, queue.settings).sweep()


@pytest.mark.parametrize("end", [lapse, lambda _, received: received.drop()])
@pytest.mark.parametrize("has_begun", [False, True])
def test_nothing_is_left_of_one_that_never_begins(
    queue: JobQueue, end: Callable[[JobQueue, Received], None], has_begun: bool
) -> None:
    received = Received(queue).take(25)
    assert received.hand_on()
    some, *_ = refs(queue)
    chunk = None
    if has_begun:
        assert queue.chunks.pop(("batch",)) == some.rq_id
        chunk = queue.attempts.start(some)
    end(queue, received)
    assert nothing_is_left(queue)
    if chunk is not None:  # its worker learns that
        assert not queue.attempts.beat(some, "worker")
        assert not Batches(queue.redis, queue.settings).put_items(some, chunk, 0, [Outcome()])
    with pytest.raises(ItemsLostError):
        received.take(1).begin(received.count, received.costs)
    received.drop()
    assert nothing_is_left(queue)


def test_long_chunks_wait_until_all_is_known(queue: JobQueue) -> None:
    assert not Received(queue).take(3, seconds=2.0).hand_on()
    assert not Received(queue).take(130, seconds=0.9).hand_on()
    assert not depth(queue)


def test_long_items_after_short_ones_are_heavy(queue: JobQueue) -> None:
    received = Received(queue).take(25)
    assert received.hand_on()
    light = refs(queue)
    assert not received.take(3, seconds=20.0).hand_on()
    view = received.begin(received.count, received.costs)
    heavy = refs(queue)[len(light) :]
    assert [queue.attempts.lane(ref) for ref in heavy] == ["heavy-batch"] * 3
    assert {queue.attempts.lane(ref) for ref in light} == {"batch"}
    assert (backlog(queue, "batch"), backlog(queue, "heavy-batch")) == (2500, 60_000)
    assert view.estimate_s == 62.5
    received.answer(heavy)
    assert (backlog(queue, "batch"), backlog(queue, "heavy-batch")) == (2500, 0)
    received.answer(light[:2])
    assert backlog(queue, "batch") == 100 * (25 - 2 * queue.settings.chunk_size)


def test_a_full_lane_refuses_the_rest(queue: JobQueue) -> None:
    """What was given is ended; before the end it is only not given."""
    from worker.jobs.plan import QueueFullError

    queue.settings = queue.settings.model_copy(update={"max_backlog": 5.0})
    other, received = Received(queue).take(25), Received(queue).take(20)
    assert received.hand_on()
    assert other.hand_on()
    assert not received.take(25).hand_on()
    with pytest.raises(QueueFullError):
        received.begin(received.count, received.costs)
    received.drop()
    other.begin(25, {})
    assert {ref.job_id for ref in refs(queue)} == {other.job_id}
