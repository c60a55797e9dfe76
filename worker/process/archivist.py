"""The process that moves answers to the archive.

One worker of an installation at a time has one. It uses the idle time of the processors, and ends with its
worker. A lock in Redis says that somebody moves answers, or has just looked. It is no RQ job, since it is
needed most when Redis takes no more data.
"""

from __future__ import annotations

import contextlib
import os
import time

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from worker.answers.layout import ResultKeys
from worker.jobs.archiving import keep_moving
from worker.process.horse import Horse
from worker.settings import WorkerSettings

_ROUND_SECONDS = 5.0  # of one round; a third of the time after which another worker takes over
_ROUNDS = 80
_LOOK_PAUSE = 5.0  # until the next look
_LOWEST_PRIORITY = 19  # niceness


class Archivist:
    """Starts the process for a worker, if there is an archive and no other one has."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self._lock = f"{ResultKeys.of(settings).archive}:moving"
        self._horse: Horse | None = None
        self._next = 0.0

    def look_after(self) -> None:
        """Start the process if it is time to, or note that it has ended; takes no time."""
        if self.settings.archive_url is None or time.monotonic() < self._next:
            return
        if self._horse is not None:
            if self._horse.has_exited():
                self.end()
            return
        self._next = time.monotonic() + _LOOK_PAUSE
        with contextlib.suppress(RedisError, OSError):  # it is tried again soon
            if self._is_first():
                self._horse = Horse(self.settings, self._move)
                self._horse.order("move")

    def _is_first(self) -> bool:
        """Whether no other worker does so; all may if Redis is too full for the lock."""
        try:
            return bool(self.redis.set(self._lock, 1, nx=True, px=int(3000 * _ROUND_SECONDS)))
        except OutOfMemoryError:
            return True

    def _move(self, _order: str) -> bool:
        """In the process: move answers until none is due. Returns that it may exit."""
        os.setpriority(os.PRIO_PROCESS, 0, _LOWEST_PRIORITY)
        for _ in range(_ROUNDS):
            has_more = keep_moving(self.redis, self.settings, _ROUND_SECONDS)
            with contextlib.suppress(OutOfMemoryError):
                seconds = 3 * _ROUND_SECONDS if has_more else _LOOK_PAUSE
                self.redis.set(self._lock, 1, px=int(1000 * seconds))
            if not has_more:
                break
        return False

    def end(self) -> None:
        """End it; what it has not moved stays where it is."""
        if self._horse is not None:
            self._horse.end()
            self._horse = None
