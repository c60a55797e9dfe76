"""Where the images of two pieces of J = 0 cross: exactly once, or not at all; where one ends at another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import BITS, Vector
from rpr_solver.verify.images import UNDECIDED, Image, Pairs, chord, is_simple, normal_of

STEP = 1 << 240
"""From one piece of a chain to the next."""
_LONGEST_RUN, _MOST_PAIRS = 48, 3000
Edge = tuple[int, int]
"""A chain, and the number of the crossing on it after which the edge begins."""
Side = tuple[int, int, bool]
"""An edge, and whether it is the left side."""
OUTSIDE: Side = (-1, 0, True)


@dataclass(frozen=True, eq=False)
class Leaf:
    """A piece of chain ``chain``, and where on it: from ``low`` to ``high``."""

    piece: Image
    chain: int
    low: int
    high: int

    @cached_property
    def halves(self) -> tuple[Leaf, Leaf]:
        """Two parts of it."""
        middle, (first, last) = (self.low + self.high) // 2, self.piece.halves
        if not self.low < middle < self.high:
            raise OpenError(UNDECIDED)
        return Leaf(first, self.chain, self.low, middle), Leaf(last, self.chain, middle, self.high)

    def meets(self, other: Leaf) -> bool:
        """Whether two leaves may have a point of a chain in common."""
        return self.chain == other.chain and self.low < other.high and other.low < self.high


@dataclass
class Crossing:
    """Two leaves whose images cross exactly once, the second one to the left."""

    leaves: tuple[Leaf, Leaf]

    def refine(self, patches: Pairs[Any]) -> None:
        """Takes parts of both leaves."""
        pairs = product(self.leaves[0].halves, self.leaves[1].halves)
        found = [x for first, second in pairs for x in crossings(first, second, patches)]
        if len(found) != 1:
            raise OpenError(UNDECIDED)
        self.leaves = found[0].leaves

    def joins(self, first: tuple[Edge, Edge], second: tuple[Edge, Edge]) -> Iterator[tuple[Side, Side]]:
        """Sides of one region, given the edges before and after the crossing on both chains."""
        (a_in, a_out), (b_in, b_out) = first, second
        # b crosses a to the left: round the crossing a goes out, b goes out, a comes in, b comes in
        yield (*a_in, True), (*b_out, True)
        yield (*b_in, True), (*a_in, False)
        yield (*a_out, False), (*b_in, False)
        yield (*b_out, False), (*a_out, True)


@dataclass(frozen=True)
class Mark:
    """A place on a chain, between two pieces."""

    chain: int
    low: int

    @property
    def high(self) -> int:
        """The same place."""
        return self.low

    def meets(self, other: Leaf) -> bool:
        """Whether it is inside of a leaf; leaves end there."""
        return self.chain == other.chain and other.low < self.low < other.high


@dataclass
class Contact:
    """Where a chain ends at another one, which it touches: both places, and how.

    Attributes:
        starts: whether the second chain begins there.
        left: whether it is on the left of the first one.
    """

    leaves: tuple[Mark, Mark]
    starts: bool
    left: bool

    def refine(self, patches: Pairs[Any]) -> None:
        """Nothing is narrower than a place."""

    def joins(self, first: tuple[Edge, Edge], second: tuple[Edge, Edge]) -> Iterator[tuple[Side, Side]]:
        """Sides of one region; there is no edge from the end of a chain to its start: it is outside."""
        (a_in, a_out), (b_in, b_out) = first, second
        (b, none), left = (b_out, b_in) if self.starts else (b_in, b_out), self.left
        yield (*a_in, left), (*b, left == self.starts)
        yield (*a_out, left), (*b, left != self.starts)
        yield (*a_in, not left), (*a_out, not left)
        yield (*none, True), OUTSIDE
        yield (*none, False), OUTSIDE


def crossings(first: Leaf, second: Leaf, patches: Pairs[Any]) -> Iterator[Crossing]:
    """All crossings of the images of two leaves.

    Raises:
        OpenError: intervals do not tell.
    """
    todo, left = [(first, second)], _MOST_PAIRS
    while todo:
        x, y = todo.pop()
        left -= 1
        if not left:
            raise OpenError(UNDECIDED)
        spend(30, BITS)
        if _apart(x.piece, y.piece) or patches.hold(x.piece, y.piece):
            continue
        if _cross(x.piece, y.piece):
            yield Crossing((x, y) if _cross(x.piece, y.piece) > 0 else (y, x))
        elif x.piece.size >= y.piece.size:
            todo += [(part, y) for part in x.halves]
        else:
            todo += [(x, part) for part in y.halves]


def _apart(x: Image, y: Image) -> bool:
    (a, b, c, d), (p, q, r, s) = x.box, y.box
    if b < p or q < a or d < r or s < c:
        return True
    for vector in (chord(x), chord(y), x.tangent, y.tangent):
        normal = normal_of(vector)
        (c, r), (d, s) = x.along(normal), y.along(normal)
        if abs(c - d) > r + s:
            return True
    return False


def _cross(x: Image, y: Image) -> int:
    """±1 if both images cross exactly once, y leading to the left or to the right of x; 0 if that is open.

    They are transversal, and each leads through the other's strip.
    """
    sense = x.heading * y.heading and x.crosses(y) * x.heading * y.heading
    return sense if sense and _leads_through(x, y) and _leads_through(y, x) else 0


def _leads_through(x: Image, y: Image) -> bool:
    """Whether the ends of x are on different sides of a strip that holds y."""
    normal = normal_of(chord(y))
    middle, radius = y.along(normal)
    first, last = (beyond(point.image, point.blur, normal, middle, radius) for point in x.ends)
    return first * last < 0


def beyond(image: Vector, blur: int, normal: Vector, middle: int, radius: int) -> int:
    """±1 where a point is beyond a strip, 0 otherwise."""
    value = image[0] * normal[0] + image[1] * normal[1] - middle
    room = radius + blur * (abs(normal[0]) + abs(normal[1]))
    return (value > room) - (value < -room)


def in_one_run(x: Leaf, y: Leaf, chain: Sequence[Leaf]) -> bool:
    """Whether two leaves, the first of a chain, are neighbours, or of one run that does not meet itself."""
    if x.chain != y.chain:
        return False
    first, last = sorted((x.low // STEP, y.low // STEP))
    between = last - first
    if between == 1 or between == len(chain) - 1:
        return True
    if _apart(x.piece, y.piece):
        return True
    pieces = [leaf.piece for leaf in chain]
    runs = pieces[first : last + 1], pieces[last:] + pieces[: first + 1]
    return any(len(run) <= _LONGEST_RUN and is_simple(run) for run in runs)
