"""Two poses, of one joint vector or of two: a path between them without a singularity, or why there is
none.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any, Unpack

from rpr_solver.contract import document_head
from rpr_solver.errors import InputError, SolverError, Unproved
from rpr_solver.exact.decimals import rounded_near
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive
from rpr_solver.model.joint_points import Kind, PoseKind
from rpr_solver.model.lengths import Bounds, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.boxes import Resolution
from rpr_solver.paths.cells import Cells
from rpr_solver.paths.conditioning import PathCondition, is_beyond
from rpr_solver.paths.corridors import Corridors
from rpr_solver.paths.joint_paths import Range, in_slice
from rpr_solver.paths.path import Path, path_of
from rpr_solver.paths.path_poses import PathPose
from rpr_solver.paths.proofs import NO_BOUNDS, Clearance, ProvedRoute
from rpr_solver.paths.question import (
    End,
    Ends,
    Lengths,
    PathOptions,
    PathTerms,
    PoseQuestion,
    common,
    document_lengths,
    span_json,
)
from rpr_solver.paths.routes import DecimalPose, EndPose
from rpr_solver.paths.search import Outcome
from rpr_solver.paths.within_limits import LimitedSearch
from rpr_solver.transitions.census import bare_census


class Obstacle(Kind):
    """Why there is no path between two poses; all but ``UNDECIDED`` are proved.

    >>> Obstacle.OPPOSITE_SIGNS == "opposite-signs"
    True
    """

    OPPOSITE_SIGNS = "opposite-signs"
    """J has different signs at both poses: every path between them meets a singularity, in any slices."""
    OTHER_ASPECT = "other-aspect"
    """The poses lie in different aspects of the slice, or of the range in which the fixed leg may move:
    every path in it meets a singularity."""
    SINGULAR_POSE = "singular-pose"
    """One of the poses is singular itself: in a matrix of all pairs; a single path refuses the question."""
    OUTSIDE_LIMITS = "outside-limits"
    """A pose does not keep the joint limits."""
    SEPARATED_BY_LIMITS = "separated-by-limits"
    """Every path between the poses meets a singularity or exceeds a joint limit."""
    TOO_NARROW = "too-narrow"
    """Every path between the poses comes nearer to a singular pose than the clearance that is asked for."""
    ILL_CONDITIONED = "ill-conditioned"
    """One of the poses has a greater condition number than is asked for."""
    UNDECIDED = "undecided"
    """No path was found, and none is excluded: the singular curves at the ends of the range are not
    supported, joint limits leave only ways that are too narrow for the resolution, or the path that was found
    has less clearance or a greater condition number than is asked for."""


@dataclass(frozen=True)
class NoPath:
    """The reason why two poses are not joined by a path; false, as ``if path := joint_path(…)`` wants it.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held in the slice.
        digits: significant digits of the angles.
        lengths: L1, L2 and L3 at both poses, exact, in the user's unit; None if each pose has its own.
        start: the first pose.
        stop: the second pose.
        obstacle: the reason; all but ``UNDECIDED`` are proved.
        between: the lengths between which the fixed leg was free; None if it was held.
        limits: the joint limits, by legs.
        connecting: for another aspect, the ends of a range of the fixed leg within which a path exists; it
            begins or ends with a length of the poses. None if none was found, or with joint limits.
        resolution: where joint limits separate the poses, or leave it undecided: the size of the smallest
            boxes of poses that were examined. None otherwise.
        clearance: where it is less than was asked for: that of the widest path that was found.
        condition: where it is greater than was asked for: that of the best path that was found.
        near_pose: where joint limits leave it undecided: a pose near which it is. None otherwise.

    >>> from rpr_solver import EXAMPLES, joint_path
    >>> joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    <NoPath from pose 1 to pose 3: opposite-signs>
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    lengths: Lengths | None
    start: PathPose
    stop: PathPose
    obstacle: Obstacle
    between: tuple[Fraction, Fraction] | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)
    connecting: tuple[Fraction, Fraction] | None = None
    resolution: Resolution | None = None
    clearance: Clearance | None = None
    condition: PathCondition | None = None
    near_pose: DecimalPose | None = None

    def __bool__(self) -> bool:
        return False

    def __repr__(self) -> str:
        return f"<NoPath from {self.start.name} to {self.stop.name}: {self.obstacle}>"

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
            **({} if self.near_pose is None else {"near_pose": self.near_pose.to_json(leg)}),
            **({} if self.clearance is None else {"clearance": self.clearance.to_json()}),
            **({} if self.condition is None else {"condition": self.condition.to_json()}),
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
    **options: Unpack[PathOptions],
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
        options: as :class:`~rpr_solver.paths.question.PathOptions` says: ``limits``, ``fixed_leg``,
            ``digits``, ``samples``, ``timing``, ``duration``, ``clearance`` and ``max_condition``.

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
    terms = PathTerms.of(**options)
    lengths = parse_all({"l1": l1, "l2": l2, "l3": l3}, parse_positive)
    length = lengths[f"l{terms.leg}"]
    span = None if between is None else checked_range(between, (length, length), terms.leg)
    reader = Ends(manipulator, SliceMap.of(manipulator, terms.leg), terms.digits)
    joint = lengths["l1"], lengths["l2"], lengths["l3"]
    first, last = reader.of_joint_vector(joint, {"start": start, "stop": stop})
    return _answer(manipulator, terms, span, (first, last))


def pose_path(
    manipulator: Manipulator,
    start: PoseQuestion,
    stop: PoseQuestion,
    *,
    between: tuple[Exact, Exact] | None = None,
    **options: Unpack[PathOptions],
) -> Path | NoPath:
    """A path without a singularity from any pose to any other one, or why there is none.

    A pose is given by its joint vector and its number, ``{"l1": 27, "l2": 20, "l3": 20, "pose": 2}``, or by
    its angles and the length of the fixed leg, ``{"alpha_deg": "12.5", "theta1_deg": -30, "l1": 27}``; all
    these are exact.

    Args:
        manipulator: the geometry.
        start: the first pose.
        stop: the second pose.
        between: two lengths between which the fixed leg may move. None holds it, if both poses have the same
            length of it; otherwise it moves between both lengths.
        options: as :func:`joint_path` takes them.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the singular curves are not supported, or a path could not be proved.

    >>> from rpr_solver import EXAMPLES
    >>> start, stop = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}, {"l1": 30, "l2": 21, "l3": 19, "pose": 1}
    >>> path = pose_path(EXAMPLES["innocenti"], start, stop, samples=5)
    >>> path
    <Path from pose 1 of L1=27 L2=20 L3=20 to pose 1 of L1=30 L2=21 L3=19: J < 0, 5 samples, 15 digits>
    >>> given = {"alpha_deg": 60, "theta1_deg": -60, "l1": 27}
    >>> pose_path(EXAMPLES["innocenti"], start, given).obstacle
    'opposite-signs'
    """
    terms = PathTerms.of(**options)
    reader = Ends(manipulator, SliceMap.of(manipulator, terms.leg), terms.digits)
    first, last = reader.read(start, "start"), reader.read(stop, "stop")
    lengths = min(first.length, last.length), max(first.length, last.length)
    span = None if lengths[0] == lengths[1] else lengths
    if between is not None:
        span = checked_range(between, lengths, terms.leg)
    return _answer(manipulator, terms, span, (first, last))


def _answer(
    manipulator: Manipulator, terms: PathTerms, span: tuple[Fraction, Fraction] | None, ends: tuple[End, End]
) -> Path | NoPath:
    first, last = ends
    if first.is_same(last):
        raise InputError.of("stop", f"is {last.named.name}, where the path begins; give another pose")
    named, lengths = common(ends)
    return _Question(manipulator, terms, lengths, span, ends, named).answer()


@dataclass(frozen=True)
class _Question:
    """Whether two poses are joined.

    Attributes:
        manipulator: the geometry.
        terms: what a path is to keep, and how it is written.
        lengths: L1, L2 and L3 at both poses, in the user's unit; None if each has its own.
        span: the lengths between which the fixed leg may move; None if it is held.
        ends: the first pose and the second one.
        named: the same as the document has them.
    """

    manipulator: Manipulator
    terms: PathTerms
    lengths: Lengths | None
    span: tuple[Fraction, Fraction] | None
    ends: tuple[End, End]
    named: tuple[PathPose, PathPose]

    def answer(self) -> Path | NoPath:
        """A path, or why there is none."""
        bounds = self.terms.bounds
        if any(end.is_outside(bounds) for end in self.ends):
            return self._none(Obstacle.OUTSIDE_LIMITS)
        first, last = self.ends
        sign, poses = first.sign, (first.pose, last.pose)
        if sign != last.sign:
            return self._none(Obstacle.OPPOSITE_SIGNS)
        free = narrowed(self.span, bounds.get(self.terms.leg, NO_BOUNDS))
        limited = LimitedSearch.of(*poses, sign, bounds, free)
        joined = route_without_limits(poses, sign, None if free is None else limited.span)
        if joined is Obstacle.OTHER_ASPECT:
            connecting = None if bounds else _connecting(self.manipulator, *poses, sign)
            return self._none(joined, connecting=connecting)
        found: ProvedRoute | Obstacle | Outcome = joined
        if limited.limits.walls:
            found = limited.found(None if isinstance(joined, Obstacle) else joined)
        if isinstance(found, Outcome):
            obstacle = Obstacle.SEPARATED_BY_LIMITS if found.is_separated else Obstacle.UNDECIDED
            return self._none(obstacle, resolution=limited.resolution(found), near_pose=limited.near(found))
        if isinstance(found, Obstacle):
            return self._none(found)
        if self.terms.clearance is not None:
            return self._wide(found, limited)
        return self._kept(found, limited)

    def _wide(self, known: ProvedRoute, limited: LimitedSearch) -> Path | NoPath:
        """The widest path, or a reason why it is not as wide as was asked for."""
        asked = self.terms.clearance or Fraction(0)
        ends = limited.start, limited.stop
        corridors = Corridors.of(ends, limited.span, limited.sign, limited.limits, asked)
        found, clearance = corridors.widest(known)
        if clearance.proved >= asked:
            return self._kept(found, limited, clearance)
        is_excluded = clearance.bound is not None and clearance.bound < asked
        return self._none(Obstacle.TOO_NARROW if is_excluded else Obstacle.UNDECIDED, clearance=clearance)

    def _kept(
        self, known: ProvedRoute, limited: LimitedSearch, clearance: Clearance | None = None
    ) -> Path | NoPath:
        """A path whose condition numbers are as they were asked for: the known one, or else the widest."""
        terms = self.terms
        if terms.condition is None:
            return self._path(known, clearance)
        scale, asked = terms.condition.scale(self.manipulator), terms.condition.most
        condition = PathCondition.of(known[0], scale, asked)
        if condition.is_kept:
            return self._path(known, clearance, condition)
        if any(is_beyond(end.pose, scale, asked) for end in self.ends):
            return self._none(Obstacle.ILL_CONDITIONED, condition=condition)
        if clearance is None:
            ends = limited.start, limited.stop
            corridors = Corridors.of(ends, limited.span, limited.sign, limited.limits)
            with suppress(Unproved):
                wide = corridors.widest(known)[0]
                other = PathCondition.of(wide[0], scale, asked)
                if other.is_kept:
                    return self._path(wide, None, other)
                condition = min(condition, other, key=lambda found: found.greatest)
        return self._none(Obstacle.UNDECIDED, condition=condition)

    def _path(
        self, found: ProvedRoute, clearance: Clearance | None, condition: PathCondition | None = None
    ) -> Path:
        return path_of(
            self.manipulator,
            found,
            self.terms,
            between=self.span,
            named=self.named,
            clearance=clearance,
            condition=condition,
        )

    def _none(self, obstacle: Obstacle, **more: Any) -> NoPath:
        leg, digits, bounds = self.terms.leg, self.terms.digits, self.terms.bounds
        head = self.manipulator, leg, digits, self.lengths
        return NoPath(*head, *self.named, obstacle, self.span, bounds, **more)


def route_without_limits(
    poses: tuple[EndPose, EndPose], sign: int, span: tuple[Fraction, Fraction] | None
) -> ProvedRoute | Obstacle:
    """A route between poses with this sign of J, in the slice or in a range of scaled lengths.

    Raises:
        SolverError: the singular curves of the slice are not supported, or no route could be proved.
    """
    start, stop = poses
    found = None
    if start.legs[0] == stop.legs[0]:
        found = in_slice(Cells.of(start.slice_map, start.legs[0]), start, stop, sign)
    if found is None and span is not None:
        try:
            whole = Range.of(start.slice_map, span, sign)
        except SolverError:
            return Obstacle.UNDECIDED
        found = whole.route(start, stop)
    return Obstacle.OTHER_ASPECT if found is None else found


def checked_range(
    between: tuple[Exact, Exact], lengths: tuple[Fraction, Fraction], leg: int
) -> tuple[Fraction, Fraction]:
    """Two lengths of the fixed leg, ascending; ``lengths`` are those of the poses.

    Raises:
        InputError: naming ``between``: the lengths are not positive, or do not hold those of the poses.
    """
    low, high = (parse_positive(end, "between") for end in between)
    if not low <= lengths[0] <= lengths[1] <= high or low == high:
        held = " and ".join(map(exact_str, dict.fromkeys(lengths)))
        raise InputError.of(
            "between", f"is {exact_str(low)} to {exact_str(high)}; it must hold l{leg} = {held}"
        )
    return low, high


def narrowed(span: tuple[Fraction, Fraction] | None, bounds: Bounds) -> tuple[Fraction, Fraction] | None:
    """The part of a range of the fixed leg that its joint limits allow; None if that is one length alone."""
    if span is None:
        return None
    low, high = bounds
    ends = max(span[0], low or span[0]), span[1] if high is None else min(span[1], high)
    return None if ends[0] == ends[1] else ends


def _connecting(
    manipulator: Manipulator, start: EndPose, stop: EndPose, sign: int
) -> tuple[Fraction, Fraction] | None:
    """The nearest range of the fixed leg within which a path exists, among those that the census suggests."""
    slice_map = start.slice_map
    least, most = sorted(pose.legs[0] / slice_map.scale for pose in (start, stop))
    transitions = bare_census(manipulator, slice_map.fixed_leg, _CENSUS_DIGITS).transitions
    # aspects meet or part only where ∇J = 0, which swallowtails are not
    marks = sorted({Fraction(t.length) for t in transitions if t.kind is not PoseKind.SWALLOWTAIL})
    above = [x for x in marks if x > most]
    below = [x for x in reversed(marks) if x < least]
    candidates = [_short((x + y) / 2) for x, y in pairwise([*above, *(2 * x for x in above[-1:])])]
    candidates += [_short((x + y) / 2) for x, y in pairwise([*below, Fraction(0)])]
    for end in sorted(candidates, key=lambda end: max(end - most, least - end))[:_MOST_RANGES]:
        low, high = min(least, end), max(most, end)
        try:
            span = Range.of(slice_map, (low * slice_map.scale, high * slice_map.scale), sign)
            if span.route(start, stop) is not None:
                return low, high
        except SolverError:
            continue
    return None


def _short(x: Fraction) -> Fraction:
    """A nearby decimal."""
    return rounded_near(x, 10)
