"""Frames with ticks: the part of a picture that has scales."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rpr_solver.figures.scales import Scale, ticks
from rpr_solver.notebook.scene import Box, Line, Paint, Path, Point, Shape, Text

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

    @classmethod
    def square(cls, box: Box, values: Box) -> Frame:
        """As :meth:`of`, with equal scales in both directions: more values are shown in one of them."""
        pixel = max(values.width / box.width, values.height / box.height)
        (x, y), w, h = values.centre, box.width * pixel / 2, box.height * pixel / 2
        return cls.of(box, Box(x - w, y - h, x + w, y + h))

    @property
    def values(self) -> Box:
        """The box of values."""
        return Box(self.x.low, self.y.low, self.x.high, self.y.high)

    def place(self, point: Point) -> Point:
        """The place of a point in the picture."""
        return self.x(point[0]), self.y(point[1])

    def line(self, points: Line) -> list[Point]:
        """The places of points."""
        return [self.place(point) for point in points]

    def shapes(
        self, x_title: str, y_title: str, x_ticks: Ticks | None = None, y_ticks: Ticks | None = None
    ) -> Iterator[Shape]:
        """Yields grid, edge, ticks and titles."""
        box = self.box
        across = ticks(self.x.low, self.x.high, int(box.width / 80)) if x_ticks is None else x_ticks
        up = ticks(self.y.low, self.y.high, int(box.height / 60)) if y_ticks is None else y_ticks
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
