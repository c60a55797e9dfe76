"""Chunks that are given back to the heavy lane, with the test acting as the worker."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
from redis import Redis

from tests.support.chunks import entry, finish, refs, work
from tests.support.jobs import a_document, a_heavy_document, a_request, submit_batch, table_of
from tests.worker.jobs.test_lanes import backlog, depths
from worker.answers.kind import JobRequest
from worker.answers.kinds import Item
from worker.jobs.chunks import ChunkRef
from worker.jobs.installation import Roster, read_ends
from worker.jobs.plan import LANES, Lane
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Interruptions, Sweeper
from worker.settings import WorkerSettings

Given = tuple[ChunkRef, Lane]


@pytest.fixture
def strong(queue: JobQueue) -> None:
    """There is a worker for heavy chunks."""
    Roster(queue.redis, queue.settings).beat("strong")


def note(queue: JobQueue, ref: ChunkRef, *, is_new: bool = True, gives_back: bool = True) -> Given | None:
    return queue.attempts.note_overrun(ref, is_new=is_new, gives_back=gives_back)


def give_back(queue: JobQueue, ref: ChunkRef) -> ChunkRef:
    """Give a chunk that is taken from the queue back, as a worker does."""
    queue.chunks.discard(ref)
    given = note(queue, ref)
    assert given is not None
    queue.attempts.end_beat(ref)
    queue.chunks.put_back(*given, is_first=False)
    return given[0]


def backlogs(queue: JobQueue) -> dict[str, int]:
    lanes = LANES
    return {lane: work for lane in lanes if (work := backlog(queue, lane))}


@pytest.mark.usefixtures("strong")
@pytest.mark.parametrize("request_", [a_request("1", "2"), a_document()], ids=["table", "document"])
def test_a_job_of_one_chunk(queue: JobQueue, request_: JobRequest) -> None:
    queue.submit(request_)
    before = backlogs(queue)
    (ref,) = refs(queue)
    queue.attempts.start(ref)
    following = give_back(queue, ref)
    assert depths(queue) == {"heavy": 1}
    assert before.keys() == {"small"}
    assert backlogs(queue) == {"heavy": before["small"]}
    view = queue.get(request_.job_id)
    assert view is not None
    assert (view.status, view.overruns) == ("running", 1)
    told = queue.redis.xrange(queue.records.keys.job(request_.job_id).events)
    assert [fields[b"status"] for _, fields in told] == [b"queued", b"running", b"running"]
    given = entry(queue)
    assert (given.ref, given.state, given.horses_lost, given.workers_lost) == (following, "queued", 0, 0)
    assert note(queue, ref) is None, "the attempt is over"
    queue.attempts.start(following)
    assert note(queue, following) is None, "it is in the heavy lane already"
    queue.cancel(request_.job_id)
    assert backlogs(queue) == {}


@pytest.mark.usefixtures("strong")
def test_what_a_chunk_has_kept_stays(queue: JobQueue, table_request: JobRequest) -> None:
    """And each lane has its own chunks' work, whichever ends first."""
    other = queue.submit(a_request("7", digits=31))
    queue.submit(table_request)
    before = backlogs(queue)
    first, second = (ref for ref in refs(queue) if ref.job_id == table_request.job_id)
    work(queue, first, 1)
    done_one = backlogs(queue)["bulk"]
    following = give_back(queue, first)
    [given] = [e for e in queue.records.open_chunks() if e.ref == following]
    assert given.offset == 1
    after = backlogs(queue)
    assert after["bulk"] + after["heavy"] == done_one
    assert after["heavy"] == pytest.approx(before["bulk"] * 2 / 5, abs=3)
    work(queue, following, 1)
    assert backlogs(queue) == after, "its work is done with its last slice"
    work(queue, following)
    assert "heavy" not in backlogs(queue)
    work(queue, second)
    assert backlogs(queue).keys() == {"small"}
    assert [s["l1"] for s in table_of(queue, table_request.job_id)["slices"]] == ["1", "2", "3", "4", "5"]
    queue.cancel(other.id)


@pytest.mark.usefixtures("strong")
def test_the_rest_of_a_chunk_of_a_batch_goes_to_the_heavy_batches(queue: JobQueue) -> None:
    view = submit_batch(queue, [Item(request=a_request(str(n))) for n in range(1, 6)])
    [first, *_] = refs(queue)
    queue.attempts.start(first)
    give_back(queue, first)
    assert depths(queue) == {"batch": 1, "heavy-batch": 1}
    assert set(backlogs(queue)) == {"batch", "heavy-batch"}
    queue.cancel(view.id)
    assert depths(queue) == {}
    assert backlogs(queue) == {}


@pytest.mark.usefixtures("strong")
def test_a_worker_that_dies_as_it_gives_back(queue: JobQueue) -> None:
    """Between two steps: the sweeper finds the chunk, and its lane, and counts no loss."""
    queue.submit(a_request("1"))
    (ref,) = refs(queue)
    queue.attempts.start(ref)
    queue.chunks.discard(ref)
    assert note(queue, ref) is not None
    sweeper = Sweeper(queue.redis, replace_losses(queue.settings))
    while not depths(queue):
        time.sleep(0.002)
        sweeper.sweep()
    assert depths(queue) == {"heavy": 1}
    assert (entry(queue).workers_lost, entry(queue).horses_lost) == (0, 0)
    assert read_ends(queue.redis.hgetall(queue.records.keys.ends)).lost == {}
    finish(queue)
    view = queue.get(a_request("1").job_id)
    assert view is not None
    assert view.status == "succeeded"


def replace_losses(settings: WorkerSettings) -> WorkerSettings:
    return settings.model_copy(update={"max_worker_losses": 0})


def test_it_stays_where_nobody_else_would_take_it(queue: JobQueue) -> None:
    """It is noted once, and given back once there is a worker for it."""
    Roster(queue.redis, queue.settings).beat("light", is_light=True)
    queue.submit(a_request("1"))
    (ref,) = refs(queue)
    queue.attempts.start(ref)
    assert note(queue, ref) is None
    assert note(queue, ref, is_new=False) is None
    Roster(queue.redis, queue.settings).beat("strong")
    assert note(queue, ref, is_new=False) is not None
    ends = read_ends(queue.redis.hgetall(queue.records.keys.ends))
    assert ends.overruns == {("cusp-table", "left"): 1, ("cusp-table", "given-back"): 1}
    view = queue.get(ref.job_id)
    assert view is not None
    assert view.overruns == 1


@pytest.mark.usefixtures("strong")
def test_a_heavy_chunk_is_only_noted(queue: JobQueue) -> None:
    queue.submit(a_heavy_document())
    (ref,) = refs(queue)
    queue.attempts.start(ref)
    assert note(queue, ref) is None
    assert entry(queue).ref == ref


@pytest.mark.usefixtures("strong")
def test_what_was_given_back_is_put_back_into_its_lane(queue: JobQueue, redis: Redis) -> None:
    """After a loss, too; and a deadline and a cancel find it there."""
    queue.submit(a_request("1"), deadline_s=0.001)
    (ref,) = refs(queue)
    queue.attempts.start(ref)
    following = give_back(queue, ref)
    queue.chunks.discard(following)
    assert queue.attempts.start(following) is not None
    assert Interruptions(queue.redis, queue.settings).run_again(following, "horses", "", "")
    assert depths(queue) == {"heavy": 1}
    assert entry(queue).ref == replace(following, attempt=following.attempt + 1)
    time.sleep(0.005)
    Sweeper(redis, queue.settings).sweep()
    view = queue.get(ref.job_id)
    assert view is not None
    assert view.error is not None
    assert (view.status, view.error["type"]) == ("failed", "timeout")
    assert depths(queue) == {}
    assert backlogs(queue) == {}
