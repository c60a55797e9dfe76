"""Strict JSON of bounded depth, in which every number is kept as it was written."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import NoReturn

MAX_DEPTH = 32
"""Maximum depth; no document of the contract comes near it."""


class JsonError(ValueError):
    """The text is not strict JSON.

    Attributes:
        detail: the fault, in a sentence.
        field: the repeated key, or "body".
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
    try:
        value: object = json.loads(
            text,
            parse_float=JsonNumber,
            parse_int=JsonNumber,
            parse_constant=_refuse_constant,
            object_pairs_hook=_object,
        )
    except json.JSONDecodeError as error:
        raise JsonError(
            f"{name} is not valid JSON: {error.msg} at line {error.lineno}, column {error.colno}.",
            line=error.lineno,
        ) from None
    except RecursionError:
        raise _too_deep(name) from None
    _check_depth(value, name)
    return value


def json_kind(value: object) -> str:
    """Returns the kind of a JSON value as a message names it."""
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    kinds: dict[type, str] = {JsonNumber: "a number", str: "a string", list: "a list", dict: "an object"}
    return kinds.get(type(value), type(value).__name__)


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    members = dict(pairs)
    if len(members) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise JsonError(f"The key {key[:100]!r} is given twice in one object.", field=key)
            seen.add(key)
    return members


def _refuse_constant(name: str) -> NoReturn:
    raise JsonError(f"{name} is not a JSON number; every number must be finite.")


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
