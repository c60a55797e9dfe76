"""Workers and their horses: what they compute, and what becomes of it when they end."""

from __future__ import annotations

import os
import signal
import time

import pytest
from redis import Redis
from rq.job import Job
from rq.registry import FailedJobRegistry
from rq.serializers import JSONSerializer

from tests.support.jobs import (
    a_document,
    a_pose_table,
    a_request,
    ended,
    read_batch,
    submit_batch,
    table_of,
)
from tests.support.processes import PATIENCE, Workers, descendants, is_running, until
from worker.answers.kinds import Item
from worker.jobs.queue import JobQueue
from worker.jobs.records import Client
from worker.settings import WorkerSettings

HARD = "tests.support.hard_tasks."


def of_task(redis: Redis, name: str) -> JobQueue:
    return JobQueue(redis, WorkerSettings(task=HARD + name))


def failed(queue: JobQueue) -> list[Job]:
    """The RQ jobs in the failed registries of the lanes."""
    registries = [FailedJobRegistry(queue=lane) for lane in queue.chunks.queues.values()]
    return [
        Job.fetch(name, connection=queue.redis, serializer=JSONSerializer)
        for registry in registries
        for name in registry.get_job_ids()
    ]


def error_of(job: Job) -> str:
    result = job.latest_result()
    return "" if result is None else result.exc_string or ""


def test_a_table_and_a_document(queue: JobQueue, workers: Workers) -> None:
    workers.start()
    view = ended(queue, queue.submit(a_request("1", "2", "14.98")).id)
    assert (view.status, view.done, view.total) == ("succeeded", 3, 3)
    assert [part["l1"] for part in table_of(queue, view.id)["slices"]] == ["1", "2", "14.98"]
    assert ended(queue, queue.submit(a_document(), is_unknown=True).id).status == "succeeded"


def test_known_slices_are_done_from_the_beginning(queue: JobQueue, workers: Workers) -> None:
    workers.start()
    ended(queue, queue.submit(a_request("2", "4")).id)
    workers.stop()
    view = queue.submit(a_request("1", "2", "3", "4", "5"))
    assert (view.done, view.total) == (2, 5)
    workers.start()
    view = ended(queue, view.id)
    assert (view.status, view.done) == ("succeeded", 5)


def test_an_equal_question_joins(queue: JobQueue) -> None:
    first, second = queue.submit(a_request("1")), queue.submit(a_request("1"))
    assert (first.run, first.id) == (second.run, second.id)
    assert queue.chunks.depths()["small"] == 1


def test_a_dead_worker_loses_nothing(redis: Redis, workers: Workers) -> None:
    """Worker and horse are killed; the chunk is back within ten seconds, and no orphan computes."""
    queue = of_task(redis, "gated")
    first = workers.start(task=HARD + "gated")
    view = queue.submit(a_request("1", "2"))
    until(lambda: redis.llen("begun") == 1)
    (horse,) = descendants(first.pid)
    workers.start(task=HARD + "gated")
    first.kill()
    since = time.monotonic()
    redis.set("gate", 1)
    assert ended(queue, view.id).status == "succeeded"
    assert time.monotonic() - since < 30  # 10 on an idle machine
    until(lambda: not is_running(horse))


def test_a_horse_that_dies_once_costs_nothing(redis: Redis, workers: Workers) -> None:
    queue = of_task(redis, "gated")
    worker = workers.start(task=HARD + "gated")
    view = queue.submit(a_request("1", "2"))
    until(lambda: redis.llen("begun") == 1)
    (horse,) = descendants(worker.pid)
    os.kill(horse, signal.SIGKILL)
    redis.set("gate", 1)
    assert ended(queue, view.id).status == "succeeded"
    assert not table_has_errors(queue, view.id)
    assert failed(queue) == []


def table_has_errors(queue: JobQueue, job_id: str) -> bool:
    return any("error" in part for part in table_of(queue, job_id)["slices"])


@pytest.mark.parametrize(
    ("task", "kind", "settings"),
    [
        ("crash", "worker-crashed", {}),
        ("leave", "worker-crashed", {}),
        ("greedy_python", "resource-exhausted", {}),
        ("greedy", "resource-exhausted", {"memory_limit_mb": 1024}),
    ],
)
def test_only_the_slice_is_lost_that_ends_its_process(
    redis: Redis, workers: Workers, task: str, kind: str, settings: dict[str, int]
) -> None:
    queue = of_task(redis, task)
    workers.start(task=HARD + task, **settings)
    view = ended(queue, queue.submit(a_request("11", "12", "13", "14", "15")).id)
    assert view.status == "succeeded"
    parts = {part["l1"]: part for part in table_of(queue, view.id)["slices"]}
    assert parts["13"]["error"]["type"] == kind
    assert not any("error" in part for l1, part in parts.items() if l1 != "13")
    (attempt,) = failed(queue)
    assert kind in error_of(attempt)
    assert "slice 13" in error_of(attempt)


@pytest.mark.parametrize(("task", "kind"), [("crash", "worker-crashed"), ("broken", "internal-error")])
def test_a_document_that_cannot_be_computed_fails(
    redis: Redis, workers: Workers, task: str, kind: str
) -> None:
    queue = of_task(redis, task)
    workers.start(task=HARD + task)
    view = ended(queue, queue.submit(a_document()).id)
    assert view.status == "failed"
    assert view.error is not None
    assert view.error["type"] == kind
    until(lambda: failed(queue))
    (attempt,) = failed(queue)
    assert "poses" in (attempt.description or "")
    assert error_of(attempt)


def test_a_deadline_ends_a_call_of_c(redis: Redis, workers: Workers) -> None:
    queue = JobQueue(redis, WorkerSettings(task=HARD + "endless", deadline_seconds=3))
    workers.start(task=HARD + "endless", deadline_seconds=3)
    view = ended(queue, queue.submit(a_document()).id)
    assert view.status == "failed"
    assert view.error is not None
    assert view.error["type"] == "timeout"


def test_a_cancel_ends_a_call_of_c(redis: Redis, workers: Workers) -> None:
    queue = of_task(redis, "endless")
    worker = workers.start(task=HARD + "endless")
    view = queue.submit(a_request("1"))
    until(lambda: queue.get(view.id).status == "running")  # type: ignore[union-attr]
    (horse,) = descendants(worker.pid)
    canceled = queue.cancel(view.id)
    assert canceled is not None
    assert canceled.status == "canceled"
    until(lambda: not is_running(horse))
    assert failed(queue) == []


def test_a_job_ends_when_the_last_key_withdraws(redis: Redis, workers: Workers) -> None:
    queue = of_task(redis, "gated")
    workers.start(task=HARD + "gated")
    one, other, stranger = (Client(f"key:{name}", is_known=True) for name in "abc")
    view = queue.submit(a_request("1"), by=one)
    assert queue.submit(a_request("1"), by=other).run == view.run
    for who, status in ((stranger, "active"), (one, "active"), (other, "canceled")):
        now = queue.withdraw(view.id, who)
        assert now is not None
        assert now.is_terminal == (status == "canceled")


def test_a_stopping_worker_gives_its_chunk_back(redis: Redis, workers: Workers) -> None:
    queue = of_task(redis, "slow_once")
    first = workers.start(task=HARD + "slow_once", shutdown_grace=0.2)
    view = queue.submit(a_request("1"))
    until(lambda: queue.get(view.id).status == "running")  # type: ignore[union-attr]
    first.terminate()
    assert first.wait(PATIENCE) == 0
    assert queue.chunks.depths()["small"] == 1
    workers.start(task=HARD + "slow_once")
    assert ended(queue, view.id).status == "succeeded"


def test_a_false_estimate_does_not_stop_the_small_lane(redis: Redis, workers: Workers) -> None:
    """One endless question that is estimated as small goes to the heavy lane after two seconds."""
    queue = of_task(redis, "endless_at_13")
    workers.start("light", task=HARD + "endless_at_13")
    endless = queue.submit(a_request("13", "14"))
    small = queue.submit(a_request("5"))
    assert ended(queue, small.id).status == "succeeded"
    assert queue.get(endless.id).status == "running"  # type: ignore[union-attr]
    assert queue.chunks.depths() == {"small": 0, "heavy": 1, "batch": 0}
    work = {name.decode(): int(value) for name, value in redis.hgetall(queue.keys.work).items()}
    assert work["small:done"] >= work["small:added"] - 1
    assert work["heavy:added"] > work.get("heavy:done", 0)


def test_of_a_batch_only_the_item_is_lost_that_ends_its_process(redis: Redis, workers: Workers) -> None:
    queue = of_task(redis, "crash")
    workers.start(task=HARD + "crash")
    items = [Item("a", a_request("1")), Item("b", a_request("13")), Item("c", None, {"title": "no"})]
    view = ended(queue, submit_batch(queue, [*items, Item("d", a_request("2"))]).id)
    assert (view.status, view.done, view.failed) == ("succeeded", 4, 2)
    states = {item.item.id: item for item in read_batch(queue, view)}
    assert [states[name].state for name in "abcd"] == ["succeeded", "failed", "failed", "succeeded"]
    assert states["b"].outcome.failure is not None
    assert states["b"].outcome.failure["type"] == "worker-crashed"


def test_a_batch_of_many_items(queue: JobQueue, workers: Workers) -> None:
    workers.start()
    items = [Item(None, a_pose_table(f"{10 + i}/7")) for i in range(60)]
    view = ended(queue, submit_batch(queue, items).id)
    assert (view.status, view.done, view.failed) == ("succeeded", 60, 0)


def test_an_idle_worker_ends_at_once(workers: Workers) -> None:
    worker = workers.start()
    worker.terminate()
    assert worker.wait(PATIENCE) == 0
    assert "Traceback" not in workers.log.read_text()


def test_many_false_estimates_delay_a_small_question_by_a_few_seconds(redis: Redis, workers: Workers) -> None:
    """Eight endless ones and two workers: each takes four of them, for two seconds each."""
    queue = of_task(redis, "endless_at_13")
    for duty in ("light", "all"):
        workers.start(duty, task=HARD + "endless_at_13")
    endless = [queue.submit(a_request("13", digits=digits)).id for digits in range(20, 28)]
    start = time.monotonic()
    assert ended(queue, queue.submit(a_request("5")).id).status == "succeeded"
    assert time.monotonic() - start < 30  # 10 on an idle machine
    assert sum(queue.chunks.depths().values()) >= len(endless) - 1, "all wait in the heavy lane, but one"
    for job_id in endless:
        queue.cancel(job_id)
