"""Exact numbers as text and as doubles, of any size: the one place for conversions that Python limits.

``int`` and ``str`` refuse more than 4300 digits and take quadratic time; ``float`` refuses quotients beyond
1.8e308. Whoever reads a text from outside asks :func:`digit_count` first, which converts nothing.
"""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from math import inf

_AT_ONCE = 4000
"""Digits that ``int`` and ``str`` convert; they refuse some more."""
_MOST_EXPONENT = 20
"""Digits of an exponent that are told from one another."""
MOST_COUNT: int = 10**_MOST_EXPONENT
"""What is counted of numbers with more digits than that."""


def longest_text(most_digits: int) -> int:
    """The characters of the longest text that a number with so many digits above and below needs.

    >>> longest_text(400)
    816
    """
    return 2 * most_digits + 16


def integer(text: str) -> int:
    """The integer that decimal digits, perhaps with a sign, stand for.

    >>> integer("-17"), integer("9" * 5000) == 10**5000 - 1
    (-17, True)
    """
    return int(text) if len(text) < _AT_ONCE else int(Decimal(text))


def digits(x: int) -> str:
    """The decimal digits of an integer, with its sign.

    >>> digits(-17), len(digits(10**5000))
    ('-17', 5001)
    """
    return str(x) if x.bit_length() < 3 * _AT_ONCE else f"{Decimal(x):f}"


def fraction(text: str) -> Fraction:
    """The number that the canonical text of a rational or a printed decimal stands for.

    >>> fraction("14.98"), fraction("-1/3"), fraction("1.5e+20") == 15 * 10**19
    (Fraction(749, 50), Fraction(-1, 3), True)
    """
    if len(text) < _AT_ONCE:
        return Fraction(text)
    above, _, below = text.partition("/")
    return Fraction(Decimal(above)) / Fraction(Decimal(below or "1"))


def double(x: Fraction | int) -> float:
    """The nearest double; ±inf beyond the greatest, 0 below the least.

    >>> double(Fraction(1, 4)), double(-(10**400)), double(Fraction(1, 10**400))
    (0.25, -inf, 0.0)
    """
    try:
        return float(x)
    except OverflowError:
        return inf if x > 0 else -inf


def digit_count(text: str) -> int:
    """The digits of numerator or denominator of a number, whichever has more; nothing is converted.

    The number need not be in lowest terms. 0: the text is no number. :data:`MOST_COUNT` stands for more.

    >>> digit_count("17.04"), digit_count("1e-400"), digit_count("12/345"), digit_count("abc")
    (4, 401, 3, 0)
    """
    text = text.strip()
    above, slash, below = text.partition("/")
    if slash:
        parts = [above[above[:1] in ("+", "-") :], below]
        return max(len(part.lstrip("0")) or 1 for part in parts) if all(map(_is_plain, parts)) else 0
    mantissa, mark, exponent = text.lower().partition("e")
    whole, _, part = mantissa[mantissa[:1] in ("+", "-") :].partition(".")
    power = exponent[exponent[:1] in ("+", "-") :]
    if not _is_plain(whole + part) or (mark and not _is_plain(power)):
        return 0
    whole, part, power = whole.lstrip("0"), part.rstrip("0"), power.lstrip("0")
    significant = (whole + part).lstrip("0")
    if not significant:
        return 1
    if len(power) > _MOST_EXPONENT:
        return MOST_COUNT
    shift = int(power or 0) * (-1 if exponent[:1] == "-" else 1) - len(part)
    return len(significant) + shift if shift >= 0 else max(len(significant), 1 - shift)


def _is_plain(text: str) -> bool:
    return text.isascii() and text.isdigit()
