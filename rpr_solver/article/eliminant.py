"""Steps 1–4 of the article's algorithm: F1, E1, the eliminant of degree 96, and its factors.

With t = tan(α/2), u = tan(θ1/2) and h kept symbolic (as a multiple of ω), F1 has degree 4 and E1
degree 12 in both t and u, and the eliminant of t is, up to a constant, for every geometry and L1,

    (u²+1)¹⁸ · q2² · q3² · w⁴ · s² · b1² · b3⁺² · b3⁻² · Q,    96 = 36 + 4 + 4 + 8 + 8 + 4 + 4 + 4 + 24

At a singular pose the adjugate (8) has rank 1, so (10) is the condition for three coalescing poses times
u1 v1², where u1 and v1 vanish with the adjugate's first row and column; if a leg has length zero, its angle
is undetermined. The factors other than Q are the poses of these two kinds, in closed form:

- q2, q3: leg 2 or leg 3 has length zero;
- w: legs 1 and 3 lie on the line A1A3 (k2 = k4 = 0);
- s: legs 2 and 3 lie on the line A2A3 (k1 = k3 = 0);
- b1: the leg lines meet in B1, legs 2 and 3 along its platform sides (k2 = k5 = 0);
- b3±: the leg lines meet in B3, |A1B3| = |L1 ± d3| (k1 = k4 = 0).

Hence every cusp is above a root of Q, which explains the article's conjecture
(mathematics.md#the-articles-eliminant).

For a flat platform (h = 0) the constraint Jacobian (5) is singular in every pose, (14) follows from
(13), and their resultant is 0. It then matters that h is a symbol until step 5: the eliminant is a
polynomial in h, and the coefficient of its lowest power of h takes its place.

The article's equations (6) and (8)–(11) are as it prints them, over any ring. A leg enters by its vector
(xᵢ, yᵢ) = Lᵢ (cos θᵢ, sin θᵢ), so that every Lᵢ cᵢ, Lᵢ sᵢ and Lᵢ Lⱼ sᵢⱼ is polynomial. With a common
denominator ``one``, xᵢ and yᵢ are its numerators, and each formula is made homogeneous.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any

from flint import fmpz_mpoly, fmpz_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import OMEGA, BiForm, L, T, U
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.quadratic import Form, QuadraticPoly, univariate
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.slices.reference import formal_resultant

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


DEGREE = 96
_ONE_T, _ONE_U = 1 + T**2, 1 + U**2


@dataclass(frozen=True)
class KnownFactor:
    """A factor in closed form: a form in u, its origin, and the reason why it has no cusps."""

    form: Form
    multiplicity: int
    origin: str
    reason: str
    closed_leg: int | None = None
    """The leg whose length is zero at the roots."""


@dataclass(frozen=True)
class ArticleEliminant:
    """F1 and E1 as forms in t and u, their eliminant, and its factors."""

    f1: BiForm
    e1: BiForm
    flat: bool
    """h = 0, so that (14) follows from (13) and is no condition."""
    whole: Form
    known: tuple[KnownFactor, ...]
    q: Form

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> ArticleEliminant:
        """Steps 1–4 for leg 1 of this scaled length.

        Raises:
            SolverError: the eliminant vanishes identically.
        """
        flat = slice_map.g.n == 0
        f1, e1 = article_forms(slice_map, length)
        whole = _flat_eliminant(slice_map, length) if flat else resultant(f1, e1)
        if whole.polynomial.is_zero:
            raise SolverError(
                "the article's eliminant vanishes identically in this slice:"
                " (13) and (14) hold together on a whole curve of poses, and its algorithm gives no answer"
            )
        known = known_factors(slice_map, length)
        q = whole
        for factor in known:
            for _ in range(factor.multiplicity):
                q = q.quotient(factor.form)
        return cls(f1, e1, flat, whole, known, q)


def article_forms(slice_map: SliceMap, length: Fraction) -> tuple[BiForm, BiForm]:
    """Steps 1 and 2: (13) and (14) as forms of degrees 4 and 12 in both t and u, for a scaled L1."""
    f1, e1 = _equations(slice_map, length, slice_map.g.n * OMEGA)
    return f1.primitive(), e1.primitive()


def _equations(slice_map: SliceMap, length: Fraction, height: fmpz_mpoly) -> tuple[BiForm, BiForm]:
    """(13) and (14) for B3 at this height, a constant or a symbol."""
    n, d = length.numerator, length.denominator
    one = _ONE_T * _ONE_U
    x1, y1 = (1 - U**2) * _ONE_T * n, 2 * U * _ONE_T * n
    cos, sin = 1 - T**2, 2 * T

    def vector(leg: Leg, height: fmpz_mpoly | int) -> tuple[fmpz_mpoly, fmpz_mpoly]:  # (12), times Lᵢ
        x, y = cos * leg.m - sin * height, sin * leg.m + cos * height
        return x1 + d * (x * _ONE_U - leg.ax * one), y1 + d * (y * _ONE_U - leg.ay * one)

    f, g = slice_map.f, slice_map.g
    legs = Legs(((x1, y1), vector(f, 0), vector(g, height)), d * f.ax, d * g.ax, d * g.ay, one)
    k = {i: x / one for i, x in legs.k.items()}
    h = [[[x / one for x in row] for row in m] for m in legs.second_derivatives]
    f1, e1 = legs.singularity / one, coalescence(k, h) / one
    return BiForm.of(f1, slice_map.radicand, 4, 4), BiForm.of(e1, slice_map.radicand, 12, 12)


def known_factors(slice_map: SliceMap, length: Fraction) -> tuple[KnownFactor, ...]:
    """The closed forms of all factors but Q, for a scaled L1."""
    f, g = slice_map.f, slice_map.g
    n, d = length.numerator, length.denominator
    cos, sin, one = fmpz_poly([1, 0, -1]), fmpz_poly([0, 2]), fmpz_poly([1, 0, 1])

    side = g.ax - f.ax, g.ay - f.ay
    # B1 is as far from the line A2A3 as from the line B2B3: |B2B3| is the same number of units
    distance = (cos * side[1] - sin * side[0]) * n - one * (d * (f.ax * side[1] - f.ay * side[0]))
    bx, by = g.m - f.m, g.n - f.n  # B2B3; by and the area hold ω
    area2 = (f.m * by - bx * f.n) ** 2 * slice_map.radicand
    platform2 = bx**2 + by**2 * slice_map.radicand
    along = distance * distance * platform2 - one * one * (d * d * area2 * (side[0] ** 2 + side[1] ** 2))

    def angle(dot_m: int, cross_m: int, dot: fmpz_poly, cross: fmpz_poly) -> QuadraticPoly:
        """Two directed angles are equal modulo 180°; the platform's cross product holds ω."""
        radicand, parts = slice_map.radicand, (cross * dot_m, dot * -cross_m)
        first, second = (QuadraticPoly.rational(part, radicand) for part in parts)
        return first + QuadraticPoly.omega(radicand) * second

    # at B1: from A2 and A3 as from B2 and B3
    dot = one * (n * n + d * d * (f.ax * g.ax + f.ay * g.ay))
    dot -= (cos * (f.ax + g.ax) + sin * (f.ay + g.ay)) * (n * d)
    cross = one * (d * d * (f.ax * g.ay - f.ay * g.ax))
    cross -= (cos * (g.ay - f.ay) - sin * (g.ax - f.ax)) * (n * d)
    at_b1 = angle(f.m * g.m + f.n * g.n * slice_map.radicand, f.m * g.n - f.n * g.m, dot, cross)

    # at B3 = ρ e(θ): from A1 and A2 as from B1 and B2, with ρ = L1 ± d3
    d3 = isqrt(g.platform2)
    dot_m = g.m * bx + g.n * by * slice_map.radicand
    cross_m = g.m * by - g.n * bx

    def at_b3(rho: Fraction) -> QuadraticPoly:
        p, q = rho.numerator, rho.denominator
        to_a1_a2 = one * p - (cos * f.ax + sin * f.ay) * q
        turn = -(cos * f.ay - sin * f.ax) * q
        return angle(dot_m, cross_m, to_a1_a2, turn)

    def form(polynomial: QuadraticPoly | fmpz_poly, degree: int = 2) -> Form:
        if isinstance(polynomial, fmpz_poly):
            polynomial = QuadraticPoly.rational(polynomial, slice_map.radicand)
        return Form(polynomial.primitive(), degree)

    row, column = "the adjugate's first row vanishes", "the adjugate's first column vanishes"
    meets = "the three leg lines meet in"
    return (
        KnownFactor(form(one), 18, "circular points", "u² = −1 is no angle"),
        KnownFactor(form(f.closed(length)), 2, "L2 = 0", "leg 2 has length zero", 2),
        KnownFactor(form(g.closed(length)), 2, "L3 = 0", "leg 3 has length zero", 3),
        KnownFactor(form(g.collinear), 4, "legs 1 and 3 on line A1A3", f"k2 = k4 = 0: {column}"),
        KnownFactor(form(along, 4), 2, "legs 2 and 3 on line A2A3", f"k1 = k3 = 0: {column}"),
        KnownFactor(form(at_b1), 2, f"{meets} B1", f"k2 = k5 = 0: {row}"),
        KnownFactor(form(at_b3(length + d3)), 2, f"{meets} B3, |A1B3| = L1 + d3", f"k1 = k4 = 0: {column}"),
        KnownFactor(form(at_b3(length - d3)), 2, f"{meets} B3, |A1B3| = |L1 - d3|", f"k1 = k4 = 0: {column}"),
    )


def _flat_eliminant(slice_map: SliceMap, length: Fraction) -> Form:
    """Step 4 with h a symbol: the coefficient of the lowest power of h in Res_t(F1, E1).

    As (14) follows from (13) for h = 0, E1 = c F1 + h E, and the resultant is h⁴ Res_t(F1, E). Its value for
    h = 0, without h⁴, is that coefficient, unless it is 0, as of congruent triangles.
    """
    forms = _equations(slice_map, length, L)  # L1 is put in, so that L is free to be h
    f1, e1 = (form.a for form in forms)
    whole_first = f1.subs({"L": 0})
    first = BiForm.of(whole_first, 1, 4, 4).primitive()
    rest = whole_first / first.a * e1 - e1.subs({"L": 0}) / first.a * f1
    second = BiForm.of(rest.derivative("L").subs({"L": 0}), 1, 12, 12).primitive()
    whole = resultant(first, second)
    if not whole.polynomial.is_zero:
        return whole
    terms = formal_resultant(*forms).to_dict()
    lowest = min((powers[2] for powers in terms), default=0)
    powers_of_u = {powers[1]: c for powers, c in terms.items() if powers[2] == lowest}
    return Form(QuadraticPoly.rational(univariate(powers_of_u)).primitive(), DEGREE)
