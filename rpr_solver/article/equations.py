"""The article's equations (6) and (8)–(11) as it prints them, over any ring.

A leg enters by its vector (xᵢ, yᵢ) = Lᵢ (cos θᵢ, sin θᵢ), so that every Lᵢ cᵢ, Lᵢ sᵢ and Lᵢ Lⱼ sᵢⱼ is
polynomial. With a common denominator ``one``, xᵢ and yᵢ are its numerators, and each formula is
made homogeneous.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

Vector = tuple[Any, Any]
Matrix = list[list[Any]]

LEG_ALONG = {
    1: "leg 2 along B2B3",
    2: "leg 3 along B1B3",
    3: "leg 3 along B2B3",
    4: "leg 1 along B1B3",
    5: "leg 2 along B1B2",
    6: "leg 1 along B1B2",
}
"""What kᵢ = 0 means: kᵢ is twice the cross product of a leg and a side of the platform."""


@dataclass(frozen=True)
class Legs:
    """Leg vectors with their base points; ``one`` is the denominator of the vectors."""

    vectors: tuple[Vector, Vector, Vector]
    a2x: Any
    a3x: Any
    a3y: Any
    one: Any = 1

    def cross(self, i: int, j: int) -> Any:
        """Lᵢ Lⱼ sin(θᵢ − θⱼ)."""
        (xi, yi), (xj, yj) = self.vectors[i - 1], self.vectors[j - 1]
        return yi * xj - xi * yj

    def dot(self, i: int, j: int) -> Any:
        """Lᵢ Lⱼ cos(θᵢ − θⱼ)."""
        (xi, yi), (xj, yj) = self.vectors[i - 1], self.vectors[j - 1]
        return xi * xj + yi * yj

    @property
    def singularity(self) -> Any:
        """The left side of (6), times L1 L2 L3."""
        _, (_, y2), (x3, y3) = self.vectors
        return y2 * self.a2x * self.cross(3, 1) + (y3 * self.a3x - x3 * self.a3y) * self.cross(1, 2)

    @cached_property
    def k(self) -> dict[int, Any]:
        """k1 … k6 of (9), each divided by 2."""
        (x1, y1), (x2, y2), (x3, y3) = self._homogeneous
        a2x, a3x, a3y = self.a2x, self.a3x, self.a3y
        return {
            1: y2 * (a3x - a2x) + self.cross(2, 3) - x2 * a3y,
            2: -(self.cross(1, 3) + y3 * a3x - x3 * a3y),
            3: -(y3 * (a3x - a2x) + self.cross(2, 3) - x3 * a3y),
            4: self.cross(1, 3) + y1 * a3x - x1 * a3y,
            5: -(self.cross(1, 2) + y2 * a2x),
            6: self.cross(1, 2) + y1 * a2x,
        }

    @cached_property
    def second_derivatives(self) -> tuple[Matrix, Matrix, Matrix]:
        """The matrices ∂²Γᵢ/∂θ² of (11), each divided by 2."""
        (x1, y1), (x2, y2), (x3, y3) = self._homogeneous
        a2x, a3x, a3y = self.a2x, self.a3x, self.a3y
        c12, c23, c31 = self.dot(1, 2), self.dot(2, 3), self.dot(3, 1)
        o = c12 * 0
        return (
            [[x1 * a2x + c12, -c12, o], [-c12, -(x2 * a2x - c12), o], [o, o, o]],
            [
                [o, o, o],
                [o, -(x2 * (a2x - a3x) - c23 - y2 * a3y), -c23],
                [o, -c23, x3 * (a2x - a3x) + c23 - y3 * a3y],
            ],
            [
                [x1 * a3x + c31 + y1 * a3y, o, -c31],
                [o, o, o],
                [-c31, o, c31 - x3 * a3x - y3 * a3y],
            ],
        )

    @property
    def _homogeneous(self) -> list[Vector]:
        """The vectors made of the degree of a product of two."""
        return [(x * self.one, y * self.one) for x, y in self.vectors]


def adjugate(k: dict[int, Any]) -> Matrix:
    """(8): the adjugate of ∂Γ/∂θ from k1 … k6.

    The article prints the entry −k3 k6 without its sign; (10) does not use it.
    """
    return [
        [k[1] * k[2], -(k[2] * k[5]), k[3] * k[5]],
        [k[3] * k[4], k[2] * k[6], -(k[3] * k[6])],
        [-(k[1] * k[4]), k[4] * k[5], k[1] * k[6]],
    ]


def coalescence(k: dict[int, Any], second_derivatives: Sequence[Matrix]) -> Any:
    """The left side of (10): u from the first row of the adjugate, v from its first column."""
    adj = adjugate(k)
    row, column = adj[0], [line[0] for line in adj]
    indices = range(3)
    return sum(
        column[i] * column[j] * sum(row[n] * h[i][j] for n, h in enumerate(second_derivatives))
        for i in indices
        for j in indices
    )
