"""A manipulator at one orientation: the centres of its legs' circles, and J as a polynomial in the place.

At orientation φ the platform's points are at p + R b_i, p = (x, y) being the place of the origin of its
frame, and leg i is the vector p − c_i, c_i = A_i − R b_i. So its length L_i keeps p on a circle about c_i.
With r_i = R b_i and u × v = u₁ v₂ − u₂ v₁,

    J = −Σ ((p − c_j) × (p − c_k)) (r_i × (p − c_i)),    (i, j, k) = (1, 2, 3), (2, 3, 1), (3, 1, 2).

In the first factor p × p is 0, and r_i × (p − c_i) = r_i × (p − A_i). So J, which is that of slices of
leg 1, is a polynomial of degree 2 in p; its zeros are the *singular conic*. J is 0 at each c_i, where leg i
has length 0 (mathematics.md#places-at-one-orientation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from rpr_solver.triangles import UserFrame
from rpr_solver.triangles.geometry import Geometry
from rpr_solver.triangles.surds import Surd
from rpr_solver.triangles.triangle import Point, Triangle
from rpr_solver.workspaces.tower import Number, Tower

Vector: TypeAlias = tuple[Number, Number]

COEFFICIENTS = ("xx", "xy", "yy", "x", "y", "1")
"""The names of the coefficients of J."""


@dataclass(frozen=True)
class Orientation:
    """A manipulator at an orientation, in the frame in which it was given, or that of the article.

    Attributes:
        tower: the field of all numbers.
        base: A₁, A₂ and A₃.
        arms: R b₁, R b₂ and R b₃.
        axis: the direction of the article's x-axis in the frame of the base.
        alpha: cos α and sin α.
    """

    tower: Tower
    base: tuple[Vector, Vector, Vector]
    arms: tuple[Vector, Vector, Vector]
    axis: Vector
    alpha: Vector

    @classmethod
    def of(cls, geometry: Geometry, phi: Fraction) -> Orientation:
        """That of φ, in degrees."""
        base, platform = _base(geometry), _platform(geometry.platform)
        tower = Tower(phi / 360 % 1)
        c = tower.cosine
        below = tower.turn > Fraction(1, 2)
        tower, s = tower.with_root(1 - c * c, -1 if below else 1)
        frame = UserFrame.of(geometry)
        own = () if frame is None else (frame.base.direction, frame.platform.direction)
        sums = [part for direction in own for part in direction]
        for surd in (z for corner in (*base, *platform, *sums) for z in corner):
            tower = tower.with_surd(surd)
        arms = []
        for corner in platform:
            x, y = map(tower.surd, corner)
            arms.append((x * c - y * s, x * s + y * c))
        feet = [(tower.surd(x), tower.surd(y)) for x, y in base]
        level = (tower.number(1), tower.number(0))
        axes = [(tower.surd(a[0]) + tower.surd(a[1]), tower.surd(b[0]) + tower.surd(b[1])) for a, b in own]
        (p, q), (u, v) = axes or (level, level)
        # e^{iα} = e^{iφ} q / p
        beside = u * p + v * q, v * p - u * q
        alpha = c * beside[0] - s * beside[1], c * beside[1] + s * beside[0]
        return cls(tower, (feet[0], feet[1], feet[2]), (arms[0], arms[1], arms[2]), (p, q), alpha)

    @property
    def centres(self) -> tuple[Vector, Vector, Vector]:
        """c₁, c₂ and c₃."""
        found = [(a - r, b - s) for (a, b), (r, s) in zip(self.base, self.arms, strict=True)]
        return found[0], found[1], found[2]

    @property
    def conic(self) -> tuple[Number, ...]:
        """The coefficients of J, by :data:`COEFFICIENTS`."""
        zero = self.tower.number(0)
        total = [zero] * len(COEFFICIENTS)
        rows = list(zip(self.centres, self.arms, self.base, strict=True))
        for i in range(3):
            (_, r, a), (d, _, _), (e, _, _) = rows[i], rows[(i + 1) % 3], rows[(i + 2) % 3]
            # (p − d) × (p − e) = p × (d − e) + d × e, and r × (p − c) = r × p − r × a
            line = (d[1] - e[1], e[0] - d[0], _cross(d, e))
            own = (-r[1], r[0], -_cross(r, a))
            for k, x in enumerate(_times(line, own)):
                total[k] = total[k] - x
        return tuple(total)


def _times(first: Sequence[Number], second: Sequence[Number]) -> tuple[Number, ...]:
    """The product of two linear functions."""
    (a, b, c), (d, e, f) = first, second
    return a * d, a * e + b * d, b * e, a * f + c * d, b * f + c * e, c * f


def _cross(u: Vector, v: Vector) -> Number:
    return u[0] * v[1] - u[1] * v[0]


def _base(geometry: Geometry) -> tuple[Point, Point, Point]:
    if geometry.base.points is not None:
        return geometry.base.points
    zero, (a2x, a3x, a3y, *_) = Surd.of(0), geometry.lengths
    return (zero, zero), (a2x, zero), (a3x, a3y)


def _platform(triangle: Triangle) -> tuple[Point, Point, Point]:
    if triangle.points is not None:
        return triangle.points
    zero, axis = Surd.of(0), Surd.root(triangle.axis2)
    x, y = triangle.corner3
    second = axis if triangle.squares[0] else zero
    return (zero, zero), (second, zero), (axis * x, axis * y)
