"""One slice by itself, if it is generic and its digits are decided at once; else it is left to the reference.

Sturm's theorem counts the real roots of Q, and a Newton step proves that there is one beside each eigenvalue,
so that these are all. Without numpy, or where that fails, FLINT isolates the roots. t is the common root of J
and E above each, first to a few digits, then sharpened as a root of J (sharpener.py). Decimals are correctly
rounded in any case, so the document is that of the reference byte for byte.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from flint import arb, arb_poly, ctx

from rpr_solver.exact.biform import Rows
from rpr_solver.exact.real_roots import ball_of, roots_below
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
    bits = sharpener.bits
    with ctx.workprec(bits):
        root = arb(slice_map.rho).sqrt()
        q = _measured(reference.q.ball(bits), root)
        roots = _near_eigenvalues(q)
        if roots is None:
            roots = [near_start(x.ball * root) for x in reference.roots or ()]
        if not roots:
            return []
        j, e = (form.rows for form in slice_map.sliced(reference.scaled))
        thetas = sharpener.thetas(q.coeffs(), roots)
        starts = thetas and _starts(j, e, root, thetas)
        alphas = thetas and starts and sharpener.alphas(_balls(j, root, bits), thetas, starts)
        return sharpener.points(ball_of(reference.scaled), alphas, thetas) if alphas and thetas else None


def _near_eigenvalues(q: arb_poly) -> list[HalfAngle] | None:
    """All real roots of a polynomial, ascending, near the eigenvalues of its companion matrix.

    None if numpy is not loaded, or some root is not proved.
    """
    if "numpy" not in sys.modules:
        return None
    from rpr_solver.slices.fast import real_eigenvalues

    top = max(abs(x.mid()) for x in q.coeffs())
    found = real_eigenvalues([float(x / top) for x in q.coeffs()])
    count = roots_below(q, [None], _COUNT_BITS)
    if count is None or count[0] != len(found):
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


def _starts(j: Rows, e: Rows, root: arb, thetas: Sequence[HalfAngle]) -> list[HalfAngle] | None:
    """Balls of the common roots of J and E above roots of Q; None if they are too wide."""
    with ctx.workprec(_FIRST_BITS):
        forms = [_balls(rows, root, _FIRST_BITS) for rows in (j, e)]
        starts = []
        for theta in thetas:
            first, second = ([_value(row, len(form) - 1, theta) for row in form] for form in forms)
            t = common_root(first, second)
            start = HalfAngle.of(t, _START_BITS) if t else None
            if start is None:
                return None
            starts.append(start)
        return starts


def _balls(rows: Rows, root: arb, bits: int) -> list[arb_poly]:
    """A form in half tangents times √ρ."""
    balls = [row.ball(bits) for row in rows]
    return balls if root == 1 else [_measured(p, root) * (1 / root**i) for i, p in enumerate(balls)]


def _measured(p: arb_poly, root: arb) -> arb_poly:
    """p(u/√ρ)."""
    return p if root == 1 else p(arb_poly([0, 1 / root]))


def _value(p: arb_poly, degree: int, theta: HalfAngle) -> arb:
    """The value of a form, or of the form in 1/u."""
    return arb_poly([p[degree - k] for k in range(degree + 1)])(theta.x) if theta.inverse else p(theta.x)
