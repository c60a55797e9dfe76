"""One slice by itself, if it is generic and its digits are decided at once; else it is left to the reference.

Sturm's theorem counts the real roots of Q, and a Newton step proves that there is one beside each eigenvalue,
so that these are all. Without numpy, or where that fails, FLINT isolates the roots. t is the common root of J
and E above each, first to a few digits, then sharpened as a root of J (sharpener.py). Decimals are correctly
rounded in any case, so the document is that of the reference byte for byte.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of, count_of_real_roots
from rpr_solver.model.jets import common_root
from rpr_solver.model.joint_points import JointPoint
from rpr_solver.slices.decimals import HalfAngle
from rpr_solver.slices.eliminant import DEGREE_U
from rpr_solver.slices.reference import ReferenceSlice
from rpr_solver.slices.sharpener import PoseSharpener, near_start
from rpr_solver.slices.slice_table import SliceTable, slice_certificate

_COUNT_BITS = 128
"""The precision at which Sturm's theorem decides for all but few slices."""
_FIRST_BITS = 192
"""The precision at which t is first computed."""
_REACH = 2.0**-32
"""The radius of a ball about an eigenvalue, where it is at most 1."""
_START_BITS = 24
"""Bits of t from which it is sharpened."""


def single_slice(reference: ReferenceSlice) -> SliceTable | None:
    """The table of a slice; None if it is left to the reference."""
    if not reference.is_generic:
        return None
    cusps = _cusps(reference)
    if cusps is None:
        return None
    leg = reference.slice_map.fixed_leg
    certificate = slice_certificate(leg, [(DEGREE_U, 1)], len(cusps), "balls")
    return SliceTable(leg, reference.length, reference.digits, tuple(cusps), (), certificate)


def _cusps(reference: ReferenceSlice) -> list[JointPoint] | None:
    """The cusps of a generic slice; None if one is not decided."""
    slice_map = reference.slice_map
    sharpener = PoseSharpener(slice_map, reference.digits)
    with ctx.workprec(sharpener.bits):
        coefficients = reference.q.ball(sharpener.bits).coeffs()
        if slice_map.rho > 1:
            coefficients = [x for [x] in _in_unit_1([[x] for x in coefficients], slice_map.rho)]
        roots = _near_eigenvalues(coefficients)
        if roots is None:
            root = arb(slice_map.rho).sqrt()
            roots = [near_start(x.ball * root) for x in reference.roots or ()]
        if not roots:
            return []
        thetas = sharpener.thetas(coefficients, roots)
        alphas = thetas and _alphas(reference, sharpener, thetas)
        return sharpener.points(ball_of(reference.scaled), alphas, thetas) if alphas and thetas else None


def _alphas(
    reference: ReferenceSlice, sharpener: PoseSharpener, thetas: Sequence[HalfAngle]
) -> list[HalfAngle] | None:
    """The common roots t of J and E above the roots of Q."""
    slice_map = reference.slice_map
    omega = omega_ball(slice_map.radicand, sharpener.bits)
    j, e = (form.matrix(omega) for form in slice_map.sliced(reference.scaled))
    if slice_map.rho > 1:
        j, e = (arb_mat(_in_unit_1(form.tolist(), slice_map.rho)) for form in (j, e))
    starts = _starts(j, e, thetas)
    return starts and sharpener.alphas([arb_poly(x) for x in j.transpose().tolist()], thetas, starts)


def _near_eigenvalues(coefficients: Sequence[arb]) -> list[HalfAngle] | None:
    """All real roots of a polynomial, ascending, near the eigenvalues of its companion matrix.

    None if numpy is not loaded, or some root is not proved.
    """
    if "numpy" not in sys.modules:
        return None
    from rpr_solver.slices.fast import real_eigenvalues

    top = max(abs(x.mid()) for x in coefficients)
    found = real_eigenvalues([float(x / top) for x in coefficients])
    q = arb_poly(list(coefficients))
    if count_of_real_roots(q, _COUNT_BITS) != len(found):
        return None
    with ctx.workprec(_FIRST_BITS):
        slope, roots, last = q.derivative(), [], arb.neg_inf()
        for x in found:
            middle = arb(x)
            ball = arb(x, _REACH * max(abs(x), 1))
            y = middle - q(middle) / slope(ball)
            # the only root in this ball, and beyond the one before
            if not (ball.contains(y) and last < ball):
                return None
            last = ball
            roots.append(near_start(y))
        return roots


def _starts(j: arb_mat, e: arb_mat, thetas: Sequence[HalfAngle]) -> list[HalfAngle] | None:
    """Balls of the common roots of J and E above roots of Q; None if they are too wide."""
    with ctx.workprec(_FIRST_BITS):
        starts = []
        for first, second in zip(_above(j, thetas), _above(e, thetas), strict=True):
            t = common_root(first, second)
            start = HalfAngle.of(t, _START_BITS) if t else None
            if start is None:
                return None
            starts.append(start)
        return starts


def _above(form: arb_mat, thetas: Sequence[HalfAngle]) -> list[list[arb]]:
    """The coefficients of t⁰, t¹, … of a form above each of some angles, up to a factor."""
    rows = []
    for theta in thetas:
        powers = [arb(1), theta.x]
        while len(powers) < form.nrows():
            powers.append(powers[-1] * theta.x)
        rows.append(powers[::-1] if theta.inverse else powers)
    return (arb_mat(rows) * form).tolist()


def _in_unit_1(form: list[list[arb]], rho: int) -> list[list[arb]]:
    """A form in half tangents times √ρ, by a row of coefficients for each power of one."""
    if rho == 1:
        return form
    root = arb(rho).sqrt()
    return [[x / root ** (i + k) for i, x in enumerate(row)] for k, row in enumerate(form)]
