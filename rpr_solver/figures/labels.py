"""Where labels and insets go: places that hide nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import ceil, cos, floor, hypot, pi, sin

from rpr_solver.figures.plane import Box, Line, Point
from rpr_solver.figures.scene import Text
from rpr_solver.figures.wording import box_of

_CELL, _COARSE = 4, 8
_TAKEN = 10


class Room:
    """What is taken of a picture's area, in cells of a few pixels.

    Lines take the cells that they cross; boxes of labels and marks take theirs for good.
    """

    def __init__(self, box: Box) -> None:
        self.box = box
        self._cells: dict[tuple[int, int], int] = {}
        self._free: list[list[int]] = []

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
        taken = self._sums()
        columns, rows = len(taken[0]) - 1, len(taken) - 1
        wide, high, stride = ceil(width / _CELL), ceil(height / _CELL), int(step / _CELL)
        places = [
            (hypot(x + width / 2 - target[0], y + height / 2 - target[1]), x, y)
            for k in range(0, rows - high + 1, stride)
            for i in range(0, columns - wide + 1, stride)
            if taken[k + high][i + wide] - taken[k][i + wide] == taken[k + high][i] - taken[k][i]
            for x, y in ((self.box.x0 + i * _CELL, self.box.y0 + k * _CELL),)
        ]
        if not places:
            return None
        _, x, y = min(places)
        return Box(x, y, x + width, y + height)

    def _sums(self) -> list[list[int]]:
        """How many taken cells there are above and left of each cell of the area."""
        columns, rows = ceil(self.box.width / _CELL), ceil(self.box.height / _CELL)
        taken = [[0] * (columns + 1) for _ in range(rows + 1)]
        for i, k in self._cells:
            # a cell of the plane may lie in two columns and two rows of the area
            x, y = i * _CELL - self.box.x0, k * _CELL - self.box.y0
            for column in {floor(x / _CELL), ceil(x / _CELL)}:
                for row in {floor(y / _CELL), ceil(y / _CELL)}:
                    if 0 <= column < columns and 0 <= row < rows:
                        taken[row + 1][column + 1] = 1
        for k in range(1, rows + 1):
            line, above, total = taken[k], taken[k - 1], 0
            for i in range(1, columns + 1):
                total += line[i]
                line[i] = total + above[i]
        return taken

    def inside(self, rings: Sequence[Line], least: float) -> Point | None:
        """The point inside rings with most free room around it; None if that is less than ``least``.

        What is taken after the first call does not count, so rings must not overlap.
        """
        best, place = least / _COARSE / 2, None
        if not self._free:
            self._free = self._reaches()
        for row, reaches in enumerate(self._free):
            y = self.box.y0 + (row + 0.5) * _COARSE
            crossings = sorted(x for ring in rings for x in _crossings(ring, y))
            for low, high in zip(crossings[::2], crossings[1::2], strict=False):
                first = ceil((low - self.box.x0) / _COARSE - 0.5)
                last = floor((high - self.box.x0) / _COARSE - 0.5)
                for column in range(max(first, 0), min(last + 1, len(reaches))):
                    if reaches[column] > best:
                        best, place = reaches[column], (self.box.x0 + (column + 0.5) * _COARSE, y)
        return place

    def _reaches(self) -> list[list[int]]:
        """For squares of the area, row by row, how many squares to all sides are free."""
        columns, rows = int(self.box.width / _COARSE), int(self.box.height / _COARSE)
        far = [[min(i, k, columns - 1 - i, rows - 1 - k) for i in range(columns)] for k in range(rows)]
        for i, k in self._cells:
            column = int((i * _CELL - self.box.x0) // _COARSE)
            row = int((k * _CELL - self.box.y0) // _COARSE)
            if 0 <= column < columns and 0 <= row < rows:
                far[row][column] = 0
        for turn in (1, -1):  # the distance to the nearest zero, from one corner and from the other
            for k in range(1, rows)[::turn]:
                line, before = (far[k], far[k - 1]) if turn == 1 else (far[k - 1], far[k])
                for i in range(columns)[::turn]:
                    near = min(before[max(i - 1, 0) : i + 2])
                    beside = line[i - turn] if 0 <= i - turn < columns else near
                    line[i] = min(line[i], near + 1, beside + 1)
        return far

    def _holds(self, box: Box) -> bool:
        outer = self.box
        return outer.x0 <= box.x0 and box.x1 <= outer.x1 and outer.y0 <= box.y0 and box.y1 <= outer.y1


def _cells(box: Box) -> Iterable[tuple[int, int]]:
    columns = range(int(box.x0 // _CELL), int(box.x1 // _CELL) + 1)
    rows = range(int(box.y0 // _CELL), int(box.y1 // _CELL) + 1)
    return ((i, k) for i in columns for k in rows)


def _crossings(ring: Line, y: float) -> Iterator[float]:
    """Yields where a ring crosses a horizontal line."""
    for k in range(len(ring)):
        (ax, ay), (bx, by) = ring[k - 1], ring[k]
        if (ay > y) != (by > y):
            yield ax + (y - ay) * (bx - ax) / (by - ay)
