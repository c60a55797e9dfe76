"""Many slices of one manipulator: what is quickly proved for all at once, and its decimals.

It is proved modulo a prime that Q has 24 simple roots and no spurious one; by discs in double precision that
enough of them are not real (mathematics.md#laguerres-discs); and by floats with bounds of their errors that a
pose is above each of the others (mathematics.md#poses-by-floats). A slice not decided so, as near a
transition, is left to the reference. Decimals are correctly rounded in any case, so the document is the same
byte for byte.

The decimals come from boxes that doubles prove to hold one cusp each (proofs.py, sharpener.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat, arb_poly, ctx, nmod, nmod_mat, nmod_poly

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.joint_points import JointPoint
from rpr_solver.slices.decimals import HalfAngle
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant
from rpr_solver.slices.fast.poses import root_powers
from rpr_solver.slices.fast.proofs import NearPose, guesses, proved_boxes
from rpr_solver.slices.sharpener import PoseSharpener, near_start
from rpr_solver.slices.slice_table import SliceTable, slice_certificate


class _Forms:
    """Q and J of all slices, in balls, with half tangents in the unit 1 in place of 1/√ρ."""

    def __init__(self, eliminant: Eliminant, bits: int) -> None:
        slice_map = eliminant.slice_map
        with ctx.workprec(bits):
            omega, weights = omega_ball(slice_map.radicand, bits), root_powers(slice_map.rho, DEGREE_U)
            self._q = arb_mat(eliminant.a) + arb_mat(eliminant.b) * omega
            self._j = [[c.ball(bits) for c in row] for row in slice_map.singular.coefficients]
            if slice_map.rho > 1:
                rows = zip(self._q.tolist(), weights, strict=True)
                self._q = arb_mat([[x / weight for x in row] for row, weight in rows])
                self._j = [
                    [arb_poly([x / weights[i + k] for k, x in enumerate(c.coeffs())]) for c in row]
                    for i, row in enumerate(self._j)
                ]

    def at(self, length: arb) -> tuple[list[arb], list[arb_poly]]:
        """The coefficients of Q, and those of t⁰, t¹, … of J, at one *scaled* L."""
        powers = [arb(1), length]
        for k in range(2, DEGREE_L + 1):
            powers.append(powers[k // 2] * powers[(k + 1) // 2])
        q = (self._q * arb_mat(DEGREE_L + 1, 1, powers)).entries()
        # J of flat congruent triangles does not hold L
        return q, [row[0] if len(row) == 1 else row[0] + row[1] * length for row in self._j]


BLOCK = 256
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
        self._sharpener = PoseSharpener(eliminant.slice_map, digits)
        self._forms = _Forms(eliminant, self._sharpener.bits)
        self._residues = _Residues(eliminant)
        self._boxes: dict[int, list[NearPose] | None] = {}

    def table(self, place: int) -> SliceTable | None:
        """The table of the slice at a place among the lengths; None if it is left to the reference."""
        if not self._residues.is_generic(self._scaled[place]):
            return None
        if place not in self._boxes:
            self._prove_block(place - place % BLOCK)
        boxes = self._boxes[place]
        if boxes is None:
            return None
        cusps = self.cusps(self._scaled[place], boxes)
        if cusps is None:
            return None
        leg, length = self.eliminant.slice_map.fixed_leg, self.lengths[place]
        certificate = slice_certificate(leg, [(DEGREE_U, 1)], len(boxes), "balls")
        return SliceTable(leg, length, self.digits, tuple(cusps), (), certificate)

    def cusps(self, length: Fraction, boxes: Sequence[NearPose]) -> list[JointPoint] | None:
        """The cusps in boxes of the slice of a *scaled* L, in decimals; None if one is not decided."""
        if not boxes:
            return []
        with ctx.workprec(self._sharpener.bits):
            ball = ball_of(length)
            q, j = self._forms.at(ball)
            thetas = self._sharpener.thetas(
                q, [near_start(arb(x.u, x.u_reach), inverse=x.u_inverse) for x in boxes]
            )
            starts = [HalfAngle(arb(x.t, x.t_reach), x.t_inverse) for x in boxes]
            alphas = thetas and self._sharpener.alphas(j, thetas, starts)
            return self._sharpener.points(ball, alphas, thetas) if alphas and thetas else None

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


class _Residues:
    """Q, w and q modulo a prime."""

    def __init__(self, eliminant: Eliminant) -> None:
        f, rho = eliminant.slice_map.f, eliminant.slice_map.rho
        self._p, omega, self._q = eliminant.residues
        self._along = f.collinear.residue(self._p, omega)
        self._along_or_circular = self._along * nmod_poly([1, 0, rho], self._p)
        x, y = (nmod(z.times(1, omega), self._p) for z in f.base)
        self._sides, self._base, self._rho = nmod(f.base2 - f.platform2, self._p), (2 * x, -4 * rho * y), rho

    def is_generic(self, length: Fraction) -> bool:
        """Proof for a *scaled* L: Q has 24 finite simple roots, none spurious, and w and q no common one."""
        p = self._p
        if length.denominator % p == 0:
            return False
        x = nmod(length.numerator, p) / nmod(length.denominator, p)
        powers = [nmod(1, p)]
        for _ in range(DEGREE_L):
            powers.append(powers[-1] * x)
        q = nmod_poly((self._q * nmod_mat(DEGREE_L + 1, 1, powers, p)).entries(), p)
        even, (cos, sin) = powers[2] + self._sides, self._base
        closed = nmod_poly([even - x * cos, x * sin, (even + x * cos) * self._rho], p)
        if q.degree() != DEGREE_U or closed.degree() != 2:
            return False
        pairs = (self._along, closed), (q, q.derivative()), (q, self._along_or_circular * closed)
        return all(first.gcd(second).degree() == 0 for first, second in pairs)
