"""Callbacks: the URLs to call when a job ends, and the deliveries of these events.

To claim a delivery is to take a lease: its entry moves to the time at which another may claim it, so that a
delivery survives those who make it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal, cast
from urllib.parse import urlsplit

from worker.jobs import InRedis
from worker.jobs.view import JobView, iso, job_view

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


class Callbacks(InRedis):
    """The callbacks of an installation and their deliveries."""

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
