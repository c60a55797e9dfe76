"""What is sent, as pydantic models: strict, and with every fault told in words under its dotted name.

A validator raises :class:`InputError`, which names its fault relative to the value that is read: "" for the
value itself, "step" or "range.from" for a part of it. Limits reach validators as the validation's context.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, ClassVar, Self, TypeVar, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from rpr_solver.errors import FieldProblem, InputError
from service.schemas.exact_json import json_kind
from service.schemas.limits import LimitError, Limits

T = TypeVar("T")

_LISTED = 20


@dataclass(frozen=True)
class Expected:
    """Beside the type of a field: what to give, as a message says it."""

    text: str


class Document(BaseModel):
    """An object that is sent. Unknown members are refused."""

    model_config = ConfigDict(extra="forbid")

    expected: ClassVar[str] = "give an object"

    @model_validator(mode="wrap")
    @classmethod
    def _in_words(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if isinstance(value, cls):
            return value
        if not isinstance(value, Mapping):
            raise InputError.of("", f"is {json_kind(value)}; {cls.expected}")
        errors: list[InputError] = [InputError([problem]) for problem in cls._problems_of_members(value)]
        known = {name: value[name] for name in cls._members(value) if name in value}
        try:
            document = handler(known)
        except ValidationError as error:
            errors += (at(cause, place) for place, cause in cls._causes(error))
        if errors:
            raise together(errors)
        return document

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        """The members that this object may have."""
        del value
        return [field.alias or name for name, field in cls.model_fields.items()]

    @classmethod
    def _problems_of_members(cls, value: Mapping[str, Any]) -> Iterator[FieldProblem]:
        known = cls._members(value)
        for name in islice((name for name in value if name not in known), _LISTED):
            shown = name[:60].encode("utf-8", "backslashreplace").decode()
            yield FieldProblem(shown, f"unknown field; {cls._hint(name, known)}")

    @classmethod
    def _hint(cls, name: str, known: Sequence[str]) -> str:
        near = difflib.get_close_matches(name[:60], known, n=1, cutoff=0.5)
        return f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"

    @classmethod
    def _causes(cls, error: ValidationError) -> Iterator[tuple[str, InputError]]:
        for fault in error.errors(include_url=False):
            cause = fault.get("ctx", {}).get("error")
            if not isinstance(cause, InputError):
                cause = InputError.of("", cls._sentence(fault))
            yield dotted(fault["loc"]), cause

    @classmethod
    def _sentence(cls, fault: Any) -> str:
        """What pydantic complains of by itself, in words."""
        [field] = [f for name, f in cls.model_fields.items() if fault["loc"][-1] in (name, f.alias)]
        if fault["type"] == "missing":
            texts = [hint.text for hint in field.metadata if isinstance(hint, Expected)]
            return f"is missing; {texts[0] if texts else getattr(field.annotation, 'expected', 'give it')}"
        value = fault["input"]
        said = repr(value[:40]) if type(value) is str else json_kind(value)
        return f"is {said}; it must be one of {', '.join(get_args(field.annotation))}"


M = TypeVar("M", bound=Document)


def read(model: type[M], value: object, limits: Limits, field: str = "") -> M:
    """Read what was sent.

    Args:
        model: what it should be.
        value: JSON as :func:`service.schemas.exact_json.parse_json` gives it, or exact values.
        limits: what may be asked for.
        field: how messages call the whole; without it, by the names of its members, and "body".

    Raises:
        LimitError: it is right but too large.
        InputError: naming every field at fault.
    """
    try:
        return part(model.model_validate, value, limits)
    except InputError as error:
        raise (at(error, field) if field else _whole_named(error)) from None


def part(validate: Callable[..., T], value: object, limits: Limits) -> T:
    """Read a part of what was sent by a method of pydantic's; faults are named relative to it."""
    try:
        return validate(value, context=limits)
    except ValidationError as error:
        raise together([at(f["ctx"]["error"], dotted(f["loc"])) for f in error.errors()]) from None


def limits_of(info: ValidationInfo) -> Limits:
    """The limits in the context of a validation."""
    limits: Limits = info.context or Limits()
    return limits


def at(error: InputError, place: str) -> InputError:
    """The same error of a part, named from the whole."""
    problems = [FieldProblem(_joined(place, p.field), p.message) for p in error.problems]
    if isinstance(error, LimitError):
        return LimitError(problems, error.limit, error.value)
    return InputError(problems)


def together(errors: Iterable[InputError]) -> InputError:
    """One error for all; that of a limit only if all are."""
    errors = list(errors)
    problems = [problem for error in errors for problem in error.problems]
    first = errors[0]
    if isinstance(first, LimitError) and all(isinstance(error, LimitError) for error in errors):
        return LimitError(problems, first.limit, first.value)
    return InputError(problems)


def dotted(place: Iterable[int | str]) -> str:
    """Where something is, as messages call it: ``geometry.d1``, ``l1[3]``."""
    return "".join(f"[{x}]" if isinstance(x, int) else f".{x}" for x in place).removeprefix(".")


def _joined(place: str, field: str) -> str:
    return f"{place}.{field}" if place and field and not field.startswith("[") else place + field


def _whole_named(error: InputError) -> InputError:
    return error if all(p.field for p in error.problems) else at(error, "body")
