from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import Workers
from tests.support.valkey import redis, valkey

__all__ = ["redis", "valkey"]


@pytest.fixture
def workers(valkey: EmbeddedValkey, redis: Redis, tmp_path: Path) -> Iterator[Workers]:  # noqa: ARG001
    pool = Workers(valkey.url, tmp_path / "workers.log")
    yield pool
    pool.stop()
