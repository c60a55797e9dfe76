"""Jobs as the API sees them, with the test acting as the worker."""

from __future__ import annotations

from dataclasses import astuple

import pytest
from redis import Redis
from rq.job import Job

from tests.support.jobs import (
    a_document,
    a_heavy_document,
    a_pose_table,
    a_request,
    depth,
    open_chunks,
    perform,
    read_batch,
    submit_batch,
    table_of,
)
from worker.answers.kind import JobRequest
from worker.answers.kinds import Item
from worker.jobs import sweeper
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkRef
from worker.jobs.interruptions import Cause, Interruptions
from worker.jobs.plan import QueueFullError
from worker.jobs.queue import JobQueue
from worker.jobs.quotas import Quota, QuotaError
from worker.jobs.view import JobView
from worker.process import tasks
from worker.settings import WorkerSettings


def state(queue: JobQueue, job_id: str) -> JobView:
    view = queue.get(job_id)
    assert view is not None
    return view


def work_left(queue: JobQueue) -> dict[str, int]:
    """The milliseconds that the lanes still have to do."""
    found = {name.decode(): int(value) for name, value in queue.redis.hgetall(queue.keys.work).items()}
    lanes = {name.partition(":")[0] for name in found}
    return {lane: found.get(f"{lane}:added", 0) - found.get(f"{lane}:done", 0) for lane in lanes}


def test_a_chunk_that_is_discarded_as_a_worker_takes_it_leaves_nothing(queue: JobQueue) -> None:
    view = queue.submit(a_request("1"))
    [ref] = open_chunks(queue)
    job = Job.fetch(ref.rq_id, connection=queue.redis, serializer=queue.chunks.queues["small"].serializer)
    queue.cancel(view.id)
    job.prepare_for_execution("a worker", queue.redis)
    queue.chunks.discard([ref.rq_id])
    assert queue.redis.keys("rq:job:*") == []


def test_from_queued_to_succeeded(queue: JobQueue, table_request: JobRequest) -> None:
    view = queue.submit(table_request)
    assert (view.status, view.done, view.total, view.event != "") == ("queued", 0, 5, True)
    assert queue.with_position(view).place is not None
    perform(queue)
    done = state(queue, view.id)
    assert (done.status, done.done) == ("succeeded", 5)
    assert done.started_at is not None
    assert done.ended_at is not None
    assert len(table_of(queue, view.id)["slices"]) == 5
    events = [fields for _, fields in queue.redis.xrange(queue.keys.job(view.id).events)]
    statuses = [fields[b"status"] for fields in events if fields[b"type"] == b"status"]
    assert statuses == [b"queued", b"running", b"succeeded"]
    assert sorted(fields[b"l1"] for fields in events if fields[b"type"] == b"slice") == [
        b"1",
        b"2",
        b"3",
        b"4",
        b"5",
    ]
    assert queue.submit(table_request).run == view.run
    assert queue.records.active() == []


@pytest.mark.parametrize("end", ["failed", "canceled", "expired"])
def test_a_job_that_has_no_answer_is_started_anew(queue: JobQueue, end: str) -> None:
    request = a_document()
    first = queue.submit(request)
    if end == "failed":
        assert queue.records.fail(first.id, first.run, "timeout", "too long")
        assert not queue.records.fail(first.id, first.run, "other", "again"), "the end is set once"
        assert state(queue, first.id).error == {"type": "timeout", "detail": "too long"}
    elif end == "canceled":
        queue.cancel(first.id)
    else:
        perform(queue)
        queue.redis.delete(queue.store.keys.document(request.content_hash))
    again = queue.submit(request)
    assert (again.id, again.status) == (first.id, "queued")
    assert again.run != first.run
    perform(queue)
    assert state(queue, first.id).status == "succeeded"


def test_a_canceled_job_leaves_nothing_in_the_queue(queue: JobQueue, redis: Redis) -> None:
    view = queue.submit(a_heavy_document())
    assert depth(queue) == 1
    queue.cancel(view.id)
    assert depth(queue) == 0
    assert redis.keys("rq:job:*") == []
    assert not open_chunks(queue)


def test_an_attempt_may_run_twice(queue: JobQueue, table_request: JobRequest) -> None:
    """Each slice is counted and told once."""
    view = queue.submit(table_request)
    [(ref, entry)] = open_chunks(queue).items()
    attempts = Attempts(queue.redis, queue.settings)
    chunk = attempts.start(ref, entry.first, entry.last)
    assert chunk is not None
    value = {"count": 0, "cusps": []}
    for _ in range(2):
        attempts.put_slices(ref, chunk, [1, 2], [{"l1": "2", **value}, {"l1": "3", **value}])
    assert state(queue, view.id).done == 2
    again = attempts.start(ref, entry.first, entry.last)
    assert again is not None
    assert again.positions == (0, 3, 4)
    perform(queue)
    assert state(queue, view.id).status == "succeeded"
    assert queue.redis.xlen(queue.keys.job(view.id).events) == 8


def test_late_answers_are_kept_and_change_nothing(queue: JobQueue) -> None:
    request = a_request("1", "2")
    view = queue.submit(request)
    [(ref, entry)] = open_chunks(queue).items()
    attempts = Attempts(queue.redis, queue.settings)
    chunk = attempts.start(ref, entry.first, entry.last)
    assert chunk is not None
    canceled = queue.cancel(view.id)
    assert not attempts.put_slices(ref, chunk, [0], [{"l1": "1", "count": 0, "cusps": []}])
    assert queue.get(view.id) == canceled
    assert queue.store.get_slices(request).keys() == {"1"}
    assert attempts.start(ref, 0, 1) is None, "nor does another attempt begin"


def test_an_interrupted_attempt_is_followed_by_one_alone(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    [ref] = open_chunks(queue)
    interruptions = Interruptions(queue.redis, queue.settings)
    for _ in range(2):  # its worker and the search for lost chunks, for example
        assert interruptions.happened(ref, Cause("stopped")) == ""
    [following] = open_chunks(queue)
    assert following == ChunkRef(ref.job_id, ref.run, 0, 1)
    assert [raw.decode() for raw in queue.redis.lrange(queue.chunks.queues["small"].key, 0, -1)] == [
        following.rq_id
    ]
    perform(queue)
    assert state(queue, ref.job_id).status == "succeeded"


def test_what_ends_its_worker_again_and_again_is_given_up(queue: JobQueue) -> None:
    view = queue.submit(a_document())
    interruptions = Interruptions(queue.redis, queue.settings)
    said = [interruptions.happened(next(iter(open_chunks(queue))), Cause("lost", "gone")) for _ in range(11)]
    assert said[:-1] == [""] * 10
    assert said[-1] == "poses: worker-lost: gone"
    assert state(queue, view.id).error == {"type": "worker-lost", "detail": "gone"}


# -- clients


def test_quotas_of_jobs_and_of_work(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    quotas, jobs = queue.quotas, [queue.submit(a_pose_table(str(n))) for n in range(10, 13)]
    for view in jobs[:2]:
        quotas.admit("a", view.id, 4.0, Quota(jobs=2, seconds=10))
    for quota in (Quota(jobs=2), Quota(seconds=10)):
        with pytest.raises(QuotaError) as refused:
            quotas.admit("a", jobs[2].id, 4.0, quota)
        assert (refused.value.jobs, refused.value.seconds) == (2, 8.0)
    quotas.admit("b", jobs[2].id, 1000.0, Quota(jobs=2, seconds=10))  # one is always allowed
    monkeypatch.setattr("worker.jobs.quotas._GRACE", 0)
    queue.cancel(jobs[0].id)
    quotas.admit("a", jobs[2].id, 4.0, Quota(jobs=2, seconds=10))
    quotas.forget("a", jobs[1].id)
    quotas.admit("a", "another", 1.0, Quota(jobs=2))


# -- lanes


def test_the_work_of_a_lane_is_done_slice_by_slice(queue: JobQueue) -> None:
    heavy, small = queue.submit(a_heavy_document()), queue.submit(a_request("1", "2"))
    whole = work_left(queue)
    assert whole["heavy"] == round(1000 * (heavy.estimate_seconds or 0))
    assert whole["small"] == round(1000 * (small.estimate_seconds or 0))
    [ref] = [ref for ref in open_chunks(queue) if ref.job_id == small.id]
    chunk = Attempts(queue.redis, queue.settings).start(ref, 0, 1)
    assert chunk is not None
    value = {"l1": "1", "count": 0, "cusps": []}
    Attempts(queue.redis, queue.settings).put_slices(ref, chunk, [0], [value])
    assert 0 < work_left(queue)["small"] < whole["small"]
    queue.cancel(small.id)
    assert work_left(queue)["small"] == 0
    queue.cancel(heavy.id)
    assert work_left(queue) == {}, "nothing is active"


def test_the_place_of_a_job(queue: JobQueue) -> None:
    views = [queue.submit(a_heavy_document(digits)) for digits in (30, 31, 32)]
    places = [queue.with_position(view).place for view in views]
    assert [place.position for place in places if place] == [0, 1, 2]
    seconds = [place.seconds for place in places if place]
    assert seconds[0] == 0
    assert seconds[2] == pytest.approx(sum(view.estimate_seconds or 0 for view in views[:2]), abs=0.01)
    queue.cancel(views[0].id)
    place = queue.with_position(views[2]).place
    assert place is not None
    assert place.position == 1


def test_a_full_lane_refuses_jobs_and_others_do_not(redis: Redis) -> None:
    queue = JobQueue(redis, WorkerSettings(max_backlog_seconds=1))
    first = queue.submit(a_heavy_document())  # a lane in which nothing waits takes any job
    with pytest.raises(QueueFullError) as refused:
        queue.submit(a_heavy_document(31))
    assert refused.value.lane == "heavy"
    assert refused.value.seconds == pytest.approx(first.estimate_seconds, abs=0.01)
    assert queue.submit(a_heavy_document()).run == first.run
    queue.submit(a_request("1"))


def test_a_false_estimate_takes_all_waiting_chunks_along(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once, without loss."""
    monkeypatch.setattr("worker.jobs.plan.MAX_CHUNK_SLICES", 2)
    view = queue.submit(a_request("1", "2", "3", "4", "5"))
    assert queue.chunks.depths() == {"small": 3, "heavy": 0, "batch": 0}
    ref = ChunkRef(view.id, view.run, 1, 0)
    Interruptions(queue.redis, queue.settings).happened(ref, Cause("timeout"))
    assert queue.chunks.depths() == {"small": 0, "heavy": 3, "batch": 0}
    assert {entry.losses + entry.worker_losses for entry in open_chunks(queue).values()} == {0}
    assert work_left(queue)["small"] == 0
    perform(queue)
    assert state(queue, view.id).status == "succeeded"


@pytest.mark.parametrize("later", [1000.0, None])
def test_the_latest_deadline_counts(queue: JobQueue, redis: Redis, later: float | None) -> None:
    view = queue.submit(a_request("1"), deadline_seconds=0.001)
    queue.submit(a_request("1"), deadline_seconds=later)
    sweeper.Sweeper(redis, queue.settings).sweep()
    assert state(queue, view.id).status == "queued"
    assert (state(queue, view.id).deadline_at is None) is (later is None)


def test_a_job_ends_at_its_deadline(queue: JobQueue, redis: Redis) -> None:
    view = queue.submit(a_request("1"), deadline_seconds=0.001)
    sweeper.Sweeper(redis, queue.settings).sweep()
    ended = state(queue, view.id)
    assert (ended.status, (ended.error or {})["type"]) == ("failed", "timeout")
    assert depth(queue) == 0


def test_a_job_that_lost_its_chunks_fails(queue: JobQueue, redis: Redis) -> None:
    view = queue.submit(a_request("1"))
    redis.delete(queue.keys.job(view.id).chunks)
    sweeper.Sweeper(redis, queue.settings).sweep()
    assert (state(queue, view.id).error or {})["type"] == "worker-lost"


# -- lists


def test_of_a_long_item_the_hash_is_kept_once_it_is_answered(queue: JobQueue) -> None:
    long, short = a_pose_table("14." + "1" * 1200), a_pose_table("15")
    view = submit_batch(queue, [Item("a", long), Item("b", short)])
    [(ref, entry)] = open_chunks(queue).items()
    perform(queue)
    kept = {stored.item.id: stored for stored in read_batch(queue, view)}
    assert [kept["a"].state, kept["b"].state] == ["failed", "succeeded"]  # too many digits for poses
    assert [kept["a"].item.request, kept["b"].item.request] == [long.cut(), short]
    tasks.run_chunk(*astuple(ref), entry.first, entry.last)  # as `rq requeue` has it
    assert (state(queue, view.id).done, state(queue, view.id).failed) == (2, 1)
