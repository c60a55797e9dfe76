"""Paths from pose to pose that keep joint limits, or the proof that there is none.

First the route without limits is tried. If it exceeds them, a subdivision looks for another one, or proves
that there is none. Boxes (:mod:`rpr_solver.paths.boxes`) are cut until each is proved to be allowed
everywhere or nowhere, but only where it matters: on the ways between both poses that cross the fewest
undecided boxes. If a way crosses none, its boxes hold a path. If no way is left, even through boxes that stay
undecided, there is no path: a path meets boxes that share faces, for a point on an edge lies in all the
closed boxes round it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from math import tau
from typing import TypeAlias

from flint import ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.lengths import Bounds
from rpr_solver.paths.boxes import (
    BITS,
    FIRST_LEVEL,
    Box,
    Boxes,
    PosePoint,
    Resolution,
    Verdict,
    face,
    near,
    turns,
)
from rpr_solver.paths.coarse_ways import CoarseGrid
from rpr_solver.paths.joint_paths import Corner, straightened
from rpr_solver.paths.proofs import PROOF_BITS, PathLimits, ProvedRoute, prove
from rpr_solver.paths.route import Arc, EndPose, GivenPose, IsolatedPose, Legs

_LEVELS: Mapping[int, Sequence[int]] = {2: (7, 9, 11), 3: (7, 8, 9)}
"""By the number of coordinates that are cut: the levels, one after another, at which cutting stops."""
_DEEPEST = 64
_WIDTHS = 2
"""Boxes of each level are cut that are so many of their widths away from a pose."""
_SLACK = 1
"""Ways may cross this many boxes more than the fewest, which saves searches."""

Spot = tuple[float, float, Fraction]
"""α and θ in radians, not confined to a turn, and the scaled length."""


@dataclass(frozen=True)
class Outcome:
    """What a subdivision proved.

    Attributes:
        way: spots of a polyline from one pose to the other, in allowed boxes; None if none was found.
        is_separated: whether it is proved that there is no path.
        level: of the narrowest boxes that were used: 360°/2^level wide.
        boxes: the number of boxes that were examined.
    """

    way: list[Spot] | None
    is_separated: bool
    level: int
    boxes: int


class Search:
    """The boxes that have been cut, and the verdicts about the others."""

    most_boxes, more_boxes = 40_000, 10_000
    """How many there may be, or be added to what searches between other poses have cut."""

    def __init__(self, boxes: Boxes) -> None:
        self.boxes = boxes
        self.levels = _LEVELS[len(boxes.axes)]
        self.near: dict[Box, list[Box]] = {}
        with ctx.workprec(BITS):
            self.verdicts: dict[Box, Verdict | None] = {box: boxes.verdict(box) for box in boxes.first()}

    def outcome(self, start: PosePoint, stop: PosePoint) -> Outcome:
        """Looks for a way between two allowed poses; what is cut stays cut for other poses.

        Raises:
            Unproved: a pose is too near to the edge of what is allowed.
        """
        with ctx.workprec(BITS):
            return self._outcome(start, stop)

    def _outcome(self, start: PosePoint, stop: PosePoint) -> Outcome:
        first, last = self.settled(start), self.settled(stop)
        done = FIRST_LEVEL
        most_boxes = max(self.most_boxes, len(self.verdicts) + self.more_boxes)
        for level in self.levels:
            while len(self.verdicts) < most_boxes:
                from_start = self.distances(first, level)
                if last not in from_start:
                    if last not in self.distances(first, None):
                        return Outcome(None, True, self.narrowest(), len(self.verdicts))
                    break
                if from_start[last] == 0:
                    way = self.way(start, self.chain(from_start, last), stop)
                    return Outcome(way, False, self.narrowest(), len(self.verdicts))
                from_stop = self.distances(last, level)
                most = from_start[last] + 1 + _SLACK
                crossed = [
                    box
                    for box, steps in from_start.items()
                    if self.verdicts[box] is Verdict.UNDECIDED and steps + from_stop.get(box, most) <= most
                ]
                for box in self.chosen(crossed):
                    self.cut(box)
            else:
                break
            done = level
        return Outcome(None, False, done, len(self.verdicts))

    def chosen(self, boxes: list[Box]) -> list[Box]:
        """Those of the undecided boxes on the best ways that are cut next."""
        return boxes

    def narrowest(self) -> int:
        return max(box[0] for box, verdict in self.verdicts.items() if verdict is not None)

    def cut(self, box: Box) -> None:
        for other in self.beside(box):
            self.near.pop(other, None)
        self.near.pop(box, None)
        self.verdicts[box] = None
        for part in self.boxes.parts(box):
            self.verdicts[part] = self.boxes.verdict(part)

    def settled(self, place: PosePoint) -> Box:
        """An allowed box round a pose, cut out if need be."""
        for level in range(FIRST_LEVEL, _DEEPEST):
            box = self.boxes.holding(place, level)
            if box is None:
                break
            verdict = self.verdicts.get(box)
            if verdict is Verdict.IN:
                self.open_round(place, level)
                return box
            if verdict is Verdict.UNDECIDED:
                self.cut(box)
        raise Unproved("a pose is too near to a singularity or to a limit")

    def open_round(self, place: PosePoint, deepest: int) -> None:
        """Cuts the undecided boxes round a pose, the nearer the narrower, as deep as its own box was cut.

        A pose just inside a limit has an allowed box that is not wider than its distance from the limit;
        boxes beside it, each wider and farther from the limit, lead from there to the wide ones.
        """
        for level in range(FIRST_LEVEL, deepest + 1):
            near = [box] if (box := self.boxes.holding(place, level)) else []
            for axis in self.boxes.axes:
                steps = range(-_WIDTHS, _WIDTHS + 1)
                near = [x for box in near for step in steps if (x := self.boxes.beside(box, axis, step))]
            for box in near:
                if self.verdicts.get(box) is Verdict.UNDECIDED:
                    self.cut(box)

    def distances(self, start: Box, deepest: int | None) -> dict[Box, int]:
        """How many undecided boxes, of a lower level than this, must be entered to reach each box."""
        found = {start: 0}
        queue = deque([start])
        done: set[Box] = set()
        while queue:
            box = queue.popleft()
            if box in done:
                continue
            done.add(box)
            steps = found[box]
            for other in self.beside(box):
                verdict = self.verdicts[other]
                if verdict is Verdict.OUT or other in done:
                    continue
                if verdict is Verdict.IN:
                    if steps < found.get(other, steps + 1):
                        found[other] = steps
                        queue.appendleft(other)
                elif (deepest is None or other[0] < deepest) and steps + 1 < found.get(other, steps + 2):
                    found[other] = steps + 1
                    queue.append(other)
        return found

    def chain(self, distances: dict[Box, int], last: Box) -> list[Box]:
        """Few allowed boxes, each beside the next, from the first one to the last."""
        before: dict[Box, Box | None] = {last: None}
        queue = deque([last])
        while queue:
            box = queue.popleft()
            for other in self.beside(box):
                if other not in before and distances.get(other) == 0:
                    before[other] = box
                    queue.append(other)
        chain = [next(iter(distances))]
        while (following := before[chain[-1]]) is not None:
            chain.append(following)
        return chain

    def beside(self, box: Box) -> list[Box]:
        """The boxes, not cut any further, that share a part of a face with one."""
        if box not in self.near:
            self.near[box] = [
                other
                for axis in self.boxes.axes
                for step in (-1, 1)
                if (same := self.boxes.beside(box, axis, step)) is not None
                for other in self._uncut(same, axis, step)
            ]
        return self.near[box]

    def _uncut(self, box: Box, axis: int, step: int) -> Iterator[Box]:
        """The boxes into which one is cut, at the face by which it is entered, or the one that holds it."""
        while box not in self.verdicts:
            box = self.boxes.whole(box)
        if self.verdicts[box] is not None:
            yield box
            return
        parts = self.boxes.parts(box)
        places = [part[axis + 1] for part in parts]
        side = min(places) if step > 0 else max(places)
        for part in parts:
            if part[axis + 1] == side:
                yield from self._uncut(part, axis, step)

    def way(self, start: PosePoint, chain: Sequence[Box], stop: PosePoint) -> list[Spot]:
        """A polyline through the faces between boxes; its first spot is the start, no turns added."""
        at = turns(start)
        corner = near(self.boxes.middle(chain[0]), at)
        spots = [at]
        for box, following in pairwise(chain):
            other = near(self.boxes.middle(following), corner)
            spots.append(face(corner, other, self.boxes.sizes(box), self.boxes.sizes(following)))
            corner = other
        spots.append(near(turns(stop), corner))
        return [(tau * float(alpha), tau * float(theta), length) for alpha, theta, length in spots]


Span: TypeAlias = tuple[Fraction, Fraction]
Searches: TypeAlias = dict[tuple[int, Span], Search]
_INWARDS = [Fraction(1, 10**k) for k in range(2, 9)]


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
        """A route from boxes or from the coarse grid, or the outcome of the subdivision.

        Raises:
            Unproved: as :meth:`found`.
        """
        inner = [self._inside(pose, end) for end, pose in enumerate((self.start, self.stop))]
        # a route in the slice is found sooner than one in the range
        held = [(self.start.legs[0],) * 2] if self.start.legs[0] == self.stop.legs[0] else []
        spans = dict.fromkeys([*held, self.span])
        for span in spans:
            # boxes of three coordinates are many, so that the coarse grid comes first
            if span[0] != span[1] and (coarse := self._coarse(inner, span)):
                return coarse
            key = self.sign, span
            if key not in self.searches:
                self.searches[key] = Search(self._boxes(span))
            search = self.searches[key]
            try:
                outcome = search.outcome(*(_place(pose) for pose in inner))
            except Unproved:  # a pose is nearer to a limit than the narrowest boxes are wide
                outcome = Outcome(None, False, search.narrowest(), len(search.verdicts))
            if outcome.way is not None:
                return self._along(inner, outcome.way)
            if span[0] == span[1] and not outcome.is_separated and (coarse := self._coarse(inner, span)):
                return coarse
        return outcome

    def _coarse(self, inner: Sequence[EndPose], span: tuple[Fraction, Fraction]) -> ProvedRoute | None:
        """A proved route along a way on a coarse grid between two poses that are not on a limit."""
        grid = CoarseGrid(self.start.slice_map, self.sign, self.limits, *span)
        nodes = [grid.seen(pose) for pose in inner]
        if nodes[0] is None or nodes[1] is None or (way := grid.way(nodes[0], nodes[1])) is None:
            return None
        last = _place(inner[1])
        shifts = [tau * (a - b) / grid.sizes[0] for a, b in zip(way[-1], nodes[1], strict=True)]
        ending = float(last[0]) + shifts[0], float(last[1]) + shifts[1], last[2]
        first = float(inner[0].angles[0]), float(inner[0].angles[1]), inner[0].legs[0]
        try:
            return self._along(inner, [first, *map(grid.spot, way), ending])
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
        return straightened(slice_map, self.sign, self.start, self.stop, corners, self.limits)

    def kept(self, unlimited: ProvedRoute) -> ProvedRoute | None:
        """A route without limits, if it is proved to keep them."""
        route, _ = unlimited
        with ctx.workprec(PROOF_BITS):
            proof = prove(route.slice_map, route.at(PROOF_BITS - 64), self.sign, limits=self.limits)
        return None if proof is None else (route, proof)

    def resolution(self, outcome: Outcome) -> Resolution:
        """The size of the smallest boxes of an outcome."""
        size = (self.span[1] - self.span[0]) / self.start.slice_map.scale
        length = size / self._boxes(self.span).lengths(outcome.level) if size else None
        return Resolution(Fraction(360, 1 << outcome.level), length)

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
