from __future__ import annotations

import pytest
from redis import Redis

from tests.support.jobs import a_request
from tests.support.valkey import redis, valkey
from worker.answers.kind import JobRequest
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

__all__ = ["redis", "valkey"]


@pytest.fixture
def settings() -> WorkerSettings:
    """Short times, but for locks, which no worker renews here."""
    return WorkerSettings(chunk_size=3, sweep_interval=0.001, lost_grace=0.005, beat_ttl=60)


@pytest.fixture
def queue(redis: Redis, settings: WorkerSettings) -> JobQueue:
    return JobQueue(redis, settings)


@pytest.fixture
def table_request() -> JobRequest:
    """Five slices: two chunks with the settings above."""
    return a_request("1", "2", "3", "4", "5")
