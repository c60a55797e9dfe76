"""Intervals with ends that are multiples of 2^−bits, rounded outwards; π, sine and cosine in them.

Only the operations that closure equations need. Ends are Python integers, so nothing overflows. π is by
Machin's formula, sine and cosine by Taylor's series.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isqrt

from rpr_solver.verify.core.reader import spend, spend_by_digits

_SPARE = 32
_ULPS = 1 << 8


@dataclass(frozen=True, slots=True)
class Interval:
    """All real numbers from ``lower`` to ``upper``, in units of 2^−``bits``."""

    lower: int
    upper: int
    bits: int

    @classmethod
    def of(cls, x: Fraction | int, bits: int, radius: Fraction | int = 0) -> Interval:
        """The numbers within ``radius`` of ``x``."""
        low, high = (Fraction(x) - radius) * (1 << bits), (Fraction(x) + radius) * (1 << bits)
        return cls(low.numerator // low.denominator, -(-high.numerator // high.denominator), bits)

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
    """Cosine and sine of all angles of an interval, in radians, of absolute value below 64."""
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


def angle_near(cos: Interval, sin: Interval, guess: Interval) -> Interval:
    """An angle in radians with about this cosine and sine, less than two radians from a guess.

    Each step leaves a sixth of the cube of the error: x + sin(a − x) is x + (a − x) to third order.
    """
    x = (guess.lower + guess.upper) // 2
    while True:
        at_cos, at_sin = cos_sin(Interval(x, x, guess.bits))
        error = sin * at_cos - cos * at_sin
        step = (error.lower + error.upper) // 2
        x += step
        if abs(step) < _ULPS:
            return Interval(x, x, guess.bits)


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
