"""What clients want of jobs, until when, how much of them they may hold, and what they see of them: their
state, and lists of them, the newest first.

A job is canceled only when the last client no longer wants it. A subscription is a field of the job's record:
`by:KEY` for a client with a key, `by:ADDRESS#TOKEN` for one of which only the network address is known; its
value is the time. A request that waits for the job has a field `wait:TOKEN` with the time at which it stops
waiting, so that what other requests of its client withdraw does not end it, and a process that died does not
keep it.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal, cast

from worker.answers.kinds import is_batch
from worker.jobs.plan import InRedis, Keys, QueuePosition
from worker.lua.scripts import VIEW_FIELDS

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

    def arguments(self, keys: Keys) -> dict[str, str | int]:
        """What the scripts take."""
        ledger = keys.kept(self.client) if self.client else ""
        return {"ledger": ledger, "bytes": self.whole, "kept_bytes": self.kept}


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
        """Count a job, with its estimated work and its bytes, as one of the client's.

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


Status = Literal["queued", "running", "succeeded", "failed", "canceled"]


ACTIVE: frozenset[Status] = frozenset({"queued", "running"})


@dataclass(frozen=True)
class JobView:
    """The state of a job. Times are ISO 8601 in UTC.

    Attributes:
        deadline_at: when the job fails unless it is done; None if a client waits without a deadline.
        place: its position in the queue, if it is queued.
        failed: the items of a batch that are done without an answer.
        estimate_s: its estimated work, in seconds of one core; None if it is not known.
        overruns: how many of its chunks took a few times their estimate.
        event: the event of this state, if known: events to wait for follow it.
    """

    id: str
    status: Status
    done: int
    total: int
    created_at: str
    started_at: str | None
    finished_at: str | None
    error: dict[str, str] | None
    run: str
    deadline_at: str | None = None
    place: QueuePosition | None = None
    failed: int = 0
    estimate_s: float | None = None
    overruns: int = 0
    event: str = field(default="", compare=False)

    @property
    def is_terminal(self) -> bool:
        """Whether the job has ended."""
        return self.status not in ACTIVE

    @property
    def run_seconds(self) -> float | None:
        """The seconds from its start to its end; None until then, and for one that never began."""
        if self.started_at is None or self.finished_at is None:
            return None
        start, end = map(datetime.fromisoformat, (self.started_at, self.finished_at))
        return (end - start).total_seconds()


def view_of(job_id: str, fields: Sequence[bytes | None]) -> JobView | None:
    """Returns the state of a job from `VIEW_FIELDS` of its record, or None if there is none."""
    named = {name: raw.decode() for name, raw in zip(VIEW_FIELDS, fields, strict=False) if raw is not None}
    is_shown = "run" in named and "status" in named and "receiving" not in named
    return job_view(job_id, named) if is_shown else None


def job_view(job_id: str, fields: Mapping[str, str]) -> JobView:
    """Returns the state of a job from the fields of its record."""
    created, started, finished, deadline = (
        iso(float(fields[name])) if name in fields else None
        for name in ("created", "started", "finished", "deadline")
    )
    error = fields.get("error")
    return JobView(
        id=job_id,
        status=cast(Status, fields["status"]),
        done=int(fields.get("done", 0)),
        total=int(fields.get("total", 0)),
        created_at=created or "",
        started_at=started,
        finished_at=finished,
        error=json.loads(error) if error else None,
        run=fields["run"],
        deadline_at=deadline,
        failed=int(fields.get("failed", 0)),
        estimate_s=int(fields["work"]) / 1000 if "work" in fields else None,
        overruns=int(fields.get("overruns", 0)),
    )


def iso(seconds: float) -> str:
    """Returns a time, in seconds since 1970, in ISO 8601."""
    text = datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")
    return text.replace("+00:00", "Z")


What = Literal["jobs", "batches"]


_STEP, _STEPS = 100, 5  # how many are looked at at once, and how often for one page


@dataclass(frozen=True)
class Listed:
    """A job in a list.

    Attributes:
        view: its state.
        maker: the client that asked for it first, if it is known.
        runs_s: the seconds for which it has run; None if it has not begun.
    """

    view: JobView
    maker: str | None
    runs_s: float | None


@dataclass(frozen=True)
class Page:
    """A page of a list; `before` is where the next one begins, None after the last one."""

    items: Sequence[Listed]
    before: str | None


class Listing(InRedis):
    """The lists of jobs."""

    def page(
        self, what: What, client: str | None, statuses: frozenset[Status], before: str, limit: int
    ) -> Page:
        """Returns jobs or batches in one of the states, at most `limit`, made before the time `before`.

        The cost of a page is bounded, so that one may have few items, or none, and yet not be the last one.
        `client`: only what this one asked for.
        """
        index = f"{self.keys.active}:made:{what}" + ("" if client is None else f":{client}")
        if client is None and statuses <= ACTIVE:
            index = self.keys.active
        found: list[Listed] = []
        for _ in range(_STEPS):
            entries = self._entries(index, before)
            for job_id, score, listed in self._read(entries):
                is_asked_for = is_batch(job_id) is (what == "batches")
                if is_asked_for and listed is not None and listed.view.status in statuses:
                    found.append(listed)
                before = score
                if len(found) == limit:
                    return Page(found, before)
            if len(entries) < _STEP:
                return Page(found, None)
        return Page(found, before)

    def _entries(self, index: str, before: str) -> list[tuple[str, str]]:
        raw: Any = self.redis.zrevrangebyscore(
            index, f"({before}" if before else "+inf", "-inf", start=0, num=_STEP, withscores=True
        )
        return [(job_id.decode(), f"{score:.6f}") for job_id, score in raw]

    def _read(self, entries: Sequence[tuple[str, str]]) -> list[tuple[str, str, Listed | None]]:
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.time()
            for job_id, _ in entries:
                pipe.hmget(self.keys.job(job_id).record, [*VIEW_FIELDS, "maker"])
            (seconds, micros), *records = pipe.execute()
        now = seconds + micros / 1e6
        return [
            (job_id, score, _listed(job_id, fields, now))
            for (job_id, score), fields in zip(entries, records, strict=True)
        ]


def _listed(job_id: str, fields: list[bytes | None], now: float) -> Listed | None:
    view = view_of(job_id, fields)
    if view is None:
        return None
    started = dict(zip(VIEW_FIELDS, fields, strict=False))["started"]
    runs = view.run_seconds
    if started is not None and not view.is_terminal:
        runs = max(0.0, now - float(started))
    maker = fields[-1]
    return Listed(view, maker.decode() if maker else None, runs)
