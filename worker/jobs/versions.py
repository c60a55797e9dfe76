"""The versions of the solver that share one Redis, each with jobs, queues and results of its own."""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.answers.layout import UNNAMED, ResultKeys
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings


class Versions:
    """The versions beside this one, and whose job is whose."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self._key = Keys.of(settings).versions

    def note(self) -> None:
        """Note that this version works here."""
        self.redis.sadd(self._key, self.settings.solver_version)

    def others(self) -> list[str]:
        """Returns the others that have worked here; the first ones did not note it."""
        noted = {raw.decode() for raw in cast("set[bytes]", self.redis.smembers(self._key))}
        return sorted({*noted, UNNAMED} - {self.settings.solver_version})

    def other_of(self, job_id: str) -> str | None:
        """Returns the other version that has a job, or a question with this id; None if none has."""
        prefix = self.settings.key_prefix
        for version in self.others():
            job, question = Keys(prefix, version).job(job_id), ResultKeys(prefix, version).question(job_id)
            if self.redis.exists(job.record, question):
                return version
        return None
