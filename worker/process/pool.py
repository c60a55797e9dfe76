"""The worker processes of one machine: started together, started again when one dies, stopped together."""

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
from rq import Worker

from worker.connection import connect
from worker.process.os_limits import signal_name
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_HEALTHY = 30.0  # seconds of life after which an end counts as the first one again
_LONGEST_DELAY = 30.0
_STOP_MARGIN = 4.0

# `-P` and this instead of `-m`: a directory called "worker" where the user happens to be must not be taken.
_PROGRAM = "import sys; sys.path.append(sys.argv.pop(1)); from worker.__main__ import main; sys.exit(main())"


@dataclass
class _Member:
    process: subprocess.Popen[bytes] | None
    name: str
    started: float
    deaths: int = 0
    next_start: float = 0.0


class WorkerPool:
    """`count` workers. Use it from one thread that lives as long as the workers shall.

    `rq.worker_pool.WorkerPool` does not serve: its workers outlive it when it is killed, it starts one that
    dies at once again and again without a pause, and it cannot tell when all of them are ready.
    """

    def __init__(
        self,
        count: int,
        redis_url: str,
        log_level: str = "WARNING",
        on_death: Callable[[str], None] = lambda how: log.warning("a worker ended (%s)", how),
    ) -> None:
        self.count = count
        self._on_death = on_death
        self._redis = connect(redis_url)
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
        """Whether all workers have registered themselves."""
        if not self._members:
            return True
        try:
            registered = self._redis.exists(
                *(Worker.redis_worker_namespace_prefix + m.name for m in self._members)
            )
        except RedisError:
            return False
        return registered == len(self._members)

    def look_after(self) -> None:
        """Start workers again that have died, later and later when it goes on."""
        moment = time.monotonic()
        for i, member in enumerate(self._members):
            if member.process is not None and member.process.poll() is not None:
                self._note_death(member, member.process.returncode, moment)
            if member.process is None and moment >= member.next_start:
                fresh = self._spawn()
                fresh.deaths = member.deaths
                self._members[i] = fresh

    def stop(self, hurry: Callable[[], bool] = lambda: False) -> None:
        """Stop all workers; what they were working on is in the queue again afterwards."""
        processes = [m.process for m in self._members if m.process is not None]
        self._members = []
        for process in processes:
            process.terminate()
        end = time.monotonic() + WorkerSettings().shutdown_grace + _STOP_MARGIN
        hurried = False
        while any(process.poll() is None for process in processes):
            if time.monotonic() > end:
                for process in processes:
                    process.kill()
                break
            if hurry() and not hurried:
                hurried, end = True, min(end, time.monotonic() + 1.0)
                for process in processes:
                    process.terminate()
            time.sleep(0.01)
        for process in processes:
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
            start_new_session=True,  # a terminal's Ctrl-C reaches the stack only, which stops them in order
        )
        return _Member(process, name, time.monotonic())

    def _note_death(self, member: _Member, code: int, moment: float) -> None:
        member.deaths = 1 if moment - member.started > _HEALTHY else member.deaths + 1
        delay = min(_LONGEST_DELAY, 0.5 * 2 ** (member.deaths - 1)) if member.deaths > 1 else 0.0
        self._on_death(signal_name(-code) if code < 0 else f"exit status {code}")
        member.process, member.next_start = None, moment + delay
