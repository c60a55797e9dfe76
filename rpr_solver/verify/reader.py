"""Strict JSON: from bytes, or from what JSON made of them, to frozen values by a closed schema.

A reader takes a JSON value and its JSON pointer (RFC 6901), and returns a value of its type, or refuses it.
Objects become read-only mappings with the members of the schema and no others, lists become tuples.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from itertools import pairwise
from math import isfinite
from types import MappingProxyType
from typing import Any

from rpr_solver.contract import MAX_DIGITS, MIN_DIGITS
from rpr_solver.errors import InputError, shown

Read = Callable[[object, str], Any]
Record = Mapping[str, Any]

MAX_DEPTH = 32
"""Maximum depth of a document; none of the contract comes near it."""
MAX_NUMBER_DIGITS = 400
"""The default limit on the digits of a side or a length, as for the solver's input."""
PLACES = 5
"""So many times longer may a number be as a text: a quotient of n digits that terminates, such as 1/2^n, has
up to 3.4 n places."""
_LONGEST_INTEGER, _LONGEST_FLOAT, _LONGEST_NAME = 12, 30, 100
_NUMBER = re.compile(r"[0-9.]+", re.ASCII)


def refusal(at: str, message: str) -> InputError:
    """The error of a member that is not as documents have it."""
    return InputError.of(at or "document", message)


def parsed(source: str | bytes) -> Any:
    """The value of a JSON text in which each object has each key once, and all numbers are finite and short.

    Raises:
        InputError: it is no such text.
    """

    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) < len(pairs):
            names = sorted(name for name, _ in pairs)
            twice = next(x for x, y in pairwise(names) if x == y)
            raise refusal("", f"has the key {shown(twice)} twice in one object")
        return result

    def no_number(text: str) -> Any:
        raise refusal("", f"has the number {shown(text)}; documents have integers, and decimals as texts")

    def whole(text: str) -> int:
        return no_number(text) if text == "-0" or len(text) > _LONGEST_INTEGER else int(text)

    def part(text: str) -> float:
        return float(text) if len(text) < _LONGEST_FLOAT and isfinite(float(text)) else no_number(text)

    try:
        text = source.decode("utf-8") if isinstance(source, bytes) else source
        return json.loads(
            text, object_pairs_hook=members, parse_int=whole, parse_float=part, parse_constant=no_number
        )
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise refusal("", f"is not JSON: {shown(str(error))}") from None


def check_bounds(
    document: Mapping[str, Any], *, number_digits: int = MAX_NUMBER_DIGITS, most_digits: int = MAX_DIGITS
) -> int:
    """Refuses what is too deep, is no text, or has a number too long to be converted; else about its length.

    Args:
        document: a document, as JSON reads it.
        number_digits: maximum number of digits of a side or a length.
        most_digits: maximum of the document's own ``digits`` that explains longer numbers.

    Returns:
        About the number of characters of the document as JSON.

    Raises:
        InputError: naming the member.

    >>> check_bounds({"digits": 15, "slices": [{"l1": "14." + "9" * 9999}]})
    Traceback (most recent call last):
    rpr_solver.errors.InputError: /slices/0/l1: has a number of 10002 characters; at most 2075 are read here
    """
    digits = document.get("digits")
    own = digits if type(digits) is int and MIN_DIGITS <= digits <= most_digits else MIN_DIGITS
    most, size = PLACES * (number_digits + own), 0
    waiting: list[tuple[object, str, int]] = [(document, "", 0)]
    # each value is taken once, and no value is deeper than the limit: without recursion, so for any depth
    while waiting:
        value, at, depth = waiting.pop()
        if isinstance(value, str):
            _check_text(value, at)
            length = max(map(len, _NUMBER.findall(value)), default=0)
            if length > most:
                raise refusal(at, f"has a number of {length} characters; at most {most} are read here")
            size += len(value)
        size += 2
        if not isinstance(value, Mapping | list | tuple):
            continue
        if depth >= MAX_DEPTH:
            raise refusal(at[:_LONGEST_NAME], f"is nested more than {MAX_DEPTH} levels deep")
        if isinstance(value, Mapping):
            for name in value:
                _check_text(name, at)
            size += sum(map(len, value))
            waiting += [(item, f"{at}/{pointer_step(name)}", depth + 1) for name, item in value.items()]
        else:
            waiting += [(item, f"{at}/{n}", depth + 1) for n, item in enumerate(value)]
    return size


def _check_text(value: object, at: str) -> None:
    try:
        if not isinstance(value, str):
            raise refusal(at, f"has the member {shown(value)}, which is no text")
        value.encode()
    except UnicodeEncodeError:
        raise refusal(at, "has half of a character (a lone surrogate)") from None


def pointer_step(name: str) -> str:
    """The name of a member as a step of a JSON pointer, in one line and not too long."""
    short = name[:_LONGEST_NAME].replace("~", "~0").replace("/", "~1")
    return short if short.isprintable() else "".join(x if x.isprintable() else ascii(x)[1:-1] for x in short)


def record(required: Mapping[str, Read], optional: Mapping[str, Read] = MappingProxyType({})) -> Read:
    """An object with these members, each once, and no others; they are put into this order."""
    known = {**required, **optional}

    def read(value: object, at: str) -> Record:
        if not isinstance(value, Mapping):
            raise refusal(at, f"{shown(value)} is not an object")
        for name in value:
            if name not in known:
                raise refusal(f"{at}/{pointer_step(str(name))}", "is no member that documents have here")
        for name in required:
            if name not in value:
                raise refusal(f"{at}/{name}", "is missing")
        return MappingProxyType(
            {name: item(value[name], f"{at}/{name}") for name, item in known.items() if name in value}
        )

    return read


def rows(item: Read, least: int = 0, most: int = 100_000) -> Read:
    """A list of values, each read alike."""

    def read(value: object, at: str) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or not least <= len(value) <= most:
            raise refusal(at, f"is not a list of {least if least == most else f'{least} to {most}'} values")
        return tuple(item(x, f"{at}/{n}") for n, x in enumerate(value))

    return read


def either(test: Callable[[Record], object], first: Read, second: Read) -> Read:
    """The first reader for objects of which something holds, the second one for all other values."""
    return lambda value, at: (first if isinstance(value, Mapping) and test(value) else second)(value, at)


def nothing_or(item: Read) -> Read:
    """null, or a value."""
    return lambda value, at: None if value is None else item(value, at)


def word(*known: str) -> Read:
    """One of some texts."""

    def read(value: object, at: str) -> str:
        if not isinstance(value, str) or value not in known:
            raise refusal(at, f"{shown(value)} is none of {', '.join(known)}")
        return value

    return read


def text(pattern: str = r"[^\x00-\x1f]*", most: int = 2000) -> Read:
    """A text that is repeated or compared, not computed with."""
    form = re.compile(pattern)

    def read(value: object, at: str) -> str:
        if not isinstance(value, str) or len(value) > most or not form.fullmatch(value):
            raise refusal(at, f"{shown(value)} is not a text as documents have it here")
        return value

    return read


def count(least: int = 0, most: int = 100_000) -> Read:
    """An integer as such."""

    def read(value: object, at: str) -> int:
        if type(value) is not int or not least <= value <= most:
            raise refusal(at, f"is {shown(value)}; an integer from {least} to {most} belongs here")
        return value

    return read


def drawn(value: object, at: str) -> float:
    """A float of a drawing."""
    if type(value) is float or (type(value) is int and abs(value) < 10**_LONGEST_INTEGER):
        return float(value)
    raise refusal(at, f"is {shown(value)}; a number belongs here")


def truth(value: object, at: str) -> bool:
    """true or false."""
    if not isinstance(value, bool):
        raise refusal(at, f"{shown(value)} is neither true nor false")
    return value


class NoClaim:
    """What stands for a member that claims nothing: how the solver found its answer, or a drawing of it."""


def no_claim(read: Read) -> Read:
    """A member of which the form is checked, and nothing else; :func:`names_without_claim` names it."""

    def checked(value: object, at: str) -> NoClaim:
        read(value, at)
        return NoClaim()

    return checked


def anything(value: object, at: str) -> object:
    """A value of any form, within the bounds of all documents."""
    del at
    return value


def names_without_claim(value: object, at: str = "") -> set[str]:
    """The members of a document that claim nothing, with * for the places in lists."""
    if isinstance(value, NoClaim):
        return {at}
    if isinstance(value, Mapping):
        return {x for name, item in value.items() for x in names_without_claim(item, f"{at}/{name}")}
    if isinstance(value, tuple):
        return {x for item in value for x in names_without_claim(item, f"{at}/*")}
    return set()
