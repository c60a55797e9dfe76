"""The parts of the allowed region: of the poses at which J has a sign and the legs keep their limits.

Boxes (:mod:`rpr_solver.paths.boxes`) are cut until the undecided ones hide nothing. On an undecided box
there may be a direction in which everything grows that is not decided there: J, and the room that limits
leave. Then each allowed pose of the box is joined to one on the faces in this direction, and so on from box
to box. If this never returns to a box, it ends in boxes that are allowed everywhere, or the first box has no
allowed pose.

So there are at most as many parts as the allowed boxes have components, and at least as many as these have
together with the undecided boxes. Where both agree, their number is proved
(mathematics.md#parts-of-the-allowed-region).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from graphlib import CycleError, TopologicalSorter
from itertools import combinations, product
from math import gcd
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.paths.box_tree import BoxTree
from rpr_solver.paths.boxes import Box, Boxes, PosePoint, Verdict
from rpr_solver.paths.cells import reached
from rpr_solver.singular.aspects import UnionFind

if TYPE_CHECKING:
    from rpr_solver.paths.pose_boxes import Doubles

_DEEPEST: Mapping[int, int] = {2: 16, 3: 10}
"""By the number of coordinates that are cut: the level at which cutting stops."""
_MOST_BOXES: Mapping[int, int] = {2: 40_000, 3: 40_000}

Direction = tuple[float, float, float]
"""Along α, θ and L, in widths of a box."""
_STEPS = (-4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0)
_FLAT = sorted(
    ((p, q, 0.0) for p, q in product(_STEPS, repeat=2) if gcd(int(p), int(q)) == 1),
    key=lambda way: sum(map(bool, way)),
)
_WAYS = np.array([*_FLAT, *(way for way in product((-1.0, 0.0, 1.0), repeat=3) if way[2])])
"""Directions along few sides, which are tried first: those along one of α and θ, along both, and others."""
_FINE = 256
_TURNS = 6
_LEAST_RATE = 1e-9
"""How fast conditions must grow at least, relatively: far more than any rounding."""
_TINY = 1e-300
"""What keeps a quotient from being 0 / 0."""
_BETTER = 1.2
"""By so much a later direction must be better than one along fewer sides."""


class AllowedRegion(BoxTree):
    """The allowed region of one sign of J, cut into boxes and counted.

    Attributes:
        groups: of boxes, each a part if that is proved; those with the most room first.
        resolution: the size of the narrowest boxes.
    """

    def __init__(self, boxes: Boxes) -> None:
        super().__init__(boxes)
        self._targets: dict[Box, list[Box] | None] = {}
        self._wider: dict[Box, frozenset[int]] = {}
        deepest, count = _DEEPEST[len(boxes.axes)], _Count.of(self)
        while wanted := [box for box in count.open_boxes if box[0] < deepest]:
            if len(self.verdicts) > _MOST_BOXES[len(boxes.axes)]:
                break
            self.cut(wanted)
            count = _Count.of(self)
        self.groups = sorted(
            count.groups, key=lambda group: -sum(Fraction(1, 4 ** box[0]) for box in group.inside)
        )
        self._of_box = {box: k for k, group in enumerate(self.groups) for box in group.boxes}
        self.resolution = boxes.resolution(self.narrowest())

    def group_of(self, place: PosePoint) -> int | None:
        """The number, from 0, of the group that holds an allowed pose of this sign; None if it is too near an
        edge."""
        box = self.leaf(place)
        return None if box is None else self._of_box.get(box)

    def is_inside(self, box: Box) -> bool:
        """Whether a box is allowed everywhere."""
        return self.verdicts[box] is Verdict.IN

    def targets(self, box: Box) -> list[Box] | None:
        """The boxes to which the allowed poses of an undecided one are joined, if they are not in it alone;
        None if there is no direction in which everything grows."""
        if box not in self._targets:
            self._targets[box] = self._ahead(box, self.judgements[box].missing)
        return self._targets[box]

    def _ahead(self, box: Box, numbers: frozenset[int]) -> list[Box] | None:
        """The boxes beyond the faces in a direction in which conditions grow; None if there is none."""
        mids, radii = (part[sorted(numbers)] for part in self.judgements[box].slopes)
        low, high = (0.0 if self.boxes.neighbour(box, 2, k) is None else k * np.inf for k in (-1, 1))
        if (direction := _rising(mids, radii, (low, high))) is None:
            return None
        steps = [(axis, 1 if size > 0 else -1) for axis, size in enumerate(direction) if size]
        beside = ((self.boxes.neighbour(box, *step), step) for step in steps)
        return [other for same, step in beside if same is not None for other in self.uncut(same, *step)]

    def turn(self, boxes: Iterable[Box]) -> bool:
        """Gives boxes with ways that return directions in which also grows what is undecided on those of them
        that are beside; whether one has another direction now.

        So do boxes of both sides of a thin corner find a common direction.
        """
        wider = {}
        asked = set(boxes)
        for box in asked:
            more = self._asked(box).union(*(self._asked(x) for x in self.neighbours(box) if x in asked))
            if more != self._asked(box):
                wider[box] = more
        for box, numbers in wider.items():
            self._wider[box] = numbers
            if (targets := self._ahead(box, numbers)) is not None:
                self._targets[box] = targets
        return bool(wider)

    def _asked(self, box: Box) -> frozenset[int]:
        return self._wider.get(box) or self.judgements[box].missing

    def forget(self, box: Box) -> None:
        """Forgets what depends on how the boxes beside one are cut."""
        super().forget(box)
        self._targets.pop(box, None)
        self._wider.pop(box, None)


def _rising(mids: Doubles, radii: Doubles, ends: tuple[float, float]) -> Direction | None:
    """The direction in which conditions (rows) grow most evenly, by their slopes and their radii; None if it
    is not proved that all grow. ``ends`` are those of its part along L.
    """
    sizes = np.sqrt((mids**2).sum(axis=1))
    if not (np.isfinite(mids).all() and np.isfinite(radii).all() and len(sizes) and sizes.all()):
        return None
    first = _WAYS[(ends[0] <= _WAYS[:, 2]) & (_WAYS[:, 2] <= ends[1])]
    ways = np.concatenate([first, _between_slopes(mids, ends)])
    # how fast each condition grows at least, relative to its fastest growth
    least = (ways @ mids.T - abs(ways) @ radii.T) / (np.sqrt((ways**2).sum(axis=1))[:, None] * sizes)
    best, rate = None, _LEAST_RATE
    for number, own in enumerate(least.min(axis=1).tolist()):
        if own > rate * (1 if best is None else _BETTER):
            best, rate = number, own
    if best is None:
        return None
    p, q, r = ways[best].tolist()
    return p, q, r


def _between_slopes(mids: Doubles, ends: tuple[float, float]) -> Doubles:
    """Directions between slopes, and between their parts along α and θ; their parts along L have these
    ends."""
    found = [np.zeros((0, 3))]
    for slopes in (mids, mids * [1, 1, 0]):
        units = slopes / (np.linalg.norm(slopes, axis=1, keepdims=True) + _TINY)
        for count in range(2, len(units) + 1):
            ways = np.array(list(combinations(units, count))).sum(axis=1)
            ways[:, 2] = ways[:, 2].clip(*ends)
            most = abs(ways).max(axis=1)
            found.append(np.rint(_FINE * ways[most > 0] / most[most > 0, None]))
    return np.concatenate(found)


@dataclass(frozen=True)
class Group:
    """Boxes that may have allowed poses, and hang together.

    Attributes:
        boxes: all of them.
        inside: those that are allowed everywhere.
        is_one: whether its allowed poses are proved to be one part.
        stuck: an undecided box that stands in the way of the proof, or any box.
    """

    boxes: list[Box]
    inside: list[Box]
    is_one: bool
    stuck: Box


@dataclass(frozen=True)
class _Count:
    """What is known of the parts with these boxes.

    Attributes:
        groups: of boxes; no part meets two of them.
        open_boxes: undecided boxes that are to be cut for more.
    """

    groups: list[Group]
    open_boxes: list[Box]

    @classmethod
    def of(cls, region: AllowedRegion) -> _Count:
        """The count of a region as it is cut."""
        allowed, undecided = region.leaves(Verdict.IN), region.leaves(Verdict.UNDECIDED)
        leads = _turned_leads(region, undecided)
        inside = _joined(region, allowed)
        maybe = _joined(region, [*allowed, *(box for box in undecided if leads.get(box, True))])
        groups, wanted = [], []
        for boxes in maybe.classes():
            loose = [box for box in boxes if box not in leads and not region.is_inside(box)]
            stuck = [box for box in loose if region.targets(box) is None] or loose
            stuck = stuck or _between(region, inside, boxes)
            wanted += stuck
            own = list(filter(region.is_inside, boxes))
            groups.append(Group(boxes, own, not stuck, (stuck or boxes)[0]))
        return cls(groups, wanted)


def _turned_leads(region: AllowedRegion, undecided: Sequence[Box]) -> dict[Box, bool]:
    """The same as :func:`_leads`, with other directions for boxes whose ways return."""
    leads = _leads(region, undecided)
    for _ in range(_TURNS):
        if not region.turn(x for x in undecided if x not in leads and region.targets(x) is not None):
            break
        leads = _leads(region, undecided)
    return leads


def _joined(region: AllowedRegion, boxes: Sequence[Box]) -> UnionFind[Box]:
    """Classes of boxes that hang together by faces."""
    found = UnionFind(boxes)
    for box in boxes:
        for other in region.neighbours(box):
            if other in found:
                found.join(box, other)
    return found


def _leads(region: AllowedRegion, undecided: Sequence[Box]) -> dict[Box, bool]:
    """Whether the allowed poses of undecided boxes are joined to allowed boxes, or there are none; without
    the boxes of which that is not known."""
    found: dict[Box, bool] = {}
    ahead = {box: targets for box in undecided if (targets := region.targets(box)) is not None}
    open_boxes = set(undecided)
    order = TopologicalSorter({box: open_boxes.intersection(own) for box, own in ahead.items()})
    with suppress(CycleError):  # boxes from which no way returns are in order all the same
        order.prepare()
    while ready := [box for box in order.get_ready() if box in ahead]:
        for box in ready:
            found[box] = any(found.get(other) or region.is_inside(other) for other in ahead[box])
        order.done(*ready)
    return found


def _between(region: AllowedRegion, inside: UnionFind[Box], boxes: Sequence[Box]) -> list[Box]:
    """The undecided boxes at which what is nearest to one component of allowed boxes meets another one; none
    if there is one component alone."""
    known, nearest = set(boxes), dict[Box, Box]()
    before = reached(
        filter(region.is_inside, boxes),
        lambda box: ((other, box) for other in region.neighbours(box) if other in known),
    )
    for box, last in before.items():
        nearest[box] = inside.root(box) if last is None else nearest[last]
    return [
        box
        for box in boxes
        if not region.is_inside(box)
        and any(nearest.get(other, nearest[box]) != nearest[box] for other in region.neighbours(box))
    ]
