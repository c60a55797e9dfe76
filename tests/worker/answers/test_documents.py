"""Jobs that compute one document, with the test acting as the worker."""

from __future__ import annotations

import pytest
from redis import Redis

import rpr_solver
from rpr_solver import EXAMPLES, SolverError
from tests.support.jobs import a_request, depth, open_chunks, perform
from worker.answers.censuses import CENSUS
from worker.answers.documents import CUSP_CURVES, POSES, VERIFICATION
from worker.answers.kind import JobRequest
from worker.answers.kinds import as_kept, request_from_json
from worker.jobs import sweeper
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkRef
from worker.jobs.queue import JobQueue
from worker.process import tasks
from worker.settings import WorkerSettings


@pytest.fixture
def request_() -> JobRequest:
    content = {"geometry": EXAMPLES["innocenti"].to_json(), "l1": "14.98", "l2": "15", "l3": "30"}
    return JobRequest(POSES, {**content, "digits": 20})


def open_chunk(queue: JobQueue) -> ChunkRef:
    [ref] = open_chunks(queue)
    return ref


@pytest.mark.parametrize("end", ["succeeds", "is canceled", "is known"])
def test_an_ended_job_keeps_the_hash_of_a_long_question(queue: JobQueue, redis: Redis, end: str) -> None:
    """Its state, its answer, and the same question again do not need more. One that failed is kept whole, so
    that its chunks can be requeued."""
    head = {"geometry": EXAMPLES["innocenti"].to_json(), "digits": 20}
    document = {**head, "slices": [], "padding": "x" * 100_000}
    request = JobRequest(VERIFICATION, {**head, "document": document})
    if end == "is known":
        queue.store.put_document(request, {"answer": 42})
    view, key = queue.submit(request), queue.records.keys.job(request.job_id).record
    if end != "is known":
        assert redis.memory_usage(key, samples=0) > 100_000
        ref = open_chunk(queue)
        chunk = Attempts(queue.redis, queue.settings).start(ref, 0, 0)
        assert chunk is not None
        assert chunk.request == request
        if end == "succeeds":
            Attempts(queue.redis, queue.settings).put_document(ref, request, {"answer": 42})
        else:
            queue.cancel(view.id)
    assert sum(redis.memory_usage(name, samples=0) or 0 for name in redis.keys("cusps:job*")) < 8000
    has_answer = end in ("succeeds", "is known")
    assert queue.result(view.id) == ({"answer": 42} if has_answer else None)
    queue.remember(request)
    assert queue.kept_answer(view.id) == queue.result(view.id)
    assert (redis.memory_usage(queue.store.keys.question(view.id)) or 0) < 1000
    redis.delete(queue.store.keys.document(request.content_hash))
    assert queue.result(view.id) is queue.kept_answer(view.id) is None
    again = queue.submit(request)
    assert (again.status, again.id) == ("queued", view.id)
    chunk = Attempts(queue.redis, queue.settings).start(open_chunk(queue), 0, 0)
    assert chunk is not None
    assert chunk.request == request, "whole again"


def test_what_is_needed_for_an_answer_is_kept() -> None:
    """A table is put together from its slices, a census may be cut from a longer one."""
    table = a_request(*(f"{n}.{'1' * 100}" for n in range(100)))
    assert as_kept(table) is table
    for kind in (CENSUS, CUSP_CURVES):
        request = JobRequest(kind, {"range": "9" * 5000})
        assert as_kept(request) is request
    short, long = (JobRequest(POSES, {"l1": "9" * count}) for count in (100, 5000))
    assert as_kept(short) is short
    cut = request_from_json(as_kept(long).to_json())
    assert (cut.content_hash, cut.job_id) == (long.content_hash, long.job_id)
    assert cut.is_cut
    assert as_kept(cut) == cut


def test_a_known_document_needs_no_work(queue: JobQueue, redis: Redis, request_: JobRequest) -> None:
    first = queue.submit(request_)
    perform(queue)
    redis.delete(queue.records.keys.job(first.id).record)
    again = queue.submit(request_)
    assert (again.status, again.done, again.total) == ("succeeded", 1, 1)
    assert open_chunks(queue) == {}


def test_progress_is_reported_and_ignored_after_the_end(queue: JobQueue, request_: JobRequest) -> None:
    view = queue.submit(request_)
    ref = open_chunk(queue)
    Attempts(queue.redis, queue.settings).start(ref, 0, 0)
    Attempts(queue.redis, queue.settings).put_progress(ref, 3, 8)
    running = queue.get(view.id)
    assert running is not None
    assert (running.status, running.done, running.total) == ("running", 3, 8)
    Attempts(queue.redis, queue.settings).put_document(ref, request_, {"answer": 42})
    Attempts(queue.redis, queue.settings).put_progress(ref, 4, 8)
    done = queue.get(view.id)
    assert done is not None
    assert (done.status, done.done, done.total) == ("succeeded", 8, 8)


@pytest.mark.parametrize(
    ("error", "kind"), [(SolverError("undecided"), "solver-error"), (KeyError("x"), "internal-error")]
)
def test_an_error_fails_the_job(
    queue: JobQueue, request_: JobRequest, monkeypatch: pytest.MonkeyPatch, error: Exception, kind: str
) -> None:
    def fail(*_: object, **_options: object) -> None:
        raise error

    view = queue.submit(request_)
    monkeypatch.setattr(rpr_solver, "poses", fail)
    with pytest.raises(type(error)):
        perform(queue)
    failed = queue.get(view.id)
    assert failed is not None
    assert (failed.status, (failed.error or {})["type"]) == ("failed", kind)
    assert queue.submit(request_).status == "queued"


def test_a_lost_document_is_put_back(
    queue: JobQueue, redis: Redis, request_: JobRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweeper, "GRACE", 0)
    queue.submit(request_)
    redis.delete(queue.chunks.queues["small"].key)
    assert sweeper.Sweeper(redis, WorkerSettings()).sweep() == 1
    assert open_chunk(queue).attempt == 1
    assert depth(queue) == 1


def test_progress_is_reported_a_few_times_a_second() -> None:
    reports: list[tuple[int, int]] = []
    progress = tasks.Throttle(lambda done, total: reports.append((done, total)), pause=60)
    for step in range(5):
        progress(step, 5)
    assert reports == [(0, 5)]
