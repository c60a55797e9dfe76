"""The texts of a document, looked at once before anything is read: how long they are, and what they are not.

Every number is as long as the question's or as its digits explain; those of a certificate, and of polynomials
and equations, are products of many sides and lengths.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from math import lcm
from typing import Any

from rpr_solver.contract import MAX_DIGITS, MIN_DIGITS
from rpr_solver.errors import InputError

MAX_DEPTH = 32
"""Maximum depth of a document; none of the contract comes near it."""

MOST_NUMBER_DIGITS = 400
"""The default limit on the digits of a side or a length, as for the solver's input."""

_NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
_PRODUCTS = frozenset({"certificate", "polynomial", "equation"})
_FACTORS = 100  # coefficients have at most 74 sides as factors
_SPARE = 10
_SPREAD = 4
_SIDES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")

Member = tuple[str, Any, bool]
"""The dotted name of a member, its value, and whether it is a product of many sides."""


def check_texts(
    document: Mapping[str, Any], *, number_digits: int = MOST_NUMBER_DIGITS, most_digits: int = MAX_DIGITS
) -> None:
    """Refuses a document that cannot be read in a time that its length explains.

    Args:
        document: a document, as JSON reads it.
        number_digits: maximum number of digits of a side or a length.
        most_digits: maximum of the document's own ``digits`` that explains longer numbers.

    Raises:
        InputError: naming the member: it has a number that is too long, or a text that is none, or it is
            nested too deeply.

    >>> check_texts({"digits": 15, "slices": [{"l1": "14." + "9" * 999}]})
    Traceback (most recent call last):
    rpr_solver.errors.InputError: slices[0].l1: has 1001 digits; here at most 425 are read, for 15 digits
    """
    own = _own_digits(document.get("digits"), most_digits)
    most = number_digits + own + _SPARE
    longest, products = 0, []
    for name, value, is_product in _members(document):
        if is_product:
            products.append((name, value))
            continue
        length = _length(value, most)
        if length > most:
            raise _too_long(name, length, most, own)
        longest = max(longest, length)
    most = _FACTORS * (_unit_digits(document) + max(longest, own) + _SPARE)
    for name, value in products:
        length = _length(value)
        if length > most:
            raise _too_long(name, length, most, own)


def _own_digits(digits: object, most: int) -> int:
    """The digits that a document claims to have; the minimum if it does not say."""
    text = str(digits) if isinstance(digits, int | str) else ""
    own = int(text) if text.isdecimal() and len(text) <= len(str(MAX_DIGITS)) else 0
    return own if MIN_DIGITS <= own <= most else MIN_DIGITS


def _too_long(name: str, length: int, most: int, digits: int) -> InputError:
    return InputError.of(name, f"has {length} digits; here at most {most} are read, for {digits} digits")


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
            place = f"{name}.{key[:60]}" if name else key[:60]
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
    return int(max(x.numerator.bit_length(), x.denominator.bit_length()) * 0.30103) + 1


def _unit_digits(document: Mapping[str, Any]) -> int:
    """The digits of the longest side as an integer in the smallest common unit; 0 if they cannot be read."""
    geometry = document.get("geometry")
    texts: Sequence[object] = [geometry.get(name) for name in _SIDES] if isinstance(geometry, Mapping) else ()
    sides = [side for text in texts if (side := _side(text)) is not None]
    unit = lcm(*(side.denominator for side in sides))
    return max((_digits(side * unit) for side in sides), default=0)


def _side(text: object) -> Fraction | None:
    if not isinstance(text, str | int):
        return None
    try:
        above, _, below = str(text).partition("/")
        return Fraction(Decimal(above)) / Fraction(Decimal(below or "1"))
    except (ArithmeticError, ValueError):
        return None
