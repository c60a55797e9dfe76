"""Strict JSON of bounded depth, in which every number is kept as it was written."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from rpr_solver.verify.core.reader import MAX_DEPTH

_INTEGER = re.compile(r"0|-?[1-9][0-9]*", re.ASCII)


class JsonError(ValueError):
    """The text is not strict JSON.

    Attributes:
        detail: the fault, in a sentence.
        field: the member at fault, such as "geometry.d1" or "l1[0]", or "body".
        line: the line of the fault, if it is known.
    """

    def __init__(self, detail: str, field: str = "body", line: int | None = None) -> None:
        self.detail, self.field, self.line = detail, field[:100], line
        super().__init__(detail)


class JsonNumber(str):
    """The text of a JSON number. It differs from a JSON string by its type only."""

    __slots__ = ()


def parse_json(body: bytes, name: str = "The body") -> object:
    """Parse strict JSON (RFC 8259). Numbers become :class:`JsonNumber`, with every digit.

    Args:
        body: the text, in UTF-8.
        name: what messages call it.

    Raises:
        JsonError: not UTF-8, not JSON, a key given twice, or nested too deeply.

    >>> parse_json(b'{"d1": 17.040}')
    {'d1': '17.040'}
    """
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError as error:
        raise JsonError(f"{name} is not valid UTF-8: byte {error.start} cannot be decoded.") from None
    faults: list[_Fault] = []

    def fault(detail: str) -> _Fault:
        faults.append(_Fault(detail))
        return faults[-1]

    def members(pairs: list[tuple[str, object]]) -> dict[str, object]:
        obj = dict(pairs)
        if len(obj) < len(pairs):
            counts = Counter(key for key, _ in pairs)
            twice = next(key for key, count in counts.items() if count > 1)
            obj[twice] = fault(f"The key {twice[:100]!r} is given twice.")
        return obj

    try:
        value: object = json.loads(
            text,
            parse_float=JsonNumber,
            parse_int=JsonNumber,
            parse_constant=lambda text: fault(f"{text} is not a JSON number; every number must be finite."),
            object_pairs_hook=members,
        )
    except json.JSONDecodeError as error:
        raise JsonError(
            f"{name} is not valid JSON: {error.msg} at line {error.lineno}, column {error.colno}.",
            line=error.lineno,
        ) from None
    except RecursionError:
        raise _too_deep(name) from None
    _check_depth(value, name)
    if faults:
        raise next(_errors(value, ""))
    return value


def json_kind(value: object) -> str:
    """Returns the kind of a JSON value as a message names it."""
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    kinds: dict[type, str] = {JsonNumber: "a number", str: "a string", list: "a list", dict: "an object"}
    return kinds.get(type(value), type(value).__name__)


def plain(value: object) -> Any:
    """A document with its integers as such, so that it is what the service sent.

    Its other numbers are texts, so none that is a number in JSON is taken for one: it becomes a float.
    """
    if isinstance(value, JsonNumber):
        return int(Decimal(value)) if _INTEGER.fullmatch(value) else float(value)
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value


@dataclass(frozen=True)
class _Fault:
    """What stands in a value for a member that strict JSON does not allow."""

    detail: str


def _errors(value: object, field: str) -> Iterator[JsonError]:
    """The faults in a value, each with the name of its member."""
    if isinstance(value, _Fault):
        yield JsonError(f"{field}: {value.detail}" if field else value.detail, field or "body")
    elif isinstance(value, dict):
        for key, member in value.items():
            yield from _errors(member, f"{field}.{key}" if field else key)
    elif isinstance(value, list):
        for k, element in enumerate(value):
            yield from _errors(element, f"{field}[{k}]")


def _check_depth(value: object, name: str) -> None:
    level: list[object] = [value]
    for _ in range(MAX_DEPTH):
        level = [child for parent in level for child in _children(parent)]
        if not level:
            return
    raise _too_deep(name)


def _children(value: object) -> Iterator[object]:
    members = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return (child for child in members if isinstance(child, dict | list))


def _too_deep(name: str) -> JsonError:
    return JsonError(f"{name} is nested more than {MAX_DEPTH} levels deep.")
