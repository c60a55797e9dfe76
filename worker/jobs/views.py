"""The state of a job, as the API sees it, and the lists of jobs, the newest first."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal, cast

from worker.jobs import InRedis, QueuePosition
from worker.lua import VIEW_FIELDS

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
                if listed is not None and listed.view.status in statuses and is_one(job_id, what):
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


def is_one(job_id: str, what: What) -> bool:
    """Whether a job is one of those that are listed: a batch, or not."""
    return job_id.startswith("ba-") is (what == "batches")


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
