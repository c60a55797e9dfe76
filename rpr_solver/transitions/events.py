"""Events: lengths of the fixed leg at which the number of cusps may change, with their degenerate poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_all, round_fraction
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.precision import GREATEST_BITS, TIMES_BEFORE_EXACT, decided
from rpr_solver.model.classify import ExactPose, PoseKind
from rpr_solver.model.joint_points import JointPoint, joint_point, point_of_pose
from rpr_solver.model.slice_map import SliceMap

Coordinates = tuple[arb, arb, arb, arb]
"""α and θ in degrees, and the free legs in the user's unit."""


@dataclass(frozen=True)
class BallPose:
    """The degenerate pose of an event: its kind, and its coordinates as balls at a precision in bits."""

    kind: PoseKind
    coordinates: Callable[[int], Coordinates]
    exact: Callable[[], ExactPose]
    """The same pose in a number field."""


class Event(Protocol):
    """A length L at which the number of cusps may change (scaled units)."""

    @property
    def pose(self) -> ExactPose | BallPose | None:
        """The degenerate pose; None if only the length is known."""

    @property
    def exact_length(self) -> Algebraic | None:
        """L (scaled) as an algebraic number, or None if it is only known by balls."""

    @property
    def lasting(self) -> bool:
        """Whether neighbouring slices have a degenerate pose of the same kind beside this one."""

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""


@dataclass(frozen=True)
class Landmark:
    """A length, exact, at which the number of cusps may change, with its degenerate pose if one is known."""

    exact_length: Algebraic
    pose: ExactPose | None = None
    lasting: bool = False

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self.exact_length.ball(bits)


def length_text(slice_map: SliceMap, group: Sequence[Event], digits: int) -> str:
    """The length of simultaneous events as a correctly rounded decimal in the user's unit."""
    for event in group:
        if event.exact_length is not None and event.exact_length.rational is not None:
            return round_fraction(event.exact_length.rational / slice_map.scale, digits)

    def length(bits: int) -> list[arb]:
        ball = group[0].scaled_length(bits)
        with ctx.workprec(bits):
            return [ball / slice_map.scale_ball()]

    return _rounded(length, digits, GREATEST_BITS)[0]


def event_point(pose: ExactPose | BallPose, fixed_leg: int, digits: int) -> JointPoint:
    """The degenerate pose of an event."""
    if isinstance(pose, ExactPose):
        return point_of_pose(pose, digits).point
    try:
        texts = _rounded(pose.coordinates, digits, TIMES_BEFORE_EXACT * digit_bits(digits))
        return joint_point(texts, fixed_leg)
    except Unproved:
        return point_of_pose(pose.exact(), digits).point


def _rounded(balls: Callable[[int], Sequence[arb]], digits: int, limit: int) -> list[str]:
    def texts(bits: int) -> list[str] | None:
        values = balls(bits)
        with ctx.workprec(bits):
            return round_all(values, digits)

    return decided(texts, digit_bits(digits) + 128, limit, "the digits of a transition could not be decided")
