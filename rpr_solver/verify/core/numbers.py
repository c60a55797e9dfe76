"""Numbers of documents: each has one text, and a printed decimal stands for all that round to it.

Six exact numbers make a manipulator.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from math import gcd, isqrt

from rpr_solver.errors import shown
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import (
    Read,
    Record,
    bits_in,
    count,
    record,
    refusal,
    rows,
    spend_by_digits,
    word,
)

MOST_DIGITS = 10_000
"""The longest decimal that is read, in digits; the greatest exponent."""
SPARE_BITS = 40
_MOST_LETTERS, _PYTHON_READS = 2_000_000, 4000
_INTEGER = re.compile(r"0|-?[1-9][0-9]*", re.ASCII)
_EXACT = re.compile(r"(-?)(0|[1-9][0-9]*)(?:\.([0-9]*[1-9]))?", re.ASCII)
_QUOTIENT = re.compile(r"(-?[1-9][0-9]*)/([1-9][0-9]*)", re.ASCII)
_DECIMAL = re.compile(r"-?([0-9]+)(?:\.([0-9]+))?(?:e([+-][0-9]{1,4}))?", re.ASCII)
_SHORT = re.compile(r"(-?[1-9][0-9]*)e-([1-9][0-9]{0,3})", re.ASCII)
_ROOT = re.compile(r"sqrt\((.+)\)", re.ASCII)


@dataclass(frozen=True)
class Printed:
    """A printed decimal: its value, and half a unit of its last digit."""

    text: str
    value: Fraction
    half: Fraction

    @classmethod
    def exact_zero(cls) -> Printed:
        """The text "0", which stands for 0 alone."""
        return cls("0", Fraction(0), Fraction(0))

    @property
    def is_zero(self) -> bool:
        """Whether the text is an exact zero."""
        return self.text == "0"

    @property
    def lower(self) -> Fraction:
        """The least number that may stand behind the text."""
        return self.value - (self.inward if self.value > 0 else self.half)

    @property
    def upper(self) -> Fraction:
        """The greatest number that may stand behind the text."""
        return self.value + (self.inward if self.value < 0 else self.half)

    @property
    def inward(self) -> Fraction:
        """How far numbers that round to the text are from it on the side of 0: less at a power of ten."""
        digits = self.text.partition("e")[0].strip("-0.").replace(".", "")
        return self.half / 10 if digits == "1" else self.half

    def below(self, x: Fraction) -> bool | None:
        """Whether the number behind the text is less than another; None if its digits leave that open."""
        if self.upper < x:
            return True
        return False if x < self.lower or not self.half else None

    def above(self, x: Fraction) -> bool | None:
        """Whether the number behind the text is greater than another; None if its digits leave that open."""
        if x < self.lower:
            return True
        return False if self.upper < x or not self.half else None

    def rounds(self, x: Interval, turn: int = 0) -> bool | None:
        """Whether every number of an interval, perhaps after turns of ``turn``, rounds to the text.

        True only if all are strictly within half a unit; False if none is; None if that is open.
        """
        shift = round((self.value - x.middle) / turn) * turn if turn else 0
        lower, upper = self.lower - shift, self.upper - shift
        if x.inside(lower, upper):
            return True
        unit = 1 << x.bits
        return False if x.upper < lower * unit or x.lower > upper * unit else None


def first_wrong(
    row: Mapping[str, Printed],
    values: Mapping[str, Interval],
    vanishes: Callable[[str], bool],
    *,
    doubted: bool = True,
) -> str | None:
    """The first printed number that is wrong for something with these values, angles in degrees; None if all
    are right.

    Of numbers that are printed as an exact 0, and may be it, ``vanishes`` is asked by their names. One that
    may be half way between two printed ones, which no interval tells, is wrong if it is to be ``doubted``.
    """
    for name, x in values.items():
        printed, turn = row[name], 360 if name.endswith("_deg") else 0
        right = x.contains(0) and vanishes(name) if printed.is_zero else printed.rounds(x, turn)
        if right is False or (doubted and not right):
            return name
    return None


HALF_WAY = "a number of it is half way between two printed ones, as far as intervals tell"


def bits_of(numbers: Iterable[Printed], spare: int = SPARE_BITS) -> int:
    """Bits well below the last digits of printed numbers."""
    least = min((x.half for x in numbers if not x.is_zero), default=Fraction(1))
    return (least.denominator // least.numerator).bit_length() + spare


def sums(numbers: Iterable[Fraction]) -> Iterator[Fraction]:
    """The sums of the first n numbers, from n = 0; denominators may grow with each.

    Raises:
        ExhaustedError: the work is used up.
    """
    total = Fraction(0)
    yield total
    for x in numbers:
        total += x
        spend_by_digits(4, bits_in(total), bits_in(x))
        yield total


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
        # with other factors than 2 and 5, so that it does not terminate
        if d // gcd(d, 10 ** d.bit_length()) > 1 and gcd(n, d) == 1:
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
    if number < 2 or isqrt(number) ** 2 == number:
        raise refusal(at, f"{shown(value)} is not sqrt() of an integer > 1 that is no square")
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


def polynomial(variable: str, least: int, most: int) -> Read:
    """A polynomial over ℤ[ω] of a degree between bounds: its coefficients, with ω² if there is an ω."""
    numbers = rows(integer, least + 1, most + 1)
    read_members = record(
        {"variable": word(variable), "degree": count(least, most), "coefficients": numbers},
        {"omega": radicand, "omega_coefficients": numbers},
    )

    def read(value: object, at: str) -> Record:
        members: Record = read_members(value, at)
        if ("omega" in members) != ("omega_coefficients" in members):
            raise refusal(at, "has one of omega and omega_coefficients without the other")
        for name in ("coefficients", "omega_coefficients"):
            if len(members.get(name, members["coefficients"])) != members["degree"] + 1:
                raise refusal(f"{at}/{name}", "has not one number more than the degree")
        return members

    return read


LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
_SIDES: dict[str, Read] = dict.fromkeys(LENGTHS[:3], exact) | dict.fromkeys(LENGTHS[3:], POSITIVE)
_READ = record({**_SIDES, "orientation": word("ccw", "cw")})


@dataclass(frozen=True)
class Geometry:
    """A manipulator: A1 = (0, 0), A2 = (a2x, 0), A3 = (a3x, a3y); d1 = |B1B2|, d2 = |B2B3|, d3 = |B3B1|."""

    a2x: Fraction
    a3x: Fraction
    a3y: Fraction
    d1: Fraction
    d2: Fraction
    d3: Fraction
    clockwise: bool
    texts: Mapping[str, str] = field(compare=False)

    @classmethod
    def read(cls, value: object, at: str) -> Geometry:
        """Reads the member ``geometry`` of a document.

        Raises:
            InputError: naming what is missing or impossible.
        """
        numbers = _READ(value, at)
        texts = {name: str(value[name]) for name in (*LENGTHS, "orientation")}  # type: ignore[index]
        a2x, a3x, a3y, d1, d2, d3 = (numbers[name] for name in LENGTHS)
        result = cls(a2x, a3x, a3y, d1, d2, d3, numbers["orientation"] == "cw", texts)
        if result.height_squared < 0:
            raise refusal(f"{at}/d1", "d1, d2 and d3 are not the sides of a triangle")
        if len(set(result.base)) < 3:
            raise refusal(f"{at}/a2x", "two corners of the base coincide")
        return result

    @property
    def hash(self) -> str:
        """The hash that the document should have."""
        text = ";".join(f"{name}={text}" for name, text in self.texts.items())
        return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()

    @property
    def base(self) -> tuple[tuple[Fraction, Fraction], ...]:
        """A1, A2, A3."""
        zero = Fraction(0)
        return (zero, zero), (self.a2x, zero), (self.a3x, self.a3y)

    @property
    def foot(self) -> Fraction:
        """The component of B1B3 along B1B2."""
        return (self.d1**2 + self.d3**2 - self.d2**2) / (2 * self.d1)

    @property
    def height_squared(self) -> Fraction:
        """The square of the distance of B3 from the line B1B2."""
        return self.d3**2 - self.foot**2

    @cached_property
    def height(self) -> tuple[Fraction, int]:
        """The distance of B3 from the line B1B2, positive to the left: (factor, radicand) of a root.

        The radicand is 1 where the height is rational.
        """
        # 16 times the squared area: shorter than the squared height, which has d1 below it
        heron = 4 * self.d1**2 * self.height_squared
        n, d = heron.as_integer_ratio()
        root = isqrt(d)
        factor, radicand = Fraction(1, root), n
        if root * root != d:
            factor, radicand = Fraction(1, d), n * d
        if isqrt(radicand) ** 2 == radicand:
            factor, radicand = factor * isqrt(radicand), 1
        else:
            for p in (2, 3, 5, 7, 11, 13):
                while radicand % (p * p) == 0:
                    factor, radicand = factor * p, radicand // (p * p)
        sign = -1 if self.clockwise else 1
        return sign * factor / (2 * self.d1), radicand

    @property
    def bits(self) -> int:
        """The size of its longest number."""
        return bits_in(self.a2x, self.a3x, self.a3y, self.d1, self.d2, self.d3)

    def free_legs(self, fixed: int) -> tuple[int, int]:
        """The legs whose lengths vary while one is fixed."""
        first, second = (leg for leg in (1, 2, 3) if leg != fixed)
        return first, second

    def side_squared(self, i: int, k: int) -> Fraction:
        """|BiBk|²."""
        sides = {frozenset((1, 2)): self.d1, frozenset((2, 3)): self.d2, frozenset((1, 3)): self.d3}
        return sides[frozenset((i, k))] ** 2
