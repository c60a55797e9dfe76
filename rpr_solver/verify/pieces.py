"""Pieces of the curve J = 0 of a slice, and the image of each in the plane of the squared free legs.

In the frame of a *piece*, a direction and its left normal, J = 0 in a box |r| ≤ reach, |e| ≤ width is a graph
e(r): ∂J/∂e > 0 in the box, and J has opposite signs on both sides of a polynomial e*(r). All functions are
taken as Taylor's polynomials along this, and the rest is bounded by the amplitudes of their waves
(mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import hypot

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import (
    BITS,
    ERROR,
    FRAME,
    ONE,
    TURN,
    Front,
    Graph,
    Patch,
    Point,
    Series,
    Vector,
    fifth_power,
    framed,
    product,
)
from rpr_solver.verify.images import MOST_PIECES, Image, Pairs

_SPARE = 20
_FIRST_STEP, _LEAST_STEP = 0.2, 2.0**-100
_WIDEST_PATCH = ONE >> 5


def piece_between(front: Front, start: Point, stop: Point) -> Piece | None:
    """The piece of J = 0 from one point to another, which is ahead of it; None if it is not proved."""
    alpha, theta = (start.alpha + stop.alpha) >> 1, (start.theta + stop.theta) >> 1
    length = hypot((stop.alpha - start.alpha) / ONE, (stop.theta - start.theta) / ONE)
    reach = int(length * 0.51 * ONE) + 2 * (start.error + stop.error)
    near = False
    for last in (False, False, True):
        here = front.phases(alpha, theta)
        jet = front.singular.jet(here)
        a, t = jet[1] / ONE, jet[2] / ONE
        size = hypot(a, t)
        if not size or not length:
            return None
        if near:
            break
        if not last:  # to the curve
            x, y = int((1 << FRAME) * (a / size)), int((1 << FRAME) * (t / size))
            step = (jet[0] << (BITS + FRAME)) // (x * jet[1] + y * jet[2])
            alpha, theta = alpha - (step * x >> FRAME), theta - (step * y >> FRAME)
            near = product(abs(step), abs(step)) < fifth_power(reach) >> _SPARE
    unit = (1 << FRAME) * (1 - 2**-18)
    frame = int(unit * t / size), int(-unit * a / size)
    return _proved(front, (alpha, theta), frame, reach, (start, stop))


def _proved(
    front: Front, middle: Vector, frame: Vector, reach: int, ends: tuple[Point, Point]
) -> Piece | None:
    """The piece between two points in the box about a middle, if it is a graph there."""
    here = front.phases(*middle)
    spend(160, BITS)
    _, _, slope, _, twist, fold = framed(front.singular.jet(here), frame)
    graph = front.graph(here, frame, reach, slope) if slope > 0 else None
    if graph is None or graph.rest << 8 > reach:
        return None
    value = front.singular.along(graph)
    off = abs(value.terms[0]) + value.change
    radius = 2 * (off << BITS) // slope + 8 * max(point.error for point in ends)
    width = sum(map(abs, graph.places)) + radius
    across = reach + width  # no less than the distance from the middle
    if across > ONE:
        return None
    turn = product(front.singular.norms[3], product(across, across)) // 2
    least = slope - product(abs(twist), reach) - product(abs(fold), width) - turn - 16 * ERROR
    if least <= 0 or least * radius >> BITS <= off + ERROR:
        return None
    piece = Piece(front, ends, middle, graph, reach, width, radius)
    (first, e), (last, d) = (piece.place(point.alpha, point.theta) for point in ends)
    room = [2 * point.error for point in ends]
    inside = all(
        abs(r) + more <= reach and abs(s) + more <= width
        for (r, s), more in zip(((first, e), (last, d)), room, strict=True)
    )
    return piece if inside and first + room[0] < last - room[1] else None


@dataclass(frozen=True, eq=False)
class Piece(Image):
    """A piece of J = 0 between two points, with J > 0 on its left, and its image.

    Attributes:
        graph: a curve from which it is nowhere farther across than ``radius``.
    """

    front: Front
    ends: tuple[Point, Point]
    middle: Vector
    graph: Graph
    reach: int
    width: int
    radius: int

    def place(self, alpha: int, theta: int) -> Vector:
        """r and e of two angles; their errors are at most doubled."""
        x, y = self.graph.frame
        a, t = alpha - self.middle[0], theta - self.middle[1]
        square = x * x + y * y
        return ((a * x + t * y) << FRAME) // square, ((t * x - a * y) << FRAME) // square

    @cached_property
    def across(self) -> int:
        """No less than the distance of any of its points from the middle."""
        return self.reach + self.width

    @cached_property
    def halves(self) -> tuple[Piece, Piece]:
        """Two pieces of it.

        Raises:
            OpenError: they are too small.
        """
        first, last = (self.place(point.alpha, point.theta)[0] for point in self.ends)
        for part in (0.47, 0.56, 0.35):
            r = first + int((1 << FRAME) * part) * (last - first) // (1 << FRAME)
            e, (x, y) = self._height(r), self.graph.frame
            alpha, theta = (
                self.middle[0] + ((x * r - y * e) >> FRAME),
                self.middle[1] + ((y * r + x * e) >> FRAME),
            )
            point = self.front.point(alpha, theta, (-y, x), self.reach)
            if point is None or abs(point.alpha - alpha) + abs(point.theta - theta) > 2 * self.width:
                continue
            parts = (
                piece_between(self.front, self.ends[0], point),
                piece_between(self.front, point, self.ends[1]),
            )
            if parts[0] is not None and parts[1] is not None and self.holds(point):
                return parts[0], parts[1]
        raise OpenError("pieces of the singular curve are too small for intervals")

    def holds(self, point: Point) -> bool:
        """Whether a point of J = 0 is in its box, so on the piece or beside its ends."""
        r, e = self.place(point.alpha, point.theta)
        return abs(r) + 2 * point.error <= self.reach and abs(e) + 2 * point.error <= self.width

    def _height(self, r: int) -> int:
        """The place e of the curve at r."""
        e = 0
        for x in reversed(self.graph.places):
            e = x + e * r // self.reach
        return e

    @cached_property
    def image(self) -> tuple[Series, Series]:
        """The squared free legs along it."""
        rows = (leg.along(self.graph) for leg in self.front.legs)
        first, second = (
            Series(row.terms, row.rest + product(leg.norms[1], self.radius))
            for row, leg in zip(rows, self.front.legs, strict=True)
        )
        return first, second

    @cached_property
    def cusps(self) -> frozenset[int]:
        """The cusps that may be on it."""
        found = set()
        for n, (alpha, theta, error) in enumerate(self.front.cusps):
            near = [
                x - TURN * ((x - y + TURN // 2) // TURN)
                for x, y in zip((alpha, theta), self.middle, strict=True)
            ]
            r, e = self.place(near[0], near[1])
            if abs(r) <= self.reach + 4 * error and abs(e) <= self.width + 4 * error:
                found.add(n)
        return frozenset(found)

    @cached_property
    def tangents(self) -> tuple[Series, Series]:
        """A tangent of the image along it; on J = 0 the images of all directions are on one line."""
        x, y = self.graph.frame
        ways = ([leg.slope(self.graph, way) for leg in self.front.legs] for way in ((x, y), (-y, x)))
        rows = max(ways, key=lambda rows: sum(abs(row.terms[0]) for row in rows))
        first, second = (
            Series(row.terms, row.rest + product(leg.norms[2], self.radius))
            for row, leg in zip(rows, self.front.legs, strict=True)
        )
        return first, second


class Patches(Pairs[Piece]):
    """Squares that were found, in each of which the image of J = 0 does not meet itself."""

    def __init__(self) -> None:
        self.found: list[Patch] = []
        self.of: dict[Piece, tuple[int, set[int]]] = {}

    def _holding(self, piece: Piece) -> set[int]:
        """Those that hold a piece."""
        known, numbers = self.of.get(piece, (0, set()))
        numbers |= {
            n for n in range(known, len(self.found)) if self.found[n].holds(piece.middle, piece.across)
        }
        self.of[piece] = len(self.found), numbers
        return numbers

    def hold(self, x: Piece, y: Piece) -> bool:
        """Whether one square holds both pieces; another one is tried for them."""
        if self._holding(x) & self._holding(y):
            return True
        way = [(b - a + TURN // 2) % TURN - TURN // 2 for a, b in zip(x.middle, y.middle, strict=True)]
        reach = int(hypot(*way)) // 2 + max(x.across, y.across) + 2 * ERROR
        middle = x.middle[0] + way[0] // 2, x.middle[1] + way[1] // 2
        while reach < _WIDEST_PATCH and (patch := Patch.about(x.front, middle, reach)) is not None:
            self.found.append(patch)
            reach <<= 2
        return bool(self._holding(x) & self._holding(y))


def traced(front: Front, start: Point) -> list[Piece]:
    """The component of J = 0 through a point, in pieces.

    Raises:
        OpenError: pieces get too small, or there are too many.
    """
    return traced_to(front, start, [start])[0]


def traced_to(front: Front, start: Point, stops: Sequence[Point]) -> tuple[list[Piece], int]:
    """The part of J = 0 from a point to the first of others, in pieces, and the number of this one.

    Raises:
        OpenError: pieces get too small, or there are too many.
    """
    pieces: list[Piece] = []
    unit = (1 << FRAME) - 8
    here, step = start, _FIRST_STEP
    while len(pieces) < MOST_PIECES:
        spend(100, BITS)
        jet = front.singular.jet(front.phases(here.alpha, here.theta))
        a, t = jet[1] / ONE, jet[2] / ONE
        size = hypot(a, t)
        if not size or step < _LEAST_STEP:
            raise OpenError("pieces of the singular curve are too small for intervals")
        ahead = t / size, -a / size
        near = enumerate(stops if len(pieces) > 1 else ())
        stop, last = next(
            ((n, found) for n, x in near if (found := _closing(x, here, ahead, step))), (0, None)
        )
        there = last or front.point(
            here.alpha + int(step * ahead[0] * ONE),
            here.theta + int(step * ahead[1] * ONE),
            (int(-ahead[1] * unit), int(ahead[0] * unit)),
            int(step * ONE),
        )
        piece = None if there is None else piece_between(front, here, there)
        if there is None or piece is None:
            step /= 2
            continue
        pieces.append(piece)
        if last is not None:
            return pieces, stop
        here, step = there, min(step * 1.5, _FIRST_STEP)
    raise OpenError("the singular curve has too many pieces")


def _closing(start: Point, here: Point, ahead: tuple[float, float], step: float) -> Point | None:
    """A point at which a part of J = 0 ends, by full turns nearer, if it is less than a step ahead."""
    turns = round((here.alpha - start.alpha) / TURN), round((here.theta - start.theta) / TURN)
    point = start.turned(turns)
    x, y = (point.alpha - here.alpha) / ONE, (point.theta - here.theta) / ONE
    forward, aside = x * ahead[0] + y * ahead[1], y * ahead[0] - x * ahead[1]
    return point if 0 < forward <= 1.2 * step and abs(aside) <= step / 2 else None
