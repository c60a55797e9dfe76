"""Images of pieces of J = 0 in the plane of the squared free legs: which do not meet, and where two cross.

A *piece* has series of both legs and of a tangent along it, whatever curve it is a piece of. Two images do
not meet, or they cross exactly once, or one ends at the other (mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, Generic, Self, TypeVar

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import BITS, Point, Series, Vector

_NORMAL, MOST_PIECES = 160, 6000
UNDECIDED = "parts of the singular curve's image are too near each other for intervals"
STEP = 1 << 240
"""From one piece of a chain to the next."""
_LONGEST_RUN, _MOST_PAIRS = 48, 3000
Edge = tuple[int, int]
"""A chain, and the number of the crossing on it after which the edge begins."""
Side = tuple[int, int, bool]
"""An edge, and whether it is the left side."""
OUTSIDE: Side = (-1, 0, True)
Part = TypeVar("Part", bound="Image")


def small(vector: Vector) -> Vector:
    """A vector of small integers that has about the direction of one."""
    shift = max(max(map(abs, vector)).bit_length() - _NORMAL, 0)
    return vector[0] >> shift, vector[1] >> shift


def normal_of(vector: Vector) -> Vector:
    """A vector of small integers that is about normal to one, on its left."""
    x, y = small(vector)
    return -y, x


def chord(piece: Image) -> Vector:
    """From the image of its start to that of its end."""
    (a, b), (c, d) = (point.image for point in piece.ends)
    return c - a, d - b


class Image(ABC):
    """A piece of the image of J = 0, by series along it.

    Attributes:
        ends: its ends.
        reach: how far it reaches from its middle, as an angle.
    """

    ends: tuple[Point, Point]
    reach: int

    @property
    @abstractmethod
    def image(self) -> tuple[Series, Series]:
        """The squared free legs along it."""

    @property
    @abstractmethod
    def tangents(self) -> tuple[Series, Series]:
        """A tangent of the image along it; it runs along this, or against it."""

    @property
    @abstractmethod
    def cusps(self) -> frozenset[int]:
        """The cusps that may be on it."""

    @property
    @abstractmethod
    def halves(self) -> tuple[Self, Self]:
        """Two pieces of it.

        Raises:
            OpenError: they are too small.
        """

    def along(self, normal: Vector) -> Vector:
        """The middle and the radius of the image in a direction, a vector of small integers; times this."""
        middle, *terms = _in_direction(self.image, normal)
        return middle, sum(map(abs, terms)) + sum(
            abs(x) * row.rest for x, row in zip(normal, self.image, strict=True)
        )

    @cached_property
    def box(self) -> tuple[int, int, int, int]:
        """Least and greatest first, then second coordinates of the image."""
        (a, r), (b, s) = self.along((1, 0)), self.along((0, 1))
        return a - r, a + r, b - s, b + s

    @property
    def size(self) -> int:
        """The size of the box of its image."""
        a, b, c, d = self.box
        return max(b - a, d - c)

    @property
    def tangent(self) -> Vector:
        """A tangent of the image in the middle."""
        return self.tangents[0].terms[0], self.tangents[1].terms[0]

    @cached_property
    def heading(self) -> int:
        """Whether a piece without a cusp runs along its tangent (1) or against it (−1); 0 if that is open."""
        normal, (start, stop) = small(self.tangent), self.ends
        if self.cusps or not self.leans(normal):
            return 0
        way = sum(n * (y - x) for n, x, y in zip(normal, start.image, stop.image, strict=True))
        room = (abs(normal[0]) + abs(normal[1])) * (start.blur + stop.blur)
        return (way > room) - (way < -room)

    def leans(self, normal: Vector) -> bool:
        """Whether no tangent of the image is normal to a direction."""
        first, *terms = _in_direction(self.tangents, normal)
        rest = sum(abs(x) * row.rest for x, row in zip(normal, self.tangents, strict=True))
        return abs(first) > sum(map(abs, terms)) + rest

    def crosses(self, other: Image) -> int:
        """The sign of the cross product of all tangents of this piece and of another; 0 if that is open."""
        (a, b), (c, d) = self.tangents, other.tangents
        value, *terms = (
            p * s - q * r
            for p, q in zip(a.terms, b.terms, strict=True)
            for r, s in zip(c.terms, d.terms, strict=True)
        )
        change = sum(map(abs, terms))
        for x, y in ((a, d), (b, c)):
            change += (abs(x.terms[0]) + x.change) * y.rest + (abs(y.terms[0]) + y.change) * x.rest
        return (value > change) - (value < -change)


def _in_direction(rows: tuple[Series, Series], normal: Vector) -> list[int]:
    """The polynomial of a direction."""
    return [normal[0] * x + normal[1] * y for x, y in zip(rows[0].terms, rows[1].terms, strict=True)]


def is_simple(run: Sequence[Image]) -> bool:
    """Whether the image of consecutive pieces without a cusp is proved not to meet itself."""
    spend(10 * len(run), BITS)
    normal = small(run[len(run) // 2].tangent)
    return not any(piece.cusps for piece in run) and all(piece.leans(normal) for piece in run)


class Pairs(ABC, Generic[Part]):
    """What is known of pairs of pieces whose images do not meet, but at a common end."""

    @abstractmethod
    def hold(self, x: Part, y: Part) -> bool:
        """Whether it is known of a pair, or found."""

    def cut(self, chain: Sequence[Part]) -> list[Part]:
        """The closed chain, cut so finely that no two neighbours meet but at their common end.

        Raises:
            OpenError: pieces get too small, or there are too many.
        """
        pieces = list(chain)
        while True:
            n = len(pieces)
            pairs = [(pieces[k], pieces[(k + 1) % n]) for k in range(n)]
            bad = {k for k, pair in enumerate(pairs) if not is_simple(pair) and not self.hold(*pair)}
            if n > 2 and not bad:
                return pieces
            if n > MOST_PIECES:
                raise OpenError(UNDECIDED)
            split = bad | {(k + 1) % n for k in bad} if n > 2 else set(range(n))
            pieces = [part for k, x in enumerate(pieces) for part in (x.halves if k in split else (x,))]


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
