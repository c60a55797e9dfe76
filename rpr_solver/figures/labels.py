"""Where labels and insets go: places that hide nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import cos, hypot, pi, sin

from rpr_solver.figures.plane import Box, Line, Point, is_inside
from rpr_solver.figures.scene import Text
from rpr_solver.figures.wording import box_of

_CELL = 4
_TAKEN = 10


class Room:
    """What is taken of a picture's area, in cells of a few pixels.

    Lines take the cells that they cross; boxes of labels and marks take theirs for good.
    """

    def __init__(self, box: Box) -> None:
        self.box = box
        self._cells: dict[tuple[int, int], int] = {}

    def add_line(self, line: Line) -> None:
        """Take the cells that a polyline crosses."""
        for (ax, ay), (bx, by) in pairwise(line):
            steps = int(hypot(bx - ax, by - ay) / _CELL) + 1
            for k in range(steps + 1):
                x, y = ax + (bx - ax) * k / steps, ay + (by - ay) * k / steps
                cell = int(x // _CELL), int(y // _CELL)
                self._cells[cell] = max(self._cells.get(cell, 0), 1)

    def add_box(self, box: Box) -> None:
        """Take a box, for a label or a mark."""
        for cell in _cells(box):
            self._cells[cell] = _TAKEN

    def hidden(self, box: Box) -> int:
        """How much a box would hide: 0 for nothing."""
        return sum(self._cells.get(cell, 0) for cell in _cells(box))

    def is_free(self, box: Box) -> bool:
        """Whether a box hides nothing and lies within the area."""
        return self._holds(box) and not any(cell in self._cells for cell in _cells(box))

    def near(self, point: Point, words: str, size: float, gap: float, role: str = "ink") -> Text:
        """The label of a point, where it hides least near the point; its box is taken."""
        best: tuple[float, Text] | None = None
        for ring in range(10):
            if best is not None and best[0] < ring * 0.3:
                break
            for k in range(16):
                angle = 2 * pi * (k / 16) - pi / 4
                reach = gap + 5 * ring
                x, y = point[0] + reach * cos(angle), point[1] + reach * sin(angle)
                x += 0.32 * size * len(words) * cos(angle)
                text = Text((x, y + 0.4 * size * sin(angle)), words, size, role, "middle", bold=True)
                box = box_of(text)
                if self._holds(box):
                    cost = self.hidden(box.grown(1)) + 0.3 * ring + 0.01 * k
                    if best is None or cost < best[0]:
                        best = cost, text
        text = best[1] if best else Text(point, words, size, role, "middle", bold=True)
        self.add_box(box_of(text))
        return text

    def free_box(self, width: float, height: float, target: Point, step: float = 12) -> Box | None:
        """The free box of a size that is nearest to a point, or None."""
        places = sorted(self._corners(width, height, step), key=lambda p: _off(p, width, height, target))
        boxes = (Box(x, y, x + width, y + height) for x, y in places)
        return next(filter(self.is_free, boxes), None)

    def inside(self, rings: Sequence[Line], least: float, step: float = 10) -> Point | None:
        """The point inside rings with most free room around it; None if that is less than ``least``."""
        box = Box.around([point for ring in rings for point in ring])
        best: tuple[float, Point] | None = None
        for i in range(int(box.width / step) + 1):
            for k in range(int(box.height / step) + 1):
                point = box.x0 + (i + 0.5) * step, box.y0 + (k + 0.5) * step
                reach = self._reach(point)
                if reach > (best[0] if best else least / 2) and is_inside(point, rings):
                    best = reach, point
        return best[1] if best else None

    def _reach(self, point: Point) -> float:
        """How far a box around a point may reach and be free, at most 40."""
        reach = 0.0
        while reach < 40 and self.is_free(Box.around([point]).grown(reach + 5)):
            reach += 5
        return reach

    def _corners(self, width: float, height: float, step: float) -> Iterator[Point]:
        across, down = (self.box.width - width) / step, (self.box.height - height) / step
        for i in range(int(across) + 1):
            for k in range(int(down) + 1):
                yield self.box.x0 + i * step, self.box.y0 + k * step

    def _holds(self, box: Box) -> bool:
        outer = self.box
        return outer.x0 <= box.x0 and box.x1 <= outer.x1 and outer.y0 <= box.y0 and box.y1 <= outer.y1


def _off(corner: Point, width: float, height: float, target: Point) -> float:
    return hypot(corner[0] + width / 2 - target[0], corner[1] + height / 2 - target[1])


def _cells(box: Box) -> Iterable[tuple[int, int]]:
    columns = range(int(box.x0 // _CELL), int(box.x1 // _CELL) + 1)
    rows = range(int(box.y0 // _CELL), int(box.y1 // _CELL) + 1)
    return ((i, k) for i in columns for k in rows)
