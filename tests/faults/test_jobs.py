"""Jobs, when work horses and workers fail."""

from __future__ import annotations

import os
import re
import signal
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from redis import Redis

from tests.support.jobs import a_document, a_pose_table, a_request, depth, ended, open_chunks, table_of
from tests.support.processes import (
    PATIENCE,
    Workers,
    descendants,
    is_running,
    until,
)
from tests.support.sampling import long
from worker.answers.kind import JobRequest
from worker.jobs.queue import JobQueue
from worker.jobs.records import Client
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

both_kinds = pytest.mark.parametrize(
    "request_",
    [
        pytest.param(a_request("1", "2"), id="table"),
        pytest.param(a_document(), id="document", marks=pytest.mark.long),
    ],
)


def jobs(redis: Redis, task: str = "") -> JobQueue:
    """The queue as an API process sees it; with `task`, its chunks run one of the hard tasks."""
    name = f"tests.support.hard_tasks.{task}" if task else "worker.process.tasks.run_chunk"
    return JobQueue(redis, WorkerSettings(task=name))


def is_at_work(queue: JobQueue, view: JobView) -> bool:
    now = queue.get(view.id)
    return now is not None and now.status == "running"


def test_the_real_thing_in_silence(redis: Redis, workers: Workers) -> None:
    """Nothing fails. The job succeeds, the workers log nothing, and RQ keeps its part for a minute."""
    workers.start()
    queue = jobs(redis)
    request = a_request("14.98", "0.5", "27")
    view = ended(queue, queue.submit(request).id)
    assert view.status == "succeeded"
    table = table_of(queue, view.id)
    assert [s["l1"] for s in table["slices"]] == ["14.98", "0.5", "27"]
    assert table["slices"][0]["count"] == 6
    workers.stop()
    assert workers.log.read_text() == ""
    left = [key for key in redis.keys("rq:*") if key.startswith((b"rq:job:", b"rq:results:"))]
    assert all(0 < redis.ttl(key) <= 60 for key in left)


@both_kinds
def test_a_long_c_call_ends_at_the_deadline(redis: Redis, workers: Workers, request_: JobRequest) -> None:
    """A computation hangs in C code. It ends at the deadline, and the job fails with `timeout`, which is
    logged; workers continue."""
    worker = workers.start(deadline_seconds=1, task="tests.support.hard_tasks.endless")
    view = ended(jobs(redis), jobs(redis, "endless").submit(request_).id)
    assert view.status == "failed"
    assert view.error == {
        "type": "timeout",
        "detail": "The computation was stopped at the time limit of 1 s.",
    }
    until(lambda: descendants(worker.pid) == [])
    assert re.search(r"WARNING chunk 0: gave up [a-z-]+: timeout: .* job=" + view.id, workers.log.read_text())
    # the same worker continues
    other = ended(jobs(redis), jobs(redis, "endless").submit(a_request("3")).id)
    assert (other.error or {})["type"] == "timeout"
    assert worker.poll() is None
    # and the failure does not block the queue
    workers.stop()
    workers.start()
    again = jobs(redis).submit(request_)
    assert again.status in ("queued", "running")
    assert ended(jobs(redis), again.id).status == "succeeded"


@both_kinds
def test_a_failed_job_gives_its_reason(redis: Redis, workers: Workers, request_: JobRequest) -> None:
    """A computation raises an unexpected error. Its job fails with the reason; the worker continues."""
    worker = workers.start(task="tests.support.hard_tasks.broken")
    queue = jobs(redis, "broken")
    view = ended(queue, queue.submit(request_).id)
    assert view.error is not None
    assert (view.status, view.error["type"]) == ("failed", "internal-error")
    assert "Traceback" not in view.error["detail"]
    assert worker.poll() is None
    assert redis.zcard(queue.records.keys.active) == 0


hopeless = pytest.mark.parametrize(
    ("task", "kind"),
    [
        ("crash", "worker-crashed"),
        long("killed", "worker-crashed"),
        long("leave", "worker-crashed"),
        ("greedy", "resource-exhausted"),
        long("greedy_python", "resource-exhausted"),
    ],
)


@hopeless
def test_a_document_whose_horse_dies_each_time_fails(
    redis: Redis, workers: Workers, task: str, kind: str
) -> None:
    """A document's work horse crashes, is killed, leaves or runs out of memory at every attempt. The job
    fails with the reason; the worker continues.
    """
    worker = workers.start(memory_limit_mb=1024, task=f"tests.support.hard_tasks.{task}")
    queue = jobs(redis, task)
    view = ended(queue, queue.submit(a_document()).id)
    assert view.error is not None
    assert (view.status, view.error["type"]) == ("failed", kind)
    assert "waitpid" not in view.error["detail"]
    assert worker.poll() is None


@hopeless
def test_a_slice_whose_horse_dies_each_time_is_an_error_among_others(
    redis: Redis, workers: Workers, task: str, kind: str
) -> None:
    """One slice's work horse crashes, is killed, leaves or runs out of memory at every attempt. That slice is
    an error in the table; the others are computed, and no stored slice is computed twice.
    """
    worker = workers.start(memory_limit_mb=1024, task=f"tests.support.hard_tasks.{task}")
    queue = jobs(redis, task)
    view = ended(queue, queue.submit(a_request("1", "2", "13", "3")).id)
    assert (view.status, view.done) == ("succeeded", 4)
    table = table_of(queue, view.id)
    assert [s.get("error", {}).get("type") for s in table["slices"]] == [None, None, kind, None]
    pids = [s["certificate"]["pid"] for s in table["slices"] if "error" not in s]
    assert pids[0] == pids[1] != pids[2]  # what was done is not done again
    assert worker.poll() is None


@pytest.mark.parametrize("task", ["crash", long("broken"), long("endless"), "canceled"])
def test_what_ends_a_work_horse_ends_one_chunk(redis: Redis, workers: Workers, task: str) -> None:
    """A work horse that has run chunks of other jobs crashes, meets an unexpected error or the deadline, or
    its job is canceled. That ends one chunk; another work horse runs the next ones.
    """
    worker = workers.start(deadline_seconds=PATIENCE if task == "canceled" else 1)

    def horse_after(l1: str) -> list[int]:
        queue = jobs(redis)
        assert ended(queue, queue.submit(a_pose_table(l1)).id).status == "succeeded"
        until(lambda: [redis.hget(key, "state") for key in redis.keys("rq:worker:*")] == [b"idle"])
        return descendants(worker.pid)

    first = horse_after("14")
    assert first == horse_after("15") != []
    queue = jobs(redis, "endless" if task == "canceled" else task)
    view = queue.submit(a_document())
    if task == "canceled":
        until(lambda: is_at_work(queue, view))
        assert descendants(worker.pid) == first
        queue.cancel(view.id)
    # what is tried again is tried with the usual task
    expected = {"canceled": "canceled", "broken": "failed"}.get(task, "succeeded")
    assert ended(queue, view.id).status == expected
    until(lambda: not is_running(first[0]))
    second = horse_after("16")
    assert second == horse_after("17") != first
    assert worker.poll() is None


@pytest.mark.parametrize("victim", ["horse", "worker"])
def test_a_work_horse_or_its_worker_is_killed_between_two_chunks(
    redis: Redis, workers: Workers, victim: str
) -> None:
    """A work horse that waits for its next chunk is killed, or its worker is. No work horse outlives its
    worker; the next chunk runs in another one, without a loss counted.
    """
    worker = workers.start()
    queue = jobs(redis)
    assert ended(queue, queue.submit(a_pose_table("14")).id).status == "succeeded"
    (horse,) = descendants(worker.pid)
    os.kill(horse if victim == "horse" else worker.pid, signal.SIGKILL)
    until(lambda: not is_running(horse))
    if victim == "worker":
        workers.start()
    assert ended(queue, queue.submit(a_pose_table("15")).id).status == "succeeded"
    assert not redis.hexists(queue.records.keys.ends, "lost:horses")


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGKILL,
        *(
            pytest.param(number, marks=pytest.mark.long)
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)
        ),
    ],
    ids=str,
)
def test_a_work_horse_receives_a_signal(redis: Redis, workers: Workers, number: signal.Signals) -> None:
    """A work horse receives SIGKILL, SIGTERM, SIGINT, SIGHUP or SIGQUIT from another process. If it ends, its
    chunk runs again at once; the job is done.
    """
    worker = workers.start(task="tests.support.hard_tasks.gated")
    queue = jobs(redis, "gated")
    view = queue.submit(a_request("1", "2"))
    until(lambda: redis.llen("begun") == 1)
    (horse,) = descendants(worker.pid)
    os.kill(horse, number)
    if number != signal.SIGINT:  # which it ignores
        until(lambda: redis.llen("begun") == 2)
        assert not is_running(horse)
    redis.set("gate", 1)
    assert ended(queue, view.id).status == "succeeded"
    assert worker.poll() is None


@pytest.mark.long
def test_a_work_horse_is_stopped(redis: Redis, workers: Workers) -> None:
    """A work horse is stopped by SIGSTOP and not continued. It is killed at the deadline, and the job fails
    with `timeout`; the worker continues.
    """
    worker = workers.start(task="tests.support.hard_tasks.gated", deadline_seconds=2)
    queue = jobs(redis, "gated")
    view = queue.submit(a_request("1"))
    until(lambda: redis.llen("begun") == 1)
    (horse,) = descendants(worker.pid)
    os.kill(horse, signal.SIGSTOP)
    assert (ended(queue, view.id).error or {})["type"] == "timeout"
    assert not is_running(horse)
    assert worker.poll() is None


@pytest.mark.slow
@both_kinds
def test_another_worker_takes_over_from_a_dead_one(
    redis: Redis, workers: Workers, request_: JobRequest
) -> None:
    """A worker is killed while it computes. Its work horse ends with it; another worker computes the rest."""
    task = "tests.support.hard_tasks.slow_once"
    first = workers.start(task=task)
    queue = jobs(redis, "slow_once")
    view = queue.submit(request_)
    until(lambda: is_at_work(queue, view))
    second = workers.start(task=task)
    (horse,) = descendants(first.pid)
    first.kill()
    first.wait(PATIENCE)
    until(lambda: not is_running(horse))  # no orphan is left
    assert ended(queue, view.id).status == "succeeded"
    assert second.poll() is None


@both_kinds
def test_a_worker_that_stalled_gives_way(redis: Redis, workers: Workers, request_: JobRequest) -> None:
    """A worker is stopped by SIGSTOP and later continued. Another one takes over; the first ends its work
    horse, and progress never runs backwards.
    """
    task = "tests.support.hard_tasks.gated"
    first = workers.start(task=task)
    queue = jobs(redis, "gated")
    view = queue.submit(request_)
    until(lambda: redis.llen("begun") == 1)
    (horse,) = descendants(first.pid)
    first.send_signal(signal.SIGSTOP)
    try:
        second = workers.start(task=task)
        until(lambda: redis.llen("begun") == 2)
    finally:
        first.send_signal(signal.SIGCONT)
    until(lambda: not is_running(horse))
    redis.set("gate", 1)
    done = ended(queue, view.id)
    assert (done.status, done.done) == ("succeeded", done.total)
    assert queue.result(view.id) is not None
    assert redis.lrange("begun", 0, -1) == [b"0"] + [b"1"] * len(
        request_.parts
    )  # nothing ran twice after that
    events = redis.xrange(queue.records.keys.job(view.id).events)
    counts = [int(fields[b"done"]) for _, fields in events if b"done" in fields]
    assert counts == sorted(counts) != []
    assert first.poll() is second.poll() is None


@both_kinds
def test_a_stopped_worker_loses_nothing(redis: Redis, workers: Workers, request_: JobRequest) -> None:
    """A worker is stopped (SIGTERM) while it computes. Its chunk returns to the queue, and no loss is
    counted.
    """
    first = workers.start(task="tests.support.hard_tasks.slow_once")
    queue = jobs(redis, "slow_once")
    view = queue.submit(request_)
    until(lambda: is_at_work(queue, view))
    (horse,) = descendants(first.pid)
    first.terminate()
    assert first.wait(PATIENCE) == 0
    assert not is_running(horse)
    assert depth(queue) == 1
    workers.start()
    assert ended(queue, view.id).status == "succeeded"


def test_a_stopped_worker_finishes_a_short_chunk(redis: Redis, workers: Workers) -> None:
    """A worker is stopped (SIGINT) shortly before its chunk is done. It finishes the chunk."""
    worker = workers.start()
    queue = jobs(redis, "slow")
    view = queue.submit(a_request("1", "2", "3", "4"))
    until(lambda: is_at_work(queue, view))
    worker.send_signal(signal.SIGINT)
    assert worker.wait(PATIENCE) == 0
    done = queue.get(view.id)
    assert done is not None
    assert done.status == "succeeded"


@both_kinds
@pytest.mark.parametrize(
    "lost", [["chunks"], long(["active"]), long(["bits"]), long(["suspects", "beat"]), ["record"]]
)
def test_no_job_hangs_when_redis_loses_a_key(
    redis: Redis, workers: Workers, request_: JobRequest, lost: list[str]
) -> None:
    """Redis loses single keys of a running job. The job continues or fails, and posting it again succeeds."""
    worker = workers.start(task="tests.support.hard_tasks.gated")
    queue = jobs(redis, "gated")
    view = queue.submit(request_)
    until(lambda: redis.llen("begun") == 1)
    (ref,) = open_chunks(queue)
    keys = queue.records.keys
    names = {**keys.job(view.id)._asdict(), "active": keys.active, "suspects": keys.suspects}
    names |= {"beat": keys.beat(ref.rq_id)}
    redis.delete(*(names[name] for name in lost))

    def has_ended() -> bool:
        now = queue.get(view.id)
        return now is None or now.is_terminal

    redis.set("gate", 1)
    until(has_ended)
    assert ended(queue, queue.submit(request_).id).status == "succeeded"
    assert queue.result(view.id) is not None
    assert worker.poll() is None


def test_a_second_signal_hurries(redis: Redis, workers: Workers) -> None:
    """A stopping worker receives a second signal. It puts its chunk back at once and ends."""
    worker = workers.start()
    queue = jobs(redis, "endless")
    view = queue.submit(a_request("1"))
    until(lambda: is_at_work(queue, view))
    # repeatedly, since signals in quick succession merge
    until(lambda: worker.poll() is not None or worker.terminate())
    assert worker.returncode == 0
    assert depth(queue) == 1


def test_cancel_while_running(redis: Redis, workers: Workers) -> None:
    """A running job is canceled. Its work horse ends; later jobs, and the same job posted again, succeed."""
    worker = workers.start()
    queue = jobs(redis, "endless")
    view = queue.submit(a_request("1"))
    until(lambda: is_at_work(queue, view))
    canceled = queue.cancel(view.id)
    assert canceled is not None
    assert canceled.status == "canceled"
    until(lambda: descendants(worker.pid) == [])
    assert queue.get(view.id) == canceled
    assert ended(jobs(redis), jobs(redis).submit(a_request("2")).id).status == "succeeded"
    assert queue.get(view.id) == canceled
    assert ended(jobs(redis), jobs(redis).submit(a_request("1")).id).status == "succeeded"


def test_a_worker_that_missed_the_stop_command_notices_by_itself(redis: Redis, workers: Workers) -> None:
    """A canceled job's worker misses the stop command. It notices at its next heartbeat and ends its work
    horse.
    """
    worker = workers.start()
    queue = jobs(redis, "endless")
    view = queue.submit(a_request("1"))
    until(lambda: is_at_work(queue, view))
    queue.records.cancel(view.id)
    until(lambda: descendants(worker.pid) == [])
    now = queue.get(view.id)
    assert now is not None
    assert now.status == "canceled"


def test_cancel_at_any_moment(redis: Redis, workers: Workers) -> None:
    """Jobs are canceled just as workers take them. Each job stays canceled, and the worker continues."""
    worker = workers.start()
    queue = jobs(redis, "endless")
    for i in range(1, 13):
        view = queue.submit(a_request(str(i)))
        until(lambda: depth(queue) == 0)
        canceled = queue.cancel(view.id)
        assert canceled is not None
        assert canceled.status == "canceled"
        assert queue.get(view.id) == canceled
    assert ended(jobs(redis), jobs(redis).submit(a_request("2")).id).status == "succeeded"
    assert worker.poll() is None
    workers.stop()
    assert workers.log.read_text() == ""


def test_the_last_key_ends_a_call_of_c(redis: Redis, workers: Workers) -> None:
    """Two keys ask one question, which hangs in C code. One withdraws, and it goes on; the other does, and
    its work horse ends.
    """
    worker = workers.start()
    queue = jobs(redis, "endless")
    one, other = (Client(f"key:{name}", is_known=True) for name in "ab")
    view = queue.submit(a_request("1"), by=one)
    assert queue.submit(a_request("1"), by=other).run == view.run
    until(lambda: is_at_work(queue, view))
    (horse,) = descendants(worker.pid)
    queue.withdraw(view.id, one)
    time.sleep(0.5)  # in which it would end
    assert is_at_work(queue, view)
    assert is_running(horse)
    queue.withdraw(view.id, other)
    until(lambda: not is_running(horse))
    now = queue.get(view.id)
    assert now is not None
    assert now.status == "canceled"


def test_a_queued_job_that_is_canceled_never_runs(redis: Redis, workers: Workers) -> None:
    """A queued job is canceled. No worker runs it."""
    queue = jobs(redis)
    request = a_request("1")
    queue.cancel(queue.submit(request).id)
    workers.start()
    other = queue.submit(a_request("2"))
    assert ended(queue, other.id).status == "succeeded"
    view = queue.get(request.job_id)
    assert view is not None
    assert (view.status, view.started_at) == ("canceled", None)
    assert queue.store.get_slices(request) == {}


def test_simultaneous_equal_requests_are_computed_once(redis: Redis, workers: Workers) -> None:
    """Eight clients ask the same question at once. There is one job, and each slice is computed once."""
    for _ in range(2):
        workers.start()
    request = a_request(*map(str, range(1, 13)))
    queue = jobs(redis, "slow")
    with ThreadPoolExecutor(8) as pool:
        views = list(pool.map(lambda _: jobs(redis, "slow").submit(request), range(8)))
    assert len({view.run for view in views}) == 1
    assert ended(queue, request.job_id).status == "succeeded"
    events = redis.xrange(queue.records.keys.job(request.job_id).events)
    assert sum(fields[b"type"] == b"slice" for _, fields in events) == 12
    table = table_of(queue, request.job_id)
    assert os.getpid() not in {s["certificate"]["pid"] for s in table["slices"]}


def test_an_elimination_is_one_workers_as_long_as_it_takes(redis: Redis, workers: Workers) -> None:
    """An elimination takes longer than its lock lasts. The worker renews the lock, and the lock ends with its
    holder.
    """
    workers.start()
    queue = jobs(redis, "endless_elimination")
    request = a_request("1", "2", "3", "4", "5")
    queue.submit(request)
    lock = queue.store.keys.eliminant_lock(request.geometry_hash, 1)
    until(lambda: redis.exists(lock))
    redis.expire(lock, 1000)
    until(lambda: redis.ttl(lock) < 10)  # the beat has given it another short time
    queue.cancel(request.job_id)
    until(lambda: not redis.exists(lock))  # it does not outlive its holder
