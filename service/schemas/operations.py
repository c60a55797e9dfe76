"""The state of the service itself."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict, Field

from service.schemas.model import Model


class Health(Model):
    """The process is running."""

    status: Literal["ok"]


class Readiness(Model):
    """Requests can be served."""

    status: Literal["ready"]
    workers: int = Field(description="Number of live workers.")
    warnings: list[str] = Field(
        default=[],
        description="What endangers jobs: a setting of Redis, or a lane of the queue that stands "
        "still. Empty if nothing does.",
    )


class Version(Model):
    """The versions of the software that computes the answers."""

    service: str
    commit: str | None = Field(
        default=None,
        description="The commit of the code, with `-dirty` if it was changed since; null if it is not known.",
    )
    solver_version: str
    python: str
    libraries: dict[str, str | None]


class Limit(Model):
    """A limit and its meaning."""

    value: int
    description: str


class TimeLimit(Model):
    """A limit in seconds and its meaning."""

    value: float
    description: str


class LimitsDocument(Model):
    """All limits on requests."""

    model_config = ConfigDict(title="Limits")

    max_slices: Limit
    max_article_slices: Limit
    max_samples: Limit
    min_digits: Limit
    max_digits: Limit
    default_digits: Limit
    max_number_digits: Limit
    max_cost_seconds: Limit
    deadline: TimeLimit
    max_body_bytes: Limit
    max_body_members: Limit
    max_batch_items: Limit
    max_batch_bytes: Limit
    max_batch_wait_seconds: Limit
    max_result_bytes: Limit
    max_requests_per_minute: Limit
    max_active_jobs: Limit
    max_active_seconds: Limit
    max_kept_bytes: Limit
    max_wait_seconds: Limit
