"""When each worker of a pool was last heard of."""

from __future__ import annotations

import threading
import time

from redis.exceptions import RedisError

from worker.connection import connect
from worker.jobs.roster import Roster
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
