"""Points, boxes and polylines in the plane of a picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

Point = tuple[float, float]
Line = Sequence[Point]


@dataclass(frozen=True)
class Box:
    """A rectangle with sides parallel to the axes.

    >>> Box(0, 0, 4, 2).centre, Box(0, 0, 4, 2).grown(1)
    ((2.0, 1.0), Box(x0=-1, y0=-1, x1=5, y1=3))
    """

    x0: float
    y0: float
    x1: float
    y1: float

    @classmethod
    def around(cls, points: Iterable[Point]) -> Box:
        """The smallest box with all points, of which there is at least one."""
        xs, ys = zip(*points, strict=True)
        return cls(min(xs), min(ys), max(xs), max(ys))

    @property
    def width(self) -> float:
        """The horizontal side."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """The vertical side."""
        return self.y1 - self.y0

    @property
    def centre(self) -> Point:
        """The centre."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def corners(self) -> tuple[Point, Point, Point, Point]:
        """The corners, in turn."""
        return (self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)

    def grown(self, by: float) -> Box:
        """The box with a margin on every side; a negative one shrinks it."""
        return Box(self.x0 - by, self.y0 - by, self.x1 + by, self.y1 + by)

    def meets(self, other: Box) -> bool:
        """Whether the boxes have inner points in common."""
        return self.x0 < other.x1 and other.x0 < self.x1 and self.y0 < other.y1 and other.y0 < self.y1

    def __contains__(self, point: Point) -> bool:
        return self.x0 <= point[0] <= self.x1 and self.y0 <= point[1] <= self.y1


def distance(a: Point, b: Point) -> float:
    """The distance of two points."""
    return hypot(b[0] - a[0], b[1] - a[1])


def between(a: Point, b: Point, share: float) -> Point:
    """The point at a share of the way from one point to another."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def off_segment(point: Point, a: Point, b: Point) -> float:
    """The distance of a point from a segment.

    >>> off_segment((0, 1), (-1, 0), (1, 0)), off_segment((4, 4), (0, 0), (1, 0))
    (1.0, 5.0)
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    share = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / square if square else 0.0
    return distance(point, between(a, b, min(max(share, 0.0), 1.0)))


def area(ring: Line) -> float:
    """The area of a closed ring, positive if it runs clockwise in a picture.

    >>> area(Box(0, 0, 3, 2).corners), area(Box(0, 0, 3, 2).corners[::-1])
    (6.0, -6.0)
    """
    return sum(ring[k - 1][0] * ring[k][1] - ring[k][0] * ring[k - 1][1] for k in range(len(ring))) / 2


def simplified(line: Line, tolerance: float) -> list[Point]:
    """The polyline without points that are not needed within a tolerance (Douglas and Peucker).

    >>> simplified([(0, 0), (1, 0.01), (2, 0), (2, 2)], 0.1)
    [(0, 0), (2, 0), (2, 2)]
    """
    if len(line) < 3:
        return list(line)
    kept = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        (ax, ay), (bx, by) = line[first], line[last]
        dx, dy = bx - ax, by - ay
        length = hypot(dx, dy)
        worst, at = tolerance, 0
        for k in range(first + 1, last):
            x, y = line[k]
            off = abs(dx * (y - ay) - dy * (x - ax)) / length if length else hypot(x - ax, y - ay)
            if off > worst:
                worst, at = off, k
        if at:
            kept.add(at)
            spans += [(first, at), (at, last)]
    return [line[k] for k in sorted(kept)]


def clipped(line: Line, box: Box) -> Iterator[list[Point]]:
    """Yields the pieces of a polyline that lie in a box.

    >>> list(clipped([(-1, 1), (3, 1), (3, 5)], Box(0, 0, 2, 2)))
    [[(0.0, 1.0), (2.0, 1.0)]]
    """
    piece: list[Point] = []
    for a, b in pairwise(line):
        inside = _inside(a, b, box)
        if inside is None:
            if piece:
                yield piece
            piece = []
            continue
        start, stop = inside
        if piece and start > 0:
            yield piece
            piece = []
        if not piece:
            piece = [between(a, b, start) if start else a]
        piece.append(between(a, b, stop) if stop < 1 else b)
        if stop < 1:
            yield piece
            piece = []
    if piece:
        yield piece


def _inside(a: Point, b: Point, box: Box) -> tuple[float, float] | None:
    """The shares of a segment between which it lies in a box (Liang and Barsky)."""
    start, stop = 0.0, 1.0
    dx, dy = b[0] - a[0], b[1] - a[1]
    for slope, room in (
        (-dx, a[0] - box.x0),
        (dx, box.x1 - a[0]),
        (-dy, a[1] - box.y0),
        (dy, box.y1 - a[1]),
    ):
        if slope == 0:
            if room < 0:
                return None
        elif slope < 0:
            start = max(start, room / slope)
        else:
            stop = min(stop, room / slope)
    return (start, stop) if start < stop else None
