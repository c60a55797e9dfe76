"""Points of a slice in decimals: from balls or exact poses to digits that are proved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cmp_to_key

from flint import arb, ctx

from rpr_solver.exact.decimals import digit_bits, round_ball, round_fraction
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.model.classify import CUSP
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
class Found:
    """A classified point with its sort key (θ, α in degrees)."""

    kind: str
    theta: arb
    alpha: arb
    point: JointPoint
    proof: Mapping[str, str]
    bits: int


def found_by_balls(cusp: CuspBalls, digits: int, bits: int) -> Found | None:
    """A proved cusp in decimals; None where the balls, of working precision ``bits``, are too wide."""
    balls = (cusp.alpha_deg, cusp.theta_deg, cusp.first, cusp.second)
    texts = [round_ball(x, digits) for x in balls]
    if None in texts:
        return None
    return Found(CUSP, cusp.theta_deg, cusp.alpha_deg, joint_point(texts), _proof_json(cusp.proof), bits)


def found_exactly(pose: ExactPose, digits: int) -> Found:
    """A classified exact pose in decimals.

    Raises:
        Unproved: the digits could not be decided.
    """
    exact: list[Fraction | None] = [None, None, *pose.exact_lengths()]

    def decimals(bits: int) -> Found | None:
        balls = pose.coordinates(bits)
        with ctx.workprec(bits):
            texts = [
                round_fraction(x, digits) if x is not None else round_ball(ball, digits)
                for x, ball in zip(exact, balls, strict=True)
            ]
        if None in texts:
            return None
        proof = {"field_degree": str(pose.u.field.degree)}
        return Found(pose.kind, balls[1], balls[0], joint_point(texts), proof, bits)

    message = f"the digits of a {pose.kind} could not be decided"
    return decided(decimals, digit_bits(digits) + 128, GREATEST_BITS, message)


def in_order(found: Iterable[Found]) -> list[Found]:
    """By the fixed leg's angle, then by α."""
    return sorted(found, key=cmp_to_key(_by_angle))


def joint_point(texts: Sequence[str | None]) -> JointPoint:
    """The point with these rounded angles and lengths."""
    alpha, theta, first, second = (text or "" for text in texts)
    return JointPoint(_in_half_open_range(alpha), _in_half_open_range(theta), first, second)


def _in_half_open_range(angle: str) -> str:
    """An angle that rounds to −180 is printed as 180: the table's range is (−180, 180]."""
    return angle[1:] if angle.startswith("-180") else angle


def _proof_json(proof: CuspProof) -> dict[str, str]:
    return {
        "rank_1": proof.rank.str(5),
        "grad_J": proof.gradient.str(5),
        "v_grad_E": proof.transversal.str(5),
    }


def _by_angle(x: Found, y: Found) -> int:
    """Order by θ, then by α; angles whose balls overlap at full precision are equal."""
    for first, second in ((x.theta, y.theta), (x.alpha, y.alpha)):
        if first < second:
            return -1
        if first > second:
            return 1
    return 0
