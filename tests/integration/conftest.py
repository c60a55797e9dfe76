from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import Workers
from worker import connect


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
def workers(valkey: EmbeddedValkey, redis: Redis, tmp_path: Path) -> Iterator[Workers]:  # noqa: ARG001
    pool = Workers(valkey.url, tmp_path / "workers.log")
    yield pool
    pool.stop()
