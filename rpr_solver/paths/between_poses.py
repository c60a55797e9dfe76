"""Two poses of one joint vector: a path between them without a singularity, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any

from flint import arb, ctx

from rpr_solver.contract import (
    DEFAULT_SAMPLES,
    PATH_DIGITS,
    check_digits,
    check_integer,
    check_leg,
    document_head,
)
from rpr_solver.errors import InputError, SolverError, Unproved
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive
from rpr_solver.kinematics.pose_table import PoseTable, poses
from rpr_solver.model.classify import Kind, PoseKind
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds, ExactLimits, limits_json, read_limits
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.cells import Cells
from rpr_solver.paths.isolated import IsolatedPose
from rpr_solver.paths.joint_paths import Range, in_slice, sign_of
from rpr_solver.paths.others import PathPose, numbered, of_table
from rpr_solver.paths.path import Path, document_lengths, path_of, span_json
from rpr_solver.paths.proofs import NO_BOUNDS, PROOF_BITS, outside
from rpr_solver.paths.samples import SamplingPlan
from rpr_solver.paths.within_limits import LimitedSearch, Outcome, Resolution
from rpr_solver.transitions.census import census


class Obstacle(Kind):
    """Why there is no path between two poses.

    >>> Obstacle.OPPOSITE_SIGNS == "opposite-signs"
    True
    """

    OPPOSITE_SIGNS = "opposite-signs"
    """J has different signs at both poses: every path between them meets a singularity, in any slices."""
    OTHER_ASPECT = "other-aspect"
    """The poses lie in different aspects of the slice, or of the range in which the fixed leg may move:
    every path in it meets a singularity."""
    OUTSIDE_LIMITS = "outside-limits"
    """The joint vector of both poses does not keep the joint limits."""
    SEPARATED_BY_LIMITS = "separated-by-limits"
    """Every path between the poses meets a singularity or exceeds a joint limit."""
    UNDECIDED = "undecided"
    """No path was found, and none is excluded: the singular curves at the ends of the range are not
    supported, or joint limits leave only ways that are too narrow for the resolution."""


@dataclass(frozen=True)
class NoPath:
    """The reason why two poses are not joined by a path; false, as ``if path := joint_path(…)`` wants it.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held in the slice.
        digits: significant digits of the angles.
        lengths: L1, L2 and L3, exact, in the user's unit.
        start: the first pose.
        stop: the second pose.
        obstacle: the reason; all but ``UNDECIDED`` are proved.
        between: the lengths between which the fixed leg was free; None if it was held.
        limits: the joint limits, by legs.
        connecting: for another aspect, the ends of a range of the fixed leg within which a path exists, one
            of them being the length of the slice; None if none was found, or with joint limits.
        resolution: where joint limits separate the poses, or leave it undecided: the size of the smallest
            boxes of poses that were examined. None otherwise.

    >>> from rpr_solver import EXAMPLES, joint_path
    >>> joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    <NoPath from pose 1 to pose 3: opposite-signs>
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    lengths: tuple[Fraction, Fraction, Fraction]
    start: PathPose
    stop: PathPose
    obstacle: Obstacle
    between: tuple[Fraction, Fraction] | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)
    connecting: tuple[Fraction, Fraction] | None = None
    resolution: Resolution | None = None

    def __bool__(self) -> bool:
        return False

    def __repr__(self) -> str:
        return f"<NoPath from pose {self.start.number} to pose {self.stop.number}: {self.obstacle}>"

    def to_json(self) -> dict[str, Any]:
        """The document: that of a :class:`Path` without a path, and with its ``obstacle``."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            **document_lengths(self.lengths),
            "connected": None if self.obstacle is Obstacle.UNDECIDED else False,
            "obstacle": self.obstacle.value,
            "between": span_json(self.between),
            "limits": limits_json(self.limits) or None,
            "connecting_range": span_json(self.connecting),
            "resolution": self.resolution and self.resolution.to_json(),
            "from": self.start.to_json(leg),
            "to": self.stop.to_json(leg),
            "samples": [],
        }


_CENSUS_DIGITS = 15
_MOST_RANGES = 24


def joint_path(
    manipulator: Manipulator,
    l1: Exact,
    l2: Exact,
    l3: Exact,
    start: int,
    stop: int,
    *,
    between: tuple[Exact, Exact] | None = None,
    limits: ExactLimits | None = None,
    fixed_leg: int = 1,
    digits: int = PATH_DIGITS,
    samples: int = DEFAULT_SAMPLES,
    timing: str = "cosine",
    duration: Exact = 1,
) -> Path | NoPath:
    """A path without a singularity from one pose of a joint vector to another, or why there is none.

    Args:
        manipulator: the geometry.
        l1: the length of leg 1 at both ends, exact, > 0, in the user's unit.
        l2: the length of leg 2.
        l3: the length of leg 3.
        start: the number of the first pose, from 1, in the table of all poses (:func:`poses`).
        stop: the number of the second pose.
        between: two lengths between which the fixed leg may move; None holds it.
        limits: joint limits that the path keeps: the least and the greatest length of legs, exact, None for
            an open end: ``{"l2": (5, "20.5"), "l3": (None, 30)}``, or with the legs' numbers as keys.
        fixed_leg: the leg of fixed length, 1, 2 or 3.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        samples: the number of samples, 2 to 10001 (see :meth:`Path.resampled`).
        timing: the law of time: ``"cosine"``, ``"trapezoid"`` or ``"constant"``.
        duration: the time of the last sample, exact, > 0.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the singular curves are not supported, or a path could not be proved.

    >>> from rpr_solver import EXAMPLES
    >>> joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2)
    <Path from pose 1 to pose 2: J < 0, 101 samples, 15 digits>
    >>> joint_path(EXAMPLES["innocenti"], 27, "25.7", "9.2", 2, 4, between=(27, 30), samples=5)
    <Path from pose 2 to pose 4: J > 0, 5 samples, 15 digits>
    >>> joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, limits={"l2": (5, 21)})
    <NoPath from pose 1 to pose 2: separated-by-limits>
    """
    digits, leg = check_digits(digits), check_leg(fixed_leg)
    plan = SamplingPlan.of(samples, timing, duration)
    lengths = parse_all({"l1": l1, "l2": l2, "l3": l3}, parse_positive)
    span = None if between is None else checked_range(between, lengths[f"l{leg}"], leg)
    bounds = read_limits({} if limits is None else limits, "limits")
    table = poses(manipulator, *lengths.values(), digits=digits)
    ends = [_end(table, number, field) for number, field in ((start, "start"), (stop, "stop"))]
    if ends[0] == ends[1]:
        raise InputError.of("stop", f"is {stop}, where the path begins; give another pose")
    slice_map = SliceMap.of(manipulator, leg)
    first, last = (isolated(slice_map, table, number) for number in ends)
    named = of_table(table, ends[0], leg), of_table(table, ends[1], leg)
    joint = lengths["l1"], lengths["l2"], lengths["l3"]

    def none(obstacle: Obstacle, **more: Any) -> NoPath:
        return NoPath(manipulator, leg, digits, joint, *named, obstacle, span, bounds, **more)

    if outside(bounds, joint):
        return none(Obstacle.OUTSIDE_LIMITS)
    sign = sign_of(first)
    if sign != sign_of(last):
        return none(Obstacle.OPPOSITE_SIGNS)
    free = narrowed(span, bounds.get(leg, NO_BOUNDS))
    limited = LimitedSearch.of(first, last, sign, bounds, free)
    found = in_slice(Cells.of(slice_map, first.legs[0]), first, last, sign)
    is_supported = True
    if found is None and free is not None:
        try:
            whole = Range.of(slice_map, limited.span, sign)
        except SolverError:
            is_supported = False
        else:
            found = whole.route(first, last)
    if found is None and is_supported:
        connecting = None if bounds else _connecting(manipulator, first, last, sign)
        return none(Obstacle.OTHER_ASPECT, connecting=connecting)
    if limited.limits.walls:
        outcome = limited.kept_by(found) or limited.found()
        if isinstance(outcome, Outcome):
            obstacle = Obstacle.SEPARATED_BY_LIMITS if outcome.is_separated else Obstacle.UNDECIDED
            return none(obstacle, resolution=limited.resolution(outcome))
        found = outcome
    if found is None:
        return none(Obstacle.UNDECIDED)
    return path_of(manipulator, *found, plan, digits, between=span, limits=bounds)


def checked_range(between: tuple[Exact, Exact], length: Fraction, leg: int) -> tuple[Fraction, Fraction]:
    """Two lengths of the fixed leg, ascending.

    Raises:
        InputError: naming ``between``: the lengths are not positive, or do not hold that of the joint vector.
    """
    low, high = (parse_positive(end, "between") for end in between)
    if not low <= length <= high or low == high:
        raise InputError.of(
            "between", f"is {exact_str(low)} to {exact_str(high)}; it must hold l{leg} = {exact_str(length)}"
        )
    return low, high


def isolated(slice_map: SliceMap, table: PoseTable, number: int) -> IsolatedPose:
    """A pose of a table, isolated.

    Raises:
        Unproved: it could not be isolated.
    """
    leg = slice_map.fixed_leg
    by_leg = dict(enumerate(table.lengths.values(), 1))
    lengths = [Fraction(by_leg[i]) * slice_map.scale for i in (leg, *free_legs(leg))]
    pose = of_table(table, number, leg)
    with ctx.workprec(PROOF_BITS):
        angles = arb(pose.alpha_deg) * arb.pi() / 180, arb(pose.theta_deg) * arb.pi() / 180
        found = IsolatedPose.near(slice_map, (lengths[0], lengths[1], lengths[2]), angles)
    if found is None or numbered(found, table, leg) != pose:
        raise Unproved("a pose is too near a singularity")
    return found


def narrowed(span: tuple[Fraction, Fraction] | None, bounds: Bounds) -> tuple[Fraction, Fraction] | None:
    """The part of a range of the fixed leg that its joint limits allow; None if that is one length alone."""
    if span is None:
        return None
    low, high = bounds
    ends = max(span[0], low or span[0]), span[1] if high is None else min(span[1], high)
    return None if ends[0] == ends[1] else ends


def _end(table: PoseTable, number: int, field: str) -> int:
    count = table.count
    number = check_integer(number, field, f"the number of a pose, 1 to {count}", 1, count)
    if table.poses[number - 1].multiplicity > 1:
        raise InputError.of(field, f"is {number}, a singular pose; give a regular one")
    return number


def _connecting(
    manipulator: Manipulator, start: IsolatedPose, stop: IsolatedPose, sign: int
) -> tuple[Fraction, Fraction] | None:
    """The nearest range of the fixed leg within which a path exists, of those that the census tells apart."""
    slice_map = start.slice_map
    length = start.legs[0] / slice_map.scale
    transitions = census(manipulator, fixed_leg=slice_map.fixed_leg, digits=_CENSUS_DIGITS).transitions
    # aspects meet or part only where ∇J = 0, which swallowtails are not
    marks = sorted({Fraction(t.length) for t in transitions if t.kind is not PoseKind.SWALLOWTAIL})
    above = [x for x in marks if x > length]
    below = [x for x in reversed(marks) if x < length]
    candidates = [_short((x + y) / 2) for x, y in pairwise([*above, *(2 * x for x in above[-1:])])]
    candidates += [_short((x + y) / 2) for x, y in pairwise([*below, Fraction(0)])]
    for end in sorted(candidates, key=lambda end: abs(end - length))[:_MOST_RANGES]:
        low, high = min(length, end), max(length, end)
        try:
            span = Range.of(slice_map, (low * slice_map.scale, high * slice_map.scale), sign)
            if span.route(start, stop) is not None:
                return low, high
        except SolverError:
            continue
    return None


def _short(x: Fraction) -> Fraction:
    """A nearby decimal."""
    return Fraction(f"{float(x):.10g}")
