"""Two poses of one joint vector: a path between them without a singularity, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any, Unpack

from flint import ctx

from rpr_solver.contract import check_integer, document_head
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive
from rpr_solver.kinematics.pose_table import PoseTable, poses
from rpr_solver.model.classify import Kind, PoseKind
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.cells import Cells
from rpr_solver.paths.joint_paths import Range, in_slice, sign_of
from rpr_solver.paths.others import PathPose, isolated, of_table
from rpr_solver.paths.path import Path, PathOptions, PathTerms, document_lengths, path_of, span_json
from rpr_solver.paths.proofs import NO_BOUNDS, PROOF_BITS, ProvedRoute, outside
from rpr_solver.paths.route import IsolatedPose
from rpr_solver.paths.within_limits import LimitedSearch, Outcome, Resolution
from rpr_solver.transitions.census import bare_census


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
        options: as :class:`~rpr_solver.paths.path.PathOptions` says: ``limits``, ``fixed_leg``, ``digits``,
            ``samples``, ``timing`` and ``duration``.

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
    span = None if between is None else checked_range(between, lengths[f"l{terms.leg}"], terms.leg)
    table = poses(manipulator, *lengths.values(), digits=terms.digits)
    ends = _end(table, start, "start"), _end(table, stop, "stop")
    if ends[0] == ends[1]:
        raise InputError.of("stop", f"is {stop}, where the path begins; give another pose")
    slice_map = SliceMap.of(manipulator, terms.leg)
    joint = lengths["l1"], lengths["l2"], lengths["l3"]
    fixed, first, second = (joint[leg - 1] * slice_map.scale for leg in (terms.leg, *free_legs(terms.leg)))
    with ctx.workprec(PROOF_BITS):
        pair = [isolated(slice_map, (fixed, first, second), table, number) for number in ends]
    named = of_table(table, ends[0], terms.leg), of_table(table, ends[1], terms.leg)
    return _Question(manipulator, terms, joint, span, (pair[0], pair[1]), named).answer()


@dataclass(frozen=True)
class _Question:
    """Whether two poses of a joint vector are joined.

    Attributes:
        manipulator: the geometry.
        terms: what a path is to keep, and how it is written.
        lengths: L1, L2 and L3, in the user's unit.
        span: the lengths between which the fixed leg may move; None if it is held.
        poses: the first pose and the second one, isolated.
        named: the same with their numbers.
    """

    manipulator: Manipulator
    terms: PathTerms
    lengths: tuple[Fraction, Fraction, Fraction]
    span: tuple[Fraction, Fraction] | None
    poses: tuple[IsolatedPose, IsolatedPose]
    named: tuple[PathPose, PathPose]

    def answer(self) -> Path | NoPath:
        """A path, or why there is none."""
        bounds = self.terms.bounds
        if outside(bounds, self.lengths):
            return self._none(Obstacle.OUTSIDE_LIMITS)
        sign, other = map(sign_of, self.poses)
        if sign != other:
            return self._none(Obstacle.OPPOSITE_SIGNS)
        free = narrowed(self.span, bounds.get(self.terms.leg, NO_BOUNDS))
        limited = LimitedSearch.of(*self.poses, sign, bounds, free)
        joined = self._joined(sign, None if free is None else limited.span)
        if joined is Obstacle.OTHER_ASPECT:
            connecting = None if bounds else _connecting(self.manipulator, *self.poses, sign)
            return self._none(joined, connecting=connecting)
        found: ProvedRoute | Obstacle | Outcome = joined
        if limited.limits.walls:
            found = limited.found(None if isinstance(joined, Obstacle) else joined)
        if isinstance(found, Outcome):
            obstacle = Obstacle.SEPARATED_BY_LIMITS if found.is_separated else Obstacle.UNDECIDED
            return self._none(obstacle, resolution=limited.resolution(found))
        if isinstance(found, Obstacle):
            return self._none(found)
        return path_of(self.manipulator, found, self.terms, between=self.span)

    def _joined(self, sign: int, span: tuple[Fraction, Fraction] | None) -> ProvedRoute | Obstacle:
        """A route in the slice, or in a range of scaled lengths, joint limits apart."""
        start, stop = self.poses
        found = in_slice(Cells.of(start.slice_map, start.legs[0]), start, stop, sign)
        if found is None and span is not None:
            try:
                whole = Range.of(start.slice_map, span, sign)
            except SolverError:
                return Obstacle.UNDECIDED
            found = whole.route(start, stop)
        return Obstacle.OTHER_ASPECT if found is None else found

    def _none(self, obstacle: Obstacle, **more: Any) -> NoPath:
        leg, digits, bounds = self.terms.leg, self.terms.digits, self.terms.bounds
        head = self.manipulator, leg, digits, self.lengths
        return NoPath(*head, *self.named, obstacle, self.span, bounds, **more)


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
    """The nearest range of the fixed leg within which a path exists, among those that the census suggests."""
    slice_map = start.slice_map
    length = start.legs[0] / slice_map.scale
    transitions = bare_census(manipulator, slice_map.fixed_leg, _CENSUS_DIGITS).transitions
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
