"""Arrays of balls in doubles, with bounds of all roundings.

A ball is a midpoint and a radius; it stands for all numbers that are no farther from the midpoint. Each
operation returns balls that hold all results for numbers of its operands (mathematics.md#balls-in-doubles).
A ball with a midpoint or a radius that is infinite, or no number, stands for all numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Truths = NDArray[np.bool_]

EPS = 2.0**-52
"""ε: a rounding errs by at most ε/2 times the exact result (IEEE 754), so by ε times the rounded one."""
TRIG = 2.0**-50
"""τ: a cosine or sine of numpy errs by at most 4 units of the last place, each at most 2⁻⁵²."""
UP = 1 + 2.0**-40
"""A radius comes from less than 2¹⁰ roundings; times this factor it is no smaller than the exact one."""
TINY = 2.0**-1000
"""More than what underflow takes from a sum of less than 2¹⁰ products, 2⁻¹⁰⁷⁵ each."""


def padded(radius: Doubles) -> Doubles:
    """An upper bound of a sum of products of numbers that are not negative, from its computed value."""
    return radius * UP + TINY


class Balls:
    """An array of balls: arrays of midpoints and of radii, of one shape.

    No operation returns an infinite midpoint with a finite radius, so that a comparison of both is no proof.

    >>> x = Balls.of([arb(1) / 3, arb(2)])
    >>> (x * x).holds([1 / 9, 4.0]).tolist()
    [True, True]
    """

    __slots__ = ("mid", "rad")
    __array_ufunc__ = None  # an operation with an array on the left is one of the methods below

    def __init__(self, mid: Doubles, rad: Doubles) -> None:
        self.mid, self.rad = mid, rad

    @classmethod
    def exact(cls, numbers: Doubles) -> Balls:
        """Doubles, which are balls of radius 0."""
        return cls(numbers, np.zeros_like(numbers))

    @classmethod
    def of(cls, numbers: Sequence[arb]) -> Balls:
        """Balls of FLINT, each within one of doubles."""
        mid = np.array([float(x.mid()) for x in numbers])
        far = [float(abs(x - arb(m)).upper()) for x, m in zip(numbers, mid.tolist(), strict=True)]
        return cls(mid, padded(np.array(far)))

    @classmethod
    def stacked(cls, parts: Sequence[Balls]) -> Balls:
        """Arrays of one shape, as rows of one array."""
        return cls(np.array([x.mid for x in parts]), np.array([x.rad for x in parts]))

    @classmethod
    def joined(cls, parts: Sequence[Balls]) -> Balls:
        """Arrays one after the other, along the first axis."""
        return cls(np.concatenate([x.mid for x in parts]), np.concatenate([x.rad for x in parts]))

    def __getitem__(self, key: Any) -> Balls:
        return Balls(self.mid[key], self.rad[key])

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

    def __truediv__(self, other: Balls) -> Balls:
        """The quotients; all numbers, where the divisor may be 0."""
        with np.errstate(all="ignore"):
            mid = self.mid / other.mid
            # |y| ≥ |n| − s; the difference is rounded once
            least = (abs(other.mid) - other.rad) * (1 - 2 * EPS) - TINY
            # |x/y − m/n| ≤ (|x − m| + |m/n| |y − n|) / |y| ≤ (r + |m/n| s) / (|n| − s)
            rad = padded(padded(self.rad + padded(abs(mid)) * other.rad) / least + EPS * abs(mid))
        return Balls(mid, np.where(least > 0, rad, np.inf))

    def sin_cos(self) -> tuple[Balls, Balls]:
        """The sines and the cosines."""
        sin, cos = np.sin(self.mid), np.cos(self.mid)
        square = 0.5 * (self.rad * self.rad) + TRIG
        # |cos x − fl(cos m)| ≤ |sin m| r + r²/2 + τ, |sin m| ≤ |fl(sin m)| + τ; and likewise for sin x
        return (
            Balls(sin, padded((abs(cos) + TRIG) * self.rad + square)),
            Balls(cos, padded((abs(sin) + TRIG) * self.rad + square)),
        )

    def sum(self, axis: int) -> Balls:
        """The sums along an axis of length n."""
        mid, count = self.mid.sum(axis), self.mid.shape[axis]
        # |Σ xₖ − fl(Σ mₖ)| ≤ Σ (rₖ + n ε |mₖ|), in whatever order the terms are added
        return Balls(mid, padded((self.rad + count * EPS * abs(self.mid)).sum(axis) + EPS * abs(mid)))

    @property
    def excludes_zero(self) -> Truths:
        """Whether 0 is not in a ball."""
        return np.asarray(abs(self.mid) > self.rad)

    def ends(self) -> tuple[Doubles, Doubles]:
        """Doubles no greater, and no smaller, than all numbers of a ball; no numbers, where it holds all."""
        with np.errstate(all="ignore"):
            return np.nextafter(self.mid - self.rad, -np.inf), np.nextafter(self.mid + self.rad, np.inf)

    def holds(self, numbers: Doubles | Sequence[float]) -> Truths:
        """Whether doubles may be in the balls."""
        low, high = self.ends()
        return ~((np.asarray(numbers) < low) | (np.asarray(numbers) > high))


class Combinations:
    """Linear combinations with constant coefficients: the rows of a matrix.

    >>> sums = Combinations([[arb(1), arb(2)]])
    >>> sums.of(Balls.exact(np.array([[3.0], [5.0]]))).holds([[13.0]]).tolist()
    [[True]]
    """

    def __init__(self, rows: Sequence[Sequence[arb]]) -> None:
        shape = len(rows), len(rows[0])
        coefficients = Balls.of([x for row in rows for x in row])
        self._mid, self._rad = coefficients.mid.reshape(shape), coefficients.rad.reshape(shape)
        self._size = abs(self._mid)

    def of(self, terms: Balls) -> Balls:
        """The combinations of n terms, the rows of an array of shape (n, anything)."""
        size, errors = abs(terms.mid), (self._mid.shape[1] + 1) * EPS
        # |Σ aₖ xₖ − fl(Σ a′ₖ mₖ)| ≤ Σ |a′ₖ| (rₖ + (n + 1) ε |mₖ|) + Σ sₖ (|mₖ| + rₖ) for |aₖ − a′ₖ| ≤ sₖ,
        # in whatever order the products are added, each rounded before or not (fused)
        rad = self._size @ padded(terms.rad + errors * size) + self._rad @ (size + terms.rad)
        mid = self._mid @ terms.mid
        return Balls(mid, padded(rad + EPS * abs(mid)))
