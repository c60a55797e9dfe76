"""The server of a data directory, whether or not a service is running on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.stack.data_dir import runtime_dir
from service.stack.embedded_valkey import EmbeddedValkey
from worker.connection import UnreachableError, check


@contextmanager
def attached(data_dir: Path | None) -> Iterator[str]:
    """The address of the embedded server that runs on a directory, or of one that runs as long as the block.

    Raises:
        EmbeddedError: there is none, and none can be started.
    """
    server = EmbeddedValkey(data_dir)
    running = runtime_dir(server.data_dir) / "valkey.sock"
    if running.exists() and _answers(f"unix://{running}"):
        yield f"unix://{running}"
        return
    with server:
        yield server.url


def _answers(url: str) -> bool:
    try:
        check(url)
    except UnreachableError:
        return False
    return True
