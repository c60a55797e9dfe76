"""The worker processes of one machine: started together, restarted when they die, stopped together."""

from __future__ import annotations

import logging
import os
import secrets
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from redis.exceptions import RedisError

from worker.connection import connect
from worker.jobs.roster import Roster
from worker.process.os_limits import signal_name
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_HEALTHY = 30.0  # seconds after which a process is healthy and its earlier deaths are forgotten
_LONGEST_DELAY = 30.0
_STOP_MARGIN = 4.0

# Unlike `-m`, this does not import a directory named "worker" in the current directory.
_PROGRAM = "import sys; sys.path.append(sys.argv.pop(1)); from worker.__main__ import main; sys.exit(main())"


@dataclass
class _Member:
    process: subprocess.Popen[bytes] | None
    name: str
    started: float
    deaths: int = 0
    next_start: float = 0.0


class WorkerPool:
    """`count` workers, which end with the thread that started them.

    `rq.worker_pool.WorkerPool` is unsuitable: its workers outlive it if it is killed, it restarts a failing
    worker without a pause, and it does not know when all workers are ready.
    """

    def __init__(
        self,
        count: int,
        redis_url: str,
        log_level: str = "WARNING",
        on_death: Callable[[str], None] = lambda how: log.warning("a worker died (%s)", how),
    ) -> None:
        self.count = count
        self._on_death = on_death
        self._redis = connect(redis_url)
        self._roster = Roster(self._redis, WorkerSettings())
        self._environment = {
            **os.environ,
            "RPR_CUSPS_REDIS_URL": redis_url,
            "RPR_CUSPS_LOG_LEVEL": log_level,
        }
        self._members: list[_Member] = []

    def start(self) -> None:
        """Start all workers."""
        self._members = [self._spawn() for _ in range(self.count)]

    def is_ready(self) -> bool:
        """Whether all workers have said that they are alive."""
        try:
            return {member.name for member in self._members} <= self._roster.names()
        except RedisError:
            return False

    def look_after(self) -> None:
        """Restart workers that have died, with growing delays if they die repeatedly."""
        moment = time.monotonic()
        for i, member in enumerate(self._members):
            if member.process is not None and member.process.poll() is not None:
                self._note_death(member, member.process.returncode, moment)
            if member.process is None and moment >= member.next_start:
                fresh = self._spawn()
                fresh.deaths = member.deaths
                self._members[i] = fresh

    def stop(self, hurry: Callable[[], bool] = lambda: False) -> None:
        """Stop all workers; unfinished chunks go back to the queue."""
        processes = [m.process for m in self._members if m.process is not None]
        self._members = []
        for process in processes:
            process.terminate()
        end = time.monotonic() + WorkerSettings().shutdown_grace + _STOP_MARGIN
        is_hurried = False
        while time.monotonic() <= end and any(process.poll() is None for process in processes):
            if hurry() and not is_hurried:
                is_hurried, end = True, min(end, time.monotonic() + 1.0)
                for process in processes:
                    process.terminate()
            time.sleep(0.01)
        for process in processes:
            process.kill()  # without effect on one that has ended
            process.wait()
        self._redis.close()

    def _spawn(self) -> _Member:
        name = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}"
        root = Path(__file__).parents[2]
        process = subprocess.Popen(
            [
                *(sys.executable, "-P", "-c", _PROGRAM, str(root)),
                *("--name", name, "--parent-pid", str(os.getpid())),
            ],
            env=self._environment,
            stdin=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C on a terminal reaches the stack alone, which stops them in order
        )
        return _Member(process, name, time.monotonic())

    def _note_death(self, member: _Member, code: int, moment: float) -> None:
        member.deaths = 1 if moment - member.started > _HEALTHY else member.deaths + 1
        delay = min(_LONGEST_DELAY, 0.5 * 2 ** (member.deaths - 1)) if member.deaths > 1 else 0.0
        self._on_death(signal_name(-code) if code < 0 else f"exit status {code}")
        member.process, member.next_start = None, moment + delay
