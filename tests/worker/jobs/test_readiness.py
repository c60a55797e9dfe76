"""The lanes that stand still although workers are alive."""

from __future__ import annotations

import pytest

from tests.support.jobs import a_heavy_document, a_request
from worker.jobs import installation
from worker.jobs.installation import Roster
from worker.jobs.queue import JobQueue


def test_a_small_job_that_nobody_begins(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    queue.submit(a_request("1"))
    assert queue.readiness().warnings == (), "there is no worker at all, which is worse"
    Roster(queue.redis, queue.settings).beat("worker")
    assert queue.readiness().warnings == ()
    monkeypatch.setattr(installation, "STILL", -1.0)
    [warning] = queue.readiness().warnings
    assert warning.startswith("the lane small stands still: its first job was submitted ")


def test_a_small_job_whose_record_is_gone(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "STILL", 0.5)
    queue.redis.delete(queue.records.keys.job(queue.submit(a_request("1")).id).record)
    Roster(queue.redis, queue.settings).beat("worker")
    assert queue.readiness().warnings == ()


def test_heavy_chunks_without_a_worker_for_them(queue: JobQueue) -> None:
    queue.submit(a_heavy_document())
    roster = Roster(queue.redis, queue.settings)
    roster.beat("light", is_light=True)
    [warning] = queue.readiness().warnings
    assert "the lane heavy stands still: all workers have light duty" in warning
    roster.beat("strong")
    assert queue.readiness().warnings == ()
