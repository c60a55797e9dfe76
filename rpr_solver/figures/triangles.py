"""The base and the platform of a manipulator in floats, in a unit in which they can be drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from math import cos, radians, sin

from rpr_solver.figures.wording import exact
from rpr_solver.notebook.scene import Point

Triple = tuple[Point, Point, Point]

_LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


@dataclass(frozen=True)
class Triangles:
    """The two triangles of a manipulator.

    Attributes:
        base: A1, A2, A3.
        platform: B1, B2, B3 at α = 0, seen from B1.
        unit: the length that is 1 here, in the user's unit.
    """

    base: Triple
    platform: Triple
    unit: Decimal

    @classmethod
    def of(cls, geometry: Mapping[str, str]) -> Triangles:
        """The triangles of the contract's geometry object."""
        lengths = [exact(geometry[name]) for name in _LENGTHS]
        unit = Decimal(10) ** max(map(abs, lengths)).adjusted()
        a2x, a3x, a3y, d1, d2, d3 = (float(x / unit) for x in lengths)
        x = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1)
        y = max(d3 * d3 - x * x, 0.0) ** 0.5
        corner = (x, -y if geometry["orientation"] == "cw" else y)
        return cls(((0.0, 0.0), (a2x, 0.0), (a3x, a3y)), ((0.0, 0.0), (d1, 0.0), corner), unit)

    def length(self, text: str) -> float:
        """A length of a document in the unit of the triangles."""
        return float(exact(text) / self.unit)

    def placed(self, alpha: float, b1: Point) -> Triple:
        """The platform's points at a pose; α in degrees."""
        c, s = cos(radians(alpha)), sin(radians(alpha))
        p, q, r = ((b1[0] + c * x - s * y, b1[1] + s * x + c * y) for x, y in self.platform)
        return p, q, r

    def held(self, leg: int, length: float, alpha: float, theta: float) -> Point:
        """B1 at a pose that a leg gives: its length, and its angle; angles in degrees."""
        ax, ay = self.base[leg - 1]
        dx, dy = self.placed(alpha, (0.0, 0.0))[leg - 1]
        return ax + length * cos(radians(theta)) - dx, ay + length * sin(radians(theta)) - dy
