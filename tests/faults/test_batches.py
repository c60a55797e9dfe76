"""Batches, when items, work horses, workers or the API fail."""

from __future__ import annotations

import pytest
from redis import Redis

from tests.support.jobs import a_document, a_request, ended, read_batch, submit_batch
from tests.support.processes import PATIENCE, Workers, until
from worker.answers.items import Item
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SHORT = {"beat_interval": 0.2, "beat_ttl": 2, "sweep_interval": 0.2, "lost_grace": 0.2}


def jobs(redis: Redis, task: str = "", **settings: object) -> JobQueue:
    """The queue as an API process sees it; with `task`, its chunks run one of the hard tasks."""
    name = f"tests.support.hard_tasks.{task}" if task else "worker.process.tasks.run_chunk"
    return JobQueue(redis, WorkerSettings.model_validate({"task": name, **settings}))


def tables(*l1: str) -> list[Item]:
    return [Item(request=a_request(x)) for x in l1]


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ("crash", "worker-crashed"),
        ("leave", "worker-crashed"),
        ("greedy", "resource-exhausted"),
        ("greedy_python", "resource-exhausted"),
    ],
)
def test_an_item_whose_horse_dies_each_time(redis: Redis, workers: Workers, task: str, reason: str) -> None:
    """The work horse of one item crashes, leaves or runs out of memory at every attempt. That item fails; the
    others of its chunk are answered.
    """
    queue = jobs(redis, task)
    workers.start(task=queue.settings.task, memory_limit_mb=1024, max_losses=1, log_level="CRITICAL")
    view = ended(queue, submit_batch(queue, tables("1", "13", "2")).id)
    assert (view.status, view.done, view.failed) == ("succeeded", 3, 1)
    assert [stored.state for stored in read_batch(queue, view)] == ["succeeded", "failed", "succeeded"]
    failure = read_batch(queue, view)[1].outcome.failure
    assert failure is not None
    assert failure["type"] == reason


def test_an_item_that_never_ends(redis: Redis, workers: Workers) -> None:
    """An item hangs in C code. Its work horse ends at the deadline, and it fails; the others are answered."""
    queue = jobs(redis, "endless_at_13")
    workers.start(task=queue.settings.task, deadline=0.7, log_level="CRITICAL")
    view = ended(queue, submit_batch(queue, tables("1", "13", "2")).id)
    assert (view.status, view.failed) == ("succeeded", 1)
    failure = read_batch(queue, view)[1].outcome.failure
    assert failure is not None
    assert failure["type"] == "timeout"


def test_the_worker_of_a_batch_is_killed(redis: Redis, workers: Workers) -> None:
    """The worker of a batch is killed. Another one goes on with the item at which it was."""
    queue = jobs(redis, "slow")
    first = workers.start(task=queue.settings.task, **SHORT)
    view = submit_batch(queue, tables(*map(str, range(1, 13))))
    until(lambda: sum(stored.state == "succeeded" for stored in read_batch(queue, view)) >= 3)
    first.kill()
    first.wait(PATIENCE)
    workers.start(task=queue.settings.task, **SHORT)
    view = ended(queue, view.id)
    assert (view.status, view.done, view.failed) == ("succeeded", 12, 0)
    pids = [queue.store.get_slices(a_request(str(x)))[str(x)]["certificate"]["pid"] for x in range(1, 13)]
    assert len(set(pids)) == 2
    assert pids == sorted(pids, key=pids.index)


def test_redis_loses_the_items_of_a_batch(redis: Redis, workers: Workers) -> None:
    """Redis loses the items of a batch that waits. It fails with the reason, and the worker goes on."""
    queue = jobs(redis)
    view = submit_batch(queue, tables("1", "2"))
    redis.delete(queue.records.keys.items(view.id))
    workers.start()
    view = ended(queue, view.id)
    assert view.status == "failed"
    assert view.error is not None
    assert view.error["type"] == "worker-lost"
    assert ended(queue, submit_batch(queue, [Item(request=a_document())]).id).status == "succeeded"


def test_batches_with_the_same_questions(redis: Redis, workers: Workers) -> None:
    """Three batches and a job ask the same at the same time. Each slice and document is computed once."""
    for _ in range(2):
        workers.start()
    queue = jobs(redis, "counted")
    items = [*tables("14.98", "27"), Item(request=a_document())]
    views = [submit_batch(queue, items) for _ in range(3)]
    ended(queue, queue.submit(a_request("27", "14.98")).id)
    for view in views:
        assert ended(queue, view.id).status == "succeeded"
    assert redis.get("eliminations") == b"1"
