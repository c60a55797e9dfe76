"""What clients hold: active jobs, and their estimated work."""

from __future__ import annotations

from dataclasses import dataclass

from worker.jobs.keys import InRedis

_GRACE = 5  # seconds from the admission of a job to its record, at most
_TTL = 7 * 86400


@dataclass(frozen=True)
class Quota:
    """What a client may hold: a number of active jobs, and seconds of their estimated work; 0 is no bound."""

    jobs: int = 0
    seconds: int = 0


class QuotaError(Exception):
    """A client holds too much already.

    Attributes:
        jobs: the number of its active jobs.
        seconds: their estimated work.
    """

    def __init__(self, jobs: int, seconds: float) -> None:
        self.jobs, self.seconds = jobs, seconds
        super().__init__(f"the client has {jobs} active jobs with {seconds:.0f} s of work")


class Quotas(InRedis):
    """What each client holds. It may always have one job, however long."""

    def admit(self, client: str, job_id: str, seconds: float, quota: Quota) -> None:
        """Count a job, with its estimated work, as one of the client's.

        Raises:
            QuotaError: it is more than its quota.
        """
        if not (quota.jobs or quota.seconds):
            return
        jobs, work, is_admitted = self._run(
            "admit",
            client=self.keys.client(client),
            job_id=job_id,
            job_prefix=self.keys.job("").record,
            grace=_GRACE,
            ttl=_TTL,
            work=int(1000 * seconds),
            max_jobs=quota.jobs,
            max_work=1000 * quota.seconds,
        )
        if not is_admitted:
            raise QuotaError(jobs, work / 1000)

    def forget(self, client: str, job_id: str) -> None:
        """Count a job no longer as one of the client's."""
        self.redis.hdel(self.keys.client(client), job_id)
