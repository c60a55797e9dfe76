"""The lists of jobs and of batches as the contract shows them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from service.schemas.jobs import ESTIMATE, OVERRUNS
from service.schemas.model import Model
from worker.answers.kinds import KINDS

ListedStatus = Literal["active", "queued", "running", "succeeded", "failed", "canceled"]
"""What may be asked for: a state, or `active`."""


class ListedJob(Model):
    """A job or a batch in a list."""

    id: str
    kind: str | None = Field(
        description="The kind of the document that it computes, or `batch`.",
        json_schema_extra={"enum": [*(kind.name for kind in KINDS), "batch", None]},
    )
    status: Literal["queued", "running", "succeeded", "failed", "canceled"]
    created_at: str = Field(description="ISO 8601, UTC.", json_schema_extra={"format": "date-time"})
    started_at: str | None = Field(description="ISO 8601, UTC; null until it starts.")
    estimate_s: float | None = ESTIMATE
    runs_s: float | None = Field(
        description="For how many seconds it has run, or ran; null before its start."
    )
    overruns: int = OVERRUNS
    key: str | None = Field(
        description="The name of the key that asked for it first; null if that was without a key."
    )


class JobList(Model):
    """A page of jobs or of batches, the newest first: a key's own, or all for the operator."""

    items: list[ListedJob]
    next: str | None = Field(
        description="The address of the next page, null after the last; any page may have few items."
    )
