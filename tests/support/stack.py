"""`serve` as by a user: a supervisor and its children, as real processes."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from redis import Redis

from service.stack.data_dir import runtime_dir
from tests.support.processes import (
    PATIENCE,
    completed,
    descendants,
    environment,
    started,
)
from worker.connection import connect

SERVE = """
import sys
from pathlib import Path
from service.stack.serve import ServeSettings, serve
_, port, workers, data, url = sys.argv
settings = ServeSettings(port=int(port), workers=int(workers), data_dir=Path(data), redis_url=url or None)
sys.exit(serve(settings))
"""


@dataclass
class Stack:
    """A running stack."""

    process: subprocess.Popen[str]
    announcement: str
    data: Path

    @property
    def base(self) -> str:
        address = re.search(r"http://\S+", self.announcement)
        assert address is not None
        return address.group()

    def redis(self) -> Redis:
        return connect(f"unix://{runtime_dir(self.data)}/valkey.sock")

    def parts(self) -> list[int]:
        processes = descendants(self.process.pid)
        assert processes
        return processes

    def part(self, name: str) -> int:
        """The process id of a child: `api_process`, `valkey-server` or `worker.__main__`."""
        table = subprocess.run(
            ["ps", "-ww", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
        )
        rows = [line.split(None, 2) for line in table.stdout.splitlines()]
        [pid] = [int(row[0]) for row in rows if int(row[1]) == self.process.pid and name in row[2]]
        return pid

    def complaints(self) -> list[str]:
        """What it wrote to stderr until it ended, line by line."""
        assert self.process.stderr is not None
        return str(self.process.stderr.read()).splitlines()


def command(data: Path, *, port: int = 0, workers: int = 1, url: str = "") -> list[str]:
    return [sys.executable, "-c", SERVE, str(port), str(workers), str(data), url]


@contextmanager
def running(
    data: Path, *, workers: int = 1, url: str = "", in_full: bool = False, **settings: object
) -> Iterator[Stack]:
    options = {"in_full": in_full, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    variables = environment(**{"access_log": "off", **settings})
    with started(command(data, workers=workers, url=url), env=variables, **options) as process:
        try:
            yield Stack(process, process.stdout.readline(), data)
        finally:
            process.terminate()
            process.wait(PATIENCE)


def failure(data: Path, settings: dict[str, object] | None = None, status: int = 1, **options: object) -> str:
    done = completed(command(data, **options), environment(**(settings or {})))  # type: ignore[arg-type]
    assert done.returncode == status
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr
