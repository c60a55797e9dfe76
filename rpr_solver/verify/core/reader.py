"""The one reader: from bytes, or what JSON made of them, to frozen values by a closed schema.

A reader takes a JSON value and the JSON pointer of it, and returns a value of its type, or refuses it. Every
number has one text: decimals as :class:`Printed`, exact numbers as fractions, counts as integers. Objects
become read-only mappings with the members of the schema and no others, lists become tuples.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from math import gcd, isqrt
from types import MappingProxyType
from typing import Any

from rpr_solver.errors import InputError, shown
from rpr_solver.verify.core.printed import Printed

Read = Callable[[object, str], Any]
Record = Mapping[str, Any]

MOST_DIGITS = 10_000
"""The longest decimal that is read, in digits; the greatest exponent."""
_MOST_LETTERS, _PYTHON_READS = 2_000_000, 4000
_MOST_DEPTH, _LONGEST_COUNT = 20, 12
_INTEGER = re.compile(r"0|-?[1-9][0-9]*", re.ASCII)
_EXACT = re.compile(r"(-?)(0|[1-9][0-9]*)(?:\.([0-9]*[1-9]))?", re.ASCII)
_QUOTIENT = re.compile(r"(-?[1-9][0-9]*)/([1-9][0-9]*)", re.ASCII)
_DECIMAL = re.compile(r"-?([0-9]+)(?:\.([0-9]+))?(?:e([+-][0-9]{1,4}))?", re.ASCII)
_SHORT = re.compile(r"(-?[1-9][0-9]*)e-([1-9][0-9]{0,3})", re.ASCII)
_ROOT = re.compile(r"sqrt\((.+)\)", re.ASCII)


def refusal(at: str, message: str) -> InputError:
    """The error of a member that is not as documents have it."""
    return InputError.of(at or "document", message)


def parsed(source: str | bytes) -> Any:
    """The value of a JSON text in which each object has each key once, and all numbers are integers.

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

    try:
        text = source.decode("utf-8") if isinstance(source, bytes) else source
        return json.loads(
            text,
            object_pairs_hook=members,
            parse_int=whole,
            parse_float=no_number,
            parse_constant=no_number,
        )
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise refusal("", f"is not JSON: {shown(str(error))}") from None


def size_of(value: object, depth: int = 0) -> int:
    """About the number of characters of a document as JSON, which bounds the work on it.

    Raises:
        InputError: it is deeper than any document, or has a value that JSON has not.
    """
    if depth > _MOST_DEPTH:
        raise refusal("", "is deeper than any document")
    if isinstance(value, Mapping):
        return 2 + sum(len(str(name)) + 4 + size_of(item, depth + 1) for name, item in value.items())
    if isinstance(value, list | tuple):
        return 2 + sum(2 + size_of(item, depth + 1) for item in value)
    if isinstance(value, str):
        return 2 + len(value)
    if isinstance(value, int):
        return 1 + value.bit_length() // 3
    if value is None:
        return 4
    raise refusal("", f"has {shown(value)}, which is no value of a document")


def record(required: Mapping[str, Read], optional: Mapping[str, Read] = MappingProxyType({})) -> Read:
    """An object with these members, each once, and no others; they are put into this order."""
    known = {**required, **optional}

    def read(value: object, at: str) -> Record:
        if not isinstance(value, Mapping):
            raise refusal(at, f"{shown(value)} is not an object")
        for name in value:
            if name not in known:
                step = str(name)[:100].replace("~", "~0").replace("/", "~1")
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


def integer(value: object, at: str) -> int:
    """An integer as a text."""
    if not isinstance(value, str) or len(value) > _MOST_LETTERS or not _INTEGER.fullmatch(value):
        raise refusal(at, f"{shown(value)} is not an integer as documents write it")
    return _integer(value)


def exact(value: object, at: str) -> Fraction:
    """An exact number as a text: a decimal if it terminates, else p/q in lowest terms."""
    if not isinstance(value, str) or len(value) > _MOST_LETTERS:
        raise refusal(at, f'{shown(value)} is not an exact number as documents write it, such as "14.98"')
    if (quotient := _QUOTIENT.fullmatch(value)) is not None:
        n, d = (_integer(part) for part in quotient.groups())
        odd = d
        for p in (2, 5):
            while odd % p == 0:
                odd //= p
        if odd > 1 and gcd(n, d) == 1:
            return Fraction(n, d)
    elif (decimal := _EXACT.fullmatch(value)) is not None and value != "-0":
        sign, whole, part = decimal[1], decimal[2], decimal[3] or ""
        number = Fraction(_integer(whole + part), 10 ** len(part))
        return -number if sign else number
    raise refusal(at, f'{shown(value)} is not an exact number as documents write it, such as "14.98"')


def short(value: object, at: str) -> Fraction:
    """An exact number, or an integer with a negative power of ten."""
    form = _SHORT.fullmatch(value) if isinstance(value, str) else None
    return Fraction(integer(form[1], at), 10 ** int(form[2])) if form else exact(value, at)


def short_positive(value: object, at: str) -> Fraction:
    """The same, > 0."""
    x = short(value, at)
    if x <= 0:
        raise refusal(at, f"is {shown(value)}; it must be > 0")
    return x


def exact_within(
    low: Fraction | int, high: Fraction | int | None = None, *, ends: bool = False
) -> Callable[[object, str], Fraction]:
    """An exact number between two others, or one of them if ``ends``."""

    def read(value: object, at: str) -> Fraction:
        x = exact(value, at)
        inside = low < x and (high is None or x < high)
        if not inside and not (ends and x in (low, high)):
            raise refusal(at, f"is {shown(value)}, beyond what is possible here")
        return x

    return read


POSITIVE = exact_within(0)
"""An exact length > 0."""


def square_of(value: object, at: str) -> Fraction:
    """The square of a length > 0: an exact number, or sqrt() of one that is no square."""
    root = _ROOT.fullmatch(value) if isinstance(value, str) else None
    if root is None:
        return POSITIVE(value, at) ** 2
    x = POSITIVE(root[1], at)
    if isqrt(x.numerator) ** 2 == x.numerator and isqrt(x.denominator) ** 2 == x.denominator:
        raise refusal(at, f"is {shown(value)}, a root of a square")
    return x


def radicand(value: object, at: str) -> int:
    """The N of a text sqrt(N)."""
    root = _ROOT.fullmatch(value) if isinstance(value, str) else None
    number = integer(root[1], at) if root else 0
    if number < 2:
        raise refusal(at, f"{shown(value)} is not sqrt() of an integer > 1")
    return number


def decimal(digits: int, least: int | None = None, most: int | None = None, *, zero: bool = True) -> Read:
    """A decimal with this number of significant digits, as documents print it; "0" is an exact zero.

    Args:
        digits: significant digits.
        least: the number is greater.
        most: the number is not greater.
        zero: whether it may be 0.
    """

    def read(value: object, at: str) -> Printed:
        match = _DECIMAL.fullmatch(value) if isinstance(value, str) and len(value) < 3 * MOST_DIGITS else None
        if match is None or not isinstance(value, str):
            raise refusal(at, f"{shown(value)} is not a decimal of {digits} digits as documents print it")
        if value == "0" and zero:
            return Printed.exact_zero()
        significant = (match[1] + (match[2] or "")).lstrip("0")
        place = int(match[3] or 0) - len(match[2] or "") + len(significant) - 1
        if abs(place) > MOST_DIGITS or value != _text(significant, place, negative=value.startswith("-")):
            raise refusal(at, f"{shown(value)} is not a decimal as documents print it")
        if len(significant) != digits:
            raise refusal(at, f"{shown(value)} has {len(significant)} significant digits, not {digits}")
        unit = Fraction(10) ** (place - digits + 1)
        number = _integer(significant) * unit * (-1 if value.startswith("-") else 1)
        if (least is not None and number <= least) or (most is not None and number > most):
            raise refusal(at, f"is {shown(value)}, beyond what is possible here")
        return Printed(value, number, unit / 2)

    return read


def _text(significant: str, place: int, *, negative: bool) -> str:
    """The text of a decimal with its leading digit at a place; empty if there is no digit."""
    if not significant:
        return ""
    if -7 <= place < 0:
        plain = f"0.{'0' * (-place - 1)}{significant}"
    elif 0 <= place < len(significant):
        plain = f"{significant[: place + 1]}.{significant[place + 1 :]}".removesuffix(".")
    else:
        plain = f"{significant[0]}.{significant[1:]}".removesuffix(".") + f"e{place:+d}"
    return "-" + plain if negative else plain


def _integer(letters: str) -> int:
    return int(letters) if len(letters) < _PYTHON_READS else int(Decimal(letters))


def polynomial(variable: str, degree: int) -> Read:
    """The coefficients of a polynomial over ℤ[ω], with ω², or 1 if there is no ω."""
    numbers = rows(integer, degree + 1, degree + 1)
    read_members = record(
        {"variable": word(variable), "degree": count(degree, degree), "coefficients": numbers},
        {"omega": radicand, "omega_coefficients": numbers},
    )

    def read(value: object, at: str) -> Record:
        members: Record = read_members(value, at)
        if ("omega" in members) != ("omega_coefficients" in members):
            raise refusal(at, "has one of omega and omega_coefficients without the other")
        return members

    return read
