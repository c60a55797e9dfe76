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
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

from flint import fmpz_mpoly, fmpz_poly

from rpr_solver.article.equations import Legs, coalescence
from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import OMEGA, BiForm, L, T, U
from rpr_solver.exact.elimination import resultant, resultant_bound
from rpr_solver.exact.modular import interpolated, reconstruct, resultants
from rpr_solver.exact.quadratic import Form, QuadraticPoly
from rpr_solver.model.slice_map import Leg, SliceMap

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
        KnownFactor(form(g.collinear()), 4, "legs 1 and 3 on line A1A3", f"k2 = k4 = 0: {column}"),
        KnownFactor(form(along, 4), 2, "legs 2 and 3 on line A2A3", f"k1 = k3 = 0: {column}"),
        KnownFactor(form(at_b1), 2, f"{meets} B1", f"k2 = k5 = 0: {row}"),
        KnownFactor(form(at_b3(length + d3)), 2, f"{meets} B3, |A1B3| = L1 + d3", f"k1 = k4 = 0: {column}"),
        KnownFactor(form(at_b3(length - d3)), 2, f"{meets} B3, |A1B3| = |L1 - d3|", f"k1 = k4 = 0: {column}"),
    )


def _flat_eliminant(slice_map: SliceMap, length: Fraction) -> Form:
    """Step 4 with h a symbol: the coefficient of the lowest power of h in Res_t(F1, E1)."""
    f1, e1 = _equations(slice_map, length, L)  # L1 is put in, so that L is free to be h
    degree = sum(p.degree_t * (len(q.coefficients[0]) - 1) for p, q in ((f1, e1), (e1, f1)))
    heights, us = range(1, degree + 2), range(DEGREE + 1)
    lowest = degree + 1

    def image(p: int, omega: int, _first: bool) -> list[int]:
        nonlocal lowest
        first, second = f1.residue(p, omega), e1.residue(p, omega)
        rows = interpolated([resultants(first.at(h), second.at(h), us) for h in heights], us, heights, p)
        order = next((i for i, row in enumerate(rows) if any(row)), degree)
        if lowest > degree:
            lowest = order
        elif order < lowest:
            raise SolverError("the first prime divides the lowest coefficient in h; please report this")
        return rows[lowest]

    a, b = reconstruct(slice_map.radicand, image, resultant_bound(f1, e1))
    return Form(QuadraticPoly(fmpz_poly(a), fmpz_poly(b), slice_map.radicand), DEGREE)
