"""Decimal strings from balls and rationals: every printed digit is proved, or there is no string."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from decimal import (
    MAX_EMAX,
    MIN_EMIN,
    ROUND_DOWN,
    ROUND_HALF_DOWN,
    ROUND_HALF_EVEN,
    ROUND_HALF_UP,
    ROUND_UP,
    Context,
    Decimal,
)
from fractions import Fraction
from functools import cmp_to_key, lru_cache
from math import floor, inf, log10
from typing import TypeVar

from flint import arb, fmpz

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import fraction_of

T = TypeVar("T")


_HALF = arb(0.5)


@lru_cache(maxsize=512)
def _power_of_ten(n: int) -> fmpz:
    return fmpz(10) ** n


def round_ball(x: arb, digits: int) -> str | None:
    """``x`` rounded to ``digits`` significant digits, or None if the ball is too wide to decide them.

    An exact zero is ``"0"``. The working precision is that of the caller.

    >>> round_ball(arb(2).sqrt(), 10), round_ball(arb(1, 0.6), 10)
    ('1.414213562', None)
    """
    approximate, magnitude = float(x), abs(x)
    if not 0 < abs(approximate) < inf and (x.contains(0) or not x.is_finite()):
        return "0" if x.is_zero() else None
    lead = _place(magnitude, abs(approximate))
    least, beyond = _power_of_ten(digits - 1), _power_of_ten(digits)
    # the estimate of the leading digit's place can be off by one
    for place in (lead, lead - 1, lead + 1):
        shift = digits - 1 - place
        scaled = magnitude * _power_of_ten(shift) if shift >= 0 else magnitude / _power_of_ten(-shift)
        rounded = (scaled + _HALF).floor().unique_fmpz()
        if rounded is None:
            return None
        if rounded == beyond:
            rounded, place = least, place + 1
        if least <= rounded < beyond:  # so that 0 is not in the ball
            return place_digits(str(rounded), place, negative=approximate < 0 or bool(x < 0))
    raise Unproved("a number's leading digit could not be placed")


def _place(x: arb, approximate: float) -> int:
    """About the place of the leading digit of a positive number; it can be off by one."""
    if 0 < approximate < inf:
        return floor(log10(approximate))
    mid, _, exponent = x.mid_rad_10exp(3)
    return len(str(mid)) - 1 + int(exponent)


def quotient(x: Fraction, digits: int, rounding: str) -> Decimal:
    """An exact rational of any size, rounded to ``digits`` digits by a rounding of :mod:`decimal`."""
    return _rounding(digits, rounding).divide(Decimal(x.numerator), Decimal(x.denominator))


def rounded_near(x: Fraction, digits: int) -> Fraction:
    """The nearest number of ``digits`` significant digits."""
    return Fraction(quotient(x, digits, ROUND_HALF_EVEN))


def rounded_up(x: Fraction, digits: int) -> Fraction:
    """The least number of ``digits`` significant digits that is not less."""
    return Fraction(quotient(x, digits, ROUND_UP))


def rounded_down(x: Fraction, digits: int) -> Fraction:
    """The greatest number of ``digits`` significant digits that is not greater."""
    return Fraction(quotient(x, digits, ROUND_DOWN))


def round_fraction(x: Fraction, digits: int) -> str:
    """An exact rational rounded to ``digits`` significant digits, halves away from zero.

    >>> round_fraction(Fraction(5, 2), 3), round_fraction(Fraction(-2, 3), 3)
    ('2.50', '-0.667')
    """
    if x == 0:
        return "0"
    return _text(quotient(x, digits, ROUND_HALF_UP), digits)


def round_down(x: arb, digits: int) -> str:
    """An exact ball ≥ 0, rounded towards zero to ``digits`` significant digits.

    >>> round_down(arb(2.9999), 3), round_down(arb(0), 3)
    ('2.99', '0')
    """
    exact = fraction_of(x)
    if exact == 0:
        return "0"
    return _text(quotient(exact, digits, ROUND_DOWN), digits)


def round_all(numbers: Iterable[arb | Fraction], digits: int) -> list[str] | None:
    """Balls and exact rationals, rounded; None if one of the balls is too wide.

    >>> round_all([Fraction(1, 3), arb(2).sqrt()], 5), round_all([Fraction(1, 3), arb(1, 0.6)], 5)
    (['0.33333', '1.4142'], None)
    """
    texts = []
    for x in numbers:
        text = round_ball(x, digits) if isinstance(x, arb) else round_fraction(x, digits)
        if text is None:
            return None
        texts.append(text)
    return texts


def angle_text(text: str) -> str:
    """A rounded angle in degrees, within (−180, 180]: what rounds to −180 is printed as 180.

    >>> angle_text("-180.000"), angle_text("-179.999")
    ('180.000', '-179.999')
    """
    return text[1:] if text.startswith("-180") else text


def sorted_by_balls(items: Iterable[T], balls: Callable[[T], Sequence[arb]]) -> list[T]:
    """Items in lexicographic order of their balls; overlapping balls count as equal."""

    def compare(x: T, y: T) -> int:
        for first, second in zip(balls(x), balls(y), strict=True):
            if first < second:
                return -1
            if first > second:
                return 1
        return 0

    return sorted(items, key=cmp_to_key(compare))


def place_digits(significant: str, place: int, *, negative: bool) -> str:
    """The text of 0.d₁d₂d₃… × 10^(place+1): plain where it can be, else with an exponent.

    >>> place_digits("1498", 1, negative=False), place_digits("15", 20, negative=True)
    ('14.98', '-1.5e+20')
    """
    sign = "-" if negative else ""
    if -7 <= place < 0:
        return f"{sign}0.{'0' * (-place - 1)}{significant}"
    if 0 <= place < len(significant):
        whole, part = significant[: place + 1], significant[place + 1 :]
        return f"{sign}{whole}.{part}" if part else sign + whole
    whole, part = significant[0], significant[1:]
    return f"{sign}{whole}{'.' + part if part else ''}e{place:+d}"


def shorten(text: str, digits: int) -> str | None:
    """A correctly rounded decimal rounded again to fewer digits; None on a tie, which cannot be decided.

    >>> shorten("14.9849", 3), shorten("-0.0999999", 2), shorten("1.2500", 2)
    ('15.0', '-0.10', None)
    """
    x = Decimal(text)
    short = _rounding(digits, ROUND_HALF_UP).plus(x)
    if short.same_quantum(x):
        return text
    if short != _rounding(digits, ROUND_HALF_DOWN).plus(x):
        return None
    plain = str(short)  # fast path: this is almost always the text, and whole tables are shortened
    return _text(short, digits) if "E" in plain else plain


@lru_cache(maxsize=64)
def _rounding(digits: int, rounding: str) -> Context:
    """The context of decimals with this number of digits and of any size."""
    return Context(prec=digits, rounding=rounding, Emin=MIN_EMIN, Emax=MAX_EMAX)


def _text(x: Decimal, digits: int) -> str:
    """The text of a nonzero number of at most ``digits`` digits, padded with zeros."""
    significant, _, place = f"{x.copy_abs():.{digits - 1}e}".partition("e")
    return place_digits(significant.replace(".", ""), int(place), negative=x.is_signed())


def digit_bits(digits: int) -> int:
    """The bits that hold this number of decimal digits, with a few to spare."""
    return digits * 3322 // 1000 + 16
