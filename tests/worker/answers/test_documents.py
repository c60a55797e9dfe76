"""Jobs that compute one document, with the test acting as the worker."""

from __future__ import annotations

import pytest
from redis import Redis

from rpr_solver import EXAMPLES, SolverError, poses
from worker.answers import poses as poses_kind
from worker.answers.requests import JobRequest
from worker.jobs.attempts import ChunkRef
from worker.jobs.queue import JobQueue
from worker.jobs.sweeper import Sweeper
from worker.process import tasks
from worker.settings import WorkerSettings


@pytest.fixture
def request_() -> JobRequest:
    content = {"geometry": EXAMPLES["innocenti"].to_json(), "l1": "14.98", "l2": "15", "l3": "30"}
    return JobRequest(poses_kind.KIND, {**content, "digits": 20})


@pytest.fixture(autouse=True)
def _context(redis: Redis, settings: WorkerSettings, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tasks, "_context", tasks.Context(redis, settings))


def open_chunk(queue: JobQueue) -> ChunkRef:
    [entry] = queue.records.open_chunks()
    return entry.ref


def run(ref: ChunkRef) -> None:
    tasks.run_chunk(ref.job_id, ref.run, ref.index, ref.attempt)


def test_from_queued_to_succeeded(queue: JobQueue, request_: JobRequest) -> None:
    assert queue.known(request_) is None
    view = queue.submit(request_)
    assert (view.id, view.status, view.done, view.total) == (request_.job_id, "queued", 0, 1)
    assert queue.submit(request_).run == view.run
    assert queue.depth() == 1
    run(open_chunk(queue))
    done = queue.get(view.id)
    assert done is not None
    assert (done.status, done.done, done.total) == ("succeeded", 1, 1)
    expected = poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=20).to_json()
    assert queue.result(view.id) == queue.known(request_) == expected
    assert queue.submit(request_).run == view.run


def test_a_known_document_needs_no_work(queue: JobQueue, redis: Redis, request_: JobRequest) -> None:
    first = queue.submit(request_)
    run(open_chunk(queue))
    redis.delete(queue.records.keys.job(first.id).record)
    again = queue.submit(request_)
    assert (again.status, again.done, again.total) == ("succeeded", 1, 1)
    assert queue.records.open_chunks() == []


def test_a_document_that_was_lost_is_computed_again(
    queue: JobQueue, redis: Redis, request_: JobRequest
) -> None:
    first = queue.submit(request_)
    run(open_chunk(queue))
    redis.delete(queue.store.keys.document(request_.content_hash))
    assert queue.result(first.id) is None
    assert queue.submit(request_).status == "queued"


def test_progress_is_reported_and_ignored_after_the_end(queue: JobQueue, request_: JobRequest) -> None:
    view = queue.submit(request_)
    ref = open_chunk(queue)
    queue.records.start(ref)
    queue.records.put_progress(ref, 3, 8)
    running = queue.get(view.id)
    assert running is not None
    assert (running.status, running.done, running.total) == ("running", 3, 8)
    queue.records.put_document(ref, request_, {"answer": 42})
    queue.records.put_progress(ref, 4, 8)
    done = queue.get(view.id)
    assert done is not None
    assert (done.status, done.done, done.total) == ("succeeded", 8, 8)


def test_a_canceled_job_keeps_its_state_when_its_document_comes_late(
    queue: JobQueue, request_: JobRequest
) -> None:
    view = queue.submit(request_)
    ref = open_chunk(queue)
    queue.records.start(ref)
    canceled = queue.cancel(view.id)
    assert canceled is not None
    assert canceled.status == "canceled"
    queue.records.put_document(ref, request_, {"answer": 42})
    assert queue.get(view.id) == canceled
    assert queue.result(view.id) is None
    assert queue.known(request_) == {"answer": 42}  # valid whatever the state of the job


@pytest.mark.parametrize(
    ("error", "kind"), [(SolverError("undecided"), "solver-error"), (KeyError("x"), "internal-error")]
)
def test_an_error_fails_the_job(
    queue: JobQueue, request_: JobRequest, monkeypatch: pytest.MonkeyPatch, error: Exception, kind: str
) -> None:
    def fail(*_: object) -> None:
        raise error

    view = queue.submit(request_)
    monkeypatch.setattr(tasks, "compute", fail)
    run(open_chunk(queue))
    failed = queue.get(view.id)
    assert failed is not None
    assert (failed.status, (failed.error or {})["type"]) == ("failed", kind)
    assert queue.submit(request_).status == "queued"


def test_a_lost_document_is_put_back(queue: JobQueue, redis: Redis, request_: JobRequest) -> None:
    queue.submit(request_)
    ref = open_chunk(queue)
    redis.delete(queue.chunks.queues["small"].key)
    queue.records.start(ref)
    sweeper = Sweeper(redis, WorkerSettings(sweep_interval=0.001, lost_grace=0))
    assert sweeper.sweep() == 1
    assert open_chunk(queue).attempt == 1


def test_progress_is_reported_a_few_times_a_second() -> None:
    reports: list[tuple[int, int]] = []
    progress = tasks.Throttle(lambda done, total: reports.append((done, total)), pause=60)
    for step in range(5):
        progress(step, 5)
    assert reports == [(0, 5)]
