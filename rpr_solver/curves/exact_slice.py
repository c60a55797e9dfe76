"""The cusps in the slice of a degenerate pose, counted exactly, although its length may be irrational."""

from __future__ import annotations

from collections.abc import Iterator

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    adjoin_real_roots,
    common_roots,
    poly_gcd,
    poly_mod,
    real_balls,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.classify import PoseKind, cos_sin
from rpr_solver.model.exact_pose import ExactPose
from rpr_solver.model.jets import Pose
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant

_GREATEST_DEGREE = 8
"""Of number fields in which this is tried; others take too long."""


def most_cusps(eliminant: Eliminant, pose: ExactPose) -> int | None:
    """At least the number of cusps in the slice of a pose, and mostly this number.

    A simple root of Q has at most one cusp above it, and poses above other roots are classified
    (mathematics.md#curves-that-end). Returns None if the number field is too large, J and E share a
    curve, or leg f may be closed and stretched at once.
    """
    length, omega = pose.length, pose.local.pose.omega
    leg = eliminant.slice_map.f
    stretched = length * length - (leg.platform2 + leg.base2)
    if (
        length.field.degree > _GREATEST_DEGREE
        or (stretched * stretched - 4 * leg.platform2 * leg.base2).is_zero
    ):
        return None
    q = _eliminant_at(eliminant, length, omega)
    if not q:
        return None
    common = poly_gcd(q, trimmed([c * i for i, c in enumerate(q)][1:]))
    once = poly_mod(q, common)[0]
    simple = poly_mod(once, poly_gcd(once, common))[0]
    count = len(real_balls(simple)) if len(simple) > 1 else 0
    places: list[tuple[Algebraic | None, Algebraic, Algebraic]] = [
        (extension.root, extension.lift(length), extension.lift(omega))
        for extension in adjoin_real_roots(length.field, squarefree_part(common))
    ]
    if len(q) <= DEGREE_U:
        places.append((None, length, omega))
    for place in places:
        poses = _poses_above(eliminant, *place)
        if poses is None:
            return None
        count += sum(each.kind is PoseKind.CUSP for each in poses)
    return count


def _eliminant_at(eliminant: Eliminant, length: Algebraic, omega: Algebraic) -> Polynomial:
    """Q at an algebraic scaled L."""
    powers = list(_powers(length, DEGREE_L))
    rows = (
        [omega * int(eliminant.b[i, k]) + int(eliminant.a[i, k]) for k in range(DEGREE_L + 1)]
        for i in range(DEGREE_U + 1)
    )
    return trimmed([_inner(row, powers) for row in rows])


def _poses_above(
    eliminant: Eliminant, u: Algebraic | None, length: Algebraic, omega: Algebraic
) -> list[ExactPose] | None:
    """The real common zeros of J and E above a root u (None: ∞); None if every t is one."""
    slice_map = eliminant.slice_map
    j, e = (_above(form, u, length, omega) for form in (slice_map.singular, slice_map.coalescence))
    roots = common_roots(j, e, *cos_sin(u, length.field), length, omega)
    if roots is None:
        return None
    return [
        ExactPose.of(slice_map, Pose(*cos_sin(t, omega.field), cos, sin, length, omega))
        for t, (cos, sin, length, omega) in roots
    ]


def _above(form: BiForm, u: Algebraic | None, length: Algebraic, omega: Algebraic) -> Polynomial:
    """The coefficients of tⁱ."""

    def at(polynomial: QuadraticPoly) -> Algebraic:
        return polynomial.coefficient(form.degree_u, omega) if u is None else polynomial(u, omega)

    return [_inner([at(c) for c in row], list(_powers(length, len(row) - 1))) for row in form.coefficients]


def _inner(first: list[Algebraic], second: list[Algebraic]) -> Algebraic:
    products = [x * y for x, y in zip(first, second, strict=True)]
    return sum(products[1:], products[0])


def _powers(x: Algebraic, most: int) -> Iterator[Algebraic]:
    power = x.field(1)
    for _ in range(most + 1):
        yield power
        power = power * x
