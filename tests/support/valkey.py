"""A Valkey server and a client of it, as fixtures for the conftest that imports them.

Each such conftest has its own server: the workers of one directory of tests never see the jobs of another,
and are unaffected by its flushes.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
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
