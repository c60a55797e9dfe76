"""A Valkey server, a client of it and workers, as fixtures for the conftest that imports them.

Each such conftest has its own server: the workers of one directory of tests never see the jobs of another,
and are unaffected by its flushes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import Workers
from worker.connection import connect


@pytest.fixture(scope="session")
def valkey(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedValkey]:
    with EmbeddedValkey(tmp_path_factory.mktemp("valkey")) as server:
        yield server


@pytest.fixture
def redis(valkey: EmbeddedValkey) -> Iterator[Redis]:
    """A client of the server, with an empty database."""
    with connect(valkey.url) as client:
        client.execute_command("FLUSHALL", "SYNC")  # memory freed later would disturb what measures it
        yield client


@pytest.fixture
def workers(valkey: EmbeddedValkey, redis: Redis, tmp_path: Path) -> Iterator[Workers]:  # noqa: ARG001
    """Starts worker processes on the empty database."""
    pool = Workers(valkey.url, tmp_path / "workers.log")
    yield pool
    pool.stop()
