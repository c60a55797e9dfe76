from __future__ import annotations

from collections.abc import Iterator

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request
from worker import JobQueue, TableRequest, WorkerSettings, connect


@pytest.fixture(scope="session")
def valkey(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedValkey]:
    with EmbeddedValkey(tmp_path_factory.mktemp("valkey")) as server:
        yield server


@pytest.fixture
def redis(valkey: EmbeddedValkey) -> Iterator[Redis]:
    with connect(valkey.url) as client:
        client.flushall()
        yield client


@pytest.fixture
def settings() -> WorkerSettings:
    return WorkerSettings(chunk_size=3, sweep_interval=0.001, lost_grace=0.005)


@pytest.fixture
def queue(redis: Redis, settings: WorkerSettings) -> JobQueue:
    return JobQueue(redis, settings)


@pytest.fixture
def table_request() -> TableRequest:
    """Five slices: two chunks under the settings above."""
    return a_request("1", "2", "3", "4", "5")
