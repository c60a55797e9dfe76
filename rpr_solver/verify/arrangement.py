"""The regions into which the image of J = 0 divides the joint plane, by pieces that do not cross twice.

Each component of J = 0 is a closed chain of pieces. The images of two pieces are proved to be apart, or to
cross exactly once, or to be parts of one run of pieces that does not meet itself. So all crossings are known,
and the number of regions by Euler's formula; lines tell in which of them a point is
(mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import BITS, ERROR, Vector
from rpr_solver.verify.images import (
    OUTSIDE,
    STEP,
    UNDECIDED,
    Contact,
    Crossing,
    Edge,
    Image,
    Leaf,
    Pairs,
    Side,
    beyond,
    crossings,
    in_one_run,
)
from rpr_solver.verify.topology import Classes

_REFINEMENTS = 60
At = Crossing | Contact
Touching = Callable[[Sequence[Sequence[Leaf]]], Iterable[Contact]]
"""Where open chains end, given all chains as leaves."""


@dataclass
class Hit:
    """A leaf whose image a line crosses once, to the left (1) or to the right (−1)."""

    leaf: Leaf
    sense: int


class Row(NamedTuple):
    """Where a line crosses the image: from ``low`` to ``high`` along it, and the side before."""

    low: int
    high: int
    before: Side


class Arrangement:
    """The image of chains of pieces, with all of its crossings; they are closed, or end in contacts."""

    def __init__(
        self, chains: Sequence[Sequence[Image]], patches: Pairs[Any], touching: Touching = lambda _: ()
    ) -> None:
        self.patches = patches
        self.chains = [
            [Leaf(piece, n, k * STEP, (k + 1) * STEP) for k, piece in enumerate(self.patches.cut(chain))]
            for n, chain in enumerate(chains)
        ]
        self.crossings = list(self._crossings())
        self.contacts = list(touching(self.chains))
        self._all: list[At] = [*self.crossings, *self.contacts]
        self._order = self._ordered()
        edges = ((n, k) for n, row in enumerate(self._order) for k in range(max(len(row), 1)))
        self.sides: Classes[Side] = Classes((*edge, left) for edge in edges for left in (False, True))
        self.sides[OUTSIDE] = OUTSIDE
        self._turn()

    def _crossings(self) -> Iterator[Crossing]:
        leaves = sorted((x for chain in self.chains for x in chain), key=lambda x: x.piece.box[0])
        active: list[Leaf] = []
        for x in leaves:
            left, _, bottom, top = x.piece.box
            active = [y for y in active if y.piece.box[1] >= left]
            spend(len(active) // 4)
            for y in active:
                if (
                    y.piece.box[2] <= top
                    and y.piece.box[3] >= bottom
                    and not in_one_run(x, y, self.chains[x.chain])
                ):
                    yield from crossings(x, y, self.patches)
            active.append(x)

    def _ordered(self) -> list[list[tuple[At, int]]]:
        """The crossings on each chain in their order, and which of both leaves is that of the chain."""
        order: list[list[tuple[At, int]]] = [[] for _ in self.chains]
        for crossing in self._all:
            for k in (0, 1):
                order[crossing.leaves[k].chain].append((crossing, k))
        for row in order:
            for _ in range(_REFINEMENTS):
                row.sort(key=lambda x: (x[0].leaves[x[1]].low, x[0].leaves[x[1]].high))
                close = [
                    z
                    for x, y in pairwise(row)
                    if x[0].leaves[x[1]].high > y[0].leaves[y[1]].low
                    for z in (x, y)
                ]
                if not close:
                    break
                for crossing in {id(x): x for x, _ in close}.values():
                    crossing.refine(self.patches)
            else:
                raise OpenError(UNDECIDED)
        return order

    def _turn(self) -> None:
        """Joins the sides that follow each other round the regions at each crossing."""
        edges: dict[int, list[tuple[Edge, Edge]]] = defaultdict(lambda: [((0, 0), (0, 0))] * 2)
        for n, row in enumerate(self._order):
            for k, (crossing, which) in enumerate(row):
                edges[id(crossing)][which] = ((n, (k - 1) % len(row)), (n, k))
        for crossing in self._all:
            for pair in crossing.joins(*edges[id(crossing)]):
                self.sides.join(*pair)

    def root(self, side: Side) -> Side:
        """One of all sides that are known to be of the region of one."""
        return self.sides.root(side)

    @property
    def number(self) -> int:
        """The number of regions, by Euler's formula: of crossings, open chains, connected parts, and 1."""
        parts = Classes(range(len(self.chains)))
        for crossing in self._all:
            parts.join(crossing.leaves[0].chain, crossing.leaves[1].chain)
        return len(self.crossings) + len(self.contacts) // 2 + parts.number + 1

    def span(self, side: Side) -> Iterator[Leaf]:
        """The leaves of an edge; the first and the last one may reach beyond it."""
        (n, k, _), row = side, [x.leaves[which] for x, which in self._order[side[0]]]
        for leaf in self.chains[n]:
            after = not row or leaf.high > row[k].low
            before = not row or leaf.low < row[(k + 1) % len(row)].high
            if (after or before) if k + 1 >= len(row) else (after and before):
                yield leaf

    @property
    def classes(self) -> int:
        """How many sets of sides are left, none of which are known to be of one region."""
        return self.sides.number

    def region(self, point: tuple[Fraction, Fraction]) -> Side:
        """A side of the region of a point, by the first of some lines through it on which all is decided.

        Raises:
            OpenError: intervals do not tell.
        """
        for normal in ((1, 0), (0, 1), (2, 1), (1, -2)):
            try:
                place = along((-normal[1], normal[0]), point)
                rows = self.line(normal, along(normal, point), place)
                return next((row.before for row in rows if row.low > place), OUTSIDE)
            except OpenError as error:
                last = error
        raise last

    def complete(self) -> None:
        """Joins sides by lines through all chains, until as many are left as there are regions.

        Raises:
            OpenError: there are more.
        """
        for chain in self.chains:
            for leaf in chain[:: len(chain) // 5 + 1]:
                if self.classes == self.number:
                    return
                try:
                    self.line((1, 0), sum(point.image[0] for point in leaf.piece.ends) // 2)
                except OpenError:
                    continue
        if self.classes != self.number:
            raise OpenError(UNDECIDED)

    def line(self, normal: Vector, value: int, place: int | None = None) -> list[Row]:
        """Joins the sides between which a line leads, and returns where it crosses the image, in order.

        Args:
            normal: to the line.
            value: of its points in this direction.
            place: on the line, which is not to be where it crosses the image.

        Raises:
            OpenError: intervals do not tell.
        """
        spend(10 * sum(map(len, self.chains)), BITS)
        hits = [hit for chain in self.chains for leaf in chain for hit in _hits(leaf, normal, value)]
        across = -normal[1], normal[0]
        _separate(hits, across, normal, value)
        here, rows = OUTSIDE, []
        for hit in sorted(hits, key=lambda hit: hit.leaf.piece.along(across)[0]):
            n, k = self._edge(hit, normal, value)
            _part(hit, across, normal, value, place)
            rows.append(Row(*_range(hit.leaf.piece, across), (n, k, hit.sense < 0)))
            self.sides.join(here, rows[-1].before)
            here = n, k, hit.sense > 0
        self.sides.join(here, OUTSIDE)
        return rows

    def _edge(self, hit: Hit, normal: Vector, value: int) -> Edge:
        """The edge of a hit."""
        row = self._order[hit.leaf.chain]
        for _ in range(_REFINEMENTS):
            near = [x for x, k in row if x.leaves[k].meets(hit.leaf)]
            if not near:
                before = sum(x.leaves[k].high <= hit.leaf.low for x, k in row)
                return hit.leaf.chain, (before - 1) % max(len(row), 1)
            for crossing in near:
                crossing.refine(self.patches)
            _refine(hit, normal, value)
        raise OpenError(UNDECIDED)


def along(normal: Vector, point: tuple[Fraction, Fraction]) -> int:
    """A point in a direction."""
    return int(sum(n * x for n, x in zip(normal, point, strict=True)) * (1 << BITS))


def _separate(hits: list[Hit], across: Vector, normal: Vector, value: int) -> None:
    """Takes parts of hits until their order along the line is known."""
    for _ in range(_REFINEMENTS):
        rows = sorted((*_range(hit.leaf.piece, across), n) for n, hit in enumerate(hits))
        close = {n for x, y in pairwise(rows) if x[1] >= y[0] for n in (x[2], y[2])}
        if not close:
            return
        for n in close:
            _refine(hits[n], normal, value)
    raise OpenError(UNDECIDED)


def _part(hit: Hit, across: Vector, normal: Vector, value: int, place: int | None) -> None:
    """Takes parts of a hit until it is not at the place."""
    for _ in range(_REFINEMENTS):
        low, high = _range(hit.leaf.piece, across)
        if place is None or not low - 16 * ERROR <= place <= high + 16 * ERROR:
            return
        if hit.leaf.piece.reach < 1 << (BITS - 40):
            raise OpenError("a point is too near the image of the singular curve")
        _refine(hit, normal, value)
    raise OpenError(UNDECIDED)


def _range(piece: Image, normal: Vector) -> Vector:
    middle, radius = piece.along(normal)
    return middle - radius, middle + radius


def _hits(leaf: Leaf, normal: Vector, value: int) -> Iterator[Hit]:
    """Where a line crosses a leaf.

    Raises:
        OpenError: intervals do not tell.
    """
    middle, radius = leaf.piece.along(normal)
    if abs(value - middle) > radius + ERROR:
        return
    spend(30, BITS)
    if not leaf.piece.cusps and leaf.piece.leans(normal):
        sides = [beyond(point.image, point.blur, normal, value, ERROR) for point in leaf.piece.ends]
        if not all(sides):
            raise OpenError(UNDECIDED)
        if sides[0] != sides[1]:
            yield Hit(leaf, sides[1])
        return
    for part in leaf.halves:
        yield from _hits(part, normal, value)


def _refine(hit: Hit, normal: Vector, value: int) -> None:
    """Takes the part of a hit that the line crosses."""
    [part] = [x for half in hit.leaf.halves for x in _hits(half, normal, value)]
    hit.leaf = part.leaf
