"""Ways between two poses through boxes, all of whose poses are allowed.

Boxes (:mod:`rpr_solver.paths.boxes`) are cut until each is proved to be allowed everywhere or nowhere, but
only where it matters: on the ways between both poses that cross the fewest undecided boxes. If a way crosses
none, its boxes hold a path. If no way is left, even through boxes that stay undecided, there is no path: a
path meets boxes that share faces, for a point on an edge lies in all the closed boxes round it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import tau

from rpr_solver.errors import Unproved
from rpr_solver.exact.numerals import double
from rpr_solver.paths.box_tree import BoxTree
from rpr_solver.paths.boxes import (
    FIRST_LEVEL,
    Box,
    BoxPoint,
    PosePoint,
    Spot,
    Verdict,
    face,
    near,
    turns,
)
from rpr_solver.paths.cells import chained, reached

_LEVELS: Mapping[int, Sequence[int]] = {2: (7, 9, 11), 3: (7, 8, 9)}
"""By the number of coordinates that are cut: the levels, one after another, at which cutting stops."""
_MOST_BOXES, _MORE_BOXES = 40_000, 10_000
"""How many there may be, or be added to what searches between other poses have cut."""
_DEEPEST = 64
_WIDTHS = 2
"""Boxes of each level are cut that are so many of their widths away from a pose."""
_SLACK = 1
"""Ways may cross this many boxes more than the fewest, which saves searches."""


@dataclass(frozen=True)
class Outcome:
    """What a subdivision proved.

    Attributes:
        way: spots of a polyline from one pose to the other, in allowed boxes; None if none was found.
        is_separated: whether it is proved that there is no path.
        level: of the narrowest boxes that were used: 360°/2^level wide.
        near: about where it stays undecided; None where it does not.
    """

    way: list[Spot] | None
    is_separated: bool
    level: int
    near: Spot | None = None


class Search(BoxTree):
    """The search for ways through boxes; what is cut for one stays cut for others."""

    def outcome(self, start: PosePoint, stop: PosePoint) -> Outcome:
        """Looks for a way between two allowed poses; what is cut stays cut for other poses.

        Raises:
            Unproved: a pose is too near to the edge of what is allowed.
        """
        first, last = self.settled(start), self.settled(stop)
        done = FIRST_LEVEL
        most_boxes = max(_MOST_BOXES, len(self.verdicts) + _MORE_BOXES)
        for level in _LEVELS[len(self.boxes.axes)]:
            while len(self.verdicts) < most_boxes:
                from_start = self.distances(first, level)
                if last not in from_start:
                    if last not in self.distances(first, None):
                        return Outcome(None, True, self.narrowest())
                    break
                if from_start[last] == 0:
                    way = self.way(start, self.chain(from_start, last), stop)
                    return Outcome(way, False, self.narrowest())
                self.cut(self._crossed(from_start, last, level, _SLACK))
            else:
                break
            done = level
        return Outcome(None, False, done)

    def stuck(self, start: PosePoint, stop: PosePoint) -> Spot | None:
        """About where it stays undecided whether there is a way: an undecided box on the best ways; or a pose
        itself, if it has no allowed box."""
        ends = []
        for place in (start, stop):
            try:
                ends.append(self.settled(place))
            except Unproved:
                return spot_of(turns(place))
        crossed = self._crossed(self.distances(ends[0], None), ends[1], None, 0)
        return spot_of(self.boxes.middle(crossed[0])) if crossed else None

    def _crossed(
        self, from_start: Mapping[Box, int], last: Box, deepest: int | None, slack: int
    ) -> list[Box]:
        """The undecided boxes on ways to a box that cross the fewest of them, or so many more."""
        from_stop, most = self.distances(last, deepest), from_start.get(last, 0) + 1 + slack
        return [
            box
            for box, steps in from_start.items()
            if self.verdicts[box] is Verdict.UNDECIDED and steps + from_stop.get(box, most) <= most
        ]

    def settled(self, place: PosePoint) -> Box:
        """An allowed box round a pose, cut out if need be."""
        box = self.leaf(place)
        while box is not None and box[0] < _DEEPEST and self.verdicts[box] is Verdict.UNDECIDED:
            self.cut([box])
            box = self.leaf(place, box[0] + 1)
        if box is None or self.verdicts[box] is not Verdict.IN:
            raise Unproved("a pose is too near to a singularity or to a limit")
        self.open_round(place, box[0])
        return box

    def open_round(self, place: PosePoint, deepest: int) -> None:
        """Cuts the undecided boxes round a pose, the nearer the narrower, as deep as its own box was cut.

        A pose just inside a limit has an allowed box that is not wider than its distance from the limit;
        boxes beside it, each wider and farther from the limit, lead from there to the wide ones.
        """
        for level in range(FIRST_LEVEL, deepest + 1):
            near = [box] if (box := self.boxes.holding(place, level)) else []
            for axis in self.boxes.axes:
                steps = range(-_WIDTHS, _WIDTHS + 1)
                near = [x for box in near for step in steps if (x := self.boxes.neighbour(box, axis, step))]
            self.cut([box for box in dict.fromkeys(near) if self.verdicts.get(box) is Verdict.UNDECIDED])

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
            for other in self.neighbours(box):
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
        before = reached(
            [last],
            lambda box: ((other, box) for other in self.neighbours(box) if distances.get(other) == 0),
        )
        return chained(before, next(iter(distances)))

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
        return [spot_of(point) for point in spots]


def spot_of(point: BoxPoint) -> Spot:
    """A point of boxes in radians."""
    alpha, theta, length = point
    return tau * double(alpha), tau * double(theta), length
