"""The base of all models, and the limits on one request."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, PositiveInt

from rpr_solver.errors import FieldProblem, InputError
from worker.limits import DEADLINE, Deadline

DEFERRED = ConfigDict(defer_build=True)
"""What is built when it is first used: a process uses few models, and starts sooner."""


class Model(BaseModel):
    """A pydantic model that is built when it is first used."""

    model_config = DEFERRED


_PREFIX = "rpr_cusps_"

MIN_DIGITS = 15
MAX_DIGITS = 1000

SupportedDigits = Annotated[int, Field(ge=MIN_DIGITS, le=MAX_DIGITS)]


class Limits(Model):
    """Limits on one request. Exceeding one is a 4xx that names it; `/v1/limits` lists them."""

    model_config = ConfigDict(frozen=True)

    max_slices: PositiveInt = Field(default=2000, description="maximum number of slices in one request")
    max_article_slices: PositiveInt = Field(
        default=50, description="maximum number of slices in one request by the article's method"
    )
    max_samples: PositiveInt = Field(
        default=50, description="maximum number of sample points per cusp curve in each interval"
    )
    min_digits: SupportedDigits = Field(
        default=MIN_DIGITS, description="minimum number of significant digits of an answer"
    )
    max_digits: SupportedDigits = Field(
        default=MAX_DIGITS, description="maximum number of significant digits of an answer"
    )
    default_digits: SupportedDigits = Field(
        default=90, description="number of significant digits if a request does not specify it"
    )
    max_number_digits: int = Field(
        default=400,
        ge=1,
        le=4000,
        description="maximum number of digits in the numerator or denominator of an input number",
    )
    max_cost_seconds: PositiveInt = Field(
        default=120, description="maximum estimated work for one request, in seconds of one core"
    )
    deadline: Deadline = DEADLINE
    max_body_bytes: PositiveInt = Field(
        default=1 << 20, description="maximum size of a request body or of one item of a batch, in bytes"
    )
    max_body_members: PositiveInt = Field(
        default=20_000, description="maximum number of members and elements in a request body, about"
    )
    max_batch_items: PositiveInt = Field(default=10_000, description="maximum number of items in one batch")
    max_batch_bytes: PositiveInt = Field(
        default=64 << 20,
        description="maximum size of a batch, in bytes: of its body, and of its items in canonical form",
    )
    max_batch_wait_seconds: NonNegativeInt = Field(
        default=300,
        description="maximum time that `Prefer: wait` can keep results of a batch open, in seconds",
    )
    max_result_bytes: PositiveInt = Field(default=256 << 20, description="maximum size of a result, in bytes")
    max_requests_per_minute: NonNegativeInt = Field(
        default=6000,
        description="maximum number of requests in a minute with one key, or from one network address "
        "without keys; 0: any number; does not count for clients on the same computer without keys",
    )
    max_active_jobs: NonNegativeInt = Field(
        default=500, description="maximum number of queued and running jobs, counted in the same way"
    )
    max_active_seconds: NonNegativeInt = Field(
        default=7200,
        description="maximum estimated work of these jobs, in seconds of one core, counted in the same way",
    )
    max_kept_bytes: NonNegativeInt = Field(
        default=256 << 20,
        description="maximum size of kept questions, in bytes: of active jobs and of batches that are being "
        "received, and what the records of ended jobs keep of theirs; counted in the same way",
    )
    max_wait_seconds: NonNegativeInt = Field(
        default=30, description="maximum time that `Prefer: wait` can hold a request, in seconds"
    )

    @classmethod
    def of_environment(cls, **given: int) -> Self:
        """Returns the limits that the environment sets (`RPR_CUSPS_…`), except those that are given.

        Each command needs them, and loading `pydantic_settings` would take a sixth of its time.

        Raises:
            ValidationError: a variable is invalid.
        """
        variables = {name.lower(): text for name, text in os.environ.items()}
        found = {name: variables[_PREFIX + name] for name in cls.model_fields if _PREFIX + name in variables}
        return cls.model_validate({**found, **given})


class LimitError(InputError):
    """The input is valid but exceeds a limit."""

    def __init__(self, problems: Sequence[FieldProblem], limit: str, value: float) -> None:
        self.limit, self.value = limit, value
        super().__init__(problems)

    @classmethod
    def exceeded(cls, limits: Limits, name: str, sent: str, field: str = "") -> LimitError:
        """Returns the error that `sent` exceeds the limit `name`."""
        value: float = getattr(limits, name)
        return cls([FieldProblem(field, f"{sent}; the limit {name} is {value:.15g}")], name, value)
