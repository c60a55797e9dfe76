"""The work horse: what it runs, and its end when nobody can know of it any more."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable
from types import FrameType
from typing import Any, Self

from redis.exceptions import RedisError
from rq.job import Job

from worker.process.horse_exit import UNRECORDED

log = logging.getLogger("rpr_cusps.worker")


def perform(job: Job) -> int:
    """Run a chunk in this process, the work horse; returns its exit status."""
    try:
        job.func(**job.kwargs)
    except RedisError as error:
        log.warning("the outcome of %s could not be recorded: %s", job.id, error)
        return UNRECORDED
    except Exception:
        log.exception("%s failed", job.id)
        return 1
    return 0


class BeatAlarm:
    """Acts once no heartbeat has succeeded for `seconds`, while the main thread may be waiting for Redis.

    From then on another worker may run the chunk, and no two must at once. Use it in the main thread.

    Attributes:
        has_rung: whether it has acted.
    """

    def __init__(self, seconds: float, act: Callable[[], None]) -> None:
        self.has_rung = False
        self._seconds, self._act = seconds, act
        self._before: Any = None

    def __enter__(self) -> Self:
        self._before = signal.signal(signal.SIGALRM, self._ring)
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self._before)

    def reset(self) -> None:
        """Begin to wait anew: a heartbeat has succeeded."""
        signal.setitimer(signal.ITIMER_REAL, self._seconds)

    def _ring(self, _signum: int, _frame: FrameType | None) -> None:
        self.has_rung = True
        self._act()
