"""Workers and their horses: what they compute, and what becomes of it when they end."""

from __future__ import annotations

import pytest
from redis import Redis

from tests.support.jobs import (
    a_document,
    a_request,
    ended,
    table_of,
)
from tests.support.processes import PATIENCE, Workers
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

HARD = "tests.support.hard_tasks."


def of_task(redis: Redis, name: str) -> JobQueue:
    return JobQueue(redis, WorkerSettings(task=HARD + name))


def test_a_table_and_a_document(queue: JobQueue, workers: Workers) -> None:
    workers.start()
    view = ended(queue, queue.submit(a_request("1", "2", "14.98")).id)
    assert (view.status, view.done, view.total) == ("succeeded", 3, 3)
    assert [part["l1"] for part in table_of(queue, view.id)["slices"]] == ["1", "2", "14.98"]
    assert ended(queue, queue.submit(a_document(), is_unknown=True).id).status == "succeeded"


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


def test_an_idle_worker_ends_at_once(workers: Workers) -> None:
    worker = workers.start()
    worker.terminate()
    assert worker.wait(PATIENCE) == 0
    assert "Traceback" not in workers.log.read_text()


@pytest.mark.long
def test_many_false_estimates_delay_a_small_question_by_a_few_seconds(redis: Redis, workers: Workers) -> None:
    """Eight endless ones and two workers: each takes four of them, for two seconds each."""
    queue = of_task(redis, "endless_at_13")
    for duty in ("light", "all"):
        workers.start(duty, task=HARD + "endless_at_13")
    endless = [queue.submit(a_request("13", digits=digits)).id for digits in range(20, 28)]
    assert ended(queue, queue.submit(a_request("5")).id).status == "succeeded"
    assert sum(queue.chunks.depths().values()) >= len(endless) - 1, "all wait in the heavy lane, but one"
    for job_id in endless:
        queue.cancel(job_id)
