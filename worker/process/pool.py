"""The worker processes of one machine: started together, kept running, stopped together."""

from __future__ import annotations

import logging
import os
import secrets
import socket
import subprocess
import threading
import time
from collections.abc import Callable

from redis.exceptions import RedisError

from worker.connection import connect
from worker.jobs.installation import Roster
from worker.jobs.lanes import Duty
from worker.process.child import Child, Process, Say, end_all, python_program
from worker.settings import WorkerSettings

_PAUSE, _FIRST_PAUSE = 1.0, 0.1
_TIMEOUT = 2.0
_OUTAGE = 4.0  # seconds without an answer of Redis from which on workers cannot be judged by it
_FORGOTTEN = 3600.0
_RETURN = 30.0  # seconds that workers have to come back after such an outage


class Attendance:
    """Reads the roster again and again, in a thread of its own: Redis may hang."""

    def __init__(self, redis_url: str) -> None:
        self._redis = connect(redis_url, timeout=_TIMEOUT)
        self._roster = Roster(self._redis, WorkerSettings())
        self._heard: dict[str, float] = {}
        self._began = self._answered = self._returned = 0.0
        self._is_over = threading.Event()

    def start(self) -> None:
        """Begin to read."""
        self._began = time.monotonic()
        threading.Thread(target=self._run, daemon=True).start()

    def stop(self) -> None:
        """Stop reading, soon."""
        self._is_over.set()

    def heard(self, names: set[str]) -> bool:
        """Whether all these workers have been heard of."""
        return names <= self._heard.keys()

    def sign(self, name: str) -> float | None:
        """When a worker was last heard of (`time.monotonic()`, 0 for never); None if nobody can tell."""
        if time.monotonic() - self._answered > _OUTAGE:
            return None
        return max(self._heard.get(name, 0.0), self._returned)

    def _run(self) -> None:
        with self._redis:
            while not self._is_over.wait(_PAUSE if self._heard else _FIRST_PAUSE):
                try:
                    self._note(self._roster.silences())
                except (RedisError, OSError):
                    continue

    def _note(self, silences: dict[str, float]) -> None:
        now = time.monotonic()
        if max(self._began, self._answered) < now - _OUTAGE:  # it may not have been there at the start
            self._returned = now + _RETURN
        self._answered = now
        heard = self._heard | {name: now - silence for name, silence in silences.items()}
        self._heard = {name: moment for name, moment in heard.items() if now - moment < _FORGOTTEN}


log = logging.getLogger("rpr_cusps.worker")

_HANG_SECONDS = 10.0
_BEATS_MISSED = 3  # even if beats are rare, one that is late is no hang
_STOP_MARGIN = 4.0


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
    ) -> None:
        settings = WorkerSettings()
        self._environment = {
            **os.environ,
            "RPR_CUSPS_REDIS_URL": redis_url,
            "RPR_CUSPS_LOG_LEVEL": log_level,
        }
        self._stop_patience = settings.shutdown_grace + _STOP_MARGIN
        self._attendance = Attendance(redis_url)
        patience = max(hang_seconds, _BEATS_MISSED * settings.beat_interval)
        # one of several is kept for short work
        duties: list[Duty] = ["light" if i == 0 and count > 1 else "all" for i in range(count)]
        self._members = [_Member(self._environment, duty, say, patience) for duty in duties]

    def start(self) -> None:
        """Start all workers."""
        for member in self._members:
            member.child.start()
        if self._members:
            self._attendance.start()

    def is_ready(self) -> bool:
        """Whether all workers have said that they are alive."""
        return self._attendance.heard({member.name for member in self._members})

    def look_after(self) -> None:
        """Replace workers that died or hang; takes no time."""
        for member in self._members:
            member.child.look_after(self._attendance.sign(member.name))

    def processes(self) -> list[tuple[Process, float]]:
        """The running workers, and how long each may take to end."""
        return [(m.child.process, self._stop_patience) for m in self._members if m.child.process is not None]

    def stop(self, is_hurried: Callable[[], bool] = lambda: False) -> None:
        """Stop all workers; unfinished chunks go back to the queue."""
        end_all(self.processes(), is_hurried)
        self._attendance.stop()


class _Member:
    """A place in the pool; each worker that takes it has a name of its own."""

    def __init__(self, environment: dict[str, str], duty: Duty, say: Say, patience: float) -> None:
        self.name = ""
        self.child = Child("a worker", self._launch, say, patience)
        self._environment = environment
        self._duty = duty

    def _launch(self) -> Process:
        self.name = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}"
        return subprocess.Popen(
            python_program(
                "worker.__main__",
                *("--name", self.name, "--parent-pid", str(os.getpid()), "--duty", self._duty),
            ),
            env=self._environment,
            stdin=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C on a terminal reaches the stack alone, which stops them in order
        )
