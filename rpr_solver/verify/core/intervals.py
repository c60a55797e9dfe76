"""Intervals with ends that are multiples of 2^−bits, rounded outwards; π, sine and cosine in them.

Only the operations that closure equations need. Ends are Python integers, so nothing overflows. π is by
Machin's formula, sine and cosine by Taylor's series.

And functions on a box of several variables: value and slopes at its middle, and how far they change within:
at x₀ + s (x − x₀), where x₀ is the middle of the box, x in it and 0 ≤ s ≤ 1, the value and the partial
derivatives are within s · radius + error of ``middle`` (mathematics.md#functions-on-boxes). All numbers are
integers in units of 2^−bits; radii and errors are rounded up. Row 0 is the value, the others are variables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isqrt

from rpr_solver.verify.core.reader import spend, spend_by_digits

_SPARE = 32


@dataclass(frozen=True, slots=True)
class Interval:
    """All real numbers from ``lower`` to ``upper``, in units of 2^−``bits``."""

    lower: int
    upper: int
    bits: int

    @classmethod
    def of(cls, x: Fraction | int, bits: int, radius: Fraction | int = 0) -> Interval:
        """The numbers within ``radius`` of ``x``."""
        (n, d), (m, e) = (x - radius).as_integer_ratio(), (x + radius).as_integer_ratio()
        return cls((n << bits) // d, -((-m << bits) // e), bits)

    def at(self, bits: int) -> Interval:
        """The interval at another precision, rounded outwards."""
        if bits >= self.bits:
            return Interval(self.lower << (bits - self.bits), self.upper << (bits - self.bits), bits)
        shift = self.bits - bits
        return Interval(self.lower >> shift, -(-self.upper >> shift), bits)

    def __add__(self, other: Interval) -> Interval:
        return Interval(self.lower + other.lower, self.upper + other.upper, self.bits)

    def __sub__(self, other: Interval) -> Interval:
        return Interval(self.lower - other.upper, self.upper - other.lower, self.bits)

    def __mul__(self, other: Interval) -> Interval:
        a, b, c, d, bits = self.lower, self.upper, other.lower, other.upper, self.bits
        if a >= 0 <= c:
            return Interval((a * c) >> bits, -((-b * d) >> bits), bits)
        ends = (a * c, a * d, b * c, b * d)
        return Interval(min(ends) >> bits, -(-max(ends) >> bits), bits)

    def scaled(self, factor: int) -> Interval:
        """The product with an integer."""
        ends = (self.lower * factor, self.upper * factor)
        return Interval(min(ends), max(ends), self.bits)

    def over(self, other: Interval) -> Interval:
        """The quotient.

        Raises:
            ZeroDivisionError: the divisor contains 0.
        """
        if other.lower <= 0 <= other.upper:
            raise ZeroDivisionError("an interval that contains 0 is no divisor")
        spend_by_digits(4, self.bits, other.upper.bit_length())
        pairs = [(x << self.bits, y) for x in (self.lower, self.upper) for y in (other.lower, other.upper)]
        return Interval(min(x // y for x, y in pairs), max(-(-x // y) for x, y in pairs), self.bits)

    def root(self) -> Interval:
        """The square root; what lies below 0 is left out.

        Raises:
            ValueError: the whole interval lies below 0.
        """
        if self.upper < 0:
            raise ValueError("a negative interval has no square root")
        low = isqrt(max(self.lower, 0) << self.bits)
        high = isqrt(self.upper << self.bits)
        return Interval(low, high + 1, self.bits)

    @property
    def middle(self) -> Fraction:
        """The midpoint."""
        return Fraction(self.lower + self.upper, 2 << self.bits)

    @property
    def radius(self) -> Fraction:
        """Half the width."""
        return Fraction(self.upper - self.lower, 2 << self.bits)

    @property
    def greatest(self) -> Fraction:
        """The greatest absolute value."""
        return Fraction(max(abs(self.lower), abs(self.upper)), 1 << self.bits)

    @property
    def sign(self) -> int:
        """The sign of all numbers, or 0 if they are not of one sign."""
        return (self.lower > 0) - (self.upper < 0)

    def contains(self, x: Fraction | int) -> bool:
        """Whether a number is in the interval."""
        return self.lower <= x * (1 << self.bits) <= self.upper

    def inside(self, lower: Fraction, upper: Fraction) -> bool:
        """Whether every number is strictly between two others."""
        unit = 1 << self.bits
        return lower * unit < self.lower and self.upper < upper * unit

    def meets(self, other: Interval) -> bool:
        """Whether two intervals, perhaps of different precision, have a number in common."""
        bits = max(self.bits, other.bits)
        mine, its = bits - self.bits, bits - other.bits
        return self.lower << mine <= other.upper << its and other.lower << its <= self.upper << mine


def ends_of(x: Interval) -> tuple[Fraction, Fraction]:
    """The least and the greatest number of an interval."""
    return Fraction(x.lower, 1 << x.bits), Fraction(x.upper, 1 << x.bits)


def halved(x: Interval, times: int) -> Interval:
    """The quotient by 2^times, rounded outwards."""
    return Interval(x.lower >> times, -(-x.upper >> times), x.bits)


@lru_cache(maxsize=16)
def pi(bits: int) -> Interval:
    """π = 16 arctan(1/5) − 4 arctan(1/239)."""
    spend(bits, bits)
    unit = 1 << (bits + _SPARE)
    value = 16 * _arctan_of_inverse(5, unit) - 4 * _arctan_of_inverse(239, unit)
    middle = value >> _SPARE
    return Interval(middle - 1, middle + 2, bits)


def _arctan_of_inverse(n: int, unit: int) -> int:
    """arctan(1/n) times ``unit``; each term is off by less than 1, and there are fewer than 2^(spare − 8)."""
    power, total, k, square = unit // n, 0, 1, n * n
    while power:
        total += power // k if k % 4 == 1 else -(power // k)
        power //= square
        k += 2
    return total


def radians(degrees: Fraction, bits: int) -> Interval:
    """An angle in radians."""
    return pi(bits) * Interval.of(degrees / 180, bits)


def degrees(angle: Interval) -> Interval:
    """An angle in degrees."""
    return angle.scaled(180).over(pi(angle.bits))


def cos_sin(angle: Interval) -> tuple[Interval, Interval]:
    """Cosine and sine of all angles of an interval, in radians, of absolute value below 128."""
    bits = angle.bits
    middle = (angle.lower + angle.upper) // 2
    # both functions have slopes of at most 1
    radius = max(angle.upper - middle, middle - angle.lower) + 2
    one = 1 << bits
    cos, sin = _at(abs(middle), bits)
    if middle < 0:
        sin = -sin
    cosine, sine = (Interval(max(x - radius, -one), min(x + radius, one), bits) for x in (cos, sin))
    return cosine, sine


def _at(angle: int, bits: int) -> tuple[int, int]:
    """Cosine and sine of angle · 2^−bits ≥ 0 in units of 2^−bits, off by less than 2 units.

    Taylor's series is taken at x = angle / 2^h < 1/2, in units of 2^−scale: each of its terms, fewer than
    ``scale``, is off by at most 2 units, and so is the rest. Each of the h doublings makes an error e at
    most 3 e + 2 units. As 3^h (2 · scale + 4) < 2^(2 h + 64), less than 1 unit of 2^−bits remains.
    """
    spend(10 + 3 * isqrt(bits), bits)
    h = 8 + isqrt(bits) // 2
    scale = bits + 2 * h + 64
    x = angle << (scale - bits - h)
    sums, term, k = [0, 0], 1 << scale, 0
    while term:
        sums[k % 2] += term if k % 4 < 2 else -term
        k += 1
        term = (term * x // k) >> scale
    cos, sin = sums
    for _ in range(h):
        cos, sin = (cos * cos - sin * sin) >> scale, (cos * sin) >> (scale - 1)
    return cos >> (scale - bits), sin >> (scale - bits)


Row = list[int]


class TooWideError(Exception):
    """A box is so wide that a divisor, or what is under a root, may be 0."""


class Expansion:
    """A function on a box.

    Attributes:
        bits: the unit is 2^−bits.
        middle: its value and its partial derivatives at the middle.
        radius: bounds of their changes.
        error: a bound of the errors of all rows.
    """

    __slots__ = ("_size", "bits", "error", "middle", "radius")

    def __init__(self, bits: int, middle: Row, radius: Row, error: int) -> None:
        self.bits, self.middle, self.radius, self.error = bits, middle, radius, error
        self._size = -1

    @property
    def size(self) -> int:
        """A bound of the absolute values of all rows on the box."""
        if self._size < 0:
            pairs = zip(self.middle, self.radius, strict=True)
            self._size = max([abs(x) + r for x, r in pairs]) + self.error
        return self._size

    def __add__(self, other: Expansion) -> Expansion:
        middle = [x + y for x, y in zip(self.middle, other.middle, strict=True)]
        radius = [x + y for x, y in zip(self.radius, other.radius, strict=True)]
        return Expansion(self.bits, middle, radius, self.error + other.error)

    def __sub__(self, other: Expansion) -> Expansion:
        middle = [x - y for x, y in zip(self.middle, other.middle, strict=True)]
        radius = [x + y for x, y in zip(self.radius, other.radius, strict=True)]
        return Expansion(self.bits, middle, radius, self.error + other.error)

    def __neg__(self) -> Expansion:
        return Expansion(self.bits, [-x for x in self.middle], self.radius, self.error)

    def __mul__(self, other: Expansion) -> Expansion:
        """The product; |ab − âb̂| ≤ (|â| + |a − â|) |b − b̂| + |b̂| |a − â|, for slopes by Leibniz' rule."""
        bits, p, q, u, v = self.bits, self.middle, other.middle, self.radius, other.radius
        a, b, ra, rb = p[0], q[0], u[0], v[0]
        top_a, top_b = abs(a) + ra, abs(b) + rb
        middle = [(a * y + b * x) >> bits for x, y in zip(p, q, strict=True)]
        radius = [
            ((top_a * s + ra * abs(y) + top_b * r + rb * abs(x)) >> bits) + 1
            for x, y, r, s in zip(p, q, u, v, strict=True)
        ]
        middle[0] = (a * b) >> bits
        radius[0] = ((top_a * rb + ra * abs(b)) >> bits) + 1
        error = ((self.error * other.size + other.error * self.size) >> (bits - 1)) + 3
        return Expansion(bits, middle, radius, error)

    def doubled(self) -> Expansion:
        """Twice the function."""
        return self + self

    def halved(self) -> Expansion:
        """Half the function."""
        middle, radius = [x >> 1 for x in self.middle], [(r >> 1) + 1 for r in self.radius]
        return Expansion(self.bits, middle, radius, self.error + 1)

    def inverse(self) -> Expansion:
        """1/a, of a function that is > 0."""
        x, least, change = self._positive()
        return self._composed((1 / x, change / (x * least)), (-1 / x**2, 2 * change / least**3), least)

    def root(self) -> Expansion:
        """The square root of a function that is > 0."""
        x, least, change = self._positive()
        root, low = _root_below(x, 2 * self.bits), _root_below(least, 2 * self.bits)
        slope = 1 / (2 * root)
        return self._composed((root, change / (root + low)), (slope, change / (4 * least * low)), low)

    def _positive(self) -> tuple[Fraction, Fraction, Fraction]:
        """The value at the middle, the least on the box, and the greatest change."""
        unit = 1 << self.bits
        x, least = self.middle[0], self.middle[0] - self.radius[0] - self.error
        if least <= 0:
            raise TooWideError
        return Fraction(x, unit), Fraction(least, unit), Fraction(self.radius[0], unit)

    def _composed(
        self, value: tuple[Fraction, Fraction], slope: tuple[Fraction, Fraction], least: Fraction
    ) -> Expansion:
        """A function of this one: its value and slope at the middle, each with its greatest change.

        ``least`` is such that the slope is at most 2/least² and the second slope at most 4/least³, and ≤ 1.
        """
        bits, unit = self.bits, 1 << self.bits
        height, steep, change = (int(x * unit) for x in (value[0], slope[0], value[1]))
        bend = _up(slope[1] * unit)
        middle = [(steep * x) >> bits for x in self.middle]
        radius = [
            ((abs(steep) * r + bend * (abs(x) + r)) >> bits) + 2
            for x, r in zip(self.middle, self.radius, strict=True)
        ]
        middle[0], radius[0] = height, change + 1
        low = min(least, Fraction(1))
        size = Fraction(self.size, unit)
        error = _up((2 * self.error / low**2) + (4 * self.error / low**3 + 4) * (size + 1)) + 4
        return Expansion(bits, middle, radius, error)

    def tightened(self, half: Sequence[int]) -> Expansion:
        """The same, its value changing by no more than the mean value theorem says, on these half widths."""
        rows = zip(self.middle[1:], self.radius[1:], half, strict=True)
        change = (sum([(2 * abs(x) + r) * w for x, r, w in rows]) >> (self.bits + 1)) + 1
        if change >= self.radius[0]:
            return self
        error = self.error + (self.error * sum(half) >> self.bits) + 1
        return Expansion(self.bits, self.middle, [change, *self.radius[1:]], error)

    def with_angles(self, alpha: Expansion, theta: Expansion) -> Expansion:
        """The same, given its derivatives by the first two variables, which may have smaller radii."""
        value, a, t, *rest = self.radius
        narrow = [value, min(a, alpha.radius[0]), min(t, theta.radius[0]), *rest]
        error = self.error + 2 * max(alpha.error, theta.error)
        return Expansion(self.bits, self.middle, narrow, error)

    @property
    def is_without_zero(self) -> bool:
        """Whether the function is nowhere 0 on the box."""
        return abs(self.middle[0]) > self.radius[0] + self.error


def constant(x: Fraction, bits: int, variables: int) -> Expansion:
    """A number."""
    scaled = x * (1 << bits)
    middle = [scaled.numerator // scaled.denominator, *[0] * variables]
    return Expansion(bits, middle, [0] * (1 + variables), 0 if scaled.denominator == 1 else 1)


@dataclass(frozen=True)
class Terms:
    """A function on a box as an expansion: T differs from ``value`` by at most Σ |change| + rest."""

    value: int
    change: Row
    rest: int

    @classmethod
    def of(cls, function: Expansion, half: Sequence[int]) -> Terms:
        """The expansion of a function; ``half`` are the half widths of the box, all in units of 2^−2·bits."""
        change = [x * w for x, w in zip(function.middle[1:], half, strict=True)]
        second = sum([r * w for r, w in zip(function.radius[1:], half, strict=True)])
        rest = (second >> 1) + 1 + function.error * ((1 << function.bits) + sum(half))
        return cls(function.middle[0] << function.bits, change, rest)

    @property
    def excludes_zero(self) -> bool:
        """Whether the function is nowhere 0 on the box."""
        return abs(self.value) > sum(map(abs, self.change)) + self.rest


def have_no_common_zero(terms: Sequence[Terms], factors: Sequence[int]) -> bool:
    """Whether Σ factor · function is nowhere 0 on the box; the factors may be any integers."""
    value: int = sum([f * t.value for f, t in zip(factors, terms, strict=True)])
    columns = zip(*(t.change for t in terms), strict=True)
    change: int = sum([abs(sum([f * x for f, x in zip(factors, c, strict=True)])) for c in columns])
    rest: int = sum([abs(f) * t.rest for f, t in zip(factors, terms, strict=True)])
    return abs(value) > change + rest


def _up(x: Fraction | int) -> int:
    return -((-x) // 1)


def _root_below(x: Fraction, bits: int) -> Fraction:
    """A square root, rounded down to a multiple of 2^−bits."""
    return Fraction(isqrt((x.numerator << (2 * bits)) // x.denominator), 1 << bits)
