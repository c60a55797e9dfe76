"""Scales, from a quantity to pixels with round numbers for ticks, and frames: what has scales in a figure."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from math import floor, log10

from rpr_solver.notebook.scene import Box, Line, Paint, Path, Point, Shape, Text

_STEPS = (Decimal(1), Decimal(2), Decimal(5), Decimal(10))


@dataclass(frozen=True)
class Scale:
    """A linear map of the values from ``low`` to ``high`` to pixels from ``start`` to ``stop``.

    >>> Scale(0, 10, 50, 150)(5)
    100.0
    """

    low: float
    high: float
    start: float
    stop: float

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.stop - self.start)

    def value(self, place: float) -> float:
        """The value at a pixel."""
        return self.low + (place - self.start) / (self.stop - self.start) * (self.high - self.low)


@dataclass(frozen=True)
class WidenedScale:
    """A map that is linear between neighbouring ``knots``, each of which has its own pixel in ``places``."""

    knots: tuple[float, ...]
    places: tuple[float, ...]

    @classmethod
    def of(cls, knots: Sequence[float], start: float, stop: float, least: float) -> WidenedScale:
        """The scale in which every interval has at least ``least`` pixels, and the others keep proportions.

        >>> WidenedScale.of([0, 90, 91, 100], 0, 100, 10).places
        (0, 80.0, 90.0, 100)
        """
        widths = [b - a for a, b in pairwise(knots)]
        room = stop - start
        least = min(least, room / max(len(widths), 1))
        narrow: set[int] = set()
        while True:
            wide = sum(w for k, w in enumerate(widths) if k not in narrow)
            free = room - least * len(narrow)
            more = {k for k, w in enumerate(widths) if k not in narrow and w * free < least * wide}
            if not more:
                break
            narrow |= more
        places = [start]
        for k, w in enumerate(widths):
            places.append(places[-1] + (least if k in narrow else w * free / wide))
        return cls(tuple(knots), (*places[:-1], stop))

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        k = min(max(bisect_right(self.knots, value), 1), len(self.knots) - 1)
        (a, b), (p, q) = self.knots[k - 1 : k + 1], self.places[k - 1 : k + 1]
        return p + (value - a) / (b - a) * (q - p)

    def is_widened(self, k: int) -> bool:
        """Whether an interval, counted from 0, is drawn at least twice as wide as in proportion."""
        share = (self.knots[k + 1] - self.knots[k]) / (self.knots[-1] - self.knots[0])
        return self.places[k + 1] - self.places[k] > 2 * share * (self.places[-1] - self.places[0])


def ticks(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Round values in a range, at most about ``most`` of them, each with its text.

    >>> ticks(0, 47, 5)
    [(0.0, '0'), (10.0, '10'), (20.0, '20'), (30.0, '30'), (40.0, '40')]
    >>> ticks(-0.003, 0.0061, 5)
    [(-0.002, '−0.002'), (0.0, '0'), (0.002, '0.002'), (0.004, '0.004'), (0.006, '0.006')]
    """
    step = _step((high - low) / max(most, 1))
    first = -floor(-Decimal(low) / step)
    values = []
    while (value := first * step) <= Decimal(high):
        values.append((float(value), _text(value, step)))
        first += 1
    return values


def angle_ticks(step: int = 60) -> list[tuple[float, str]]:
    """Ticks of an angle in degrees, from −180 to 180."""
    return [(float(n), f"{n}°".replace("-", "−")) for n in range(-180, 181, step)]


def _text(value: Decimal, step: Decimal) -> str:
    """A round number; with an exponent if it has many zeros."""
    far = step < Decimal("1e-5") or abs(value) >= Decimal("1e7")
    text = "0" if not value else f"{value.normalize():e}" if far else f"{value.normalize():f}"
    return text.replace("e+", "e").replace("-", "−")


def _step(least: float) -> Decimal:
    power = Decimal(10) ** floor(log10(least))
    return next(s * power for s in _STEPS if float(s * power) >= 0.999 * least)


Ticks = Sequence[tuple[float, str]]

GRID = Paint(stroke="faint", width=0.6)
EDGE = Paint(stroke="soft", width=1)
SMALL = 13.0
"""The size of the numbers at ticks."""


@dataclass(frozen=True)
class Frame:
    """A rectangle of the picture in which a plane is drawn, its second coordinate upwards.

    >>> frame = Frame.of(Box(50, 10, 450, 310), Box(0, 0, 40, 30))
    >>> frame.place((20, 0))
    (250.0, 310.0)
    """

    box: Box
    x: Scale
    y: Scale

    @classmethod
    def of(cls, box: Box, values: Box) -> Frame:
        """The frame in a box of the picture that shows a box of values."""
        return cls(
            box, Scale(values.x0, values.x1, box.x0, box.x1), Scale(values.y0, values.y1, box.y1, box.y0)
        )

    def place(self, point: Point) -> Point:
        """The place of a point in the picture."""
        return self.x(point[0]), self.y(point[1])

    def values(self, place: Point) -> Point:
        """The point of the plane at a place of the picture."""
        return self.x.value(place[0]), self.y.value(place[1])

    def line(self, points: Line) -> list[Point]:
        """The places of points."""
        return [self.place(point) for point in points]

    def shapes(
        self, x_title: str, y_title: str, x_ticks: Ticks | None = None, y_ticks: Ticks | None = None
    ) -> Iterator[Shape]:
        """Yields grid, edge, ticks and titles."""
        box = self.box
        across = ticks(self.x.low, self.x.high, max(int(box.width / 80), 4)) if x_ticks is None else x_ticks
        up = ticks(self.y.low, self.y.high, max(int(box.height / 60), 4)) if y_ticks is None else y_ticks
        columns = [(self.x(value), words) for value, words in across]
        rows = [(self.y(value), words) for value, words in up]
        grid = [
            *([(x, box.y0), (x, box.y1)] for x, _ in columns if box.x0 + 1 < x < box.x1 - 1),
            *([(box.x0, y), (box.x1, y)] for y, _ in rows if box.y0 + 1 < y < box.y1 - 1),
        ]
        yield Path(tuple(grid), GRID)
        yield Path((box.corners,), EDGE, closed=True)
        for x, words in columns:
            yield Text((x, box.y1 + 15), words, SMALL, "soft", "middle")
        for y, words in rows:
            yield Text((box.x0 - 8, y), words, SMALL, "soft", "end")
        yield Text((box.centre[0], box.y1 + 38), x_title, 15, "ink", "middle")
        yield Text((box.x0 - 48, box.centre[1]), y_title, 15, "ink", "middle", turn=-90)
