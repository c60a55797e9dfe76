"""The names of the Redis keys of jobs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class JobKeys:
    """The keys of one job."""

    record: str
    chunks: str
    bits: str
    errors: str
    events: str


@dataclass(frozen=True)
class Keys:
    """Key names under one prefix."""

    prefix: str

    def job(self, job_id: str) -> JobKeys:
        """The keys of the job `job_id`."""
        base = f"{self.prefix}:job:{job_id}"
        return JobKeys(base, f"{base}:chunks", f"{base}:bits", f"{base}:errors", f"{base}:events")

    def beat(self, chunk_id: str) -> str:
        """Sign of life of a running chunk."""
        return f"{self.prefix}:beat:{chunk_id}"

    @property
    def active(self) -> str:
        """Sorted set of the jobs that are queued or running."""
        return f"{self.prefix}:active"

    @property
    def suspects(self) -> str:
        """Chunks that nobody seems to work on, with the time at which that was first seen."""
        return f"{self.prefix}:suspects"

    @property
    def sweep_lock(self) -> str:
        """Limits the search for lost chunks to one at a time in the whole installation."""
        return f"{self.prefix}:sweep-lock"
