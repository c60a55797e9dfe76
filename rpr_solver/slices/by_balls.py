"""From a root u of the eliminant to the pose, its joint point, and the proof that it is a cusp, by balls."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.exact.decimals import round_all
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.half_tangent import HalfTangent, common_root, pose_of
from rpr_solver.model.jets import LocalMap
from rpr_solver.model.joint_points import ClassifiedPoint, joint_point
from rpr_solver.model.slice_map import SliceMap


@dataclass(frozen=True)
class CuspBalls:
    """A cusp as balls, in the user's unit, with the numbers that prove it."""

    alpha_deg: arb
    theta_deg: arb
    first: arb
    second: arb
    proof: dict[str, arb]
    """Balls that exclude zero where a cusp needs it (:class:`~rpr_solver.PoseKind`), by their names in the
    certificate; lengths are scaled."""


def point_of_balls(cusp: CuspBalls, fixed_leg: int, digits: int, bits: int) -> ClassifiedPoint | None:
    """A proved cusp in decimals; None if the balls, of working precision ``bits``, are too wide."""
    texts = round_all((cusp.alpha_deg, cusp.theta_deg, cusp.first, cusp.second), digits)
    if texts is None:
        return None
    point, proof = joint_point(texts, fixed_leg), {name: x.str(5) for name, x in cusp.proof.items()}
    return ClassifiedPoint(PoseKind.CUSP, cusp.theta_deg, cusp.alpha_deg, point, proof, bits)


class SlicePoses:
    """The slice of one *scaled* L at one working precision: poses from roots."""

    def __init__(self, slice_map: SliceMap, length: Fraction, bits: int) -> None:
        self.slice_map = slice_map
        self.bits = bits
        self._singular = [p.ball(bits) for p in slice_map.singular.at(length)]
        self._coalescence = [p.ball(bits) for p in slice_map.coalescence.at(length)]
        with ctx.workprec(bits):
            self.length = ball_of(length)
            self.scale = slice_map.scale_ball()
            self.omega = omega_ball(slice_map.radicand, bits)

    def alpha(self, u: arb) -> HalfTangent | None:
        """tan(α/2) of the unique pose above a simple root u; None if the precision is insufficient."""
        j = [p(u) for p in self._singular]
        e = [p(u) for p in self._coalescence]
        return common_root(j, e)

    def local_map(self, u: arb, t: HalfTangent, order: int) -> LocalMap[arb]:
        """The jets at the pose (t, u)."""
        pose = pose_of(t, HalfTangent(u, arb(1)), self.length, self.omega)
        return LocalMap.at(self.slice_map, pose, order)

    def cusp(self, u: arb, t: HalfTangent) -> CuspBalls | None:
        """The cusp at (t, u), or None if a ball is too wide to prove it."""
        local = self.local_map(u, t, 3)
        j = local.singularity()
        e = local.along(local.f, j)
        proof = {
            "rank_1": _larger(local.f.alpha.value, local.f.theta.value),  # the map has rank 1
            "grad_J": _larger(j.alpha.value, j.theta.value),  # the singular curve is smooth
            "v_grad_E": local.along(local.f, e).value,  # exactly three poses coalesce
        }
        f, g = local.squared_lengths()
        # a ball of t cannot decide between 180° and −180°
        if any(x.contains(0) for x in (t.denominator, *proof.values())) or not (f > 0 and g > 0):
            return None
        theta = HalfTangent(u, arb(1))
        return CuspBalls(t.degrees(), theta.degrees(), f.sqrt() / self.scale, g.sqrt() / self.scale, proof)


def _larger(x: arb, y: arb) -> arb:
    return x if x.abs_lower() >= y.abs_lower() else y
