"""Arrays of balls in doubles, with bounds of all roundings.

A ball is a midpoint and a radius; it stands for all numbers that are no farther from the midpoint. Each operation
returns balls that hold every result for numbers of its operands (mathematics.md#balls-in-doubles). A ball with a
radius, or a midpoint, that is infinite or no number stands for all numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import arb

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Truths = NDArray[np.bool_]

EPS = 2.0**-52
"""Bounds the error of a rounding, relative to the rounded result: 2⁻⁵³ relative to the exact one, IEEE 754."""
TRIG = 2.0**-50
"""Bounds the errors of numpy's cosines and sines of doubles: 4 units of the last place of a number up to 1."""
UP = 1 + 2.0**-40
"""A radius is computed with some dozens of roundings at most; multiplied by this, it is no smaller than the exact one."""
TINY = 2.0**-1000
"""Bounds what underflow takes from a sum of products, by 2⁻¹⁰⁷⁵ each."""


def padded(radius: Doubles) -> Doubles:
    """An upper bound of a radius that was computed as a sum of products of numbers that are not negative."""
    return radius * UP + TINY


class Balls:
    """An array of balls, by arrays of midpoints and radii with one shape.

    >>> x = Balls.of([arb(1) / 3, arb(2)])
    >>> (x * x).holds([1 / 9, 4.0]).tolist()
    [True, True]
    """

    __slots__ = ("mid", "rad")
    __array_ufunc__ = None  # so that an array on the left leaves the operation to the methods below

    def __init__(self, mid: Doubles, rad: Doubles) -> None:
        self.mid, self.rad = mid, rad

    @classmethod
    def exact(cls, numbers: Doubles) -> Balls:
        """Doubles, which are balls of radius 0."""
        return cls(numbers, np.zeros_like(numbers))

    @classmethod
    def of(cls, numbers: Sequence[arb]) -> Balls:
        """Balls of FLINT, each in one of doubles."""
        mid = np.array([float(x.mid()) for x in numbers])
        far = [float(abs(x - arb(m)).upper()) for x, m in zip(numbers, mid.tolist(), strict=True)]
        return cls(mid, padded(np.array(far)))

    @classmethod
    def stacked(cls, parts: Iterable[Balls]) -> Balls:
        """Arrays of one shape as one, with one more axis, the first."""
        parts = list(parts)
        return cls(np.stack([x.mid for x in parts]), np.stack([x.rad for x in parts]))

    @classmethod
    def joined(cls, parts: Sequence[Balls]) -> Balls:
        """Arrays one after the other along the first axis."""
        return cls(np.concatenate([x.mid for x in parts]), np.concatenate([x.rad for x in parts]))

    def __getitem__(self, key: object) -> Balls:
        return Balls(self.mid[key], self.rad[key])  # type: ignore[index]

    def __neg__(self) -> Balls:
        return Balls(-self.mid, self.rad)

    def __add__(self, other: Balls) -> Balls:
        mid = self.mid + other.mid
        # |x + y − fl(m + n)| ≤ r + s + ε |fl(m + n)|
        return Balls(mid, padded(self.rad + other.rad + EPS * abs(mid)))

    def __sub__(self, other: Balls) -> Balls:
        mid = self.mid - other.mid
        # |x − y − fl(m − n)| ≤ r + s + ε |fl(m − n)|
        return Balls(mid, padded(self.rad + other.rad + EPS * abs(mid)))

    def __mul__(self, other: Balls | float) -> Balls:
        if not isinstance(other, Balls):
            mid = self.mid * other
            # |c x − fl(c m)| ≤ |c| r + ε |fl(c m)|
            return Balls(mid, padded(abs(other) * self.rad + EPS * abs(mid)))
        mid = self.mid * other.mid
        # |x y − fl(m n)| ≤ |x − m| |y| + |m| |y − n| + ε |fl(m n)| ≤ r (|n| + s) + |m| s + ε |fl(m n)|
        rad = self.rad * (abs(other.mid) + other.rad) + abs(self.mid) * other.rad
        return Balls(mid, padded(rad + EPS * abs(mid)))

    __rmul__ = __mul__

    def __truediv__(self, other: Balls) -> Balls:
        """The quotient, and all numbers where the divisor holds 0."""
        with np.errstate(all="ignore"):
            mid = self.mid / other.mid
            # |y| ≥ |n| − s, rounded down
            least = (abs(other.mid) - other.rad) * (1 - 2.0**-40) - TINY
            # |x/y − m/n| ≤ (|x − m| + |m/n| |y − n|) / |y| ≤ (r + |m/n| s) / (|n| − s), |m/n| ≤ |fl(m/n)| (1 + ε) + TINY
            rad = padded(padded(self.rad + (abs(mid) + TINY) * other.rad) / least + EPS * abs(mid))
        return Balls(mid, np.where(least > 0, rad, np.inf))

    def sin_cos(self) -> tuple[Balls, Balls]:
        """Sines and cosines."""
        sin, cos = np.sin(self.mid), np.cos(self.mid)
        square = 0.5 * self.rad * self.rad + TRIG
        # |cos x − cos m| ≤ |sin m| r + r²/2, and |sin m| ≤ |fl(sin m)| + τ; sines likewise
        return (
            Balls(sin, padded((abs(cos) + TRIG) * self.rad + square)),
            Balls(cos, padded((abs(sin) + TRIG) * self.rad + square)),
        )

    def sum(self, axis: int) -> Balls:
        """Sums along an axis."""
        mid, count = self.mid.sum(axis), self.mid.shape[axis]
        # n − 1 roundings, in any order, err by (n − 1) ε Σ |mₖ| at most
        return Balls(mid, padded((self.rad + count * EPS * abs(self.mid)).sum(axis)))

    @property
    def excludes_zero(self) -> Truths:
        """Whether 0 is in none of the numbers of a ball."""
        return abs(self.mid) > self.rad

    def ends(self) -> tuple[Doubles, Doubles]:
        """Doubles that are not above, and not below, any number of a ball."""
        with np.errstate(all="ignore"):
            return np.nextafter(self.mid - self.rad, -np.inf), np.nextafter(self.mid + self.rad, np.inf)

    def holds(self, numbers: Doubles | Sequence[float]) -> Truths:
        """Whether a double is in a ball; true for all balls that stand for all numbers."""
        low, high = self.ends()
        numbers = np.asarray(numbers)
        return ~((numbers < low) | (numbers > high))


class Combinations:
    """Linear combinations with constant coefficients: a matrix, of balls of FLINT, by rows.

    Args:
        rows: the coefficients, each row of one length.

    >>> sums = Combinations([[arb(1), arb(2)]])
    >>> sums.of_balls(Balls.exact(np.array([[3.0], [5.0]]))).holds([[13.0]]).tolist()
    [[True]]
    """

    def __init__(self, rows: Sequence[Sequence[arb]]) -> None:
        self.shape = len(rows), len(rows[0])
        flat = Balls.of([x for row in rows for x in row])
        self.mid, self.rad = flat.mid.reshape(self.shape), flat.rad.reshape(self.shape)
        self._size = abs(self.mid)

    def of_balls(self, terms: Balls) -> Balls:
        """The combinations of terms, which are rows of an array.

        The products and sums may be computed in any order, and fused: they err by (n + 1) ε Σ |aₖ mₖ| at most.
        """
        size = abs(terms.mid)
        # |Σ aₖ xₖ − fl(Σ aₖ' mₖ)| ≤ Σ |aₖ'| (rₖ + (n + 1) ε |mₖ|) + Σ sₖ (|mₖ| + rₖ)
        wide = terms.rad + ((self.shape[1] + 1) * EPS * size + TINY)
        rad = self._size @ wide + self.rad @ (size + terms.rad)
        return Balls(self.mid @ terms.mid, padded(rad))
