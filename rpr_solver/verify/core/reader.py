"""The one reader: from bytes, or what JSON made of them, to frozen values by a closed schema, within bounds.

A reader takes a JSON value and the JSON pointer of it, and returns a value of its type, or refuses it.
Objects become read-only mappings with the members of the schema and no others, lists become tuples.

What bounds the work on a document: all texts are looked at once before anything is read. Every number is as
long as the question's or as its digits explain; those of a certificate, and of polynomials and equations, are
products of many sides and lengths. Then operations are counted, so that the bound is the same everywhere. A
unit is about a microsecond of one core: a product of two short numbers, with what goes with it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from decimal import Decimal
from fractions import Fraction
from math import isfinite
from types import MappingProxyType
from typing import Any

from rpr_solver.contract import MAX_DIGITS, MIN_DIGITS
from rpr_solver.errors import InputError, shown

Read = Callable[[object, str], Any]
Record = Mapping[str, Any]

_LONGEST_COUNT, _LONGEST_FLOAT = 12, 30


def refusal(at: str, message: str) -> InputError:
    """The error of a member that is not as documents have it."""
    return InputError.of(at or "document", message)


def printable(text: str) -> str:
    """A text in which line breaks, escapes and marks of direction are written out."""
    return text if text.isprintable() else "".join(x if x.isprintable() else ascii(x)[1:-1] for x in text)


def parsed(source: str | bytes) -> Any:
    """The value of a JSON text in which each object has each key once, and all numbers are finite.

    Raises:
        InputError: it is no such text.
    """

    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) < len(pairs):
            names = [name for name, _ in pairs]
            twice = next(name for name in names if names.count(name) > 1)
            raise refusal("", f"has the key {shown(twice)} twice in one object")
        return result

    def no_number(text: str) -> Any:
        raise refusal("", f"has the number {shown(text)}; documents have integers, and decimals as texts")

    def whole(text: str) -> int:
        return no_number(text) if text == "-0" or len(text) > _LONGEST_COUNT else int(text)

    def part(text: str) -> float:
        return float(text) if len(text) < _LONGEST_FLOAT and isfinite(float(text)) else no_number(text)

    try:
        text = source.decode("utf-8") if isinstance(source, bytes) else source
        return json.loads(
            text,
            object_pairs_hook=members,
            parse_int=whole,
            parse_float=part,
            parse_constant=no_number,
        )
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise refusal("", f"is not JSON: {shown(str(error))}") from None


def record(required: Mapping[str, Read], optional: Mapping[str, Read] = MappingProxyType({})) -> Read:
    """An object with these members, each once, and no others; they are put into this order."""
    known = {**required, **optional}

    def read(value: object, at: str) -> Record:
        if not isinstance(value, Mapping):
            raise refusal(at, f"{shown(value)} is not an object")
        for name in value:
            if name not in known:
                step = printable(str(name)[:100]).replace("~", "~0").replace("/", "~1")
                raise refusal(f"{at}/{step}", "is no member that documents have here")
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
            bounds = f"{least}" if least == most else f"{least} to {most}"
            raise refusal(at, f"is not a list of {bounds} values")
        return tuple(item(x, f"{at}/{n}") for n, x in enumerate(value))

    return read


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


def nothing_or(item: Read) -> Read:
    """null, or a value."""
    return lambda value, at: None if value is None else item(value, at)


def count(least: int = 0, most: int = 100_000) -> Read:
    """An integer as such."""

    def read(value: object, at: str) -> int:
        if type(value) is not int or not least <= value <= most:
            raise refusal(at, f"is {shown(value)}; an integer from {least} to {most} belongs here")
        return value

    return read


def drawn(value: object, at: str) -> float:
    """A float of a drawing, from which nothing is concluded."""
    if type(value) not in (float, int):
        raise refusal(at, f"is {shown(value)}; a number belongs here")
    return float(value)  # type: ignore[arg-type]


def truth(value: object, at: str) -> bool:
    """true or false."""
    if not isinstance(value, bool):
        raise refusal(at, f"{shown(value)} is neither true nor false")
    return value


class Unread:
    """What stands for a member that is not read, or in its form only: nothing is concluded from it."""


def unread(value: object, at: str) -> Unread:
    """A member that is not read; :func:`names_of_unread` names it."""
    del value, at
    return Unread()


def told(read: Read) -> Read:
    """A member with the form of its kind, of which nothing else is verified."""

    def checked(value: object, at: str) -> Unread:
        read(value, at)
        return Unread()

    return checked


def names_of_unread(value: object, at: str = "") -> set[str]:
    """The members of a document that are not read, with * for the places in lists."""
    if isinstance(value, Unread):
        return {at}
    if isinstance(value, Mapping):
        return {x for name, item in value.items() for x in names_of_unread(item, f"{at}/{name}")}
    if isinstance(value, tuple):
        return {x for item in value for x in names_of_unread(item, f"{at}/*")}
    return set()


MAX_DEPTH = 32
"""Maximum depth of a document; none of the contract comes near it."""

MOST_NUMBER_DIGITS = 400
"""The default limit on the digits of a side or a length, as for the solver's input."""

_NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
_PRODUCTS = frozenset({"certificate", "polynomial", "equation"})
_FACTORS = 100  # coefficients have at most 74 sides as factors
_SPARE = 10
_SPREAD = 4

Member = tuple[str, Any, bool]
"""The dotted name of a member, its value, and whether it is a product of many sides."""


def check_texts(
    document: Mapping[str, Any], *, number_digits: int = MOST_NUMBER_DIGITS, most_digits: int = MAX_DIGITS
) -> int:
    """Refuses a document that cannot be read in a time that its length explains; else about its length.

    Args:
        document: a document, as JSON reads it.
        number_digits: maximum number of digits of a side or a length.
        most_digits: maximum of the document's own ``digits`` that explains longer numbers.

    Returns:
        About the number of characters of the document as JSON.

    Raises:
        InputError: naming the member: it has a number that is too long, or a text that is none, or it is
            nested too deeply.

    >>> check_texts({"digits": 15, "slices": [{"l1": "14." + "9" * 999}]})
    Traceback (most recent call last):
    rpr_solver.errors.InputError: slices[0].l1: has 1001 digits; here at most 425 are read, for 15 digits
    """
    own = _own_digits(document.get("digits"), most_digits)
    most, size = number_digits + own + _SPARE, 0
    for name, value, is_product in _members(document):
        letters = len(repr(value)) if isinstance(value, str | float) else 2
        size += 2 + letters if name.endswith("]") else len(name.rpartition(".")[2]) + letters + 6
        allowed = _FACTORS * most if is_product else most
        if (length := _length(value, most)) > allowed:
            message = f"has {length} digits; here at most {allowed} are read, for {own} digits"
            raise InputError.of(name, message)
    return size


def _own_digits(digits: object, most: int) -> int:
    """The digits that a document claims to have; the minimum if it does not say."""
    text = str(digits) if isinstance(digits, int | str) else ""
    own = int(text) if text.isdecimal() and len(text) <= len(str(MAX_DIGITS)) else 0
    return own if MIN_DIGITS <= own <= most else MIN_DIGITS


def _members(document: Mapping[str, Any]) -> Iterator[Member]:
    """All members that hold neither members nor elements; without recursion, so that any depth is seen."""
    waiting: list[tuple[str, Any, bool, int]] = [("", document, False, 0)]
    while waiting:
        name, value, is_product, depth = waiting.pop()
        if not isinstance(value, Mapping | list | tuple):
            if isinstance(value, str) and not _is_text(value):
                raise InputError.of(name, "is no text: it has half of a character (a lone surrogate)")
            yield name, value, is_product
            continue
        if depth >= MAX_DEPTH:
            raise InputError.of(name[:100], f"is nested more than {MAX_DEPTH} levels deep")
        if not isinstance(value, Mapping):
            waiting += [(f"{name}[{k}]", item, is_product, depth + 1) for k, item in enumerate(value)]
            continue
        for key, item in value.items():
            if not isinstance(key, str) or not _is_text(key):
                shown = ascii(key)[:60]
                raise InputError.of(name, f"has the member {shown}, which is no text")
            step = printable(key[:60])
            place = f"{name}.{step}" if name else step
            waiting.append((place, item, is_product or key in _PRODUCTS, depth + 1))


def _is_text(text: str) -> bool:
    if text.isascii():
        return True
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _length(value: object, most: int = 0) -> int:
    """The significant digits of a number, or a quarter of its size's, whichever is more.

    Of a decimal of more than ``most`` digits, those of numerator or denominator; of any other text those of
    its longest number.
    """
    if isinstance(value, int):
        return int(value.bit_length() * 0.30103) + 1
    if not isinstance(value, str):
        return 0
    text = value.strip()
    number = _NUMBER.fullmatch(text)
    if number is None:
        return max(map(len, re.findall(r"\d+", text)), default=0)
    whole, part, exponent = number[1] or "", number[2] or "", int(number[3] or 0)
    digits = (whole + part).strip("0")
    places = exponent + len(whole.lstrip("0")) if whole.strip("0") else exponent - len(part)
    size = abs(places) // _SPREAD
    if size <= most < len(digits) <= _SPREAD * most:
        side = _side(text)  # 2^-1300 has the digits of 5^1300, but is a quotient of fewer
        return _digits(side) if side is not None else len(digits)
    return max(len(digits), size)


def _digits(x: Fraction) -> int:
    return int(bits_in(x) * 0.30103) + 1


def _side(text: object) -> Fraction | None:
    if not isinstance(text, str | int):
        return None
    try:
        above, _, below = str(text).partition("/")
        return Fraction(Decimal(above)) / Fraction(Decimal(below or "1"))
    except (ArithmeticError, ValueError):
        return None


UNITS_OF_A_CHARACTER = 110
LEAST_CHARACTERS = 100_000
"""A shorter document has the work of one of this length: about ten seconds."""
_SHORT_BITS, _SCALE, _POWER, _SHIFT = 256, 850, 1.6, 19

_left: ContextVar[list[int] | None] = ContextVar("left", default=None)


class ExhaustedError(Exception):
    """A document needs more work than its length allows."""


@contextmanager
def bounded(units: int) -> Iterator[list[int]]:
    """Counts the work within, in the first entry of a list as what is left of it."""
    left = [units]
    token = _left.set(left)
    try:
        yield left
    finally:
        _left.reset(token)


def spend(products: int, bits: int = 0) -> None:
    """Counts products of numbers of some length, as Python's take: Karatsuba's method, in practice.

    Raises:
        ExhaustedError: the work is used up.
    """
    _spend(products if bits < _SHORT_BITS else int(products * (1 + (bits / _SCALE) ** _POWER)))


def spend_by_digits(steps: int, first: int, second: int) -> None:
    """Counts operations that take each pair of digits of numbers of two lengths in bits: quotients, by those
    of quotient and divisor, and products with much shorter numbers.

    Raises:
        ExhaustedError: the work is used up.
    """
    _spend(steps * (1 + (first * second >> _SHIFT)))


def bits_in(*numbers: Fraction) -> int:
    """The size of the longest numerator or denominator."""
    return max((part.bit_length() for x in numbers for part in x.as_integer_ratio()), default=0)


def spend_exact(steps: int, *numbers: Fraction) -> None:
    """Counts sums, products and comparisons of exact numbers as long as these, in lowest terms.

    Raises:
        ExhaustedError: the work is used up.
    """
    spend_by_digits(steps, size := bits_in(*numbers), size)


def _spend(units: int) -> None:
    left = _left.get()
    if left is None:
        return
    left[0] -= units
    if left[0] < 0:
        raise ExhaustedError
