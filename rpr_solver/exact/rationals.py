"""Reading and printing exact rationals: computations use the number exactly as the user wrote it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from fractions import Fraction
from math import floor, isfinite, isqrt
from numbers import Rational, Real
from typing import TypeAlias, TypeVar

from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.numerals import digit_count, integer, integer_text, longest_text

Exact: TypeAlias = int | str | Decimal | Fraction
"""An exact number: an integer, a fraction, or a text or decimal as written (``"17.04"``, ``"426/25"``)."""

K = TypeVar("K")
V = TypeVar("V")
T = TypeVar("T")

MAX_DIGITS = 400
"""Default limit on the decimal digits of an input's numerator and of its denominator."""

_DECIMAL = re.compile(r"([+-]?)(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
_QUOTIENT = re.compile(r"([+-]?\d+)/(\d+)", re.ASCII)


def parse_exact(value: Exact, field: str, *, max_digits: int = MAX_DIGITS) -> Fraction:
    """Reads a number exactly: an integer, a decimal as written, or a quotient ``"p/q"``.

    A binary float is refused, since 17.04 would already have become 17.03999…; decode JSON with
    ``parse_float=decimal.Decimal``. Integers and rationals of other libraries are read like Python's.

    Args:
        value: the number; a text may be ``"17.04"``, ``"1.704e1"`` or ``"426/25"``.
        field: the name of the number in an error message.
        max_digits: limit on the digits of numerator and denominator; it does not apply to a ``Fraction``.

    Raises:
        InputError: naming ``field``: not an exact number, not finite, or too long.

    >>> parse_exact("17.040", "d1") == parse_exact("426/25", "d1") == Fraction(426, 25)
    True
    >>> parse_exact(15.91, "a2x")
    Traceback (most recent call last):
    rpr_solver.errors.InputError: a2x: 15.91 is a binary float, not an exact number; write "15.91"
    """
    if not isinstance(value, (str, Decimal)):
        if isinstance(value, Fraction):
            return value
        if isinstance(value, Rational) and not isinstance(value, bool):
            return _bounded(Fraction(int(value.numerator), int(value.denominator)), field, max_digits)
        raise InputError.of(field, _not_exact(value))
    text = str(value).strip()
    if len(text) > longest_text(max_digits):
        if digit_count(text) > max_digits:
            raise _too_long(field, max_digits)
        raise InputError.of(field, f"{shown(text)} is too long for a number of {max_digits} digits")
    is_quotient = "/" in text and _QUOTIENT.fullmatch(text)
    number = _quotient(text, field) if is_quotient else _decimal(text, field, max_digits)
    return _bounded(number, field, max_digits)


def _quotient(text: str, field: str) -> Fraction:
    numerator, denominator = (integer(part) for part in text.split("/"))
    if denominator == 0:
        raise InputError.of(field, f"{shown(text)} has the denominator 0")
    return Fraction(numerator, denominator)


def _decimal(text: str, field: str, max_digits: int) -> Fraction:
    decimal = _DECIMAL.fullmatch(text)
    if decimal is None or not (decimal[2] or decimal[3]):
        hint = 'write a decimal such as "17.04" or a quotient "426/25"'
        if "," in text and _DECIMAL.fullmatch(pointed := text.replace(",", ".")):
            hint = f'write a decimal point, "{pointed}"'
        raise InputError.of(field, f"{shown(text)} is not a finite number; {hint}")
    sign, whole, part, exponent = decimal.groups(default="")
    significand = integer(f"{sign}{whole}{part}")
    shift = int(exponent or 0) - len(part)
    if significand == 0:
        return Fraction(0)
    if abs(shift) > 2 * max_digits:
        raise _too_long(field, max_digits)
    return Fraction(significand * 10**shift) if shift >= 0 else Fraction(significand, 10**-shift)


def parse_positive(
    value: Exact, field: str, expected: str = "a leg length must be > 0", *, max_digits: int = MAX_DIGITS
) -> Fraction:
    """Reads a number > 0 exactly.

    Raises:
        InputError: naming ``field``; for a number ≤ 0 the message ends with ``expected``.
    """
    number = parse_exact(value, field, max_digits=max_digits)
    if number <= 0:
        raise InputError.of(field, f"is {exact_str(number)}; {expected}")
    return number


def parse_not_negative(value: Exact, field: str) -> Fraction:
    """Reads a number of at least 0 exactly.

    Raises:
        InputError: naming ``field``.
    """
    number = parse_exact(value, field)
    if number < 0:
        raise InputError.of(field, f"is {exact_str(number)}; it must be at least 0")
    return number


def parse_all(values: Mapping[K, V], parse: Callable[[V, K], T]) -> dict[K, T]:
    """Reads values by their keys, mostly numbers by the names of their fields.

    Raises:
        InputError: with the problems of all values.
    """
    results: dict[K, T] = {}
    problems: list[FieldProblem] = []
    for key, value in values.items():
        try:
            results[key] = parse(value, key)
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    return results


def rational_sqrt(x: Fraction) -> Fraction | None:
    """The square root of a rational ≥ 0, or None if it is irrational.

    >>> rational_sqrt(Fraction(4, 9)), rational_sqrt(Fraction(2))
    (Fraction(2, 3), None)
    """
    above, below = isqrt(x.numerator), isqrt(x.denominator)
    is_square = above * above == x.numerator and below * below == x.denominator
    return Fraction(above, below) if is_square else None


def short_between(low: Fraction, high: Fraction) -> Fraction:
    """A decimal with few digits strictly between.

    Raises:
        ValueError: there is nothing between: ``low`` is not less than ``high``.

    >>> short_between(Fraction("1.234"), Fraction("1.31"))
    Fraction(127, 100)
    """
    if not low < high:
        raise ValueError(f"nothing lies between {low} and {high}")
    step = Fraction(1)
    while step > (high - low) / 4:
        step /= 10
    return floor((low + high) / 2 / step) * step


def one_or_more(values: Exact | Iterable[Exact], field: str) -> dict[str, Exact]:
    """The numbers of a sequence by name, ``l1[0]``, ``l1[1]``, …; a single number or text is named ``l1``.

    >>> one_or_more(["3", 4], "l1"), one_or_more("27", "l1")
    ({'l1[0]': '3', 'l1[1]': 4}, {'l1': '27'})
    """
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        return {field: values}  # type: ignore[dict-item]
    return {f"{field}[{k}]": value for k, value in enumerate(values)}


def exact_str(x: Exact) -> str:
    """The canonical text of an exact number: a decimal if it terminates, else ``"p/q"``.

    Raises:
        InputError: naming ``x``: not an exact number.

    >>> exact_str("1498/100"), exact_str(Fraction(-1, 3)), exact_str(10)
    ('14.98', '-1/3', '10')
    """
    x = parse_exact(x, "x")
    denominator = x.denominator
    twos = (denominator & -denominator).bit_length() - 1
    odd, fives = denominator >> twos, 0
    while odd % 5 == 0:
        odd //= 5
        fives += 1
    if odd != 1:
        return f"{integer_text(x.numerator)}/{integer_text(x.denominator)}"
    places = max(twos, fives)
    text = integer_text(abs(x.numerator) * 10**places // denominator).rjust(places + 1, "0")
    sign = "-" if x < 0 else ""
    return f"{sign}{text[:-places]}.{text[-places:]}" if places else sign + text


def exact_or_none(x: Fraction | None) -> str | None:
    """The canonical text of an end, or None for an open one."""
    return None if x is None else exact_str(x)


def _not_exact(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, Real):
        return f"{shown(value)} is a {type(value).__name__}, not an exact number"
    hint = f'; write "{value}"' if isfinite(value) else ""
    return f"{value} is a binary float, not an exact number{hint}"


def _bounded(x: Fraction, field: str, max_digits: int) -> Fraction:
    for part in (abs(x.numerator), x.denominator):
        # 10**n has more than 3 n bits, so most numbers need no power
        if part.bit_length() > 3 * max_digits and part >= 10**max_digits:
            raise _too_long(field, max_digits)
    return x


def _too_long(field: str, max_digits: int) -> InputError:
    return InputError.of(field, f"has more than {max_digits} digits in its numerator or denominator")
