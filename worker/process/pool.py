"""Child processes that are kept running, and the workers of one machine among them."""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterable, Sequence

from redis.exceptions import RedisError

from worker.connection import connect
from worker.process.processes import signal_name
from worker.process.programs import Process, Program
from worker.settings import Duty, WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

Say = Callable[[str], object]
"""What reports a line to the operator."""

_HEALTHY = 30.0
"""Seconds after which a process is healthy and its earlier deaths are forgotten."""

_LONGEST_DELAY = 10.0
"""Seconds between two starts of a process that dies again and again."""

_LAST_PATIENCE = 2.0
"""Seconds that a killed process may take, for example while a disk does not answer."""

_TIMEOUT = 2.0
"""Seconds to wait for Redis when it is asked which workers are ready."""

_STOP_MARGIN = 4.0
"""Seconds that a worker may take to end, beside those of its chunk."""


class Child:
    """A process that is started again whenever it ends, after a pause that grows while it keeps ending.

    A failed start is reported and repeated. Processes that end with the thread that started them need all
    calls in one thread.

    Args:
        what: its name in reports.
        launch: starts the process.
        say: reports what happens to it.
        stop_patience: how long it may take to end, in seconds.
    """

    def __init__(self, what: str, launch: Callable[[], Process], say: Say, stop_patience: float) -> None:
        self.stop_patience = stop_patience
        self.process: Process | None = None
        self._what, self._launch, self._say = what, launch, say
        self._started = self._next_start = 0.0
        self._failures = 0
        self._logged = ""

    def start(self) -> None:
        """Start the process; if that fails, a later look tries again."""
        try:
            self.adopt(self._launch())
        except Exception as error:  # whatever it is, it may be over in a moment
            why = "out of memory" if isinstance(error, MemoryError) else error
            if (text := f"cannot start {self._what}: {why}; trying again") != self._logged:
                self._say(text)
            self._logged = text
            self._delay(is_repeated=True)

    def adopt(self, process: Process) -> None:
        """Look after a process that runs already."""
        self.process = process
        self._started, self._logged = time.monotonic(), ""

    def look_after(self) -> None:
        """Start the process again if it has ended; takes no time."""
        if self.process is not None and (code := self.process.poll()) is not None:
            how = signal_name(-code) if code < 0 else f"exit status {code}"
            self._say(f"{self._what} died ({how}); starting another")
            self.process = None
            self._delay(is_repeated=time.monotonic() - self._started <= _HEALTHY)
        if self.process is None and time.monotonic() >= self._next_start:
            self.start()

    def _delay(self, *, is_repeated: bool) -> None:
        """Pause before the next start: not the first time, then 1, 2, 4 … seconds."""
        self._failures = self._failures + 1 if is_repeated else 1
        pause = min(_LONGEST_DELAY, 2.0 ** (min(self._failures, 10) - 2)) if self._failures > 1 else 0.0
        self._next_start = time.monotonic() + pause


def running(children: Iterable[Child]) -> list[tuple[Process, float]]:
    """The processes that run, and how long each may take to end."""
    return [(child.process, child.stop_patience) for child in children if child.process is not None]


def end_all(
    processes: Sequence[tuple[Process, float]], is_hurried: Callable[[], bool] = lambda: False
) -> None:
    """Ask processes to end, and kill each after its patience in seconds; in a hurry, after one second."""
    for process, _ in processes:
        _ask_to_end(process)
    start, end_of_hurry = time.monotonic(), float("inf")
    left = list(processes)
    while left:
        now = time.monotonic()
        if is_hurried() and end_of_hurry == float("inf"):
            end_of_hurry = now + 1.0
            for process, _ in left:
                _ask_to_end(process)
        for process, patience in left:
            if now > min(start + patience, end_of_hurry):
                process.kill()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(_LAST_PATIENCE)
        left = [(p, patience) for p, patience in left if p.poll() is None and now <= start + patience]
        time.sleep(0.01)


def _ask_to_end(process: Process) -> None:
    process.terminate()
    process.send_signal(signal.SIGCONT)  # a stopped process does not hear the other signal


class WorkerPool:
    """`count` workers, which end with the thread that started them.

    `rq.worker_pool.WorkerPool` is unsuitable: its workers outlive it if it is killed, it restarts a failing
    worker without a pause, and it does not know when all workers are ready.
    """

    def __init__(
        self, count: int, redis_url: str, log_level: str = "WARNING", say: Say = log.warning
    ) -> None:
        self._environment = {
            **os.environ,
            "RPR_CUSPS_REDIS_URL": redis_url,
            "RPR_CUSPS_LOG_LEVEL": log_level,
        }
        self._redis = connect(redis_url, timeout=_TIMEOUT)
        patience = WorkerSettings().shutdown_grace + _STOP_MARGIN
        # one of several is kept for short work
        duties: list[Duty] = ["light" if i == 0 and count > 1 else "all" for i in range(count)]
        self.members = [_Member(self._environment, duty, say, patience) for duty in duties]

    def start(self) -> None:
        """Start all workers."""
        for member in self.members:
            member.start()

    def is_ready(self) -> bool:
        """Whether all workers have said that they are alive."""
        try:
            return all(self._redis.exists(f"rq:worker:{member.name}") for member in self.members)
        except RedisError:
            return False

    def stop(self, is_hurried: Callable[[], bool] = lambda: False) -> None:
        """Stop all workers; unfinished chunks go back to the queue."""
        end_all(running(self.members), is_hurried)
        self._redis.close()


class _Member(Child):
    """A place in the pool; each worker that takes it has a name of its own."""

    def __init__(self, environment: dict[str, str], duty: Duty, say: Say, stop_patience: float) -> None:
        super().__init__("a worker", self._launch_anew, say, stop_patience)
        self.name = ""
        self._environment, self._duty = environment, duty

    def _launch_anew(self) -> Process:
        self.name = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}"
        options = ("--name", self.name, "--parent-pid", str(os.getpid()), "--duty", self._duty)
        return Program("worker.__main__", options, self._environment).start()
