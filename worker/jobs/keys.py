"""The names of the Redis keys of jobs."""

from __future__ import annotations

from typing import NamedTuple, cast

from redis import Redis

from rpr_solver import SOLVER_VERSION
from worker.lua import Scripts
from worker.settings import WorkerSettings

FAILURE_TTL = 86400
"""Seconds that a failed or canceled job is kept: whoever asked for it reads why within a day."""


class JobKeys(NamedTuple):
    """The keys of one job.

    Attributes:
        record: the hash with its question, its state and its counts; a field `call:URL` for each callback.
        chunks: a hash with the entry of each chunk that is not done.
        bits: one bit for each part that is done, the first in the highest bit of the first byte.
        errors: a hash, of a table L1 → error, of a batch item → what it has beside its answer.
        events: the stream of its events.
        items: the list of a batch's items.
        wanted: the set of the keys that asked for it.
    """

    record: str
    chunks: str
    bits: str
    errors: str
    events: str
    items: str
    wanted: str


class Keys:
    """Key names with one prefix.

    All that is of jobs carries the solver's version, as job ids do: nothing of one version touches a job of
    another. They share the counts of ends, deliveries, API keys and Idempotency-Keys.

    Attributes:
        ends: the counts of how jobs ended; see `worker.jobs.installation.Ends`.
        deliveries: the sorted set of deliveries that are not over, by the time at which they are due.
        delivery_counts: the number of attempts by their outcome.
        trial: written to find out whether Redis accepts data.
        active: the sorted set of queued and running jobs by the time at which they were made.
        work: the hash with the estimated work that each lane was given, and has done.
        deadlines: the sorted set of the active jobs with a deadline by its time.
        suspects: the chunks that no worker seems to run, with the time of the first suspicion.
        sweep_lock: limits the search for lost chunks to one at a time in the whole installation.
    """

    def __init__(self, prefix: str, version: str = SOLVER_VERSION) -> None:
        self.prefix, self.version = prefix, version
        self.ends = f"{prefix}:ends"
        self.deliveries = f"{prefix}:deliveries"
        self.delivery_counts = f"{prefix}:delivery-counts"
        self.trial = f"{prefix}:trial"
        self.active = f"{prefix}:active:{version}"
        self.work = f"{self.active}:work"
        self.deadlines = f"{self.active}:deadlines"
        self.suspects = f"{prefix}:suspects:{version}"
        self.sweep_lock = f"{prefix}:sweep-lock:{version}"

    @classmethod
    def of(cls, settings: WorkerSettings) -> Keys:
        """Returns those of an installation."""
        return cls(settings.key_prefix)

    def job(self, job_id: str) -> JobKeys:
        """Returns the keys of a job."""
        base = f"{self.prefix}:job-{self.version}:{job_id}"
        return JobKeys(base, *(f"{base}:{name}" for name in JobKeys._fields[1:]))

    def names(self, job_id: str) -> dict[str, str]:
        """Returns the keys that the scripts of a job may take, by their names there."""
        return self.job(job_id)._asdict() | {"active": self.active, "ends": self.ends}

    def queued(self, lane: str) -> str:
        """Returns the sorted set of the queued jobs of a lane, by their age; the scripts derive it, too."""
        return f"{self.active}:queued:{lane}"

    def listed(self, what: str, client: str | None) -> str:
        """Returns the sorted set of jobs or batches by age: of all, or of those that a client asked for."""
        return f"{self.active}:made:{what}" + ("" if client is None else f":{client}")

    def delivery(self, delivery_id: str) -> str:
        """Returns the key of a delivery; the scripts derive it in the same way."""
        return f"{self.deliveries}:{delivery_id}"

    def deliveries_of(self, job_id: str) -> str:
        """Returns the key of the list of a job's deliveries; the scripts derive it in the same way."""
        return f"{self.deliveries}-of:{job_id}"

    def beat(self, rq_id: str) -> str:
        """Returns the key that exists as long as an attempt at a chunk runs."""
        return f"{self.prefix}:beat:{rq_id}"

    def client(self, client: str) -> str:
        """Returns the key of what a client holds."""
        return f"{self.prefix}:client-{self.version}:{client}"


class InRedis:
    """A part of an installation, by what it has in Redis; cheap, and may be shared by threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self.keys = Keys.of(settings)
        self._run = Scripts(redis)

    def now(self) -> float:
        """The time by the clock of Redis, in seconds since 1970."""
        return seconds_of(self.redis.time())

    def scan(self, cursor: int, count: int) -> tuple[int, list[bytes]]:
        """Returns about `count` of all keys, and where to go on; 0 is the beginning and the end."""
        found = self.redis.scan(cursor, match=f"{self.settings.key_prefix}:*", count=count)
        return cast("tuple[int, list[bytes]]", found)


def seconds_of(time: object) -> float:
    """Returns the reply to TIME in seconds."""
    seconds, micros = cast("tuple[int, int]", time)
    return float(seconds + micros / 1e6)
