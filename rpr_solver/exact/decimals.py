"""Balls to decimal strings: every printed digit is proved, or nothing is printed."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

from flint import arb, fmpz

from rpr_solver.errors import Unproved


@lru_cache(maxsize=512)
def _power_of_ten(n: int) -> fmpz:
    return fmpz(10) ** n


def round_ball(x: arb, digits: int) -> str | None:
    """``x`` rounded to ``digits`` significant digits, or None if the ball is too wide to tell.

    An exact zero is ``"0"``. Uses the working precision of the caller.

    >>> round_ball(arb(2).sqrt(), 10), round_ball(arb(1, 0.6), 10)
    ('1.414213562', None)
    """
    if x.is_zero():
        return "0"
    if x.contains(0) or not x.is_finite():
        return None
    mid, _, exponent = x.mid_rad_10exp(3)
    lead = len(str(abs(mid))) - 1 + int(exponent)
    magnitude = abs(x)
    # the estimate of the leading digit's place can be off by one
    for place in (lead, lead - 1, lead + 1):
        shift = digits - 1 - place
        power = _power_of_ten(abs(shift))
        scaled = magnitude * power if shift >= 0 else magnitude / power
        rounded = (scaled + arb(0.5)).floor().unique_fmpz()
        if rounded is None:
            return None
        if rounded == _power_of_ten(digits):
            rounded, place = rounded // 10, place + 1
        if _power_of_ten(digits - 1) <= rounded < _power_of_ten(digits):
            return place_digits(str(rounded), place, negative=bool(x < 0))
    raise Unproved("a number's leading digit could not be placed")


def round_fraction(x: Fraction, digits: int) -> str:
    """An exact rational rounded to ``digits`` significant digits, halves away from zero.

    >>> round_fraction(Fraction(5, 2), 3), round_fraction(Fraction(-2, 3), 3)
    ('2.50', '-0.667')
    """
    if x == 0:
        return "0"
    n, d = abs(x.numerator), x.denominator
    place = len(str(n)) - len(str(d))
    if (n < d * 10**place) if place >= 0 else (n * 10**-place < d):
        place -= 1
    shift = digits - 1 - place
    n, d = (n * 10**shift, d) if shift >= 0 else (n, d * 10**-shift)
    rounded = (2 * n + d) // (2 * d)
    if rounded == 10**digits:
        rounded, place = rounded // 10, place + 1
    return place_digits(str(rounded), place, negative=x < 0)


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
    """A correctly rounded decimal rounded again to fewer digits; None on a tie, which hides the truth.

    >>> shorten("14.9849", 3), shorten("-0.0999999", 2), shorten("1.2500", 2)
    ('15.0', '-0.10', None)
    """
    if text == "0":
        return text
    negative = text.startswith("-")
    mantissa, _, exponent = text.lstrip("-").partition("e")
    whole, _, part = mantissa.partition(".")
    significant = (whole + part).lstrip("0")
    place = len(whole) - 1 + int(exponent or 0)
    if whole == "0":
        place = len(significant) - len(part) - 1
    if len(significant) <= digits:
        return text
    kept, dropped = significant[:digits], significant[digits:]
    if dropped == "5" + "0" * (len(dropped) - 1):
        return None
    if dropped[0] >= "5":
        kept = str(int(kept) + 1)
        if len(kept) > digits:
            kept, place = kept[:-1], place + 1
    return place_digits(kept, place, negative=negative)


def digit_bits(digits: int) -> int:
    """Bits that hold so many decimal digits, with a few to spare."""
    return digits * 3322 // 1000 + 16
