"""Functions on boxes, in doubles: values and slopes at the middles, and how far they may be from there.

At x₀ + s (x − x₀), where x₀ is the middle of a box, x in it and 0 ≤ s ≤ 1, a function and its derivatives are
within s·radius + error of ``middle`` (mathematics.md#functions-on-boxes); the error is that of rounding. Many
boxes are done at once: arrays have a row for the value and one for each variable, α and θ first, and a column
for each box.
"""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rpr_solver.model.jets import Jet

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from rpr_solver.margins.systems import Systems

    Doubles = NDArray[np.float64]

UNIT = 2.0**-53
UP = 1 + 2.0**-30
"""Bounds the roundings within a sum of nonnegative numbers, with a wide margin."""
_LEAST_ERROR = 2.0**-60
"""Covers underflow."""
_ALPHA, _THETA = 1, 2


class Errors(NamedTuple):
    """Two numbers for a function on boxes: one for its values, one for its partial derivatives."""

    value: float
    slope: float

    def __add__(self, other: Errors) -> Errors:  # type: ignore[override]
        return Errors(self.value + other.value, self.slope + other.slope)

    def times(self, factor: float) -> Errors:
        """Both multiplied."""
        return Errors(self.value * factor, self.slope * factor)

    def product(self, other: Errors) -> Errors:
        """Those of a product, by Leibniz' rule."""
        return Errors(self.value * other.value, self.value * other.slope + self.slope * other.value)


class Slopes:
    """A function on boxes.

    Attributes:
        middle: the values (row 0) and the partial derivatives at the middles.
        radius: bounds of their changes.
        error: bounds of the rounding errors.
    """

    __slots__ = ("_greatest", "_size", "error", "middle", "radius")

    def __init__(self, middle: Doubles, radius: Doubles, error: Errors) -> None:
        self.middle, self.radius, self.error = middle, radius, error
        self._greatest: Doubles | None = None
        self._size: Errors | None = None

    @classmethod
    def chosen(cls, which: NDArray[np.int64], options: Sequence[Slopes]) -> Slopes:
        """The function that has on each box the values of one of several."""
        middle, radius = (
            np.choose(which, [getattr(option, name) for option in options]) for name in ("middle", "radius")
        )
        value, slope = (max(errors) for errors in zip(*(option.error for option in options), strict=True))
        return cls(middle, radius, Errors(value, slope))

    @property
    def greatest(self) -> Doubles:
        """Bounds of the absolute values on the boxes."""
        if self._greatest is None:
            self._greatest = abs(self.middle) + self.radius
        return self._greatest

    @property
    def size(self) -> Errors:
        """Bounds of all absolute values, errors included; boxes where a row is NaN do not count."""
        if self._size is None:
            self._size = Errors(_most(self.greatest[0]), _most(self.greatest[1:])) + self.error
        return self._size

    def __add__(self, other: Slopes) -> Slopes:
        error = self.error + other.error + (self.size + other.size).times(2 * UNIT)
        return Slopes(self.middle + other.middle, self.radius + other.radius, error)

    def __sub__(self, other: Slopes) -> Slopes:
        return self + -other

    def __neg__(self) -> Slopes:
        return Slopes(-self.middle, self.radius, self.error)

    def __mul__(self, other: Slopes | int) -> Slopes:
        if isinstance(other, int):  # 1 or 2
            return self if other == 1 else self + self
        a, b = self.middle, other.middle
        middle = a[0] * b
        middle += b[0] * a
        radius = abs(a[0]) * other.radius
        radius += abs(b[0]) * self.radius
        radius += self.radius[0] * other.greatest
        radius += other.radius[0] * self.greatest
        # row 0 holds the product twice
        middle[0] *= 0.5
        radius[0] *= 0.5
        error = self.error.product(other.size) + self.size.product(other.error)
        return Slopes(middle, radius, error + self.size.product(other.size).times(4 * UNIT))

    def __truediv__(self, other: Slopes | int) -> Slopes:
        if isinstance(other, int):  # 2
            return Slopes(self.middle / other, self.radius / other, self.error.times(1 / other))
        x, least = other._positive()
        r = other.radius[0]
        slope = -1 / (x * x), 2 * r / least**3
        return self * other._composed((1 / x, r / (x * least)), slope, 4 / least**3)

    def sqrt(self) -> Slopes:
        """The square root of a positive function; NaN on boxes that are too wide."""
        x, least = self._positive()
        r, root, bend = self.radius[0], x**0.5, 0.25 / (least * least**0.5)
        return self._composed((root, r / root), (0.5 / root, bend * r), 2 * bend)

    def _positive(self) -> tuple[Doubles, Doubles]:
        """The values at the middles and lower bounds, NaN unless these are at least half as great."""
        x = self.middle[0]
        least = (x - self.radius[0] - 8 * self.error.value) * (2 - UP)
        least[~(2 * least >= x)] = nan
        return x, least

    def _composed(
        self, value: tuple[Doubles, Doubles], slope: tuple[Doubles, Doubles], bend: Doubles
    ) -> Slopes:
        """A function of this one: its value and its slope with their radii, a bound of its second slope."""
        middle, radius = self.middle * slope[0], self.radius * abs(slope[0]) + self.greatest * slope[1]
        middle[0], radius[0] = value
        top, rate, second = _most(value[0]), _most(abs(slope[0]) + slope[1]), _most(bend)
        own, size = self.error, self.size
        error = Errors(
            rate * own.value + 16 * UNIT * top,
            rate * own.slope + (second * own.value + 16 * UNIT * rate) * size.slope,
        )
        return Slopes(middle, radius, error.times(UP))

    def tightened(self, half: Doubles) -> Slopes:
        """The same, the radius of the value being at most that of the mean value theorem."""
        change = ((abs(self.middle[1:]) + 0.5 * self.radius[1:]) * half).sum(axis=0) * UP
        radius = self.radius.copy()
        radius[0] = change.clip(max=radius[0])
        wider = Errors(2 * self.error.slope * float(half.max(axis=1).sum()), 0.0)
        return Slopes(self.middle, radius, self.error + wider)

    def with_angles(self, alpha: Slopes, theta: Slopes) -> Slopes:
        """The same, given its derivatives by α and θ, whose values may have smaller radii."""
        radius = self.radius.copy()
        for row, slope in ((_ALPHA, alpha), (_THETA, theta)):
            radius[row] = radius[row].clip(max=slope.radius[0])
        wider = Errors(0.0, 2 * max(alpha.error.value, theta.error.value))
        return Slopes(self.middle, radius, self.error + wider)

    def expanded(self, half: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """The terms of an expansion: first and second order of each variable, and a bound of the errors.

        On a box the function differs from its value at the middle by at most the sum of the first, in
        absolute value, of half the second, and of the errors.
        """
        error = self.error.value + self.error.slope * half.sum(axis=0)
        size = abs(self.middle[0]) + (abs(self.middle[1:]) * half).sum(axis=0)
        return self.middle[1:] * half, self.radius[1:] * half, (error + 16 * UNIT * size) * UP + _LEAST_ERROR


def _most(x: Doubles) -> float:
    """The greatest number, NaN aside, rounded up."""
    return float(np.fmax.reduce(x, axis=None)) * UP


def refined(jet: Jet[Slopes], half: Doubles) -> Jet[Slopes]:
    """A jet with smaller radii: those of values by slopes, those of slopes by the values of its entries."""
    values = Jet.build(jet.order, lambda i, j: jet.table[i][j].tightened(half))

    def entry(i: int, j: int) -> Slopes:
        value = values.table[i][j]
        if i + j == jet.order:
            return value
        return value.with_angles(values.table[i + 1][j], values.table[i][j + 1])

    return Jet.build(jet.order, entry)


def moves(systems: Systems, leg: int) -> NDArray[np.bool_]:
    """The boxes on which v is not 0, for leg f (0) or g (1)."""
    moving: NDArray[np.bool_] = np.any(
        [abs(x.middle[0]) > x.radius[0] * UP + x.error.value for x in systems.tangent(leg)], axis=0
    )
    return moving
