"""Jobs as they are shown."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from worker.answers.kinds import KINDS


class Progress(BaseModel):
    """How far a job is."""

    done: int = Field(description="Slices, or steps, that are done.")
    total: int = Field(description="Slices of the job, or its steps as far as they are known.")


class JobError(BaseModel):
    """Why a job failed."""

    type: str = Field(description="timeout, worker-lost, resource-exhausted, solver-error, input-error, …")
    detail: str


class JobLinks(BaseModel):
    """Where the parts of a job are."""

    self: str
    result: str
    events: str


class Job(BaseModel):
    """An answer that is being computed, or was."""

    id: str
    kind: str = Field(
        description="What it computes.", json_schema_extra={"enum": [kind.name for kind in KINDS]}
    )
    status: Literal["queued", "running", "succeeded", "failed", "canceled"]
    progress: Progress
    created_at: str = Field(description="ISO 8601, UTC.", json_schema_extra={"format": "date-time"})
    started_at: str | None = Field(description="ISO 8601, UTC; null before.")
    finished_at: str | None = Field(description="ISO 8601, UTC; null before.")
    error: JobError | None = Field(description="Only when the job failed.")
    links: JobLinks
