"""Errors as the contract shows them (RFC 9457)."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from service.schemas.model import Model
from service.schemas.points import optional


class FieldError(Model):
    """A faulty field."""

    field: str = Field(description="The dotted name of the field, for example geometry.d1.")
    pointer: str | None = optional("The JSON pointer to it (RFC 6901), if it is in the body: /geometry/d1.")
    message: str = Field(description="The fault, and a valid alternative.")


class LimitInfo(Model):
    """The limit that was exceeded."""

    name: str
    value: float


class ProblemDocument(Model):
    """An error (RFC 9457)."""

    model_config = ConfigDict(extra="allow", title="Problem")

    type: str = Field(description="Identifies the type of problem; the address documents it.")
    title: str
    status: int
    detail: str
    errors: list[FieldError]
    instance: str | None = optional("The path of the request.")
    limit: LimitInfo | None = optional("Present if a limit was exceeded.")
    job: str | None = optional("The job concerned.")
