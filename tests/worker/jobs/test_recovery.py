"""Chunks and jobs that were lost, and what the sweeper and the workers make of them."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
from redis import Redis

from tests.support.chunks import entry, finish, refs, work
from tests.support.jobs import a_document, a_request, depth, table_of
from tests.support.processes import until
from worker.answers.kind import JobRequest
from worker.jobs import upkeep
from worker.jobs.chunks import ChunkRef, Lost
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Interruptions, Sweeper
from worker.settings import WorkerSettings


def test_a_chunk_that_no_worker_runs_is_put_back(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    queue.redis.delete(queue.chunks.queues["bulk"].key)
    sweeper = Sweeper(queue.redis, queue.settings)
    sweeper.sweep()
    assert depth(queue) == 0  # only suspected
    time.sleep(0.01)
    assert sweeper.sweep() == 2
    assert depth(queue) == 2
    assert [(e.ref.attempt, e.workers_lost) for e in queue.records.open_chunks()] == [(1, 0), (1, 0)]
    finish(queue)
    assert queue.result(table_request.job_id) is not None


def test_a_chunk_with_a_heartbeat_is_left_alone(queue: JobQueue) -> None:
    request = a_request("1")
    queue.submit(request)
    (ref,) = refs(queue)
    queue.redis.delete(queue.chunks.queues["small"].key)
    queue.redis.set(queue.records.keys.beat(ref.rq_id), "worker")
    sweeper = Sweeper(queue.redis, queue.settings)
    for _ in range(3):
        time.sleep(0.01)
        assert sweeper.sweep() == 0


def test_a_job_without_chunks_fails(queue: JobQueue, table_request: JobRequest) -> None:
    view = queue.submit(table_request)
    work(queue, refs(queue)[0], 1)
    queue.redis.delete(queue.records.keys.job(view.id).chunks)
    Sweeper(queue.redis, queue.settings).sweep()
    failed = queue.get(view.id)
    assert failed is not None
    assert failed.error is not None
    assert (failed.status, failed.error["type"]) == ("failed", "worker-lost")
    assert queue.redis.zcard(queue.records.keys.active) == 0
    assert queue.submit(table_request).done == 1
    finish(queue)
    assert queue.result(view.id) is not None


def test_a_dead_job_is_not_joined(queue: JobQueue, table_request: JobRequest) -> None:
    first = queue.submit(table_request)
    queue.redis.delete(queue.records.keys.job(first.id).chunks)
    again = queue.submit(table_request)
    assert (again.status, again.run != first.run) == ("queued", True)
    finish(queue)
    assert queue.result(first.id) is not None


def test_a_job_that_lost_its_place_is_found_again(
    queue: JobQueue, table_request: JobRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many other keys there are: each look goes on where the last one stopped, whoever made it."""
    monkeypatch.setattr(upkeep, "_WALK", 10)
    queue.redis.mset({f"other:{i}": i for i in range(300)})
    view = queue.submit(table_request)
    queue.redis.delete(queue.records.keys.active, queue.chunks.queues["bulk"].key)
    until(lambda: Sweeper(queue.redis, queue.settings).sweep() == 2)
    assert queue.redis.zscore(queue.records.keys.active, view.id) is not None
    assert depth(queue) == 2
    finish(queue)
    assert queue.result(view.id) is not None


def test_a_job_that_is_joined_gets_its_place_back(queue: JobQueue, table_request: JobRequest) -> None:
    view = queue.submit(table_request)
    queue.redis.delete(queue.records.keys.active)
    assert queue.submit(table_request) == view
    assert queue.redis.zscore(queue.records.keys.active, view.id) is not None


def test_nothing_is_left_of_a_job_without_record(queue: JobQueue, table_request: JobRequest) -> None:
    view = queue.submit(table_request)
    work(queue, refs(queue)[0], 1)
    queue.redis.delete(queue.records.keys.job(view.id).record)
    Sweeper(queue.redis, queue.settings).sweep()
    assert queue.redis.zcard(queue.records.keys.active) == 0
    assert queue.redis.keys(f"{queue.records.keys.job(view.id).record}*") == []
    assert queue.submit(table_request).done == 1


def test_jobs_that_have_ended_stay_as_they_are(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    finish(queue)
    queue.cancel(queue.submit(a_request("7")).id)
    before = [queue.get(table_request.job_id), queue.get(a_request("7").job_id)]
    for _ in range(3):
        Sweeper(queue.redis, queue.settings).sweep()
        time.sleep(0.01)
    assert before == [queue.get(table_request.job_id), queue.get(a_request("7").job_id)]
    assert queue.redis.zcard(queue.records.keys.active) == 0


def test_a_chunk_lost_too_often_fails_its_job(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    sweeper = Sweeper(queue.redis, queue.settings)
    for _ in range(2 * queue.settings.max_worker_losses + 2):
        queue.attempts.start(entry(queue).ref)
        queue.redis.ltrim(queue.chunks.queues["small"].key, 1, 0)
        queue.redis.lrem(queue.chunks.queues["bulk"].key, 1, entry(queue).ref.rq_id)
        sweeper.sweep()
        time.sleep(0.01)
    view = queue.get(table_request.job_id)
    assert view is not None
    assert view.error is not None
    assert (view.status, view.error["type"]) == ("failed", "worker-lost")
    assert depth(queue) == 0
    assert queue.submit(table_request).status == "queued"


def lose(queue: JobQueue, lost: Lost) -> bool:
    """What follows when the first open chunk of the only job has lost its horse or worker."""
    return Interruptions(queue.redis, queue.settings).run_again(
        refs(queue)[0], lost, "worker-crashed", "several times"
    )


@pytest.mark.parametrize("lost", ["horses", "workers"])
def test_a_slice_that_kills_each_time_is_given_up_and_the_others_go_on(
    queue: JobQueue, table_request: JobRequest, lost: Lost
) -> None:
    queue.submit(table_request)
    bounds = {"horses": queue.settings.max_losses, "workers": queue.settings.max_worker_losses}
    work(queue, refs(queue)[0], 1)
    for attempt in range(1, bounds[lost] + 1):
        assert lose(queue, lost)
        assert (entry(queue).ref.attempt, entry(queue).offset) == (attempt, 1)
        work(queue, entry(queue).ref, 0)
    assert lose(queue, lost)
    assert entry(queue).offset == 2
    finish(queue)
    view = queue.get(table_request.job_id)
    assert view is not None
    assert (view.status, view.done) == ("succeeded", 5)
    table = table_of(queue, table_request.job_id)
    errors = {s["l1"]: s["error"] for s in table["slices"] if "error" in s}
    assert errors == {"2": {"type": "worker-crashed", "detail": "several times"}}


def test_the_last_slice_of_a_job_can_be_given_up(queue: JobQueue) -> None:
    view = queue.submit(a_request("1"))
    for _ in range(queue.settings.max_losses + 1):
        work(queue, entry(queue).ref, 0)
        more = lose(queue, "horses")
    assert not more
    done = queue.get(view.id)
    assert done is not None
    assert done.status == "succeeded"


@pytest.mark.parametrize("lost", ["horses", "workers"])
def test_no_slice_is_given_up_for_one_of_its_group(redis: Redis, lost: Lost) -> None:
    """A chunk that was lost while it was ahead goes on one by one, even if no loss is forgiven."""
    queue = JobQueue(redis, WorkerSettings(max_losses=0, max_worker_losses=0))
    queue.submit(a_request("1", "2", "3"))
    work(queue, refs(queue)[0], 0, one_by_one=False)
    assert lose(queue, lost)
    (ref,) = refs(queue)
    chunk = queue.attempts.start(ref)
    assert chunk is not None
    assert chunk.has_losses
    work(queue, ref, 1)
    assert lose(queue, lost)
    finish(queue)
    table = table_of(queue, a_request("1", "2", "3").job_id)
    assert ["error" in part for part in table["slices"]] == [False, True, False]


def test_exhaustion_of_a_group_is_due_to_none_of_its_slices_yet(queue: JobQueue) -> None:
    queue.submit(a_request("1", "2"))
    work(queue, refs(queue)[0], 0, one_by_one=False)
    for is_left in (True, True, False):
        Interruptions(queue.redis, queue.settings).give_up(refs(queue)[0], "resource-exhausted", "too much")
        assert bool(refs(queue)) == is_left
        if is_left:
            work(queue, refs(queue)[0], 0)
    table = table_of(queue, a_request("1", "2").job_id)
    assert all("error" in part for part in table["slices"])


@pytest.mark.parametrize("lost", ["horses", "workers"])
def test_losses_are_forgotten_when_a_slice_is_done(
    queue: JobQueue, table_request: JobRequest, lost: Lost
) -> None:
    queue.submit(table_request)
    for _ in range(2):
        for _ in range(queue.settings.max_losses):
            work(queue, entry(queue).ref, 0)
            lose(queue, lost)
        work(queue, entry(queue).ref, 1)
    assert (entry(queue).offset, entry(queue).horses_lost, entry(queue).workers_lost) == (2, 0, 0)


def test_a_loss_before_the_slices_is_of_the_whole_job(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    for _ in range(queue.settings.max_losses + 1):
        queue.attempts.start(entry(queue).ref)
        lose(queue, "horses")
    view = queue.get(table_request.job_id)
    assert view is not None
    assert (view.status, view.error) == ("failed", {"type": "worker-crashed", "detail": "several times"})


def test_losses_with_the_worker_have_a_bound_of_their_own(queue: JobQueue) -> None:
    view = queue.submit(a_document())
    for _ in range(queue.settings.max_losses + 1):
        queue.attempts.start(entry(queue).ref)
        assert lose(queue, "workers")
    for _ in range(queue.settings.max_losses):
        queue.attempts.start(entry(queue).ref)
        assert lose(queue, "horses")
    queue.attempts.start(entry(queue).ref)
    assert not lose(queue, "horses")
    failed = queue.get(view.id)
    assert failed is not None
    assert failed.status == "failed"


@pytest.mark.parametrize("lost", ["horses", "workers", ""])
def test_a_chunk_that_has_not_started_cannot_be_lost(queue: JobQueue, lost: Lost) -> None:
    queue.submit(a_request("1"))
    ref = refs(queue)[0]
    for attempt in range(1, 20):
        following = queue.attempts.reopen(ref, lost)
        assert following == replace(ref, attempt=attempt)
        assert isinstance(following, ChunkRef)
        ref = following


def test_a_job_that_lost_its_parts_fails(queue: JobQueue, table_request: JobRequest) -> None:
    """Redis has evicted what the chunks are to do: none of them can be given up or done."""
    view = queue.submit(table_request)
    queue.redis.delete(queue.records.keys.job(view.id).todo)
    chunk = queue.attempts.start(refs(queue)[0])
    assert chunk is not None
    assert chunk.parts == ()
    Interruptions(queue.redis, queue.settings).give_up(refs(queue)[0], "worker-lost", "incomplete")
    failed = queue.get(view.id)
    assert failed is not None
    assert (failed.status, failed.error) == ("failed", {"type": "worker-lost", "detail": "incomplete"})


def test_nothing_is_left_to_do_of_a_job_that_ended(queue: JobQueue, table_request: JobRequest) -> None:
    key = queue.records.keys.job(queue.submit(table_request).id).todo
    assert queue.redis.llen(key) == 2
    finish(queue)
    assert not queue.redis.exists(key)


def test_a_worker_that_dies_after_its_last_slice_leaves_no_rq_job(queue: JobQueue) -> None:
    """Nobody would look for it: the chunk is done, so it is neither missing nor in the record."""
    queue.submit(a_request("1", "2"))
    assert queue.chunks.pop(["small"]) == refs(queue)[0].rq_id
    work(queue, refs(queue)[0])  # and no `end_beat`
    view = queue.submit(a_request("1", "2"))
    assert view.status == "succeeded"
    assert queue.redis.keys("rq:job:*") == []
