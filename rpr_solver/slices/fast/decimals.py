"""From boxes that doubles prove to hold one cusp each (proofs.py) to its decimals.

In each box interval Newton steps sharpen u as a root of Q, then t as the root of J above it
(mathematics.md#real-roots); that there is one is proved before. Each step about doubles the bits of the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.joint_points import JointPoint, joint_point
from rpr_solver.slices.eliminant import DEGREE_L, Eliminant
from rpr_solver.slices.fast.proofs import PROOFS, NearPose
from rpr_solver.slices.grid import HalfAngle, MapBalls, SliceDecimals

_WIDER = 24
"""Bits of a half tangent beyond those of the digits: enough for nearly all decimals, and so few that the
box on the grid decides what they decide (mathematics.md#poses-by-floats)."""
_FIRST_TARGET = 92
"""The bits that the first step finds, at least in most cases."""
_ABOVE_TARGET = 64
"""Precision of a Newton step beyond the bits that it is to find."""
_ABOVE_DIGITS = 64
_NEAR = 8
"""Roots beyond are found as 1/u."""
_DEGREE_OF_J = 4
_ONE = arb(1)
_INEXACT = arb(2) ** -110
"""The radius, relative to the number, of the balls that are printed; that of grid.py is about as small."""

Cusp = tuple[JointPoint, dict[str, str]]
"""A cusp, and its proof as the certificate shows it."""


class PoseSharpener:
    """Q and J of a manipulator with one leg fixed, for all slices and one number of digits."""

    def __init__(self, eliminant: Eliminant, digits: int) -> None:
        slice_map = eliminant.slice_map
        self._leg, self._digits = slice_map.fixed_leg, digits
        targets = [digit_bits(digits) + _WIDER + 2]
        while targets[-1] > _FIRST_TARGET:
            targets.append(targets[-1] // 2 + 3)
        self._precisions = [x + _ABOVE_TARGET for x in reversed(targets)]
        self._bits, self._bits_of_decimals = self._precisions[-1], digit_bits(digits) + _ABOVE_DIGITS
        self._maps = MapBalls.of(slice_map, self._bits_of_decimals)
        with ctx.workprec(self._bits):
            self._goal, self._wider = arb(2) ** -targets[0], arb(0, arb(2) ** (2 - targets[0]))
            omega = omega_ball(slice_map.radicand, self._bits)
            self._q = arb_mat(eliminant.a) + arb_mat(eliminant.b) * omega
        self._j = [[c.ball(self._bits) for c in row] for row in slice_map.singular.coefficients]
        self._scales: dict[int, list[arb]] = {}

    def cusps(self, length: Fraction, boxes: Sequence[NearPose], exponent: int) -> list[Cusp] | None:
        """The cusps in some boxes of a slice, in decimals; None if one is not decided.

        Args:
            length: the *scaled* L.
            boxes: one for each cusp.
            exponent: the numbers of the boxes are for lengths divided by 2^exponent.
        """
        if not boxes:
            return []
        with ctx.workprec(self._bits):
            ball = ball_of(length)
            far = [x.u_inverse and _NEAR * abs(x.u) < 1 for x in boxes]
            us = self._us(ball, boxes, far)
            ts = us and self._ts(ball, boxes, far, us)
            if not (us and ts):
                return None
            ctx.prec = self._bits_of_decimals
            decimals = SliceDecimals(self._maps, ball, self._digits)
            wider = self._wider
            cusps: list[Cusp] = []
            for box, t, u, is_far in zip(boxes, ts, us, far, strict=True):
                pose = HalfAngle(t + wider, box.t_inverse), HalfAngle(u + wider, is_far)
                degrees = decimals.degrees(*pose)
                texts = degrees and decimals.texts(degrees, decimals.pose(*pose))
                if not texts:
                    return None
                proof = self._proof(box, exponent)
                if not proof:
                    return None
                cusps.append((joint_point(texts, self._leg), proof))
            return cusps

    def _us(self, length: arb, boxes: Sequence[NearPose], far: list[bool]) -> list[arb] | None:
        """The roots u of Q in the boxes, or 1/u if they are far."""
        powers = [arb(1), length]
        for k in range(2, DEGREE_L + 1):
            powers.append(powers[k // 2] * powers[(k + 1) // 2])
        coefficients = (self._q * arb_mat(DEGREE_L + 1, 1, powers)).entries()
        straight = _with_slope(coefficients)
        reverse = _with_slope(coefficients[::-1]) if any(far) else straight
        starts = []
        for x, is_far in zip(boxes, far, strict=True):
            start = arb(x.u, x.u_reach)
            starts.append(_ONE / start if x.u_inverse and not is_far else start)
        return self._sharpened(starts, [reverse if is_far else straight for is_far in far])

    def _ts(self, length: arb, boxes: Sequence[NearPose], far: list[bool], us: list[arb]) -> list[arb] | None:
        """The roots t of J in the boxes above roots u, or 1/t."""
        straight = [row[0] if len(row) == 1 else row[0] + row[1] * length for row in self._j]
        reverse = [_reversed(row) for row in straight] if any(far) else straight
        above = []
        for x, is_far, u in zip(boxes, far, us, strict=True):
            j = [row(u) for row in (reverse if is_far else straight)]
            above.append(_with_slope(j[::-1] if x.t_inverse else j))
        return self._sharpened([arb(x.t, x.t_reach) for x in boxes], above)

    def _sharpened(self, roots: list[arb], polynomials: list[tuple[arb_poly, arb_poly]]) -> list[arb] | None:
        """Small balls of the roots in some balls, of polynomials with their slopes; None if that fails."""
        for bits in (*self._precisions, self._bits):
            if bits == self._bits and all(x.rad() < self._goal for x in roots):
                break
            ctx.prec = bits // 2 + _ABOVE_TARGET
            slopes = [slope(x) for x, (_, slope) in zip(roots, polynomials, strict=True)]
            ctx.prec = bits
            middles = [x.mid() for x in roots]
            roots = [
                middle - polynomial(middle) / slope
                for middle, slope, (polynomial, _) in zip(middles, slopes, polynomials, strict=True)
            ]
        ctx.prec = self._bits
        return roots if all(x.rad() < self._goal for x in roots) else None

    def _proof(self, box: NearPose, exponent: int) -> dict[str, str] | None:
        """The numbers of the certificate, if both bounds of each are one text, as is then all between."""
        if exponent not in self._scales:
            units = (arb(2) ** (exponent * dimension) for dimension in PROOFS.values())
            self._scales[exponent] = [arb(x, x * _INEXACT) for x in units]
        bounds, proof = iter(box.numbers), {}
        for name, scale in zip(PROOFS, self._scales[exponent], strict=True):
            text = (scale * next(bounds)).str(5)
            if (scale * next(bounds)).str(5) != text:
                return None
            proof[name] = text
        return proof


def _with_slope(coefficients: list[arb]) -> tuple[arb_poly, arb_poly]:
    polynomial = arb_poly(coefficients)
    return polynomial, polynomial.derivative()


def _reversed(polynomial: arb_poly) -> arb_poly:
    """A coefficient of J in 1/u."""
    return arb_poly([polynomial[_DEGREE_OF_J - k] for k in range(_DEGREE_OF_J + 1)])
