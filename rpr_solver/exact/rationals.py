"""Exact rationals in and out: what the user wrote is what is computed with."""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction

from rpr_solver.errors import InputError

MAX_DIGITS = 400
"""Default limit on the decimal digits of an input's numerator and of its denominator."""

_DECIMAL = re.compile(r"([+-]?)(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
_QUOTIENT = re.compile(r"([+-]?\d+)/(\d+)", re.ASCII)
_SHOWN = 40


def parse_exact(
    value: int | str | Decimal | Fraction, field: str, *, max_digits: int = MAX_DIGITS
) -> Fraction:
    """Read a number exactly: an integer, a decimal as written, or a quotient ``"p/q"``.

    Binary floats are refused, since 17.04 would already have been changed to
    17.03999…; decode JSON with ``parse_float=decimal.Decimal``.

    Args:
        value: the number; strings may be ``"17.04"``, ``"1.704e1"`` or ``"426/25"``.
        field: the name that an error message uses.
        max_digits: limit on the digits of numerator and denominator.

    Raises:
        InputError: not a number, not finite, or too long.

    >>> parse_exact("17.040", "d1") == parse_exact("426/25", "d1") == Fraction(426, 25)
    True
    """
    if isinstance(value, Fraction):
        return _bounded(value, field, max_digits)
    if isinstance(value, bool) or not isinstance(value, int | str | Decimal):
        kind = type(value).__name__
        hint = ' (write it as a decimal string such as "17.04")' if isinstance(value, float) else ""
        raise InputError.of(field, f"{shown(value)} is a {kind}, not an exact number{hint}")
    if isinstance(value, int):
        if value.bit_length() > 4 * max_digits:
            raise _too_long(field, max_digits)
        return _bounded(Fraction(value), field, max_digits)
    text = str(value).strip()
    if len(text) > 2 * max_digits + 16:
        raise _too_long(field, max_digits)
    if quotient := _QUOTIENT.fullmatch(text):
        # Python itself refuses to convert beyond 4300 digits; the length check above is stricter
        numerator, denominator = (int(part) for part in quotient.groups())
        if denominator == 0:
            raise InputError.of(field, f"{shown(text)} has the denominator 0")
        return _bounded(Fraction(numerator, denominator), field, max_digits)
    decimal = _DECIMAL.fullmatch(text)
    if decimal is None or not (decimal[2] or decimal[3]):
        raise InputError.of(
            field,
            f'{shown(text)} is not a finite number; write a decimal such as "17.04" or a quotient "426/25"',
        )
    sign, whole, part, exponent = decimal[1], decimal[2] or "", decimal[3] or "", int(decimal[4] or 0)
    significand = int(whole + part)
    shift = exponent - len(part)
    if significand == 0:
        return Fraction(0)
    if abs(shift) > 2 * max_digits:
        raise _too_long(field, max_digits)
    magnitude = Fraction(significand * 10**shift) if shift >= 0 else Fraction(significand, 10**-shift)
    return _bounded(-magnitude if sign == "-" else magnitude, field, max_digits)


def exact_str(x: Fraction) -> str:
    """The canonical text of a rational: plain digits when its decimal ends, else ``"p/q"``.

    >>> exact_str(Fraction(1498, 100)), exact_str(Fraction(-1, 3)), exact_str(Fraction(10))
    ('14.98', '-1/3', '10')
    """
    denominator, places = x.denominator, 0
    twos = (denominator & -denominator).bit_length() - 1
    odd, fives = denominator >> twos, 0
    while odd % 5 == 0:
        odd //= 5
        fives += 1
    if odd != 1:
        return f"{x.numerator}/{x.denominator}"
    places = max(twos, fives)
    digits = str(abs(x.numerator) * 10**places // denominator).rjust(places + 1, "0")
    sign = "-" if x < 0 else ""
    return f"{sign}{digits[:-places]}.{digits[-places:]}" if places else sign + digits


def shown(value: object) -> str:
    """A value as an error message quotes it: short, whatever was sent."""
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}… ({len(text)} characters)"


def _bounded(x: Fraction, field: str, max_digits: int) -> Fraction:
    for part in (abs(x.numerator), x.denominator):
        # 10**n has more than 3 n bits, so most numbers need no power
        if part.bit_length() > 3 * max_digits and part >= 10**max_digits:
            raise _too_long(field, max_digits)
    return x


def _too_long(field: str, max_digits: int) -> InputError:
    return InputError.of(field, f"has more than {max_digits} digits in its numerator or denominator")
