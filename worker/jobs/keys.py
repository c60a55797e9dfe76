"""The names of the Redis keys of jobs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from rpr_solver import SOLVER_VERSION
from worker.answers.layout import kind_of
from worker.settings import WorkerSettings


class JobKeys(NamedTuple):
    """The keys of one job."""

    record: str
    chunks: str
    bits: str
    errors: str
    events: str
    items: str
    """The items of a batch; the scripts derive this and the next ones from the name of the record."""
    questions: str
    """The long questions of an active batch."""
    todo: str
    """What the chunks are to do."""


@dataclass(frozen=True)
class SharedKeys:
    """The keys that the versions of the solver share: the counts of ends, the deliveries (also those of a
    version that no API is left of), and what has the id of a chunk in it."""

    prefix: str

    def delivery(self, delivery_id: str) -> str:
        """Returns the key of a delivery; the scripts derive it in the same way."""
        return f"{self.deliveries}:{delivery_id}"

    def deliveries_of(self, job_id: str) -> str:
        """Returns the key of the list of a job's deliveries; the scripts derive it in the same way."""
        return f"{self.deliveries}-of:{job_id}"

    def beat(self, chunk_id: str) -> str:
        """Returns the key of a running chunk's heartbeat."""
        return f"{self.prefix}:beat:{chunk_id}"

    @property
    def ends(self) -> str:
        """The counts of how jobs ended; see `worker.jobs.installation.Ends`."""
        return f"{self.prefix}:ends"

    @property
    def deliveries(self) -> str:
        """The sorted set of deliveries that are not over, by the time at which they are due."""
        return f"{self.prefix}:deliveries"

    @property
    def delivery_counts(self) -> str:
        """The number of attempts by their outcome."""
        return f"{self.prefix}:delivery-counts"

    @property
    def versions(self) -> str:
        """The set of the versions of the solver that have had jobs here."""
        return f"{self.prefix}:versions"

    @property
    def trial(self) -> str:
        """Written to find out whether Redis accepts data."""
        return f"{self.prefix}:trial"


@dataclass(frozen=True)
class Keys(SharedKeys):
    """Key names with one prefix.

    All that is of jobs carries the solver's version, as job ids do: nothing of one version touches a job of
    another. Shared are `SharedKeys`, API keys and Idempotency-Keys.
    """

    version: str = SOLVER_VERSION

    @classmethod
    def of(cls, settings: WorkerSettings) -> Keys:
        """Returns those of an installation and the version of the solver that is meant."""
        return cls(settings.key_prefix, settings.solver_version)

    def job(self, job_id: str) -> JobKeys:
        """Returns the keys of the job `job_id`."""
        base = f"{self.prefix}:{kind_of('job', self.version)}:{job_id}"
        return JobKeys(base, *(f"{base}:{name}" for name in JobKeys._fields[1:]))

    def names(self, job_id: str) -> dict[str, str]:
        """Returns the keys that the scripts of a job may take, by their names there."""
        job = dict(zip(JobKeys._fields[:5], self.job(job_id), strict=False))  # the others are derived
        common = {"active": self.active, "ends": self.ends, "workers": self.workers}
        return job | common

    def client(self, client: str) -> str:
        """Returns the key of what a client holds."""
        return f"{self.prefix}:{kind_of('client', self.version)}:{client}"

    def kept(self, client: str) -> str:
        """Returns the key of the ledger of a client's bytes."""
        return f"{self.prefix}:{kind_of('kept', self.version)}:{client}"

    @property
    def active(self) -> str:
        """The sorted set of queued and running jobs."""
        return f"{self.prefix}:active:{self.version}"

    @property
    def queued(self) -> str:
        """The sorted set of queued jobs, by lane and age; the scripts derive its name from `active`."""
        return f"{self.active}:queued"

    @property
    def work(self) -> str:
        """The estimated work that each lane was given, and has done; its name is derived in the same way."""
        return f"{self.active}:work"

    @property
    def deadlines(self) -> str:
        """The sorted set of the active jobs with a deadline; its name is derived in the same way."""
        return f"{self.active}:deadlines"

    @property
    def suspects(self) -> str:
        """The chunks that no worker seems to run, with the time of the first suspicion."""
        return f"{self.prefix}:suspects:{self.version}"

    @property
    def walk(self) -> str:
        """The position of the search for active jobs among all keys."""
        return f"{self.prefix}:walk:{self.version}"

    @property
    def sweep_lock(self) -> str:
        """The lock that limits the search for lost chunks to one at a time in the whole installation."""
        return f"{self.prefix}:sweep-lock:{self.version}"

    @property
    def workers(self) -> str:
        """The sorted set of live workers."""
        return f"{self.prefix}:workers:{self.version}"
