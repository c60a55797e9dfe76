"""From the article's frame to that of the points by which a manipulator was given.

The article has A1 at the origin, the x-axis through A2, and the pose as α, the direction of B1B2, and B1.
Whoever gives the base by points has a frame of his own; whoever gives the platform by points has one that
moves with it. Let p and q be the directions of A1A2 and of B1B2 in these two, as complex numbers of absolute
value 1. Then

    e^{iφ} = e^{iα} p / q,        x + i y = A1 + p B1 − e^{iφ} B1′

is the pose of the moving frame in the fixed one, B1′ being the point of the platform as it was given. Where a
triangle was given otherwise, its frame is the article's: A1 = 0 and p = 1, or B1′ = 0 and q = 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from rpr_solver.triangles.geometry import Geometry
from rpr_solver.triangles.surds import Surd
from rpr_solver.triangles.triangle import Point, Triangle

R = TypeVar("R")
_Sum: TypeAlias = tuple[Surd, Surd]
"""A number as a sum of two surds."""


@dataclass(frozen=True)
class GivenFrame:
    """The frame in which a triangle was given.

    Attributes:
        origin: corner 1.
        direction: the unit vector from corner 1 to corner 2, or to corner 3 where these are one, each
            component a sum of two surds.
    """

    origin: Point
    direction: tuple[_Sum, _Sum]

    @classmethod
    def of(cls, triangle: Triangle) -> GivenFrame:
        """That of the points; or corner 1 at 0 and corner 2 on the x-axis."""
        zero, one = Surd.of(0), Surd.of(1)
        if triangle.points is None:
            return cls((zero, zero), ((one, zero), (zero, zero)))
        first, second, third = triangle.points
        over = Surd.root(1 / triangle.axis2)
        if triangle.shared == 0:
            second = third
        x, y = ((v * over, -(u * over)) for u, v in zip(first, second, strict=True))
        return cls(first, (x, y))


@dataclass(frozen=True)
class UserFrame:
    """The frames of base and platform in which a manipulator was given, at least one of them by points.

    >>> from rpr_solver.triangles.geometry import read_geometry
    >>> base = {"points": [[1, 1], [1, 11], [-4, 1]]}
    >>> frame = UserFrame.of(read_geometry({"base": base, "platform": {"sides": [3, 4, 5]}}))
    >>> frame.pose(1, 0, 2, 0, lambda surd: int(surd.rational))
    (1, 3, 0, 1)
    """

    base: GivenFrame
    platform: GivenFrame

    @classmethod
    def of(cls, geometry: Geometry) -> UserFrame | None:
        """The frames of a geometry; None if neither triangle was given by points."""
        if geometry.base.points is None and geometry.platform.points is None:
            return None
        return cls(GivenFrame.of(geometry.base), GivenFrame.of(geometry.platform))

    def pose(self, cos: R, sin: R, x: R, y: R, number: Callable[[Surd], R]) -> tuple[R, R, R, R]:
        """x, y, cos φ and sin φ of the pose with cos α, sin α and B1 = (x, y) in the article's frame.

        Args:
            cos, sin, x, y: the pose, in any ring: balls, floats, or a number field.
            number: the value of a surd in the ring.
        """
        (px, py), (qx, qy) = (
            tuple(number(u) + number(v) for u, v in given.direction)  # type: ignore[operator]
            for given in (self.base, self.platform)
        )
        (ax, ay), (bx, by) = (tuple(map(number, given.origin)) for given in (self.base, self.platform))
        c, s = _times((cos, sin), _times((px, py), (qx, -qy)))
        u, v = _times((px, py), (x, y))
        dx, dy = _times((c, s), (bx, by))
        return ax + u - dx, ay + v - dy, c, s


def _times(first: tuple[Any, Any], second: tuple[Any, Any]) -> tuple[Any, Any]:
    """The product of complex numbers."""
    (a, b), (c, d) = first, second
    return a * c - b * d, a * d + b * c
