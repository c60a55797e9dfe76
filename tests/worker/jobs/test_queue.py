"""The life of a job, with the test acting as the worker."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from redis import Redis

from tests.support.chunks import entry, finish, refs, work
from tests.support.jobs import a_document, a_pose_table, a_request, depth, table_of
from worker.answers.kind import JobRequest
from worker.jobs.chunks import ChunkRef
from worker.jobs.clients import Subscriber
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings


def test_from_queued_to_succeeded(queue: JobQueue, table_request: JobRequest) -> None:
    view = queue.submit(table_request)
    assert (view.id, view.status, view.done, view.total) == (table_request.job_id, "queued", 0, 5)
    assert view.created_at.endswith("Z")
    assert view.started_at is view.finished_at is view.error is None
    assert depth(queue) == 2
    assert queue.result(view.id) is None

    first, second = refs(queue)
    work(queue, first, 2)
    running = queue.get(view.id)
    assert running is not None
    assert (running.status, running.done) == ("running", 2)
    assert running.started_at is not None

    work(queue, first)
    work(queue, second)
    done = queue.get(view.id)
    assert done is not None
    assert (done.status, done.done, done.total) == ("succeeded", 5, 5)
    assert done.created_at <= (done.started_at or "") <= (done.finished_at or "")
    table = table_of(queue, view.id)
    assert queue.known(table_request) == queue.result(view.id)
    assert [s["l1"] for s in table["slices"]] == list(table_request.parts)


def test_unknown_job(queue: JobQueue) -> None:
    assert queue.get("ct-0") is queue.result("ct-0") is queue.cancel("ct-0") is None


def test_simultaneous_equal_requests_are_one_job(
    redis: Redis, settings: WorkerSettings, table_request: JobRequest
) -> None:
    queues = [JobQueue(redis, settings) for _ in range(8)]
    with ThreadPoolExecutor(8) as pool:
        views = list(pool.map(lambda q: q.submit(table_request), queues))
    assert len({view.run for view in views}) == 1
    assert depth(queues[0]) == 2


def test_only_missing_slices_are_computed(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    finish(queue)
    view = queue.submit(a_request("4", "5", "6", "7"))
    assert (view.done, view.total) == (2, 4)
    (ref,) = refs(queue)
    chunk = queue.attempts.start(ref)
    assert chunk is not None
    assert chunk.parts == ("6", "7")


def test_all_known_is_done_at_once(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    finish(queue)
    view = queue.submit(a_request("2", "1"))
    assert (view.status, view.done, view.total) == ("succeeded", 2, 2)
    assert depth(queue) == 2  # the chunks of the first job
    assert queue.result(view.id) is not None


def test_a_succeeded_job_is_joined_while_its_results_last(queue: JobQueue, table_request: JobRequest) -> None:
    first = queue.submit(table_request)
    finish(queue)
    assert queue.submit(table_request).run == first.run
    queue.redis.delete(*queue.store.slice_keys(table_request, ["3"]))
    assert queue.result(first.id) is None
    again = queue.submit(table_request)
    assert (again.run != first.run, again.status, again.done) == (True, "queued", 4)


def test_a_failed_job_is_replaced(queue: JobQueue, table_request: JobRequest) -> None:
    first = queue.submit(table_request)
    ref = refs(queue)[0]
    work(queue, ref, 1)
    queue.records.fail(ref, "timeout", "too long")
    failed = queue.get(first.id)
    assert failed is not None
    assert (failed.status, failed.error) == ("failed", {"type": "timeout", "detail": "too long"})
    assert queue.redis.ttl(queue.records.keys.job(first.id).record) > 0

    again = queue.submit(table_request)
    assert (again.status, again.error, again.done) == ("queued", None, 1)
    finish(queue)
    done = queue.get(first.id)
    assert done is not None
    assert done.status == "succeeded"


def test_a_canceled_job_stays_canceled_until_asked_again(queue: JobQueue, table_request: JobRequest) -> None:
    first = queue.submit(table_request)
    stale = refs(queue)
    view = queue.cancel(first.id)
    assert view is not None
    assert view.status == "canceled"
    assert depth(queue) == 0
    assert queue.cancel(first.id) == view
    assert [queue.attempts.start(ref) for ref in stale] == [None, None]
    assert queue.submit(table_request).status == "queued"
    finish(queue)
    assert queue.cancel(first.id) == queue.get(first.id)
    assert queue.result(first.id) is not None


def test_late_results_change_nothing(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    old = refs(queue)[0]
    chunk = queue.attempts.start(old)
    assert chunk is not None
    queue.cancel(table_request.job_id)
    queue.submit(table_request)
    assert not queue.attempts.put_slices(old, chunk, 0, [{"l1": "1", "count": 0, "cusps": []}])
    assert queue.records.fail(old, "worker-lost", "late") is None
    assert queue.attempts.reopen(old, "workers") == "stale"
    view = queue.get(table_request.job_id)
    assert view is not None
    assert (view.status, view.done, view.error) == ("queued", 0, None)
    assert "1" in queue.store.get_slices(table_request)  # a valid result is kept


def test_slices_that_come_in_groups_are_counted_and_told_once(queue: JobQueue) -> None:
    view = queue.submit(a_request("1", "2", "3"))
    (ref,) = refs(queue)
    chunk = queue.attempts.start(ref)
    assert chunk is not None
    slices = [{"l1": l1, "count": 0, "cusps": []} for l1 in chunk.parts]
    assert queue.attempts.put_slices(ref, chunk, 0, slices[:2])
    assert entry(queue).offset == 2
    assert not queue.attempts.put_slices(ref, chunk, 1, slices[1:])  # the last one ends the job
    events = queue.redis.xrange(queue.records.keys.job(view.id).events)
    told = [(fields[b"l1"], fields[b"done"]) for _, fields in events if b"l1" in fields]
    assert told == [(b"1", b"1"), (b"2", b"2"), (b"3", b"3")]
    assert table_of(queue, view.id)["slices"] == slices


def test_an_attempt_that_was_followed_by_another_changes_nothing(
    queue: JobQueue, table_request: JobRequest
) -> None:
    queue.submit(table_request)
    old = refs(queue)[0]
    work(queue, old, 1)
    chunk = queue.attempts.start(old)
    assert chunk is not None
    assert queue.attempts.beat(old, "worker")
    following = queue.attempts.reopen(old, "workers")
    assert isinstance(following, ChunkRef)
    assert not queue.attempts.beat(old, "worker")
    assert queue.attempts.beat(following, "worker")
    assert not queue.attempts.put_slices(old, chunk, 1, [{"l1": "2", "count": 0, "cusps": []}])
    assert not queue.attempts.put_slices(old, chunk, 2, [{"l1": "3", "error": {"type": "x", "detail": "y"}}])
    assert queue.records.fail(old, "worker-lost", "late") is None
    view = queue.get(table_request.job_id)
    assert view is not None
    assert (view.status, view.done) == ("running", 1)
    assert "2" in queue.store.get_slices(table_request)  # a valid result is kept
    work(queue, following)
    assert not queue.attempts.beat(following, "worker")  # done


def test_the_progress_of_a_document_never_runs_backwards(queue: JobQueue) -> None:
    request = a_document()
    queue.submit(request)
    (old,) = refs(queue)
    queue.attempts.start(old)
    assert queue.attempts.put_progress(old, 17, 40)
    following = queue.attempts.reopen(old, "workers")
    assert isinstance(following, ChunkRef)
    queue.attempts.start(following)
    assert not queue.attempts.put_progress(old, 27, 40)
    for done in (1, 16, 18):
        assert queue.attempts.put_progress(following, done, 40)
    queue.attempts.put_document(old, request, {"answer": 1})
    view = queue.get(request.job_id)
    assert view is not None
    assert (view.status, view.done, view.total) == ("running", 18, 40)
    assert queue.store.get_document(request) == {"answer": 1}
    queue.attempts.put_document(following, request, {"answer": 1})
    assert queue.result(request.job_id) == {"answer": 1}
    events = queue.redis.xrange(queue.records.keys.job(request.job_id).events)
    assert [fields[b"done"] for _, fields in events if b"done" in fields] == [b"17", b"18"]


def test_a_slice_that_fails_leaves_the_others_unaffected(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    first, second = refs(queue)
    work(queue, first, error="2")
    work(queue, second)
    table = table_of(queue, table_request.job_id)
    assert [s["l1"] for s in table["slices"] if "error" in s] == ["2"]
    # the error soon expires in the store; its job keeps it, and the next job tries again
    queue.redis.delete(*queue.store.slice_keys(table_request, ["2"]))
    assert table_of(queue, table_request.job_id) == table
    assert queue.known(table_request) is None
    assert queue.submit(table_request).done == 4


def test_a_slice_is_counted_once(queue: JobQueue, table_request: JobRequest) -> None:
    queue.submit(table_request)
    first = refs(queue)[0]
    work(queue, first, 2)
    again = queue.attempts.reopen(first, "workers")
    assert isinstance(again, ChunkRef)
    assert queue.attempts.start(first) is None
    work(queue, again)
    view = queue.get(table_request.job_id)
    assert view is not None
    assert view.done == 3


def commands(redis: Redis) -> int:
    stats: dict[str, dict[str, int]] = redis.info("commandstats")  # type: ignore[assignment]
    return sum(of["calls"] for name, of in stats.items() if name != "cmdstat_info")


def test_a_small_job_takes_few_commands(queue: JobQueue) -> None:
    """Beside these, RQ takes two to give it to a worker, and the API two to wait for its end: under 60."""
    spent = []
    for n in range(3):
        before, request = commands(queue.redis), a_pose_table(str(10 + n))
        assert queue.known(request) is None
        view = queue.submit_for(Subscriber("address:127.0.0.1", False), request, 30, is_unknown=True)
        ref = ChunkRef(view.id, view.run, 0, 0)
        assert queue.attempts.start(ref, "worker") is not None
        queue.attempts.put_document(ref, request, {"answer": n})
        assert not queue.attempts.end_beat(ref)
        assert queue.known(request) == {"answer": n}
        spent.append(commands(queue.redis) - before)
    assert max(spent[1:]) < 56, "the first one loads the scripts"
