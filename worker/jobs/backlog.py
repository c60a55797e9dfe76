"""The places of jobs in the queue, as the scripts count them."""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.jobs.lanes import Place
from worker.settings import WorkerSettings


class Backlog:
    """The places of jobs in the queue."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._place = redis.register_script(scripts.PRELUDE + scripts.PLACE)

    def place(self, job_id: str) -> Place | None:
        """Returns the place of a job in its lane, or None if it is not queued."""
        reply = cast(
            "list[int] | None",
            self._place(
                keys=[self.keys.job(job_id).record, self.keys.active, self.keys.workers], args=[job_id]
            ),
        )
        return Place(reply[0], reply[1] / 1000) if reply else None
