"""The process that moves answers to the archive: forked by one worker of an installation at a time.

It uses the idle time of the processors, and ends with its worker. A lock in Redis says that somebody moves
answers, or has just looked for them.
"""

from __future__ import annotations

import contextlib
import select
import time

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from worker.answers.layout import ResultKeys
from worker.jobs.archiving import keep_moving
from worker.process.horse import Horse, Task
from worker.process.os_limits import stop_signals_held
from worker.process.tasks import context
from worker.settings import WorkerSettings

_SECONDS = 5.0  # of one round; a third of the time after which another worker takes over
_ROUNDS = 80
_PAUSE = 5.0  # until the next look


def move_answers() -> bool:
    """Move answers until none is due; the task of the process. Returns that it may exit."""
    own = context()
    lock = _lock(own.settings)
    for _ in range(_ROUNDS):
        has_more = keep_moving(own.redis, own.settings, _SECONDS)
        with contextlib.suppress(OutOfMemoryError):
            own.redis.set(lock, 1, px=int(1000 * (3 * _SECONDS if has_more else _PAUSE)))
        if not has_more:
            break
    return False


def _lock(settings: WorkerSettings) -> str:
    return f"{ResultKeys(settings.key_prefix, settings.solver_version).archive}:moving"


class Archivist:
    """Starts the process for a worker, if there is an archive and no other worker has done so."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self._horse: Horse | None = None
        self._next = 0.0

    def look_after(self) -> None:
        """Start it if it is time to, or note that it has ended; takes no time."""
        if self.settings.archive_url is None or time.monotonic() < self._next:
            return
        if self._horse is not None:
            if select.select([self._horse], [], [], 0)[0]:
                self.end()
            return
        self._next = time.monotonic() + _PAUSE
        with contextlib.suppress(RedisError, OSError):  # it is tried again soon
            if self._is_first():
                with stop_signals_held():
                    self._horse = Horse(self.settings)
                self._horse.lower_priority()
                self._horse.run(Task("archive", f"{__name__}.{move_answers.__name__}", {}))

    def _is_first(self) -> bool:
        """Whether no other worker does so; all may if Redis is too full for the lock."""
        try:
            return bool(self.redis.set(_lock(self.settings), 1, nx=True, px=int(3000 * _SECONDS)))
        except OutOfMemoryError:
            return True

    def end(self) -> None:
        """End it; what it has not moved stays where it is."""
        if self._horse is not None:
            self._horse.kill()
            self._horse.collect()
            self._horse = None
