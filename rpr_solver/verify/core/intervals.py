"""Intervals with ends that are multiples of 2^−bits, rounded outwards: the verifier's own arithmetic.

Only the operations that closure equations need. Ends are Python integers, so nothing overflows.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt


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

    def __add__(self, other: Interval) -> Interval:
        return Interval(self.lower + other.lower, self.upper + other.upper, self.bits)

    def __sub__(self, other: Interval) -> Interval:
        return Interval(self.lower - other.upper, self.upper - other.lower, self.bits)

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower, self.bits)

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
        ends = [Fraction(x, y) for x in (self.lower, self.upper) for y in (other.lower, other.upper)]
        low, high = min(ends) * (1 << self.bits), max(ends) * (1 << self.bits)
        return Interval(low.numerator // low.denominator, -(-high.numerator // high.denominator), self.bits)

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
