"""What the service tells of itself."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Health(BaseModel):
    """The process runs."""

    status: Literal["ok"]


class Readiness(BaseModel):
    """Requests can be served."""

    status: Literal["ready"]
    workers: int = Field(description="Workers that are alive.")


class Version(BaseModel):
    """What computes the answers."""

    service: str
    solver_version: str
    python: str
    libraries: dict[str, str | None]


class Limit(BaseModel):
    """One limit."""

    value: int
    description: str


class LimitsDocument(BaseModel):
    """All limits of requests."""

    model_config = ConfigDict(title="Limits")

    max_slices: Limit
    max_article_slices: Limit
    max_samples: Limit
    min_digits: Limit
    max_digits: Limit
    default_digits: Limit
    max_number_digits: Limit
    max_body_bytes: Limit
    max_wait_seconds: Limit
