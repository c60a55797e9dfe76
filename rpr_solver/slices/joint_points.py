"""Points of a slice in decimals: from balls or exact poses to digits that are proved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.exact.decimals import angle_text, digit_bits, round_ball, round_fraction, sorted_by_balls
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.model.classify import PoseKind
from rpr_solver.slices.by_balls import CuspBalls, CuspProof
from rpr_solver.slices.by_fields import ExactPose


@dataclass(frozen=True)
class JointPoint:
    """A point of a slice as correctly rounded decimals: angles in degrees, lengths in the user's unit.

    ``theta_deg`` is the angle of the fixed leg; ``first`` and ``second`` are the lengths of the
    other two legs in the order of their numbers.
    """

    alpha_deg: str
    theta_deg: str
    first: str
    second: str

    def to_json(self, fixed_leg: int) -> dict[str, str]:
        """The contract's object: ``alpha_deg``, ``theta1_deg``, ``l2``, ``l3`` for leg 1."""
        first, second = free_legs(fixed_leg)
        return {
            "alpha_deg": self.alpha_deg,
            f"theta{fixed_leg}_deg": self.theta_deg,
            f"l{first}": self.first,
            f"l{second}": self.second,
        }

    @classmethod
    def from_json(cls, obj: Mapping[str, str], fixed_leg: int) -> JointPoint:
        """The inverse of :meth:`to_json`; other members are passed over."""
        first, second = free_legs(fixed_leg)
        return cls(obj["alpha_deg"], obj[f"theta{fixed_leg}_deg"], obj[f"l{first}"], obj[f"l{second}"])


def free_legs(fixed_leg: int) -> tuple[int, int]:
    """The other two legs, in the order of their numbers."""
    first, second = (leg for leg in (1, 2, 3) if leg != fixed_leg)
    return first, second


@dataclass(frozen=True)
class ClassifiedPoint:
    """A point of a slice, what it is, and what proves that; with its sort key (θ, α in degrees) as balls."""

    kind: PoseKind
    theta: arb
    alpha: arb
    point: JointPoint
    proof: Mapping[str, str]
    bits: int


def point_of_balls(cusp: CuspBalls, digits: int, bits: int) -> ClassifiedPoint | None:
    """A proved cusp in decimals; None where the balls, of working precision ``bits``, are too wide."""
    balls = (cusp.alpha_deg, cusp.theta_deg, cusp.first, cusp.second)
    texts = [round_ball(x, digits) for x in balls]
    if None in texts:
        return None
    return ClassifiedPoint(
        PoseKind.CUSP, cusp.theta_deg, cusp.alpha_deg, joint_point(texts), _proof_json(cusp.proof), bits
    )


def point_of_pose(pose: ExactPose, digits: int) -> ClassifiedPoint:
    """A classified exact pose in decimals.

    Raises:
        Unproved: the digits could not be decided.
    """
    exact: list[Fraction | None] = [None, None, *pose.exact_lengths()]

    def decimals(bits: int) -> ClassifiedPoint | None:
        balls = pose.coordinates(bits)
        with ctx.workprec(bits):
            texts = [
                round_fraction(x, digits) if x is not None else round_ball(ball, digits)
                for x, ball in zip(exact, balls, strict=True)
            ]
        if None in texts:
            return None
        proof = {"field_degree": str(pose.u.field.degree)}
        return ClassifiedPoint(pose.kind, balls[1], balls[0], joint_point(texts), proof, bits)

    message = f"the digits of a {pose.kind or 'pose'} could not be decided"
    return decided(decimals, digit_bits(digits) + 128, GREATEST_BITS, message)


def in_order(points: Iterable[ClassifiedPoint]) -> list[ClassifiedPoint]:
    """By the fixed leg's angle, then by α."""
    return sorted_by_balls(points, lambda point: (point.theta, point.alpha))


def cusps_and_degenerate(
    points: Iterable[ClassifiedPoint], fixed_leg: int
) -> tuple[list[ClassifiedPoint], list[dict[str, str]]]:
    """The cusps among classified points, and the others as the contract's objects."""
    cusps, degenerate = [], []
    for x in points:
        if x.kind is PoseKind.CUSP:
            cusps.append(x)
        else:
            degenerate.append({"kind": x.kind.value, **x.point.to_json(fixed_leg)})
    return cusps, degenerate


def joint_point(texts: Sequence[str | None]) -> JointPoint:
    """The point with these rounded angles and lengths."""
    alpha, theta, first, second = (text or "" for text in texts)
    return JointPoint(angle_text(alpha), angle_text(theta), first, second)


def _proof_json(proof: CuspProof) -> dict[str, str]:
    return {
        "rank_1": proof.rank.str(5),
        "grad_J": proof.gradient.str(5),
        "v_grad_E": proof.transversal.str(5),
    }
