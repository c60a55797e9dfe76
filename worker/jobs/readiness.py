"""Whether a job would be done now, and which lanes of the queue stand still."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

from redis import Redis

from worker.connection import eviction_warning
from worker.jobs.chunks import ChunkQueue
from worker.jobs.keys import Keys
from worker.jobs.lanes import Lane
from worker.jobs.roster import Roster
from worker.settings import WorkerSettings

STILL = 60.0
"""Seconds after which a small job should have begun, whatever else there is to do."""

_TTL = 1000  # milliseconds


@dataclass(frozen=True)
class Readiness:
    """The workers that are alive, and what endangers jobs: settings of Redis, lanes that stand still."""

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
    stalled = _stalled(redis, settings) if workers else ()
    return Readiness(workers, (*(() if warning is None else (warning,)), *stalled))


def _stalled(redis: Redis, settings: WorkerSettings) -> Iterator[str]:
    """Yields a warning for each lane that nobody empties, although workers are alive."""
    roster, queues = Roster(redis, settings), ChunkQueue(redis, settings).queues
    heavy: tuple[Lane, ...] = ("heavy", "heavy-batch")
    with redis.pipeline(transaction=False) as pipe:
        pipe.lindex(queues["small"].key, 0)
        for lane in heavy:
            pipe.llen(queues[lane].key)
        pipe.time()
        head, *depths, (seconds, _) = pipe.execute()
    if head is not None:
        job = Keys.of(settings).job(head.decode().rsplit("-", 3)[0])
        created = redis.hget(job.record, "created")
        age = seconds - float(cast("bytes | None", created) or seconds)
        if age > STILL:
            yield f"the lane small stands still: its first job was submitted {age:.0f} s ago"
    if any(depths) and not roster.names() - roster.light():
        for lane, depth in zip(heavy, depths, strict=True):
            if depth:
                yield f"the lane {lane} stands still: all workers have light duty, and {depth} chunks wait"
