"""What is sent, as pydantic models: strict, and with every fault told in words under its dotted name.

A validator raises :class:`InputError`, which names its fault relative to the value that is read: "" for the
value itself, "step" or "range.from" for a part of it. The :class:`Source` is the validation's context.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
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
class Source:
    """Where values come from, and what may be asked for there.

    Attributes:
        limits: what may be asked for.
        names: how messages call members such as "l1" or "limits.l2": by the options that gave them.
        is_text: whether every value is text, as on a command line; JSON tells numbers from strings.
    """

    limits: Limits
    names: Mapping[str, str] = field(default_factory=dict)
    is_text: bool = False

    @classmethod
    def of(cls, info: ValidationInfo) -> Source:
        """The source of a validation."""
        source: Source = info.context or cls(Limits())
        return source

    def called(self, place: str) -> str:
        """How messages call a member."""
        for member, name in self.names.items():
            if place == member or place.startswith((f"{member}.", f"{member}[")):
                return name + re.sub(r"^\[\d+\]", "", place.removeprefix(member))
        return place or "body"


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
        known = cls._members(value)
        errors = [InputError([problem]) for problem in cls._problems_of_members(value, known)]
        try:
            document = handler({name: value[name] for name in known if name in value})
        except ValidationError as error:
            errors += (at(cause, place) for place, cause in cls._causes(error))
        if errors:
            raise together(errors)
        return document

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        """The members that this object may have."""
        del value
        return cls._names()

    @classmethod
    @cache
    def _names(cls) -> Sequence[str]:
        return [info.alias or name for name, info in cls.model_fields.items()]

    @classmethod
    def _problems_of_members(cls, value: Mapping[str, Any], known: Sequence[str]) -> Iterator[FieldProblem]:
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
        [info] = [f for name, f in cls.model_fields.items() if fault["loc"][-1] in (name, f.alias)]
        if fault["type"] == "missing":
            texts = [hint.text for hint in info.metadata if isinstance(hint, Expected)]
            return f"is missing; {texts[0] if texts else getattr(info.annotation, 'expected', 'give it')}"
        value = fault["input"]
        said = repr(value[:40]) if type(value) is str else json_kind(value)
        return f"is {said}; it must be one of {', '.join(get_args(info.annotation))}"


M = TypeVar("M", bound=Document)


def read(model: type[M], value: object, source: Source) -> M:
    """Read what was sent.

    Args:
        model: what it should be.
        value: JSON as :func:`service.schemas.exact_json.parse_json` gives it, options, or exact values.
        source: where it comes from, and what may be asked for there.

    Raises:
        LimitError: it is right but too large.
        InputError: naming every field at fault.
    """
    try:
        return part(model.model_validate, value, source)
    except InputError as error:
        raise renamed(error, source.called) from None


@contextmanager
def named(option: str) -> Iterator[None]:
    """Errors of what is read here are those of this option."""
    try:
        yield
    except InputError as error:
        raise at(error, option) from None


@contextmanager
def unnamed(member: str) -> Iterator[None]:
    """Errors of the solver, which calls a member by its usual name, are told relative to it."""
    try:
        yield
    except InputError as error:
        raise renamed(error, lambda field: field.removeprefix(member).removeprefix(".")) from None


def part(validate: Callable[..., T], value: object, source: Source) -> T:
    """Read a part of what was sent by a method of pydantic's; faults are named relative to it."""
    try:
        return validate(value, context=source)
    except ValidationError as error:
        raise together([at(f["ctx"]["error"], dotted(f["loc"])) for f in error.errors()]) from None


def at(error: InputError, place: str) -> InputError:
    """The same error of a part, named from the whole."""
    return renamed(error, lambda field: _joined(place, field))


def renamed(error: InputError, name: Callable[[str], str]) -> InputError:
    """The same error with other names of the fields."""
    problems = [FieldProblem(name(p.field), p.message) for p in error.problems]
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
