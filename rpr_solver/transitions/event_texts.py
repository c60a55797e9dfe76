"""The lengths and poses of events as correctly rounded decimals in the user's unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_all, round_fraction
from rpr_solver.exact.precision import GREATEST_BITS, TIMES_BEFORE_EXACT, decided
from rpr_solver.model.exact_pose import ExactPose
from rpr_solver.model.joint_points import JointPoint, joint_point, point_of_pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_types import BallPose, Event


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
