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
from worker.process.programs import Process, Program, Say, Start
from worker.settings import Duty, WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_HEALTHY = 30.0  # seconds after which a process is healthy and its earlier deaths are forgotten
_LONGEST_DELAY = 10.0
_START_PATIENCE = 60.0  # seconds until the first sign of life, while a whole machine may be starting
_BLINK = 2.0  # a longer time between two looks means that the observer itself was stopped
_LAST_PATIENCE = 2.0

_TIMEOUT = 2.0
_HANG_SECONDS = 10.0
_STOP_MARGIN = 4.0


class Child:
    """A process, judged by its signs of life, not by the process table alone.

    A failed start is reported and repeated. Processes that end with the thread that started them need all
    calls in one thread.

    Args:
        what: its name in reports.
        launch: starts the process.
        say: reports what happens to it.
        patience: how long it may be silent, in seconds.
        stop_patience: how long it may take to end.
    """

    def __init__(
        self, what: str, launch: Callable[[], Process], say: Say, patience: float, stop_patience: float
    ) -> None:
        self.what = what
        self.stop_patience = stop_patience
        self.process: Process | None = None
        self._launch, self._say, self._patience = launch, say, patience
        self._started = self._looked = time.monotonic()
        self._judged_from = 0.0
        self._failures = 0
        self._next_start = 0.0
        self._logged = ""
        self._is_killed = False

    def start(self) -> None:
        """Start the process; if that fails, a later look tries again."""
        try:
            process = self._launch()
        except Exception as error:  # whatever it is, it may be over in a moment
            why = "out of memory" if isinstance(error, MemoryError) else error
            if (text := f"cannot start {self.what}: {why}; trying again") != self._logged:
                self._say(text)
            self._logged = text
            self._delay(is_repeated=True)
        else:
            self.adopt(process)

    def adopt(self, process: Process) -> None:
        """Look after a process that was started elsewhere."""
        self.process, self._started = process, time.monotonic()
        self._is_killed, self._logged = False, ""

    def sign(self) -> float | None:
        """The time of its last sign of life (`time.monotonic()`, 0 for none yet), None if that is unknown."""
        return None

    def loss(self) -> str | None:
        """The reason why it can no longer do its work, if there is one."""
        return None

    def look_after(self) -> None:
        """Start the process again if it has ended, and kill it if it hangs; takes no time."""
        now = time.monotonic()
        if now - self._looked > _BLINK:
            self._judged_from = now
        self._looked = now
        if self.process is not None and (code := self.process.poll()) is not None:
            self._note_end(code)
        elif self.process is not None and not self._is_killed and (reason := self._fault()):
            self._say(f"{self.what} {reason}; starting another")
            self.process.kill()
            self._is_killed = True
        if self.process is None and now >= self._next_start:
            self.start()

    def _fault(self) -> str | None:
        if (sign := self.sign()) is None:
            return None
        if sign > self._started and (lost := self.loss()):
            return lost
        patience = self._patience if sign > self._started else max(_START_PATIENCE, self._patience)
        silence = time.monotonic() - max(sign, self._started, self._judged_from)
        return f"gives no sign of life for {silence:.0f} s" if silence > patience else None

    def _note_end(self, code: int) -> None:
        if not self._is_killed:
            how = signal_name(-code) if code < 0 else f"exit status {code}"
            self._say(f"{self.what} died ({how}); starting another")
        self.process = None
        self._delay(is_repeated=time.monotonic() - self._started <= _HEALTHY)

    def _delay(self, *, is_repeated: bool) -> None:
        self._failures = self._failures + 1 if is_repeated else 1
        exponent = min(self._failures, 10) - 2
        pause = min(_LONGEST_DELAY, 2.0**exponent) if exponent >= 0 else 0.0
        self._next_start = time.monotonic() + pause if pause else 0.0


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
                with contextlib.suppress(
                    subprocess.TimeoutExpired
                ):  # the kernel keeps it until a disk answers
                    process.wait(_LAST_PATIENCE)
        left = [(p, patience) for p, patience in left if p.poll() is None and now <= start + patience]
        time.sleep(0.01)


def _ask_to_end(process: Process) -> None:
    process.terminate()
    process.send_signal(signal.SIGCONT)  # a stopped process does not hear the other signal


class WorkerPool:
    """`count` workers, which end with the thread that started them.

    `rq.worker_pool.WorkerPool` is unsuitable: its workers outlive it if it is killed, it restarts a failing
    worker without a pause, never one that hangs, and it does not know when all workers are ready.
    """

    def __init__(
        self,
        count: int,
        redis_url: str,
        log_level: str = "WARNING",
        say: Say = log.warning,
        hang_seconds: float = _HANG_SECONDS,
        start: Start = Program.start,
    ) -> None:
        settings = WorkerSettings()
        self._environment = {
            **os.environ,
            "RPR_CUSPS_REDIS_URL": redis_url,
            "RPR_CUSPS_LOG_LEVEL": log_level,
        }
        self._start = start
        self._redis = connect(redis_url, timeout=_TIMEOUT)
        terms = say, hang_seconds, settings.shutdown_grace + _STOP_MARGIN
        # one of several is kept for short work
        duties: list[Duty] = ["light" if i == 0 and count > 1 else "all" for i in range(count)]
        self.members = [_Member(self, duty, *terms) for duty in duties]

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

    def launch(self, name: str, duty: Duty) -> Process:
        """Start the process of a worker."""
        options = ("--name", name, "--parent-pid", str(os.getpid()), "--duty", duty)
        return self._start(Program("worker.__main__", options, self._environment))


class _Member(Child):
    """A place in the pool; each worker that takes it has a name of its own."""

    def __init__(self, pool: WorkerPool, duty: Duty, say: Say, patience: float, stop_patience: float) -> None:
        super().__init__("a worker", self._launch_anew, say, patience, stop_patience)
        self.name = ""
        self._pool, self._duty = pool, duty

    def _launch_anew(self) -> Process:
        self.name = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}"
        return self._pool.launch(self.name, self._duty)
