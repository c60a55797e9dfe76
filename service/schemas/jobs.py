"""Jobs as the contract shows them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from service.schemas.model import Model
from service.schemas.points import optional
from worker.answers.kinds import KINDS

ESTIMATE: Any = Field(
    default=None, description="The estimated work, in seconds of one core; null if it is not known."
)
OVERRUNS: Any = Field(
    default=0,
    description="How many of its chunks took a few times their estimate. A worker that is kept for short "
    "work has given them back to the others, without a loss; each is told by a `status` event.",
)


class Progress(Model):
    """The progress of a job."""

    done: int = Field(description="Completed slices or steps.")
    total: int = Field(description="All slices of the job, or the steps known so far; may grow.")


class JobError(Model):
    """Why a job failed."""

    type: str = Field(description="timeout, worker-lost, resource-exhausted, solver-error, input-error, …")
    detail: str


class JobLinks(Model):
    """The addresses of a job's resources."""

    self: str
    result: str
    events: str
    cancel: str | None = optional(
        "In the answer to the question only: DELETE it to withdraw this question, and no other client's."
    )


class Timings(Model):
    """How long a job took, in seconds."""

    queued_seconds: float | None = Field(description="Until it started or ended; null while it is queued.")
    running_seconds: float | None = Field(description="From its start to its end; null before its end.")


class StreamEvent(Model):
    """A server-sent event: its fields."""

    id: str = Field(description="Resumes the stream, as Last-Event-ID.")
    event: Literal["status", "slice", "progress", "item"]
    data: str = Field(
        description="JSON. `status`: the job or batch as it was then; also when a chunk has overrun. "
        "`slice`: `l1`, `slice` and `progress`. `progress`: `progress`. `item`: `index`, `status` and "
        "`progress`.",
        json_schema_extra={"contentMediaType": "application/json", "contentSchema": {"type": "object"}},
    )


class Job(Model):
    """The computation of an answer.

    The states of a run go one way: queued, running, then one of the others, which stays. If the question is
    asked again after a job has failed, was canceled or has expired, it begins a new run under the same id.
    """

    id: str
    kind: str = Field(
        description="The kind of the document that it computes.",
        json_schema_extra={"enum": [kind.name for kind in KINDS]},
    )
    status: Literal["queued", "running", "succeeded", "failed", "canceled"]
    run: str = Field(description="Distinguishes the runs of the job.")
    done: bool = Field(description="Whether this run has ended: succeeded, failed or canceled.")
    progress: Progress
    created_at: str = Field(description="ISO 8601, UTC.", json_schema_extra={"format": "date-time"})
    started_at: str | None = Field(description="ISO 8601, UTC; null until the job starts.")
    finished_at: str | None = Field(description="ISO 8601, UTC; null until the job ends.")
    expires_at: str | None = Field(
        description="ISO 8601, UTC: until when it can be fetched; null until it ends."
    )
    timings: Timings
    error: JobError | None = Field(description="null unless the job failed.")
    position: int | None = Field(
        description="Jobs before it in its lane of the queue; null unless it is queued."
    )
    deadline_at: str | None = Field(
        description="When it fails unless it is done, by the latest `deadline_s`; null without one."
    )
    estimate_s: float | None = ESTIMATE
    overruns: int = OVERRUNS
    links: JobLinks
