"""The state of an installation."""

from __future__ import annotations

import pytest

from tests.support.jobs import a_heavy_document, a_request
from worker.jobs import Lane, installation
from worker.jobs.queue import JobQueue


def register(queue: JobQueue, *lanes: Lane) -> None:
    """Enter a worker for some lanes into RQ's register."""
    name = f"rq:worker:{'-'.join(lanes)}"
    queue.redis.hset(name, "state", "idle")
    for lane in lanes:
        queue.redis.sadd(f"rq:workers:{queue.chunks.queues[lane].name}", name)


def test_a_small_job_that_nobody_begins(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    queue.submit(a_request("1"))
    assert queue.readiness().warnings == (), "there is no worker at all, which is worse"
    register(queue, "small", "heavy")
    assert queue.readiness().warnings == ()
    monkeypatch.setattr(installation, "STILL", -1.0)
    [warning] = queue.readiness().warnings
    assert "small" in warning


def test_a_small_job_whose_record_is_gone(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "STILL", 0.5)
    queue.redis.delete(queue.keys.job(queue.submit(a_request("1")).id).record)
    register(queue, "small", "heavy")
    assert queue.readiness().warnings == ()


def test_heavy_chunks_without_a_worker_for_them(queue: JobQueue) -> None:
    queue.submit(a_heavy_document())
    register(queue, "small")
    [warning] = queue.readiness().warnings
    assert "heavy" in warning
    register(queue, "small", "heavy", "batch")
    assert (queue.readiness().warnings, queue.readiness().workers) == ((), 2)


def test_a_dead_worker_is_not_counted(queue: JobQueue) -> None:
    register(queue, "small")
    queue.redis.delete("rq:worker:small")  # as its expiry does
    assert queue.workers() == 0
