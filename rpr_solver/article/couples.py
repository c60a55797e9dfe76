"""Step 7 of the article's algorithm: whether a couple (α, θ1) that solves (13) and (14) is a cusp, and why.

The article calls a common solution (t, u) of its two equations a couple.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypedDict

from flint import acb_poly, arb, arb_poly, ctx

from rpr_solver.article.eliminant import LEG_ALONG, Legs, Vector, adjugate
from rpr_solver.exact.decimals import round_all, round_ball
from rpr_solver.exact.factors import FactorShape
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Leg
from rpr_solver.model.jets import HalfTangent, LocalMap, pose_of
from rpr_solver.model.joint_points import ClassifiedPoint, ExactPose, PoseKind, joint_point, point_of_pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.grid import larger
from rpr_solver.slices.reference import SlicePoses


class CoupleReport(TypedDict):
    """A couple (α, θ1) above a real root; its verdict is ``"kept"``, ``"degenerate"`` or ``"rejected"``."""

    alpha_deg: str
    theta1_deg: str
    verdict: str
    reason: str


class FactorReport(TypedDict):
    """A factor of the eliminant: its origin, the reason for it, and the couples above its real roots.

    ``irreducible`` are its own factors over the field of coefficients.
    ``rejected_in_step_6`` counts the real solutions of (13) that violate (14); None if they were not counted.
    """

    origin: str
    degree: int
    multiplicity: int
    irreducible: list[FactorShape]
    reason: str
    real_roots: int
    rejected_in_step_6: int | None
    couples: list[CoupleReport]


class Conjecture(TypedDict):
    """Whether all cusps of the slice belong to the factor of degree 24, as the article conjectures."""

    holds: bool
    answer: str


class AuditReport(TypedDict):
    """The article's steps 1 to 7: the equations, the eliminant's factors, and the conjecture."""

    equations: str
    eliminant_degree: int
    h: str
    factors: list[FactorReport]
    conjecture: Conjecture


KEPT, DEGENERATE, REJECTED = "kept", "degenerate", "rejected"
_TRIPLE = "three direct kinematic solutions coincide"
_SHOWN_DIGITS = 15


def _report(alpha: str, theta1: str, verdict: str, reason: str) -> CoupleReport:
    return {"alpha_deg": alpha, "theta1_deg": theta1, "verdict": verdict, "reason": reason}


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


class CouplePoses(SlicePoses):
    """Also the derivatives at the pose above a root, and the proof that it is a cusp."""

    def __init__(self, slice_map: SliceMap, length: Fraction, bits: int) -> None:
        super().__init__(slice_map, length, bits)
        self.slice_map, self.bits = slice_map, bits
        with ctx.workprec(bits):
            self.length = ball_of(length)
            self.scale = slice_map.scale_ball()
            self.omega = omega_ball(slice_map.radicand, bits)

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
            "rank_1": larger(local.f.alpha.value, local.f.theta.value),  # the map has rank 1
            "grad_J": larger(j.alpha.value, j.theta.value),  # the singular curve is smooth
            "v_grad_E": local.along(local.f, e).value,  # exactly three poses coalesce
        }
        f, g = local.squared_lengths()
        # a ball of t cannot decide between 180° and −180°
        if any(x.contains(0) for x in (t.denominator, *proof.values())) or not (f > 0 and g > 0):
            return None
        theta = HalfTangent(u, arb(1))
        return CuspBalls(t.degrees(), theta.degrees(), f.sqrt() / self.scale, g.sqrt() / self.scale, proof)


def couple_by_balls(cusp: CuspBalls) -> CoupleReport:
    """The couple of a proved cusp."""
    alpha, theta = (round_ball(x, _SHOWN_DIGITS) or x.str(5) for x in (cusp.alpha_deg, cusp.theta_deg))
    return _report(alpha, theta, KEPT, _TRIPLE)


def rejected_by_balls(
    local: LocalMap[arb], u: arb, t: HalfTangent, closed_leg: int | None
) -> CoupleReport | None:
    """Rejects a couple for which E ≠ 0 is proved, with the reason; None if the balls do not decide it.

    The couple must satisfy (13) and (14). If E ≠ 0 there, (10) can only hold because the first row or column
    of (8) vanishes; if that needs every kᵢ that is not proved to be nonzero, these kᵢ are 0.
    ``closed_leg`` is a leg of length zero.
    """
    j = local.singularity()
    if all(local.along(leg, j).value.contains(0) for leg in (local.f, local.g)):
        return None
    legs = _legs(local, arb(1))
    zero = {i for i, k in legs.k.items() if k.contains(0)}
    if not _vanishing(zero) or any(_vanishing(zero - {i}) for i in zero):
        return None
    texts = round_all((t.degrees(), HalfTangent(u, arb(1)).degrees()), _SHOWN_DIGITS)
    if texts is None or t.denominator.contains(0):
        return None
    reasons = [] if closed_leg is None else [f"leg {closed_leg} has length zero"]
    return _report(texts[0], texts[1], REJECTED, _because(reasons, zero))


def adjugate_stands(local: LocalMap[arb]) -> bool:
    """Proves that neither the first row nor the first column of (8) vanishes; then (10) is (7)."""
    adj = adjugate(_legs(local, arb(1)).k)
    row, column = adj[0], [line[0] for line in adj]
    return all(any(not x.contains(0) for x in part) for part in (row, column))


def exact_couple(exact: ExactPose, digits: int) -> tuple[CoupleReport, ClassifiedPoint | None]:
    """Reports on a couple in a number field; also its point, unless it is rejected."""
    kind, local = exact.kind, exact.local
    shown = point_of_pose(exact, _SHOWN_DIGITS).point
    if kind is PoseKind.ORDINARY:
        squares = enumerate(local.squared_lengths(), 2)
        closed = [f"leg {leg} has length zero" for leg, square in squares if square.is_zero]
        k = _legs(local, exact.length.field(1)).k
        reason = _because(closed, {i for i, x in k.items() if x.is_zero})
        return _report(shown.alpha_deg, shown.theta1_deg, REJECTED, reason), None
    verdict, reason = (KEPT, _TRIPLE) if kind is PoseKind.CUSP else (DEGENERATE, kind.value)
    return _report(shown.alpha_deg, shown.theta1_deg, verdict, reason), point_of_pose(exact, digits)


def count_real(coefficients: Sequence[arb]) -> int | None:
    """The number of real roots of a polynomial with simple roots; None if the balls do not decide it."""
    if not coefficients or coefficients[-1].contains(0):
        return None
    try:
        roots = acb_poly(arb_poly(list(coefficients))).roots()
    except ValueError:
        return None
    real = [root for root in roots if root.imag.contains(0)]
    alone = all(not root.conjugate().overlaps(x) for root in real for x in roots if x is not root)
    return len(real) if alone else None


def _legs(local: LocalMap[Any], one: Any) -> Legs:
    """(12): the leg vectors of a pose, in any ring."""
    pose = local.pose
    cos, sin, omega = pose.cos_alpha, pose.sin_alpha, pose.omega
    b1 = pose.length * pose.cos_theta, pose.length * pose.sin_theta

    def vector(leg: Leg) -> Vector:
        x, y = leg.rotated(cos, sin, omega)
        return b1[0] + x - leg.ax, b1[1] + y - leg.ay

    f, g = local.slice_map.f, local.slice_map.g
    return Legs((b1, vector(f), vector(g)), f.ax, g.ax, g.ay, one)


def _vanishing(zero: Collection[int]) -> list[str]:
    """Which of the adjugate's first row and first column vanish if just these kᵢ are 0."""
    adj = adjugate({i: 0 if i in zero else 1 for i in LEG_ALONG})
    parts = {"row": adj[0], "column": [line[0] for line in adj]}
    return [name for name, entries in parts.items() if not any(entries)]


def _because(reasons: list[str], zero: Collection[int]) -> str:
    """Why (14) holds without three solutions coinciding: the given reasons, else the kᵢ that are 0."""
    parts = _vanishing(zero)
    if parts and not reasons:
        where = ", ".join(LEG_ALONG[i] for i in sorted(zero))
        names = " = ".join(f"k{i}" for i in sorted(zero))
        verb = "vanishes" if len(parts) == 1 else "vanish"
        reasons = [f"{names} = 0 ({where}), so the adjugate's first {' and '.join(parts)} {verb}"]
    return "; ".join([*reasons, "v.grad J != 0: only two solutions coincide"])
