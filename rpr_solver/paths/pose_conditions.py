"""How well conditioned the poses of a joint vector are, and how far they are from singular ones.

The angles of the poses are found with more digits until the condition numbers
(:mod:`rpr_solver.model.conditioning`) are decided. The clearance is that of paths (paths.md#samples), with
leg 1 held: α and θ1 may change together by less, and no singular pose is met. It is the radius of a disc of
poses in which boxes prove that J has no zero, or that which the derivatives of J prove, if that is greater.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import degrees

import numpy as np
from flint import acb, arb, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.decimals import digit_bits, round_ball, round_down
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import Exact, rational_sqrt
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.conditioning import Invariants, Pair, arms, scale_of
from rpr_solver.model.fibre import Closure, DecimalPose, fibre
from rpr_solver.model.given_poses import enclosed
from rpr_solver.model.pose_table import PoseTable
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import BOUND_DIGITS, PROOF_BITS
from rpr_solver.paths.routes import local_map
from rpr_solver.paths.samples import clearance_of
from rpr_solver.paths.singular_field import DEGREE, Pieces, SingularField, Tube
from rpr_solver.triangles import Surd

_SPARE_BITS = 64
_STRAY = 1e-12
"""In degrees, more than what an angle of a pose is rounded by as a double."""
_SHARE = 0.999
"""Of what the derivatives prove, which boxes are tried with first."""
_CLOSE = 1.01
"""How much wider a disc is that is no longer tried."""
_WIDEST = 180.0
"""In degrees; no disc is tried that is wider."""


def with_condition(table: PoseTable, length_scale: Exact | None = None) -> PoseTable:
    """The same table, each pose with its condition number and its clearance.

    Both have their meaning at the top of :mod:`rpr_solver.model.conditioning` and of this module. A pose of
    multiplicity 2 or more is singular: its condition number is infinite (None), its clearance 0.

    Args:
        table: all poses of a joint vector (:func:`~rpr_solver.model.pose_table.poses`).
        length_scale: λ, by which rotations are measured, exact, > 0, in the user's unit; the radius of
            gyration of the platform's joints unless given.

    Raises:
        InputError: naming ``length_scale``.
        SolverError: digits could not be proved.

    >>> from rpr_solver import EXAMPLES, poses
    >>> table = with_condition(poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15))
    >>> [(pose.condition, pose.clearance_deg) for pose in table.poses]
    [('1.71349566770790', '31.2997'), ('3.67245238857095', '51.6266')]
    """
    return _Conditions(table, scale_of(table.manipulator, length_scale)).whole()


class _Conditions:
    def __init__(self, table: PoseTable, scale: Surd) -> None:
        self.table, self.scale = table, scale
        self.slice_map = SliceMap.of(table.manipulator, with_shared=True)
        self.closure = Closure.of(self.slice_map, table.squares)

    def whole(self) -> PoseTable:
        """The table with all numbers."""
        bits = digit_bits(self.table.digits) + _SPARE_BITS
        message = "the digits of a condition number could not be proved"
        texts = decided(self._texts, bits, GREATEST_BITS, message)
        poses = tuple(
            replace(pose, condition=text, clearance_deg=clearance)
            for pose, (text, clearance) in zip(self.table.poses, texts, strict=True)
        )
        return replace(self.table, poses=poses, length_scale=str(self.scale))

    def _texts(self, bits: int) -> list[tuple[str | None, str]] | None:
        """Both numbers of all poses; None if the digits of their angles do not decide them."""
        found: list[tuple[str | None, str]] = []
        for pose in fibre(self.closure, bits * 1000 // 3322).poses:
            if pose.multiplicity > 1:
                found.append((None, "0"))
                continue
            with ctx.workprec(bits + _SPARE_BITS):
                text = round_ball(self._invariants(pose).condition(), self.table.digits)
                clearance = self._clearance(pose) if text else None
            if text is None or clearance is None:
                return None
            found.append((text, clearance))
        return found

    def _invariants(self, pose: DecimalPose) -> Invariants:
        degree = arb.pi() / 180
        alpha, *thetas = (enclosed(text) * degree for text in pose.texts[:4])
        omega, turn = omega_ball(self.slice_map.radicand, ctx.prec), acb(0, alpha).exp()
        first, second = (_pair(turn * leg.points(omega)[0]) for leg in (self.slice_map.f, self.slice_map.g))
        directions = [(sin_cos[1], sin_cos[0]) for sin_cos in (theta.sin_cos() for theta in thetas)]
        return Invariants.of(directions, arms(first, second), self.scale.ball() * self.slice_map.scale_ball())

    def _clearance(self, pose: DecimalPose) -> str | None:
        """The clearance in degrees, rounded down; None if J may be 0."""
        angles = tuple(enclosed(text) * arb.pi() / 180 for text in pose.texts[:2])
        square = self.closure.squares[0]
        length = ball_of(square).sqrt()
        j = local_map(self.slice_map, length, (angles[0], angles[1]), 2).singularity()
        least = (clearance_of(self.slice_map, length, j) * 180 / arb.pi()).lower()
        if not least > 0:
            return None
        exact = rational_sqrt(square)
        if exact is not None:
            least = least.max(
                arb(_disc(self.slice_map, exact, angles, 1 if j.value > 0 else -1, float(least)))
            )
        return round_down(least, BOUND_DIGITS)


def _pair(z: acb) -> Pair:
    return z.real, z.imag


def _disc(slice_map: SliceMap, length: Fraction, angles: Sequence[arb], sign: int, known: float) -> float:
    """The radius in degrees of a disc round a pose in which boxes prove that J has a sign; 0 if they prove
    none. ``known`` is a radius that is proved otherwise, nearly."""
    with ctx.workprec(PROOF_BITS):
        field = SingularField.of(slice_map, length, sign)
    spot = np.array([[degrees(float(angle)) for angle in angles]])
    pieces = Pieces.of(spot, spot, np.full((1, 2), _STRAY))

    def is_proved(radius: float) -> bool:
        return Tube.proved(field, pieces, radius * DEGREE) is not None

    proved, tried = 0.0, _SHARE * known
    while tried < _WIDEST and is_proved(tried):
        proved, tried = tried, 2 * tried
    # Invariant: a disc of the radius ``proved`` is proved, or it is 0; one of ``tried`` is not. It ends as
    # their ratio falls with each step.
    while proved and tried > proved * _CLOSE:
        middle = (proved + tried) / 2
        if is_proved(middle):
            proved = middle
        else:
            tried = middle
    return proved
