"""Deadlines of jobs, as their clients give them."""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings


class Deadlines:
    """The deadlines of active jobs; `JobRecords.create` sets the first one."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._extend = redis.register_script(scripts.PRELUDE + scripts.EXTEND)

    def extend(self, job_id: str, seconds: float | None) -> None:
        """Give an active job the deadline of one more client; the latest counts, and None is none."""
        self._extend(
            keys=[self.keys.job(job_id).record, self.keys.active],
            args=[job_id, "" if seconds is None else seconds],
        )

    def over(self) -> list[str]:
        """Returns the active jobs whose deadline is over."""
        seconds, micros = self.redis.time()
        late = self.redis.zrangebyscore(self.keys.deadlines, "-inf", seconds + micros / 1e6)
        return [raw.decode() for raw in cast("list[bytes]", late)]
