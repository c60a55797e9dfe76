"""Whether a job would be done now."""

from __future__ import annotations

from dataclasses import dataclass

from redis import Redis

from worker.connection import eviction_warning
from worker.jobs.keys import Keys
from worker.jobs.roster import Roster
from worker.settings import WorkerSettings

_TTL = 1000  # milliseconds


@dataclass(frozen=True)
class Readiness:
    """The workers that are alive, and what is wrong with the settings of Redis."""

    workers: int
    warnings: tuple[str, ...]


def readiness(redis: Redis, settings: WorkerSettings) -> Readiness:
    """Returns whether jobs would be done, after writing to Redis.

    Raises:
        RedisError: Redis cannot be reached, or accepts no data.
    """
    redis.set(Keys.of(settings).trial, 1, px=_TTL)
    workers = len(Roster(redis, settings).names())
    warning = eviction_warning(redis)
    return Readiness(workers, () if warning is None else (warning,))
