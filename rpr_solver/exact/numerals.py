"""Exact numbers as text and as doubles, of any size: the one place for conversions that Python limits.

``int`` and ``str`` refuse more than 4300 digits and take quadratic time; ``float`` refuses quotients beyond
1.8e308. Whoever reads a text from outside asks :func:`digit_count` first, which converts nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Context, Decimal
from fractions import Fraction
from math import inf

from rpr_solver.errors import FieldProblem, InputError

_AT_ONCE = 4000
"""Digits that ``int`` and ``str`` convert; they refuse some more."""
_LEAST_LENGTH = Fraction(1, 10**150)
_MOST_DIGITS: int = 10**20
"""What stands for a number of digits that is not told."""


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


def integer_text(x: int) -> str:
    """The decimal digits of an integer, with its sign.

    >>> integer_text(-17), len(integer_text(10**5000))
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


def check_doubles(lengths: Mapping[str, Fraction], what: str) -> None:
    """Checks that doubles hold lengths, their squares and products.

    Args:
        lengths: by the names of their fields.
        what: is computed with them.

    Raises:
        InputError: naming each that is neither 0 nor between 1e-150 and 1e150.
    """
    problems = [
        FieldProblem(
            name, f"is {_scientific(x)}; {what} are computed in doubles: give 0, or 1e-150 to 1e150 in size"
        )
        for name, x in lengths.items()
        if x and not _LEAST_LENGTH <= abs(x) <= 1 / _LEAST_LENGTH
    ]
    if problems:
        raise InputError(problems)


def _scientific(x: Fraction) -> str:
    return f"{Context(prec=5).divide(Decimal(x.numerator), Decimal(x.denominator)).normalize():e}"


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
    if len(power) > 20:
        return _MOST_DIGITS
    shift = int(power or 0) * (-1 if exponent[:1] == "-" else 1) - len(part)
    return len(significant) + shift if shift >= 0 else max(len(significant), 1 - shift)


def _is_plain(text: str) -> bool:
    return text.isascii() and text.isdigit()
