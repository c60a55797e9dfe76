"""The slice in floats, for drawing: J, its roots near a guess, leg lengths. Floats decide nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import cos, hypot, isfinite, pi, sin

import numpy as np
from numpy.typing import NDArray

from rpr_solver.errors import InputError, SolverError
from rpr_solver.legs import singularity, slopes_by_vector, slopes_on_line
from rpr_solver.model.slice_map import Leg, SliceMap

_NEWTON_STEPS = 12
"""The most steps: each but the first few doubles the digits, and a double has 16."""
_CLOSE = 1e-13
"""In radians: a step below is the last one. Where the steps run out, a last one below its root will do."""
_ASIDE = 0.5
"""By the length of a chord: the iteration leads no farther from its middle."""
_THIRD_OF_A_TURN = 2 * pi / 3
"""In radians: nor that for a zero on a line, where arcs of the curve may be as far from each other."""

Vector = tuple[float, float]
Floats = NDArray[np.float64]


class OutOfDoublesError(SolverError, InputError):
    """Doubles do not hold the lengths of a slice: a question that needs them alone cannot be answered, others
    have another way."""


@dataclass(frozen=True)
class FloatSlice:
    """A slice scaled to a size of about 1.

    Attributes:
        unit: the user's unit of length times this is 1 here.
        length: of the fixed leg.
        legs: the platform point and the base point of each free leg, seen from the fixed one.
    """

    unit: float
    length: float
    legs: tuple[tuple[Vector, Vector], tuple[Vector, Vector]]

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> FloatSlice:
        """The slice of one *scaled* length.

        Raises:
            OutOfDoublesError: the lengths are too large or too small.
        """
        legs = slice_map.f, slice_map.g
        size = length + sum(leg.size for leg in legs)

        try:
            unit = float(slice_map.scale / size)
            first, second = (_points(leg, size) for leg in legs)
        except OverflowError:
            unit = 0.0
        if not isfinite(unit) or unit < 1e-290:
            name = f"l{slice_map.fixed_leg}" if 2 * length > size else "geometry"
            fault = "is too large or too small for double precision; give another unit"
            raise OutOfDoublesError.of(name, fault)
        return cls(unit, float(length / size), (first, second))

    def joints(self, alpha: float, theta: float) -> Vector:
        """The lengths of the two free legs."""
        ca, sa = cos(alpha), sin(alpha)
        x, y = self.length * cos(theta), self.length * sin(theta)
        ((m, n), (ax, ay)), ((p, q), (bx, by)) = self.legs
        first = hypot(x + ca * m - sa * n - ax, y + sa * m + ca * n - ay)
        return first, hypot(x + ca * p - sa * q - bx, y + sa * p + ca * q - by)

    def singular_between(self, chords: Floats) -> Floats:
        """The poses on J = 0 at right angles to the middles of chords; NaN where none is found.

        Args:
            chords: α and θ at both ends, a row each, with J > 0 on the left.
        """
        middles, ways = (chords[:, :2] + chords[:, 2:]) / 2, chords[:, 2:] - chords[:, :2]
        normals = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
        aside = np.zeros((len(chords), 1))
        with np.errstate(invalid="ignore", divide="ignore"):
            for _ in range(_NEWTON_STEPS):
                alpha, theta = (middles + aside * normals).T
                c, s, tip = (
                    np.cos(alpha),
                    np.sin(alpha),
                    (self.length * np.cos(theta), self.length * np.sin(theta)),
                )
                slopes = []
                for (m, n), (x, y) in self.legs:
                    arm = c * m - s * n, s * m + c * n
                    vector = tip[0] + arm[0] - x, tip[1] + arm[1] - y
                    slopes.append(slopes_by_vector(vector, arm, tip, self.length**2))
                value, by_alpha, by_theta = singularity(*slopes)
                slope = by_alpha * normals[:, 0] + by_theta * normals[:, 1]
                step = value / slope
                aside -= step[:, None]
                if (np.abs(step) < _CLOSE).all():
                    break
            good = (slope > 0) & (np.abs(step) < _CLOSE**0.5) & (np.abs(aside[:, 0]) < _ASIDE)
        return np.where(good[:, None], middles + aside * normals, np.nan)

    def on_line(self, theta: float) -> SingularOnLine:
        """J as a function of α at one θ."""
        direction = cos(theta), sin(theta)
        (m, a), (n, b) = self.legs
        a1, a2, b0, b1, b2 = slopes_on_line(m, a, direction, self.length)
        d1, d2, e0, e1, e2 = slopes_on_line(n, b, direction, self.length)
        return SingularOnLine(
            (
                a1 * e0 - b0 * d1,
                a2 * e0 - b0 * d2,
                a1 * e1 - b1 * d1,
                a2 * e2 - b2 * d2,
                a1 * e2 + a2 * e1 - b1 * d2 - b2 * d1,
            )
        )


@dataclass(frozen=True)
class SingularOnLine:
    """J = k₀ cos α + k₁ sin α + k₂ cos² α + k₃ sin² α + k₄ sin α cos α."""

    k: tuple[float, float, float, float, float]

    def value_and_slope(self, alpha: float) -> Vector:
        """J and ∂J/∂α."""
        k0, k1, k2, k3, k4 = self.k
        c, s = cos(alpha), sin(alpha)
        value = c * (k0 + k2 * c + k4 * s) + s * (k1 + k3 * s)
        return value, k1 * c - k0 * s + 2 * (k3 - k2) * s * c + k4 * (c * c - s * s)

    def slope_and_bend(self, alpha: float) -> Vector:
        """∂J/∂α and ∂²J/∂α²."""
        k0, k1, k2, k3, k4 = self.k
        c, s = cos(alpha), sin(alpha)
        cross, square = 2 * s * c, c * c - s * s
        return k1 * c - k0 * s + (k3 - k2) * cross + k4 * square, -k0 * c - k1 * s + 2 * (
            k3 - k2
        ) * square - 2 * k4 * cross

    def root(self, guess: float) -> float | None:
        """A zero of J near a guess, by Newton's iteration."""
        return newton(self.value_and_slope, guess)

    def turning(self, guess: float) -> float | None:
        """A zero of ∂J/∂α near a guess."""
        return newton(self.slope_and_bend, guess)


def _points(leg: Leg, size: Fraction) -> tuple[Vector, Vector]:
    m, a = leg.doubles(size)
    return (m.real, m.imag), (a.real, a.imag)


def newton(function: Callable[[float], Vector], guess: float) -> float | None:
    """A zero near a guess, or None if the iteration does not settle within a third of a turn."""
    x, last = guess, _THIRD_OF_A_TURN
    for _ in range(_NEWTON_STEPS):
        value, slope = function(x)
        if not slope:
            return None
        step = value / slope
        x -= step
        if abs(x - guess) > _THIRD_OF_A_TURN:
            return None
        if abs(step) < _CLOSE:
            return x
        last = step
    return x if abs(last) < _CLOSE**0.5 else None


def drawn(column: Sequence[float]) -> list[float]:
    """Numbers for a drawing, with the ten digits that a document keeps of them."""
    texts = "%.10g " * len(column) % tuple(column)  # at once, which is faster
    return list(map(float, texts.split()))
