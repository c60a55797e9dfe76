"""What clients want of jobs, until when, and how much of them they may hold.

A job is canceled only when the last client no longer wants it. A subscription is a field of the job's record:
`by:KEY` for a client with a key, `by:ADDRESS#TOKEN` for one of which only the network address is known; its
value is the time. A request that waits for the job has a field `wait:TOKEN` with the time at which it stops
waiting, so that what other requests of its client withdraw does not end it, and a process that died does not
keep it.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field

from worker.jobs import InRedis

MAX_RECORD_FIELDS = 1000
"""Fields of a record, of which a dozen are its own; clients beyond that are one that never withdraws."""

_MARGIN = 10.0  # seconds, until a request that has stopped waiting has said so
_GRACE = 5  # seconds from the admission of a job to its record, at most
_TTL = 7 * 86400


@dataclass(frozen=True)
class Subscriber:
    """A client that wants a job.

    Attributes:
        client: its key, or its network address.
        is_known: whether that distinguishes it from all others, as a key does.
        token: distinguishes its request; on withdrawing, the request that is meant, or empty.
    """

    client: str
    is_known: bool
    token: str = field(default_factory=lambda: secrets.token_hex(12))

    @property
    def name(self) -> str:
        """The name of its subscription."""
        return self.client if self.is_known else f"{self.client}#{self.token}"


@dataclass(frozen=True)
class Subscription:
    """A client, and the seconds from now for which its request waits."""

    who: Subscriber
    seconds: float = 0.0

    @property
    def arguments(self) -> dict[str, str | float]:
        """What the scripts take."""
        seconds = self.seconds + _MARGIN if self.seconds > 0 else 0
        return {"name": self.who.name, "token": self.who.token, "seconds": seconds}


class Subscriptions(InRedis):
    """The clients of jobs."""

    def add(self, job_id: str, who: Subscriber, seconds: float = 0.0) -> bool:
        """Subscribe a client whose request waits `seconds` from now; returns False if the job has ended.

        A request that waited and goes without the answer subscribes again, with 0 seconds.
        """
        by = Subscription(who, seconds).arguments
        keys = self.keys.names(job_id)
        return bool(self._run("subscribe", keys, by, job_id=job_id, limit=MAX_RECORD_FIELDS))

    def extend_deadline(self, job_id: str, seconds: float | None) -> None:
        """Give an active job the deadline of one more client; the latest counts, and None is none."""
        deadline_s = "" if seconds is None else seconds
        self._run("extend_deadline", self.keys.names(job_id), job_id=job_id, deadline_s=deadline_s)

    def leave(self, job_id: str, who: Subscriber) -> None:
        """Note that the request of a client waits no longer; a subscription it has not withdrawn stays."""
        self.redis.hdel(self.keys.job(job_id).record, f"wait:{who.token}")

    def withdraw(self, job_id: str, who: Subscriber) -> None:
        """Withdraw the subscription of a client.

        Of a client that is not known, without a token, it is the newest of its address that does not wait.
        """
        name, address, token = (who.client, "", "") if who.is_known else ("", who.client, who.token)
        self._run("withdraw", self.keys.names(job_id), name=name, address=address, token=token)


@dataclass(frozen=True)
class Bytes:
    """The bytes of a question.

    Attributes:
        whole: while its job is active.
        kept: after its end.
        client: the client for whom they are counted; none if empty.
    """

    whole: int
    kept: int
    client: str = ""


@dataclass(frozen=True)
class Quota:
    """What a client may hold: a number of active jobs, seconds of their estimated work, and bytes of kept
    questions; 0 is no bound."""

    jobs: int = 0
    seconds: int = 0
    kept_bytes: int = 0


class QuotaError(Exception):
    """A client holds too much already.

    Attributes:
        jobs: the number of its active jobs.
        seconds: their estimated work.
        kept_bytes: the bytes of its questions, if these are too many.
        retry_s: the seconds until enough of them have expired; 0 if active jobs must end before.
    """

    def __init__(self, jobs: int, seconds: float, kept_bytes: int | None = None, retry_s: int = 0) -> None:
        self.jobs, self.seconds, self.kept_bytes, self.retry_s = jobs, seconds, kept_bytes, retry_s
        kept = "" if kept_bytes is None else f" and {kept_bytes} bytes of questions"
        super().__init__(f"the client has {jobs} active jobs with {seconds:.0f} s of work{kept}")


class Quotas(InRedis):
    """What each client holds. It may always have one job, however long."""

    def admit(self, client: str, job_id: str, seconds: float, quota: Quota, size: int = 0) -> None:
        """Count a job, of so much estimated work and bytes, as one of the client's.

        Raises:
            QuotaError: it is more than its quota.
        """
        if quota.jobs or quota.seconds or quota.kept_bytes:
            work, max_work = int(1000 * seconds), 1000 * quota.seconds
            bounds = {"ttl": _TTL, "work": work, "max_jobs": quota.jobs, "max_work": max_work}
            self._ask("admit", client, job_id, size, quota, bounds)

    def receive(self, client: str, job_id: str, size: int, quota: Quota, seconds: float) -> None:
        """Count the received bytes of a question; more are expected within the given seconds.

        Raises:
            QuotaError: it is more than its quota.
        """
        if quota.kept_bytes:
            self._ask("receive", client, job_id, size, quota, {"seconds": seconds})

    def forget(self, client: str, job_id: str) -> None:
        """Count a job no longer as one of the client's."""
        self.redis.hdel(self.keys.client(client), job_id)

    def forget_received(self, client: str, job_id: str) -> None:
        """Stop counting the received part of a question."""
        self.redis.hdel(self.keys.kept(client), job_id)

    def _ask(
        self, script: str, client: str, job_id: str, size: int, quota: Quota, more: Mapping[str, float]
    ) -> None:
        jobs, work, outcome, *of_bytes = self._run(
            script,
            more,
            client=self.keys.client(client),
            ledger=self.keys.kept(client),
            job_id=job_id,
            job_prefix=self.keys.job("").record,
            size=size,
            max_bytes=quota.kept_bytes,
            grace=_GRACE,
        )
        if outcome != 1:
            raise QuotaError(jobs, work / 1000, *of_bytes)
