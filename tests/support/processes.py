"""Real processes: workers, and a look at what is still running."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from worker import connect

T = TypeVar("T")

ROOT = Path(__file__).parents[2]


@dataclass
class Workers:
    """Starts worker processes and ends them, by their ids, when the test is over."""

    url: str
    log: Path
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self, **settings: object) -> subprocess.Popen[bytes]:
        """One worker, ready for work; settings as in `WorkerSettings`."""
        name = f"test-{os.getpid()}-{len(self.processes)}-{time.monotonic_ns()}"
        with self.log.open("ab") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "worker", "--redis-url", self.url, "--name", name],
                env=environment(**settings),
                cwd=ROOT,
                stderr=log,
            )
        self.processes.append(process)
        with connect(self.url) as client:
            until(lambda: client.hget(f"rq:worker:{name}", "state") == b"idle")
        return process

    def stop(self) -> None:
        """End all workers."""
        for process in self.processes:
            process.send_signal(signal.SIGTERM)
        for process in self.processes:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def environment(**settings: object) -> dict[str, str]:
    """The environment of a child process, in which worker settings are given and hard tasks are found."""
    given = {f"RPR_CUSPS_{name.upper()}": str(value) for name, value in settings.items()}
    paths = [*filter(None, [os.environ.get("PYTHONPATH")]), str(ROOT)]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **given}


def until(condition: Callable[[], T], seconds: float = 20.0) -> T:
    """Wait for something that must come about, and give what it came to."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "it did not come about in time"
        time.sleep(0.02)
    return value


def is_running(pid: int) -> bool:
    """Whether a process runs; one that has ended and was not collected yet does not."""
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return bool(state.stdout.strip()) and not state.stdout.strip().startswith("Z")


def descendants(pid: int) -> list[int]:
    """All processes that a process has started, and those that they have started."""
    table = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    pairs = [(int(child), int(parent)) for child, parent in (line.split() for line in table.splitlines())]
    found = [pid]
    for parent in found:
        found += [child for child, its_parent in pairs if its_parent == parent]
    return [child for child in found[1:] if is_running(child)]
