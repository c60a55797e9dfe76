"""Paths from pose to pose that keep joint limits, or the proof that there is none.

First the route without limits is tried. If it exceeds them, a subdivision (:mod:`rpr_solver.paths.search`)
looks for another one, or proves that there is none.

A way on a grid of poses (:mod:`rpr_solver.paths.pose_grid`), as far as possible from singularities and
limits, in floats, is a proposal alone: the polyline is proved, or dropped. Wide ways are found at once like
this, where a subdivision would have to cut very many boxes, above all with the fixed leg free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import radians
from typing import TypeAlias

from flint import ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.lengths import Bounds
from rpr_solver.paths.boxes import Boxes, PosePoint, Resolution, Spot, decimal_pose
from rpr_solver.paths.joint_paths import Corner, Straightener
from rpr_solver.paths.pose_grid import PoseGrid
from rpr_solver.paths.proofs import PROOF_BITS, PathLimits, ProvedRoute, prove, proved_route
from rpr_solver.paths.routes import Arc, DecimalPose, EndPose, GivenPose, IsolatedPose, Legs
from rpr_solver.paths.search import Outcome, Search

Span: TypeAlias = tuple[Fraction, Fraction]
Searches: TypeAlias = dict[tuple[int, Span], Search]
_INWARDS = [Fraction(1, 10**k) for k in range(2, 9)]
"""Shares of a leg's length by which a pose on a limit is tried to be moved inwards, one after another."""


@dataclass(frozen=True)
class LimitedSearch:
    """The search for a path between two poses within limits.

    Attributes:
        sign: that of J at both poses.
        start: the first pose.
        stop: the second pose.
        limits: of the free legs; both poses keep them.
        span: the scaled lengths between which the fixed leg may move, both the same if it is held.
        searches: subdivisions by sign and span, shared by searches within the same limits.
    """

    sign: int
    start: EndPose
    stop: EndPose
    limits: PathLimits
    span: Span
    searches: Searches = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        start: EndPose,
        stop: EndPose,
        sign: int,
        bounds: Mapping[int, Bounds],
        span: tuple[Fraction, Fraction] | None,
    ) -> LimitedSearch:
        """The search with limits by the legs' numbers and the range of the fixed leg, in the user's unit."""
        slice_map, length = start.slice_map, start.legs[0]
        ends = (length, length) if span is None else (span[0] * slice_map.scale, span[1] * slice_map.scale)
        return cls(sign, start, stop, PathLimits.of(slice_map, bounds, (start.legs, stop.legs)), ends)

    def found(self, unlimited: ProvedRoute | None) -> ProvedRoute | Outcome:
        """A proved route, if possible the one without limits; or the outcome of the subdivision without one.

        Raises:
            Unproved: there is a path, but it could not be proved; or an end is too near to what is excluded.
        """
        if unlimited is not None and (kept := self.kept(unlimited)) is not None:
            return kept
        closer = replace(self, limits=self.limits.closer((self.start, self.stop)))
        try:
            outcome = self._searched()
        except Unproved:
            return closer._searched()
        if closer.limits != self.limits and isinstance(outcome, Outcome) and not outcome.is_separated:
            # ends just inside limits are left as those on limits are
            with suppress(Unproved):
                return closer._searched()
        return outcome

    def _searched(self) -> ProvedRoute | Outcome:
        """A route from boxes or from the grid, or the outcome of the subdivision.

        Raises:
            Unproved: as :meth:`found`.
        """
        inner = [self._inside(pose, end) for end, pose in enumerate((self.start, self.stop))]
        # a route in the slice is found sooner than one in the range
        held = [(self.start.legs[0],) * 2] if self.start.legs[0] == self.stop.legs[0] else []
        spans = dict.fromkeys([*held, self.span])
        for span in spans:
            # boxes of three coordinates are many, so that the grid comes first
            if span[0] != span[1] and (coarse := self._coarse(inner, span)):
                return coarse
            key = self.sign, span
            if key not in self.searches:
                self.searches[key] = Search(self._boxes(span))
            search = self.searches[key]
            places = _place(inner[0]), _place(inner[1])
            try:
                outcome = search.outcome(*places)
            except Unproved:  # a pose is nearer to a limit than the narrowest boxes are wide
                outcome = Outcome(None, False, search.narrowest())
            if outcome.way is not None:
                return self._along(inner, outcome.way)
            if span[0] == span[1] and not outcome.is_separated and (coarse := self._coarse(inner, span)):
                return coarse
        return outcome if outcome.is_separated else replace(outcome, near=search.stuck(*places))

    def _coarse(self, inner: Sequence[EndPose], span: Span) -> ProvedRoute | None:
        """A proved route along a way on a grid between two poses that are not on a limit."""
        grid = PoseGrid.of(inner, span, self.sign, self.limits)
        if (parts := grid.way(inner, is_wide=False)) is None:
            return None
        spots = [
            (radians(a), radians(t), min(max(Fraction(x) * grid.field.unit, span[0]), span[1]))
            for part in parts
            for a, t, x in part.tolist()
        ]
        try:
            return self._along(inner, spots)
        except Unproved:
            return None

    def _along(self, inner: Sequence[EndPose], way: Sequence[Spot]) -> ProvedRoute:
        """The route along a polyline, from the start by way of the poses that are not on a limit.

        Raises:
            Unproved: it could not be proved.
        """
        slice_map = self.start.slice_map
        corners: list[Corner] = [(a, t, length / slice_map.scale) for a, t, length in way]
        before, after = (pose is not own for pose, own in zip(inner, (self.start, self.stop), strict=True))
        corners = [*corners[:1] * before, *corners, *corners[-1:] * after]
        return Straightener(slice_map, self.sign, self.limits).joined(self.start, self.stop, corners)

    def kept(self, unlimited: ProvedRoute) -> ProvedRoute | None:
        """A route without limits, if it is proved to keep them."""
        return proved_route(unlimited[0], self.sign, self.limits)

    def resolution(self, outcome: Outcome) -> Resolution:
        """The size of the smallest boxes of an outcome."""
        return self._boxes(self.span).resolution(outcome.level)

    def near(self, outcome: Outcome) -> DecimalPose | None:
        """About where an outcome stays undecided."""
        return outcome.near and decimal_pose(outcome.near, self.start.slice_map.scale)

    def _boxes(self, span: tuple[Fraction, Fraction]) -> Boxes:
        return Boxes(self.start.slice_map, self.sign, self.limits, *span)

    def _inside(self, pose: EndPose, end: int) -> EndPose:
        """A pose that is not on a limit, and is joined to an end by a straight line within the limits."""
        if isinstance(pose, GivenPose) or not any(wall.touched[end] for wall in self.limits.walls):
            return pose
        for share in _INWARDS:
            with ctx.workprec(PROOF_BITS):
                inner = IsolatedPose.near(pose.slice_map, self._shifted(pose.legs, share, end), pose.angles)
                if inner is not None:
                    points = [(*own.angles, ball_of(own.legs[0])) for own in (pose, inner)]
                    arcs = [Arc.over(points[::-1] if end else points)]
                    at_ends = end == 0, end == 1
                    if prove(pose.slice_map, arcs, self.sign, limits=self.limits, at_ends=at_ends):
                        return inner
        raise Unproved("no way from a limit inwards could be proved")

    def _shifted(self, legs: Legs, share: Fraction, end: int) -> Legs:
        """Leg lengths changed by this share of them, away from the limits on which they lie."""
        fixed, *free = legs
        for wall in self.limits.walls:
            if wall.touched[end]:
                free[wall.leg] *= 1 - wall.side * share
        return fixed, free[0], free[1]


def _place(pose: EndPose) -> PosePoint:
    return *pose.angles, pose.legs[0]
