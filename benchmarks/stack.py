"""The real service for a benchmark: embedded Valkey, workers and API on a free port of 127.0.0.1."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

GEOMETRY = {"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"}
"""The article's first manipulator."""


@dataclass(frozen=True)
class Stack:
    """A running service: the process of `serve`, and the port of its API."""

    pid: int
    port: int

    @property
    def url(self) -> str:
        """The address of the API."""
        return f"http://127.0.0.1:{self.port}"


@contextmanager
def serving(*options: str, **settings: str) -> Iterator[Stack]:
    """Runs `rpr-cusps serve` in an empty data directory, and ends it with the block.

    `settings` are variables of its environment, without the prefix `RPR_CUSPS_`.
    """
    environment = {**os.environ, **{f"RPR_CUSPS_{name}": value for name, value in settings.items()}}
    with tempfile.TemporaryDirectory() as data:
        own = [] if "--redis-url" in options else ["--data-dir", data]
        command = [sys.executable, "-m", "service", "serve", "--port", "0", *own, *options]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment
        ) as process:
            try:
                assert process.stdout is not None
                address = re.search(r"http://[\d.]+:(\d+)", process.stdout.readline())
                if address is None:
                    raise SystemExit("the service did not start")
                yield Stack(process.pid, int(address[1]))
            finally:
                process.terminate()
