"""What clients want of jobs, until when, and how much of them they may hold.

A job is canceled only when the last client no longer wants it. A subscription is a field of the job's record:
`by:KEY` for a client with a key, `by:ADDRESS#TOKEN` for one of which only the network address is known; its
value is the time. A request that waits for the job has a field `wait:TOKEN` with the time at which it stops
waiting, so that what other requests of its client withdraw does not end it, and a process that died does not
keep it.

Callbacks are the URLs to call when a job ends, and the deliveries of these events. To claim a delivery is to
take a lease: its entry moves to the time at which another may claim it, so that a delivery survives those who
make it.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Literal, cast
from urllib.parse import urlsplit

from redis import Redis

from worker.jobs.lanes import Keys
from worker.jobs.views import JobView, iso, job_view
from worker.lua import Scripts
from worker.settings import WorkerSettings

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


class Subscriptions:
    """The clients of jobs."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._run = Scripts(redis)

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


class Quotas:
    """What each client holds. It may always have one job, however long."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._run = Scripts(redis)

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


MAX_CALLBACKS_PER_JOB = 100

_READY_SECONDS = 60
"""After which a delivery that waits for its host's turn is looked at again, in case that turn was lost."""

_MAX_AT_ONCE = 1000

State = Literal["pending", "delivered", "gone", "refused", "exhausted"]
"""The state of a delivery: `gone` if the receiver answered 410, `refused` if its address is not allowed,
`exhausted` after the last attempt."""


class TooManyCallbacksError(Exception):
    """A job has as many callbacks as it may have."""


@dataclass(frozen=True)
class DeliveryAttempt:
    """One attempt at a delivery.

    Attributes:
        at: when it began, in seconds since 1970.
        status: the HTTP status of the answer, if one came.
        problem: why it did not succeed; None if it did, or its end is not known.
        is_over: whether its end is known; it is not while it lasts, or if its process died.
    """

    at: float
    status: int | None = None
    problem: str | None = None
    is_over: bool = True

    @property
    def at_iso(self) -> str:
        """When it began, in ISO 8601."""
        return iso(self.at)

    def to_json(self) -> str:
        """Returns it as it is kept."""
        return json.dumps({"at": self.at, "status": self.status, "problem": self.problem})


@dataclass(frozen=True)
class Delivery:
    """The event of one end of a job for one receiver.

    Attributes:
        id: the same at every attempt.
        url: where it goes.
        state: how it stands.
        claim: the number of attempts that were begun, also of the one that a claim has begun.
        next_at: when the next attempt is due, ISO 8601; None if there is none.
        job: the job as it ended.
        attempts: those so far.
    """

    id: str
    url: str
    state: State
    claim: int
    next_at: str | None
    job: JobView
    attempts: tuple[DeliveryAttempt, ...]

    @property
    def host(self) -> str:
        """The name of its receiver, as it takes turns with others."""
        with suppress(ValueError):
            return urlsplit(self.url).hostname or ""
        return ""


class Callbacks:
    """The callbacks of an installation and their deliveries. Instances are cheap, and safe for threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._run = Scripts(redis)

    def add(self, job_id: str, url: str) -> None:
        """Have a URL called when a job ends; at once if it has ended.

        Raises:
            TooManyCallbacksError: the job has too many.
        """
        keys = self.keys.names(job_id)
        if self._run("add_callback", keys, job_id=job_id, url=url, limit=MAX_CALLBACKS_PER_JOB) == -1:
            raise TooManyCallbacksError(job_id)

    def claim(self, lease: float, must_wait: Iterable[str] = ()) -> Delivery | None:
        """Start an attempt at a due delivery; no other process does for `lease` seconds.

        Args:
            lease: how long.
            must_wait: hosts whose deliveries are passed over: their names, or `*.` and what names end with.
        """
        reply = self._run(
            "claim_delivery",
            due=self.keys.deliveries,
            lease=lease,
            waits=_READY_SECONDS,
            many=_MAX_AT_ONCE,
            waiting=must_wait,
        )
        return _delivery(dict(zip(reply[::2], reply[1::2], strict=True))) if reply else None

    def settle(
        self,
        delivery: Delivery,
        state: State,
        attempt: DeliveryAttempt,
        delay: float = 0.0,
        rest: float = 0.0,
    ) -> bool:
        """Note how an attempt ended; the next one is due in `delay` seconds if it is still pending.

        Args:
            delivery, state, attempt, delay: as said.
            rest: how long no other delivery goes to this host, in seconds.

        Returns False if the lease was over and another attempt has begun.
        """
        reply = self._run(
            "settle_delivery",
            due=self.keys.deliveries,
            counts=self.keys.delivery_counts,
            id=delivery.id,
            claim=delivery.claim,
            state=state,
            delay=delay,
            entry=attempt.to_json(),
            host=delivery.host if rest else "",
            rest=rest,
        )
        return bool(reply)

    def of_job(self, job_id: str) -> list[Delivery]:
        """Returns the deliveries of a job, the oldest first, as long as they are kept."""
        ids = cast("list[bytes]", self.redis.lrange(self.keys.deliveries_of(job_id), 0, -1))
        with self.redis.pipeline(transaction=False) as pipe:
            for raw in ids:
                pipe.hgetall(self.keys.delivery(raw.decode()))
            return [_delivery(fields) for fields in pipe.execute() if fields]


def _delivery(raw: Mapping[bytes, bytes]) -> Delivery:
    fields = {name.decode(): value.decode() for name, value in raw.items()}
    claim = int(fields["claims"])
    texts = (fields.get(f"attempt:{number}") for number in range(1, claim + 1))
    return Delivery(
        id=fields["id"],
        url=fields["url"],
        state=cast(State, fields["state"]),
        claim=claim,
        next_at=iso(float(fields["next"])) if "next" in fields else None,
        job=job_view(fields["job"], {name[2:]: text for name, text in fields.items() if name[:2] == "j:"}),
        attempts=tuple(_attempt(json.loads(text)) for text in texts if text),
    )


def _attempt(kept: Mapping[str, object]) -> DeliveryAttempt:
    return DeliveryAttempt(
        at=cast(float, kept["at"]),
        status=cast("int | None", kept.get("status")),
        problem=cast("str | None", kept.get("problem")),
        is_over="status" in kept,
    )
