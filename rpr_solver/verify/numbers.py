"""Numbers of documents: each has one text, and a printed decimal stands for all numbers that round to it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, isqrt

from flint import acb, arb, fmpz

from rpr_solver.contract import MAX_DIGITS
from rpr_solver.errors import shown
from rpr_solver.verify.reader import Read, refusal

_EXACT = re.compile(r"(-?)(0|[1-9][0-9]*)(?:\.([0-9]*[1-9]))?", re.ASCII)
_QUOTIENT = re.compile(r"(-?[1-9][0-9]*)/([1-9][0-9]*)", re.ASCII)
_DECIMAL = re.compile(r"-?([0-9]+)(?:\.([0-9]+))?(?:e([+-][0-9]{1,5}))?", re.ASCII)
_ROOT = re.compile(r"sqrt\((.+)\)", re.ASCII)
_PLAIN_PLACES = 7
"""A number below 10^-7, or with more places before the point than digits, is printed with an exponent."""


def ball(x: Fraction | int) -> arb:
    """A rational number at the working precision."""
    return arb(fmpz(x.numerator)) / fmpz(x.denominator)


def angle(x: acb) -> arb:
    """The angle of a number that is not 0, also near the negative axis."""
    return (-x).arg() + arb.pi() if x.real < 0 else x.arg()


def is_positive(x: arb) -> bool | None:
    """Whether a number is > 0; None if its sign is open."""
    return True if x > 0 else False if x < 0 else None


@dataclass(frozen=True)
class Printed:
    """A printed decimal, which stands for all numbers that round to it.

    Attributes:
        text: as it is printed; "0" stands for the number 0 alone.
        number: its significant digits, as an integer with its sign.
        place: of the last digit: the decimal is number · 10^place.
    """

    text: str
    number: int
    place: int

    @property
    def is_zero(self) -> bool:
        """Whether it is an exact zero."""
        return self.text == "0"

    @property
    def value(self) -> Fraction:
        """The decimal."""
        return self.number * Fraction(10) ** self.place

    @property
    def lower(self) -> Fraction:
        """The least number that rounds to it."""
        return self._bounds[0] * Fraction(10) ** self.place / 20

    @property
    def upper(self) -> Fraction:
        """The greatest number that rounds to it."""
        return self._bounds[1] * Fraction(10) ** self.place / 20

    @property
    def bits(self) -> int:
        """So many bits after the point tell it from its neighbours, with some to spare."""
        return 0 if self.is_zero else max(-self.place * 10 // 3 + 8, 0)

    @property
    def _bounds(self) -> tuple[int, int]:
        """What rounds to it, in twentieths of its last digit: half a digit, or a tenth of this below 10^n."""
        if self.is_zero:
            return 0, 0
        inner = 1 if self.text.partition("e")[0].strip("-0.").replace(".", "") == "1" else 10
        low, high = (inner, 10) if self.number > 0 else (10, inner)
        return 20 * self.number - low, 20 * self.number + high

    def rounds(self, x: arb, turn: arb | int = 0) -> bool | None:
        """Whether every number of a ball rounds to it, perhaps after whole turns of ``turn``.

        Returns:
            True if all do, strictly; False if none does; None if that is open. An exact 0 is proved by the
            exact ball 0 alone.
        """
        if turn:
            x = x - turn * ((x - ball(self.value)) / turn + arb(0.5)).mid().floor()
        if self.is_zero:
            return True if x.is_zero() else None if x.contains(0) else False
        power, (low, high) = 20 * fmpz(10) ** abs(self.place), self._bounds
        scaled = x * power if self.place <= 0 else x * 400 / power
        if scaled > low and scaled < high:
            return True
        return False if scaled < low or scaled > high else None


def bits_of(numbers: Iterable[Printed]) -> int:
    """So many bits after the point tell each of some printed numbers from its neighbours."""
    return max((x.bits for x in numbers), default=0)


def exact(value: object, at: str) -> Fraction:
    """An exact number as a text: a decimal if it terminates, else p/q in lowest terms."""
    if isinstance(value, str):
        if (quotient := _QUOTIENT.fullmatch(value)) is not None:
            n, d = (_integer(part) for part in quotient.groups())
            # with other factors than 2 and 5, so that it does not terminate
            if d // gcd(d, 10 ** d.bit_length()) > 1 and gcd(n, d) == 1:
                return Fraction(n, d)
        elif (decimal := _EXACT.fullmatch(value)) is not None and value != "-0":
            sign, whole, part = decimal[1], decimal[2], decimal[3] or ""
            number = Fraction(_integer(whole + part), 10 ** len(part))
            return -number if sign else number
    raise refusal(at, f'{shown(value)} is not an exact number as documents write it, such as "14.98"')


def exact_within(low: Fraction | int, high: Fraction | int | None = None, *, ends: bool = False) -> Read:
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
NOT_NEGATIVE = exact_within(0, ends=True)
"""An exact length ≥ 0."""


def square_of(value: object, at: str) -> Fraction:
    """The square of a length ≥ 0: an exact number, or sqrt() of one that is no square."""
    root = _ROOT.fullmatch(value) if isinstance(value, str) else None
    if root is None:
        length: Fraction = NOT_NEGATIVE(value, at)
        return length**2
    x: Fraction = POSITIVE(root[1], at)
    if all(isqrt(part) ** 2 == part for part in x.as_integer_ratio()):
        raise refusal(at, f"is {shown(value)}, a root of a square")
    return x


def printed(digits: int, least: int | None = None, most: int | None = None, *, zero: bool = True) -> Read:
    """A decimal with so many significant digits, as documents print it; "0" is an exact zero.

    Args:
        digits: significant digits.
        least: the number is greater.
        most: the number is not greater.
        zero: whether it may be 0.
    """

    def read(value: object, at: str) -> Printed:
        match = _DECIMAL.fullmatch(value) if isinstance(value, str) else None
        if match is None or not isinstance(value, str):
            raise refusal(at, f"{shown(value)} is not a decimal of {digits} digits as documents print it")
        if value == "0" and zero:
            return Printed("0", 0, 0)
        significant = (match[1] + (match[2] or "")).lstrip("0")
        place = int(match[3] or 0) - len(match[2] or "") + len(significant) - 1
        if abs(place) > MAX_DIGITS or value != _text(significant, place, negative=value.startswith("-")):
            raise refusal(at, f"{shown(value)} is not a decimal as documents print it")
        if len(significant) != digits:
            raise refusal(at, f"{shown(value)} has {len(significant)} significant digits, not {digits}")
        number = _integer(significant) * (-1 if value.startswith("-") else 1)
        result = Printed(value, number, place - digits + 1)
        below = least is not None and _compared(result, least) <= 0
        if below or (most is not None and _compared(result, most) > 0):
            raise refusal(at, f"is {shown(value)}, beyond what is possible here")
        return result

    return read


def _compared(x: Printed, bound: int) -> int:
    """The sign of a printed decimal less an integer."""
    first, second = x.number * int(10 ** max(x.place, 0)), bound * int(10 ** max(-x.place, 0))
    return (first > second) - (first < second)


def _text(significant: str, place: int, *, negative: bool) -> str:
    """The text of a decimal with its leading digit at a place; empty if there is no digit."""
    if not significant:
        return ""
    if -_PLAIN_PLACES <= place < 0:
        plain = f"0.{'0' * (-place - 1)}{significant}"
    elif 0 <= place < len(significant):
        plain = f"{significant[: place + 1]}.{significant[place + 1 :]}".removesuffix(".")
    else:
        plain = f"{significant[0]}.{significant[1:]}".removesuffix(".") + f"e{place:+d}"
    return "-" + plain if negative else plain


def _integer(letters: str) -> int:
    number: int = int(fmpz(letters))  # without Python's limit, and in a time that is nearly linear
    return number
