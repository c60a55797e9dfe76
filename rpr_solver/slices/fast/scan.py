"""Many slices of one manipulator: what is quickly proved for all at once, and its decimals.

It is proved modulo a prime that Q has 24 simple roots and no spurious one; by discs in double precision that
enough of them are not real (mathematics.md#laguerres-discs); and by floats with bounds of their errors that a
pose is above each of the others (mathematics.md#poses-by-floats). A slice not decided so, as near a
transition, is left to the reference. Decimals are correctly rounded in any case, so the document is the same
byte for byte.

The decimals come from boxes that doubles prove to hold one cusp each (proofs.py). In each, interval Newton
steps sharpen u as a root of Q, then t as the root of J above it (mathematics.md#real-roots). Each step about
doubles the bits of the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat, arb_poly, ctx, nmod, nmod_mat, nmod_poly

from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.joint_points import ClassifiedPoint, JointPoint
from rpr_solver.slices.decimals import HalfAngle, PointDecimals
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant
from rpr_solver.slices.fast.poses import root_powers
from rpr_solver.slices.fast.proofs import NearPose, guesses, proved_boxes
from rpr_solver.slices.slice_table import SliceTable, slice_certificate

_BEYOND = 26
"""Bits of a half tangent beyond those of the digits: enough for nearly all decimals."""
_FIRST_TARGET = 92
"""The bits that the first step finds, at least in most cases."""
_ABOVE_TARGET = 64
"""Precision of a Newton step beyond the bits that it is to find."""
_ABOVE_DIGITS = 64
_NEAR = 8
"""Roots beyond are found as 1/u."""
_DEGREE_OF_J = 4
_ONE = arb(1)


class PoseSharpener:
    """From boxes of poses to printed cusps: for all slices of one leg, and one number of digits."""

    def __init__(self, eliminant: Eliminant, digits: int) -> None:
        slice_map = eliminant.slice_map
        targets = [digit_bits(digits) + _BEYOND]
        while targets[-1] > _FIRST_TARGET:
            targets.append(targets[-1] // 2 + 3)
        self._precisions = [x + _ABOVE_TARGET for x in reversed(targets)]
        self._bits, self._bits_of_decimals = self._precisions[-1], digit_bits(digits) + _ABOVE_DIGITS
        self._decimals = PointDecimals(slice_map, digits, self._bits_of_decimals)
        with ctx.workprec(self._bits):
            self._goal = arb(2) ** -targets[0]
            omega = omega_ball(slice_map.radicand, self._bits)
            self._q = arb_mat(eliminant.a) + arb_mat(eliminant.b) * omega
            self._j = [[c.ball(self._bits) for c in row] for row in slice_map.singular.coefficients]
            if slice_map.rho > 1:
                self._measure(slice_map.rho)
        self._bridge = Bridge.of(slice_map)

    def _measure(self, rho: int) -> None:
        """Gives half tangents the unit 1, as in the boxes, in place of 1/√ρ."""
        weights = root_powers(rho, DEGREE_U)
        rows = [[x / weights[k] for x in row] for k, row in enumerate(self._q.tolist())]
        self._q = arb_mat(rows)
        self._j = [
            [arb_poly([x / weights[i + k] for k, x in enumerate(c.coeffs())]) for c in row]
            for i, row in enumerate(self._j)
        ]

    def cusps(self, length: Fraction, boxes: Sequence[NearPose]) -> list[JointPoint] | None:
        """The cusps in some boxes of a slice, in decimals; None if one is not decided.

        Args:
            length: the *scaled* L.
            boxes: one for each cusp.
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
            cusps = []
            for box, t, u, is_far in zip(boxes, ts, us, far, strict=True):
                cusp = self._cusp(ball, HalfAngle(t, box.t_inverse), HalfAngle(u, is_far))
                if cusp is None:
                    return None
                cusps.append(cusp)
            if not self._bridge.is_along:
                cusps.sort(key=lambda cusp: cusp.theta.mid())
            return [cusp.point for cusp in cusps]

    def _cusp(self, length: arb, alpha: HalfAngle, theta: HalfAngle) -> ClassifiedPoint | None:
        """The cusp at these angles of the forms."""
        if self._bridge.is_along:
            return self._decimals.cusp(length, alpha, theta)
        angles = self._bridge.angles_of(alpha.tangent, theta.tangent)
        first, second = (HalfAngle.of(x, self._bits_of_decimals - _ABOVE_DIGITS) for x in angles)
        return first and second and self._decimals.cusp(length, first, second)

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


def _with_slope(coefficients: list[arb]) -> tuple[arb_poly, arb_poly]:
    polynomial = arb_poly(coefficients)
    return polynomial, polynomial.derivative()


def _reversed(polynomial: arb_poly) -> arb_poly:
    """A coefficient of J in 1/u."""
    return arb_poly([polynomial[_DEGREE_OF_J - k] for k in range(_DEGREE_OF_J + 1)])


BLOCK = 128
"""Slices whose poses are proved at once: progress is reported, and memory bounded, in between."""


class Scan:
    """Slices of which a block is proved when the first of it is asked for, and each printed by itself.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.
    """

    def __init__(self, eliminant: Eliminant, lengths: Sequence[Fraction], digits: int) -> None:
        self.eliminant, self.lengths, self.digits = eliminant, lengths, digits
        self._scaled = [x * eliminant.slice_map.scale for x in lengths]
        self._sharpener = PoseSharpener(eliminant, digits)
        self._boxes: dict[int, list[NearPose] | None] = {}

    def table(self, place: int) -> SliceTable | None:
        """The table of the slice at a place among the lengths; None if it is left to the reference."""
        if not _is_generic(self.eliminant, self._scaled[place]):
            return None
        if place not in self._boxes:
            self._prove_block(place - place % BLOCK)
        boxes = self._boxes[place]
        if boxes is None:
            return None
        cusps = self._sharpener.cusps(self._scaled[place], boxes)
        if cusps is None:
            return None
        leg, length = self.eliminant.slice_map.fixed_leg, self.lengths[place]
        certificate = slice_certificate(leg, [(DEGREE_U, 1)], len(boxes), "balls")
        return SliceTable(leg, length, self.digits, tuple(cusps), (), certificate)

    def _prove_block(self, first: int) -> None:
        """Prove the poses of a block of slices; those of the last block are forgotten."""
        lengths = self._scaled[first : first + BLOCK]
        roots = guesses(self.eliminant, lengths)
        boxes = proved_boxes(self.eliminant, lengths, [x.real for x in roots])
        complete = (len(x.real) + 2 * x.inside == DEGREE_U for x in roots)
        self._boxes = {
            place: found if has_all else None
            for place, (found, has_all) in enumerate(zip(boxes, complete, strict=True), first)
        }


def _is_generic(eliminant: Eliminant, length: Fraction) -> bool:
    """Proof modulo a prime that Q has 24 finite simple roots, none spurious, and w and q no common one."""
    f = eliminant.slice_map.f
    p, omega, matrix = eliminant.residues
    if length.denominator % p == 0:
        return False
    x = nmod(length.numerator, p) / nmod(length.denominator, p)
    powers = [nmod(1, p)]
    for _ in range(DEGREE_L):
        powers.append(powers[-1] * x)
    q = nmod_poly((matrix * nmod_mat(DEGREE_L + 1, 1, powers, p)).entries(), p)
    along, closed = f.collinear().residue(p, omega), f.closed(length).residue(p, omega)
    if q.degree() != DEGREE_U or closed.degree() != 2:
        return False
    spurious = along * closed * nmod_poly([1, 0, eliminant.slice_map.rho], p)
    pairs = (along, closed), (q, q.derivative()), (q, spurious)
    return all(first.gcd(second).degree() == 0 for first, second in pairs)
