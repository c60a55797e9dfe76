"""Strict pydantic models for input; every fault is a sentence under the field's dotted name.

A validator raises :class:`InputError`, which names the fault relative to the validated value: "" for the
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
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from rpr_solver.errors import FieldProblem, InputError
from service.schemas.exact_json import json_kind
from service.schemas.limits import LimitError, Limits
from service.schemas.model import Model

T = TypeVar("T")


_LISTED, _LISTED_IN_PART = 20, 50


@dataclass(frozen=True)
class Source:
    """Where values come from: a request, a command line, or code.

    Attributes:
        limits: the limits that apply.
        names: the options behind members such as "l1" or "limits.l2", for messages.
        is_text: whether every value is text, as on a command line; JSON distinguishes numbers and strings.
    """

    limits: Limits
    names: Mapping[str, str] = field(default_factory=dict)
    is_text: bool = False

    @classmethod
    def of(cls, info: ValidationInfo) -> Source:
        """Returns the source of a validation."""
        source: Source = info.context or cls(Limits.of_environment())
        return source

    def called(self, place: str) -> str:
        """Returns the name of a member in messages."""
        for member, name in self.names.items():
            if place == member or place.startswith((f"{member}.", f"{member}[")):
                return name + re.sub(r"^\[\d+\]", "", place.removeprefix(member))
        return place or "body"


@dataclass(frozen=True)
class Expected:
    """Metadata of a field: the advice in the message that it is missing."""

    text: str


class Document(Model):
    """An object in the input. Unknown members are refused."""

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
        """Returns the members that this object may have."""
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
        near = difflib.get_close_matches(name[:60].lower(), known, n=1, cutoff=0.5)
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
        """Returns the sentence for a fault that pydantic detects by itself."""
        [info] = [f for name, f in cls.model_fields.items() if fault["loc"][-1] in (name, f.alias)]
        if fault["type"] == "missing":
            texts = [hint.text for hint in info.metadata if isinstance(hint, Expected)]
            return f"is missing; {texts[0] if texts else getattr(info.annotation, 'expected', 'give it')}"
        value = fault["input"]
        shown = repr(value[:40]) if type(value) is str else json_kind(value)
        return f"is {shown}; it must be one of {', '.join(_words(info.annotation))}"


def _words(annotation: Any) -> Iterator[str]:
    """Yields the words of a literal type, perhaps one of a union."""
    for part in get_args(annotation):
        yield from [part] if isinstance(part, str) else _words(part)


def given(description: str, **more: Any) -> Any:
    """Returns a field that may be missing but is never null."""
    return Field(default=None, description=description, json_schema_extra=_without_default, **more)


def _without_default(schema: dict[str, Any]) -> None:
    schema.pop("default", None)


M = TypeVar("M", bound=Document)


def read(model: type[M], value: object, source: Source) -> M:
    """Read input as a model.

    Args:
        model: the expected model.
        value: JSON as :func:`service.schemas.exact_json.parse_json` returns it, options, or exact values.
        source: where the input comes from.

    Raises:
        LimitError: the input is valid but exceeds a limit.
        InputError: naming every faulty field.
    """
    try:
        return part(model.model_validate, value, source)
    except InputError as error:
        raise renamed(error, source.called) from None


@contextmanager
def named(option: str) -> Iterator[None]:
    """Attribute the input errors of a block to an option."""
    try:
        yield
    except InputError as error:
        raise at(error, option) from None


@contextmanager
def unnamed(member: str) -> Iterator[None]:
    """Name the solver's input errors relative to a member, rather than by the member's usual name."""
    try:
        yield
    except InputError as error:
        raise renamed(error, lambda field: field.removeprefix(member).removeprefix(".")) from None


def part(validate: Callable[..., T], value: object, source: Source) -> T:
    """Read a part of the input by a method of pydantic's; faults are named relative to the part."""
    try:
        return validate(value, context=source)
    except ValidationError as error:
        faults = error.errors()[:_LISTED_IN_PART]
        raise together([at(fault["ctx"]["error"], dotted(fault["loc"])) for fault in faults]) from None


def at(error: InputError, place: str) -> InputError:
    """Returns the error of a part as an error of the whole."""
    return renamed(error, lambda field: _joined(place, field))


def renamed(error: InputError, name: Callable[[str], str]) -> InputError:
    """Returns the error with renamed fields."""
    problems = [FieldProblem(name(p.field), p.message) for p in error.problems]
    if isinstance(error, LimitError):
        return LimitError(problems, error.limit, error.value)
    return InputError(problems)


def together(errors: Iterable[InputError]) -> InputError:
    """Returns one error for all; a LimitError only if all are."""
    errors = list(errors)
    problems = [problem for error in errors for problem in error.problems]
    first = errors[0]
    if isinstance(first, LimitError) and all(isinstance(error, LimitError) for error in errors):
        return LimitError(problems, first.limit, first.value)
    return InputError(problems)


def dotted(place: Iterable[int | str]) -> str:
    """Returns a place as messages name it: ``geometry.d1``, ``l1[3]``."""
    return "".join(f"[{x}]" if isinstance(x, int) else f".{x}" for x in place).removeprefix(".")


def _joined(place: str, field: str) -> str:
    return f"{place}.{field}" if place and field and not field.startswith("[") else place + field
