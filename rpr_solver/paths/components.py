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

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from math import gcd, hypot, isfinite

from flint import arb, ctx

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.paths.box_tree import BoxTree
from rpr_solver.paths.boxes import BITS, FIRST_LEVEL, Box, Boxes, PosePoint, Resolution, Verdict
from rpr_solver.singular.aspects import UnionFind

_DEEPEST: Mapping[int, int] = {2: 16, 3: 10}
"""By the number of coordinates that are cut: the level at which cutting stops."""
_MOST_BOXES: Mapping[int, int] = {2: 40_000, 3: 20_000}

Direction = tuple[int, int, int]
"""Along α, θ and L, in widths of a box."""
_FLAT = [(p, q, 0) for p, q in product((-4, -2, -1, 0, 1, 2, 4), repeat=2) if gcd(p, q) == 1]
_FINE = 256
_TURNS = 6
_BETTER = 1.2
"""By so much a later direction must be better than one along fewer sides."""
_ALL = [*_FLAT, *((p, q, r) for p, q, r in product((-1, 0, 1), repeat=3) if r)]


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
        self._known: dict[Box, tuple[frozenset[int], list[list[arb]]]] = {}
        self._deepest = _DEEPEST[len(boxes.axes)]
        with ctx.workprec(BITS):
            count = _Count.of(self)
            while wanted := [box for box in count.open_boxes if box[0] < self._deepest]:
                if len(self.verdicts) > _MOST_BOXES[len(boxes.axes)]:
                    break
                for box in wanted:
                    self.cut(box)
                count = _Count.of(self)
            self.groups = sorted(
                count.groups, key=lambda group: -sum(Fraction(1, 4 ** box[0]) for box in group.inside)
            )
        self._of_box = {box: k for k, group in enumerate(self.groups) for box in group.boxes}
        level = self.narrowest()
        low, high, scale = boxes.low, boxes.high, boxes.slice_map.scale
        size = (high - low) / scale / boxes.lengths(level) if high > low else None
        self.resolution = Resolution(Fraction(360, 1 << level), size)

    def group_of(self, place: PosePoint) -> int | None:
        """The number, from 0, of the group that holds an allowed pose of this sign; None if it is too near an
        edge."""
        with ctx.workprec(BITS):
            for level in range(FIRST_LEVEL, self._deepest + 1):
                box = self.boxes.holding(place, level)
                if box is None or self.verdicts.get(box) is not None:
                    return None if box is None else self._of_box.get(box)
        return None

    def is_inside(self, box: Box) -> bool:
        """Whether a box is allowed everywhere."""
        return self.verdicts[box] is Verdict.IN

    def targets(self, box: Box) -> list[Box] | None:
        """The boxes to which the allowed poses of an undecided one are joined, if they are not in it alone;
        None if there is no direction in which everything grows."""
        if box not in self._targets:
            direction = self._direction(box, self._conditions(box)[0])
            self._targets[box] = None if direction is None else self._ahead(box, direction)
        return self._targets[box]

    def _ahead(self, box: Box, direction: Direction) -> list[Box] | None:
        found: list[Box] = []
        for axis, step in enumerate(direction):
            if step:
                same = self.boxes.neighbour(box, axis, 1 if step > 0 else -1)
                if same is None:  # the end of the range
                    return None
                found += self.uncut(same, axis, step)
        return found

    def _conditions(self, box: Box) -> tuple[frozenset[int], list[list[arb]]]:
        """The numbers of what is undecided on a box, and how each condition grows along its sides."""
        if box not in self._known:
            turn, _, length = self.boxes.sizes(box)
            angle = 2 * arb.pi() * ball_of(turn)
            units = angle, angle, ball_of(length)
            grown, missing = [], set()
            for number, (is_kept, slopes) in enumerate(self.boxes.slopes(box)):
                moved = [slope * unit for slope, unit in zip(slopes, units, strict=True)]
                size = sum((abs(x.mid()) for x in moved), arb(0)).mid()
                grown.append([x / size for x in moved])
                if not is_kept:
                    missing.add(number)
            self._known[box] = frozenset(missing), grown
        return self._known[box]

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
            direction = self._direction(box, numbers)
            if direction is not None and (targets := self._ahead(box, direction)) is not None:
                self._targets[box] = targets
        return bool(wider)

    def _asked(self, box: Box) -> frozenset[int]:
        return self._wider.get(box) or self._conditions(box)[0]

    def _direction(self, box: Box, numbers: frozenset[int]) -> Direction | None:
        """The direction in which conditions grow most evenly on a box."""
        _, grown = self._conditions(box)
        return _rising([grown[k] for k in sorted(numbers)], is_flat=2 not in self.boxes.axes)

    def cut(self, box: Box) -> None:
        """Cuts a box; what it is joined to, and its neighbours, is asked again."""
        for other in (box, *self.neighbours(box)):
            self._targets.pop(other, None)
            self._wider.pop(other, None)
        super().cut(box)


def _rising(conditions: Sequence[Sequence[arb]], is_flat: bool) -> Direction | None:
    """A direction in which all conditions are proved to grow."""
    rough = [[(float(x.mid()), float(x.rad())) for x in own] for own in conditions]
    if not all(isfinite(mid) and isfinite(rad) for own in rough for mid, rad in own):
        return None
    best, rate = None, 0.0
    for direction in _candidates([[mid for mid, _ in own] for own in rough], is_flat):
        least = min((_rate(direction, own) for own in rough), default=-1.0)
        if least > rate * _BETTER:
            best, rate = direction, least
    if best is None or not all(_dot(best, own) >= 0 for own in conditions):
        return None
    return best


def _dot(direction: Direction, slopes: Sequence[arb]) -> arb:
    return sum((d * x for d, x in zip(direction, slopes, strict=True)), arb(0))


def _rate(direction: Direction, slopes: Sequence[tuple[float, float]]) -> float:
    """How fast a condition grows at least, relative to its fastest growth; about."""
    norm = hypot(*direction) * hypot(*(mid for mid, _ in slopes))
    least = sum(d * mid - abs(d) * rad for d, (mid, rad) in zip(direction, slopes, strict=True))
    return least / norm if norm else -1.0


def _candidates(slopes: Sequence[Sequence[float]], is_flat: bool) -> Iterator[Direction]:
    """Directions along few sides first, then those between slopes."""
    yield from _FLAT if is_flat else _ALL
    units = [[x / size for x in own] for own in slopes if (size := hypot(*own))]
    for count in range(2, len(units) + 1):
        for chosen in combinations(units, count):
            way = [sum(x) for x in zip(*chosen, strict=True)]
            if is_flat:
                way[2] = 0.0
            if (most := max(map(abs, way))) > 0:
                p, q, r = (round(_FINE * x / most) for x in way)
                yield p, q, r


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
    waits: dict[Box, int] = {}
    waiting: dict[Box, list[Box]] = {}
    found: dict[Box, bool] = {}
    settled = deque[Box]()
    ahead = {box: targets for box in undecided if (targets := region.targets(box)) is not None}
    open_boxes = set(undecided)
    for box, targets in ahead.items():
        before = [other for other in targets if other in open_boxes]
        waits[box] = len(before)
        for other in before:
            waiting.setdefault(other, []).append(box)
        if not before:
            settled.append(box)
    while settled:
        box = settled.popleft()
        found[box] = any(
            found[other] if other in open_boxes else region.is_inside(other) for other in ahead[box]
        )
        for other in waiting.get(box, ()):
            waits[other] -= 1
            if not waits[other]:
                settled.append(other)
    return found


def _between(region: AllowedRegion, inside: UnionFind[Box], boxes: Sequence[Box]) -> list[Box]:
    """The undecided boxes at which what is nearest to one component of allowed boxes meets another one; none
    if there is one component alone."""
    known = set(boxes)
    nearest = {box: inside.root(box) for box in boxes if region.is_inside(box)}
    queue = deque(nearest)
    while queue:
        box = queue.popleft()
        for other in region.neighbours(box):
            if other in known and other not in nearest:
                nearest[other] = nearest[box]
                queue.append(other)
    return [
        box
        for box in boxes
        if not region.is_inside(box)
        and any(nearest.get(other, nearest[box]) != nearest[box] for other in region.neighbours(box))
    ]
