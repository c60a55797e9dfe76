from __future__ import annotations

import pytest
from redis import Redis

from tests.support.jobs import a_request
from tests.support.valkey import redis, valkey, workers
from worker.answers.kind import JobRequest
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

__all__ = ["redis", "valkey", "workers"]


@pytest.fixture
def settings() -> WorkerSettings:
    return WorkerSettings()


@pytest.fixture
def queue(redis: Redis, settings: WorkerSettings) -> JobQueue:
    return JobQueue(redis, settings)


@pytest.fixture
def table_request() -> JobRequest:
    """Five slices."""
    return a_request("1", "2", "3", "4", "5")
