"""The closure equations at given leg lengths, and the sixth-degree polynomial of direct kinematics.

With leg 1 fixed, X = B1 and v = R(α) m − a for each other leg, the squared lengths are

    |X|² = s₁,    |X + v|² = s   ⟺   2 v·X = s − s₁ − |v|²,

two equations linear in X. Their solution, substituted into |X|² = s₁, gives one form of degree 6 in
t = tan(α/2) (mathematics.md#the-fibre). Only squares of the leg lengths occur.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.slice_map import Leg, SliceMap

DEGREE = 6


@dataclass(frozen=True)
class LinearSystem:
    """``weight`` · vᵢ·X = cᵢ for the two moving legs, at one α, in any ring."""

    first: tuple[Any, Any]
    second: tuple[Any, Any]
    right: tuple[Any, Any]
    weight: int

    @property
    def determinant(self) -> Any:
        """v₂ × v₃: zero where the two equations are dependent."""
        (a, b), (c, d) = self.first, self.second
        return a * d - b * c

    @property
    def numerators(self) -> tuple[Any, Any]:
        """``weight`` · determinant · X."""
        (a, b), (c, d), (e, f) = self.first, self.second, self.right
        return e * d - f * b, f * a - e * c


@dataclass(frozen=True)
class Closure:
    """The closure equations of one joint vector: ``squares`` are s₁, s₂, s₃ in scaled units."""

    slice_map: SliceMap
    squares: tuple[Fraction, Fraction, Fraction]

    @classmethod
    def of(cls, slice_map: SliceMap, squares: Sequence[Fraction]) -> Closure:
        """From squared lengths in the user's unit; leg 1 must be the slice map's fixed leg."""
        s1, s2, s3 = (s * slice_map.scale**2 for s in squares)
        return cls(slice_map, (s1, s2, s3))

    @property
    def denominator(self) -> int:
        """A common denominator of the squares."""
        return lcm(*(s.denominator for s in self.squares))

    def linear(self, cos: Any, sin: Any, one: Any, omega: Any) -> LinearSystem:
        """The linear system at α, where cos α : sin α : 1 = ``cos`` : ``sin`` : ``one``."""
        den = self.denominator
        s1, *others = self.squares

        def equation(leg: Leg, square: Fraction) -> tuple[tuple[Any, Any], Any]:
            x, y = leg.rotated(cos, sin, omega)
            constant = int(den * (square - s1 - leg.platform2 - leg.base2))
            right = one * constant + (x * leg.ax + y * leg.ay) * (2 * den)
            return (x - one * leg.ax, y - one * leg.ay), right

        first, second = (
            equation(leg, s) for leg, s in zip((self.slice_map.f, self.slice_map.g), others, strict=True)
        )
        return LinearSystem(first[0], second[0], (first[1], second[1]), 2 * den)

    @cached_property
    def sextic(self) -> QuadraticPoly:
        """A(t) + ω B(t), primitive and of formal degree 6; a lower degree is a root at α = 180°."""
        radicand, den = self.slice_map.radicand, self.denominator
        cos, sin, one = (QuadraticPoly.rational(c, radicand) for c in ([1, 0, -1], [0, 2], [1, 0, 1]))
        system = self.linear(cos, sin, one, QuadraticPoly.omega(radicand))
        x, y = system.numerators
        determinant: QuadraticPoly = system.determinant / one.a
        # both terms are divisible by 1 + t² once: X is isotropic at t = ±i
        norm: QuadraticPoly = (x * x + y * y) / one.a
        return (norm - one * determinant * determinant * (4 * den * int(den * self.squares[0]))).primitive()
