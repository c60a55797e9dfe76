"""Errors as they are shown (RFC 9457)."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from service.schemas.points import optional


class FieldError(BaseModel):
    """One field at fault."""

    field: str = Field(description="Its dotted name, for example geometry.d1.")
    message: str = Field(description="What is wrong with it and what would be right.")


class LimitInfo(BaseModel):
    """The limit that was exceeded."""

    name: str
    value: int


class ProblemDocument(BaseModel):
    """An error (RFC 9457)."""

    model_config = ConfigDict(extra="allow", title="Problem")

    type: str = Field(description="Names the kind of problem; its page documents it.")
    title: str
    status: int
    detail: str
    errors: list[FieldError]
    instance: str | None = optional("The path that was asked for.")
    limit: LimitInfo | None = optional("Only when a limit was exceeded.")
    job: str | None = optional("The job that this is about.")
