"""Strict JSON of bounded depth, in which every number is kept as it was written, and strict pydantic models
for input; every fault is a sentence under the field's dotted name.

A validator raises :class:`InputError`, which names the fault relative to the validated value: "" for the
value itself, "step" or "range.from" for a part of it. The :class:`Source` is the validation's context.
"""

from __future__ import annotations

import difflib
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, ClassVar, Self, TypeVar, get_args

from pydantic import (
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from rpr_solver.errors import FieldProblem, InputError, clipped
from rpr_solver.exact.numerals import digit_count, integer, longest_text
from rpr_solver.verify.reader import MAX_DEPTH
from service.schemas.foreign import foreign
from service.schemas.limits import LimitError, Limits, Model

_INTEGER = re.compile(r"0|-?[1-9][0-9]*", re.ASCII)


class JsonError(ValueError):
    """The text is not strict JSON.

    Attributes:
        message: the fault, in a sentence.
        field: the member at fault, such as "geometry.d1" or "l1[0]", or "body".
        line: the line of the fault, if it is known.
        limit: the limit that a number exceeds, if that is the fault.
        detail: the fault with the name of its member.
    """

    def __init__(
        self, message: str, field: str = "body", line: int | None = None, limit: LimitError | None = None
    ) -> None:
        self.message, self.field, self.line, self.limit = message, clipped(field, 100), line, limit
        self.detail = message if field == "body" else f"{self.field}: {message}"
        super().__init__(self.detail)


class JsonNumber(str):
    """The text of a JSON number. It differs from a JSON string by its type only."""

    __slots__ = ()


def parse_json(body: bytes, name: str = "The body", limits: Limits | None = None) -> object:
    """Parse strict JSON (RFC 8259). Numbers become :class:`JsonNumber`, with every digit.

    A number that is too long for any member is refused by its length, before anything converts it. Strings
    may have any length here; who takes one for a number (`numbers.exact_number`) looks at its length first.

    Args:
        body: the text, in UTF-8.
        name: what messages call it.
        limits: those on the digits of a number.

    Raises:
        JsonError: not UTF-8, not JSON, a key given twice, nested too deeply, or with a number that is too
            long.

    >>> parse_json(b'{"d1": 17.040}')
    {'d1': '17.040'}
    """
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError as error:
        if other := foreign(body):
            raise JsonError(f"{name} is not JSON: {other}.") from None
        raise JsonError(f"{name} is not valid UTF-8: byte {error.start} cannot be decoded.") from None
    known = limits or Limits()
    most = known.max_number_digits
    faults: list[_Fault] = []

    def fault(detail: str, limit: LimitError | None = None) -> _Fault:
        faults.append(_Fault(detail, limit))
        return faults[-1]

    def number(longest: int, text: str) -> JsonNumber | _Fault:
        if len(text) <= longest:
            return JsonNumber(text)
        limit = LimitError.of_digits(known, max(digit_count(text), len(text)))
        return fault(f"{limit.problems[0].message}.", limit)

    def members(pairs: list[tuple[str, object]]) -> dict[str, object]:
        obj = dict(pairs)
        if len(obj) < len(pairs):
            counts = Counter(key for key, _ in pairs)
            twice = next(key for key, count in counts.items() if count > 1)
            obj[twice] = fault(f"The key {clipped(twice, 100)!r} is given twice.")
        return obj

    try:
        value: object = json.loads(
            text,
            parse_float=partial(number, longest_text(most)),
            parse_int=partial(number, most + 1),
            parse_constant=lambda text: fault(f"{text} is not a JSON number; every number must be finite."),
            object_pairs_hook=members,
        )
    except json.JSONDecodeError as error:
        if other := foreign(body):
            raise JsonError(f"{name} is not JSON: {other}.", line=error.lineno) from None
        raise JsonError(
            f"{name} is not valid JSON: {error.msg} at line {error.lineno}, column {error.colno}.",
            line=error.lineno,
        ) from None
    except RecursionError:
        raise _too_deep(name) from None
    if _is_deeper([value], MAX_DEPTH + 1):
        raise _too_deep(name)
    if faults:
        raise next(_errors(value, ""))
    return value


def json_kind(value: object) -> str:
    """Returns the kind of a JSON value as a message names it."""
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    kinds: dict[type, str] = {JsonNumber: "a number", str: "a string", list: "a list", dict: "an object"}
    return kinds.get(type(value), type(value).__name__)


def shown(value: object) -> str:
    """Returns a value as a message shows it: a string in quotes, anything else by its kind."""
    return repr(clipped(value)) if type(value) is str else json_kind(value)


def plain(value: object) -> Any:
    """A document with its integers as such, so that it is what the service sent.

    Its other numbers are texts, so none that is a number in JSON is taken for one: it becomes a float.
    """
    if isinstance(value, JsonNumber):
        return integer(value) if _INTEGER.fullmatch(value) else float(value)
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value


@dataclass(frozen=True)
class _Fault:
    """What takes the place of a member that strict JSON does not allow, or of a number that is too long."""

    detail: str
    limit: LimitError | None = None


def _errors(value: object, field: str) -> Iterator[JsonError]:
    """The faults in a value, each with the name of its member."""
    if isinstance(value, _Fault):
        yield JsonError(value.detail, field or "body", limit=value.limit)
    elif isinstance(value, dict):
        for key, member in value.items():
            yield from _errors(member, f"{field}.{key}" if field else key)
    elif isinstance(value, list):
        for k, element in enumerate(value):
            yield from _errors(element, f"{field}[{k}]")


def _is_deeper(value: dict[str, object] | list[object], levels: int) -> bool:
    members = value.values() if isinstance(value, dict) else value
    return not levels or any(_is_deeper(x, levels - 1) for x in members if isinstance(x, dict | list))


def _too_deep(name: str) -> JsonError:
    return JsonError(f"{name} is nested more than {MAX_DEPTH} levels deep.")


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

    model_config = ConfigDict(extra="forbid", serialize_by_alias=True)

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

    def given(self) -> dict[str, Any]:
        """Returns the members that are given."""
        return {name: value for name, value in self if value is not None}

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
        unknown = [name for name in value if name not in known]
        for name in unknown[:_LISTED]:
            sent = clipped(name, 60).encode("utf-8", "backslashreplace").decode()
            is_last = len(unknown) > _LISTED and name is unknown[_LISTED - 1]
            more = f" … and {len(unknown) - _LISTED} more unknown fields" if is_last else ""
            yield FieldProblem(sent, f"unknown field; {cls._hint(name, known)}{more}")

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
        words = ", ".join(_words(info.annotation))
        if fault["type"] == "missing":
            texts = [hint.text for hint in info.metadata if isinstance(hint, Expected)]
            other = f"give one of {words}" if words else getattr(info.annotation, "expected", "give it")
            return f"is missing; {texts[0] if texts else other}"
        return f"is {shown(fault['input'])}; it must be one of {words}"


def _words(annotation: Any) -> Iterator[str]:
    """Yields the words of a literal type, perhaps one of a union."""
    for part in get_args(annotation):
        yield from [part] if isinstance(part, str) else _words(part)


def given(description: str | None = None, **more: Any) -> Any:
    """Returns a field that may be missing but is never null."""
    return Field(default=None, description=description, json_schema_extra=_without_default, **more)


def _without_default(schema: dict[str, Any]) -> None:
    schema.pop("default", None)


M = TypeVar("M", bound=Document)


def read(model: type[M], value: object, source: Source) -> M:
    """Read input as a model.

    Args:
        model: the expected model.
        value: JSON as :func:`service.schemas.document.parse_json` returns it, options, or exact values.
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
