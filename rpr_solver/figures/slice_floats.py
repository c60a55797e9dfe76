"""A slice in floats: the free legs and J at a pose, to draw traced curves smoothly at any magnification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, hypot, radians, sin

from rpr_solver.figures.triangles import Triangles
from rpr_solver.notebook.scene import Point

Angles = tuple[float, float]
"""α and the angle of the fixed leg, in degrees."""


@dataclass(frozen=True)
class SliceFloats:
    """The map of a slice, (α, θ) → the lengths of the free legs, in floats.

    Attributes:
        length: of the fixed leg, in the unit of ``shape``.
        moving: for each free leg its platform point and its base point, both seen from the fixed leg.
        unit: the unit of ``shape`` in the user's.
    """

    length: float
    moving: tuple[tuple[Point, Point], tuple[Point, Point]]
    unit: float

    @classmethod
    def of(cls, geometry: Mapping[str, str], fixed_leg: int, length: str) -> SliceFloats:
        """The slice of a geometry with this leg at this length."""
        shape = Triangles.of(geometry)
        (bx, by), (ax, ay) = shape.platform[fixed_leg - 1], shape.base[fixed_leg - 1]
        first, second = (
            ((b[0] - bx, b[1] - by), (a[0] - ax, a[1] - ay))
            for k, (b, a) in enumerate(zip(shape.platform, shape.base, strict=True), 1)
            if k != fixed_leg
        )
        return cls(shape.length(length), (first, second), float(shape.unit))

    def lengths(self, pose: Angles) -> Point:
        """The lengths of the free legs, in the user's unit."""
        (_, _, x, y), (_, _, u, v), _ = self._vectors(pose)
        return hypot(x, y) * self.unit, hypot(u, v) * self.unit

    def singular(self, pose: Angles) -> tuple[float, float, float]:
        """J, up to a constant factor, and its slopes by α and θ, in radians."""
        (rx, ry, x, y), (sx, sy, u, v), (px, py) = self._vectors(pose)
        f_a, f_t = y * rx - x * ry, y * px - x * py
        g_a, g_t = v * sx - u * sy, v * px - u * py
        square = self.length * self.length
        f_aa, f_at, f_tt = rx * rx + ry * ry - x * rx - y * ry, px * rx + py * ry, square - x * px - y * py
        g_aa, g_at, g_tt = sx * sx + sy * sy - u * sx - v * sy, px * sx + py * sy, square - u * px - v * py
        return (
            f_a * g_t - f_t * g_a,
            f_aa * g_t + f_a * g_at - f_at * g_a - f_t * g_aa,
            f_at * g_t + f_a * g_tt - f_tt * g_a - f_t * g_at,
        )

    def onto_curve(self, pose: Angles) -> Angles:
        """The point of the singular curve near a point that is almost on it."""
        for _ in range(2):
            value, a, t = self.singular(pose)
            square = a * a + t * t
            if square == 0:
                break
            step = value / square * _DEGREE
            pose = pose[0] - step * a, pose[1] - step * t
        return pose

    def _vectors(
        self, pose: Angles
    ) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float], Point]:
        """For each free leg its turned platform point and its vector; and the vector of the fixed leg."""
        ca, sa = cos(radians(pose[0])), sin(radians(pose[0]))
        px, py = self.length * cos(radians(pose[1])), self.length * sin(radians(pose[1]))
        ((mx, my), (ax, ay)), ((nx, ny), (bx, by)) = self.moving
        rx, ry = ca * mx - sa * my, sa * mx + ca * my
        sx, sy = ca * nx - sa * ny, sa * nx + ca * ny
        return (rx, ry, px + rx - ax, py + ry - ay), (sx, sy, px + sx - bx, py + sy - by), (px, py)


_DEGREE = 57.29577951308232
