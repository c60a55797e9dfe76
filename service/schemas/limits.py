"""The base of all models, and the limits on one request."""

from __future__ import annotations

import os
from collections.abc import Sequence
from inspect import cleandoc
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, NonNegativeInt, PositiveInt

from rpr_solver.errors import FieldProblem, InputError
from worker.limits import ATTRIBUTES, DEADLINE, Constant, Deadline, describe_fields, is_setting

DEFERRED = ConfigDict(defer_build=True)
"""What is built when it is first used: a process uses few models, and starts sooner."""


class Model(BaseModel):
    """A pydantic model that is built when it is first used.

    What its docstring says of its attributes is the description of its fields.
    """

    model_config = DEFERRED

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        describe_fields(cls)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        schema = handler(core)
        own = handler.resolve_ref_schema(schema)
        if text := cls.about():
            own["description"] = " ".join(text.split())
        for member in own.get("properties", {}).values():
            member.pop("title", None)  # derived from the name
            if member.get("default", ...) is None:
                del member["default"]  # null is as missing
            if "description" in member:
                member["description"] = " ".join(member["description"].split())
        return schema

    @classmethod
    def about(cls) -> str:
        """Returns what the docstring says before the attributes."""
        return cleandoc(cls.__doc__ or "").partition(ATTRIBUTES)[0].strip()


class Detail(Model):
    """A part of an answer that is an object in the contract, described in words.

    Few programs read it, and it may get more members.
    """

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        text = " ".join(cls.about().split())
        return {"type": "object", "additionalProperties": True, **({"description": text} if text else {})}


_PREFIX = "rpr_cusps_"

MIN_DIGITS = 15
MAX_DIGITS = 1000


class Limits(Model):
    """Limits on one request. Exceeding one is a 4xx that names it; `/v1/limits` lists them.

    Attributes:
        max_slices: maximum number of slices in one request
        max_article_slices: maximum number of slices in one request by the article's method
        max_samples: maximum number of sample points per cusp curve in each interval
        min_digits: minimum number of significant digits of an answer
        max_digits: maximum number of significant digits of an answer
        default_digits: number of significant digits if a request does not specify it
        max_number_digits: maximum number of digits in the numerator or denominator of an input number
        max_cost_seconds: maximum estimated work for one request, in seconds of one core
        max_body_bytes: maximum size of a request body or of one item of a batch, in bytes
        max_body_members: maximum number of members and elements in a request body, about
        max_batch_items: maximum number of items in one batch
        max_batch_bytes: maximum size of a batch, in bytes: of its body, and of its items in canonical form
        max_batch_wait_seconds: maximum time that `Prefer: wait` can keep results of a batch open, in seconds
        max_result_bytes: maximum size of a result, in bytes
        max_requests_per_minute: maximum number of requests in a minute with one key, or from one network
            address without keys; 0: any number; does not count for clients on the same computer without keys
        max_active_jobs: maximum number of queued and running jobs, counted in the same way
        max_active_seconds: maximum estimated work of these jobs, in seconds of one core, counted in the same
            way
        max_wait_seconds: maximum time that `Prefer: wait` can hold a request, in seconds
    """

    model_config = ConfigDict(frozen=True)

    max_slices: PositiveInt = 2000
    max_article_slices: Constant[int] = 50
    max_samples: Constant[int] = 50
    min_digits: Constant[int] = MIN_DIGITS
    max_digits: Constant[int] = MAX_DIGITS
    default_digits: Constant[int] = 90
    max_number_digits: Constant[int] = 400
    max_cost_seconds: PositiveInt = 120
    deadline_seconds: Deadline = DEADLINE
    max_body_bytes: PositiveInt = 1 << 20
    max_body_members: Constant[int] = 20_000
    max_batch_items: PositiveInt = 10_000
    max_batch_bytes: Constant[int] = 64 << 20
    max_batch_wait_seconds: Constant[int] = 300
    max_result_bytes: Constant[int] = 256 << 20
    max_requests_per_minute: NonNegativeInt = 6000
    max_active_jobs: NonNegativeInt = 500
    max_active_seconds: NonNegativeInt = 7200
    max_wait_seconds: Constant[int] = 30

    @classmethod
    def of_environment(cls, **given: int) -> Self:
        """Returns the limits that the environment sets (`RPR_CUSPS_…`), except those that are given.

        Each command needs them, and loading `pydantic_settings` would take a sixth of its time.

        Raises:
            ValidationError: a variable is invalid.
        """
        variables = {name.lower(): text for name, text in os.environ.items()}
        found = {
            name: variables[_PREFIX + name]
            for name, field in cls.model_fields.items()
            if is_setting(field) and _PREFIX + name in variables
        }
        return cls.model_validate({**found, **given})


class LimitError(InputError):
    """The input is valid but exceeds a limit."""

    def __init__(self, problems: Sequence[FieldProblem], limit: str, value: float) -> None:
        self.limit, self.value = limit, value
        super().__init__(problems)

    @classmethod
    def of_digits(cls, limits: Limits, digits: int) -> LimitError:
        """Returns the error that a number has too many digits, as `digit_count` counts them."""
        counted = f"{digits} digits" if digits < 10**20 else "more than 10^20 digits"
        return cls.exceeded(limits, "max_number_digits", f"a number with {counted}")

    @classmethod
    def exceeded(cls, limits: Limits, name: str, sent: str, field: str = "") -> LimitError:
        """Returns the error that `sent` exceeds the limit `name`."""
        value: float = getattr(limits, name)
        return cls([FieldProblem(field, f"{sent}; the limit {name} is {value:.15g}")], name, value)
