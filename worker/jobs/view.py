"""The state of a job, as it is shown."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Literal, cast

from worker.answers.kinds import is_batch
from worker.lua.scripts import VIEW_FIELDS

Status = Literal["queued", "running", "succeeded", "failed", "canceled"]

State = Literal[Status, "completed"]
"""What callers see: a batch ends as `completed`, since some of its items may have failed."""

ACTIVE: frozenset[Status] = frozenset({"queued", "running"})


@dataclass(frozen=True)
class QueuePosition:
    """The number of jobs before a queued job in its lane, and the estimated seconds that they take."""

    position: int
    seconds: float


@dataclass(frozen=True)
class JobView:
    """The state of a job. Times are ISO 8601 in UTC.

    Attributes:
        deadline_at: when the job fails unless it is done; None if a client waits without a deadline.
        place: its position in the queue, if it is queued.
        failed: the items of a batch that are done without an answer.
        estimate_seconds: its estimated work, in seconds of one core; None if it is not known.
        event: the event of this state, if known: events to wait for follow it.
    """

    id: str
    status: Status
    done: int
    total: int
    created_at: str
    started_at: str | None
    ended_at: str | None
    error: dict[str, str] | None
    run: str
    deadline_at: str | None = None
    place: QueuePosition | None = None
    failed: int = 0
    estimate_seconds: float | None = None
    event: str = field(default="", compare=False)

    @property
    def is_terminal(self) -> bool:
        """Whether the job has ended."""
        return self.status not in ACTIVE

    @property
    def state(self) -> State:
        """The status as callers see it."""
        return shown_state(self.id, self.status)


def shown_state(job_id: str, status: Status) -> State:
    """Returns the status of a job or a batch as callers see it."""
    return "completed" if status == "succeeded" and is_batch(job_id) else status


def view_of(job_id: str, fields: Sequence[bytes | None]) -> JobView | None:
    """Returns the state of a job from `VIEW_FIELDS` of its record, or None if there is none."""
    named = {name: raw.decode() for name, raw in zip(VIEW_FIELDS, fields, strict=False) if raw is not None}
    return job_view(job_id, named) if "run" in named and "status" in named else None


def job_view(job_id: str, fields: Mapping[str, str], event: str = "") -> JobView:
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
        ended_at=finished,
        error=json.loads(error) if error else None,
        run=fields["run"],
        deadline_at=deadline,
        failed=int(fields.get("failed", 0)),
        estimate_seconds=int(fields["work"]) / 1000 if "work" in fields else None,
        event=event,
    )


def iso(seconds: float) -> str:
    """Returns a time, in seconds since 1970, in ISO 8601."""
    text = datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")
    return text.replace("+00:00", "Z")
