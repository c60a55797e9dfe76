"""Where labels and insets go: places that hide nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import reduce
from itertools import pairwise, product
from math import ceil, cos, floor, hypot, inf, pi, sin
from operator import or_

from rpr_solver.figures.sheet import box_of
from rpr_solver.notebook.scene import Box, Line, Point, Text

_CELL, _COARSE = 4, 8
_MARGIN = 2
_TAKEN = 10
_FAR, _CLOSE = 0.3, 2.0
"""What five pixels farther away cost, in cells of lines that are hidden; for names that stay close."""


class OccupancyGrid:
    """The occupied area of a picture, in cells of a few pixels.

    Lines occupy the cells that they cross; boxes of labels and marks occupy theirs permanently. Each row of
    cells is a number with a bit for each column.
    """

    def __init__(self, box: Box, lines: Iterable[Line] = (), points: Iterable[Point] = ()) -> None:
        """The area of a box, with curves, and marks at points, that are drawn there."""
        self.box = box
        self._left, self._top = (floor(x / _CELL) - _MARGIN for x in (box.x0, box.y0))
        self._columns, rows = (
            ceil(x / _CELL) + _MARGIN - first for x, first in ((box.x1, self._left), (box.y1, self._top))
        )
        self._crossed, self._boxed = [0] * rows, [0] * rows
        self._free: list[list[int]] = []
        for line in lines:
            self.add_line(line)
        for point in points:
            self.add_point(point)

    def add_line(self, line: Line) -> None:
        """Take the cells that a polyline crosses."""
        crossed, left, top, columns = self._crossed, self._left, self._top, self._columns
        for (ax, ay), (bx, by) in pairwise(line):
            steps = int(hypot(bx - ax, by - ay) / _CELL) + 1
            for k in range(steps + 1):
                column = int((ax + (bx - ax) * k / steps) // _CELL) - left
                row = int((ay + (by - ay) * k / steps) // _CELL) - top
                if 0 <= row < len(crossed) and 0 <= column < columns:
                    crossed[row] |= 1 << column

    def add_point(self, at: Point) -> None:
        """Take the place of a mark at a point."""
        self.add_box(Box.around([at]).grown(8))

    def add_box(self, box: Box) -> None:
        """Take a box, for a label or a mark."""
        rows, columns = self._under(box)
        for row in rows:
            self._boxed[row] |= columns

    def hidden(self, box: Box) -> int:
        """How much a box would hide: 0 for nothing."""
        rows, columns = self._under(box)
        boxed = sum((self._boxed[row] & columns).bit_count() for row in rows)
        crossed = sum((self._crossed[row] & ~self._boxed[row] & columns).bit_count() for row in rows)
        return _TAKEN * boxed + crossed

    def near(self, point: Point, words: str, size: float, gap: float, role: str = "ink") -> Text:
        """The label of a point, where it hides least near the point; its box is taken."""
        return near_one_of(self, [point], words, size, gap, role)

    def near_if_free(
        self, point: Point, words: str, size: float, gap: float, role: str = "ink", most: float = _TAKEN
    ) -> Text | None:
        """The same, but None where every label would hide another one, or lines in ``most`` cells."""
        found = _nearest(self, point, words, size, gap, role)
        if found is None or found[0] >= most:
            return None
        self.add_box(box_of(found[1]))
        return found[1]

    def free_box(self, width: float, height: float, target: Point, step: float = 12) -> Box | None:
        """The free box of a size that is nearest to a point, or None."""
        columns, rows = ceil(self.box.width / _CELL), ceil(self.box.height / _CELL)
        wide, high, stride = ceil(width / _CELL), ceil(height / _CELL), int(step / _CELL)
        taken, window = self._taken(rows), (1 << wide) - 1
        places = []
        for k in range(0, rows - high + 1, stride):
            under = reduce(or_, taken[k : k + high])
            for i in range(0, columns - wide + 1, stride):
                if not under >> i & window:
                    x, y = self.box.x0 + i * _CELL, self.box.y0 + k * _CELL
                    places.append((hypot(x + width / 2 - target[0], y + height / 2 - target[1]), x, y))
        if not places:
            return None
        _, x, y = min(places)
        return Box(x, y, x + width, y + height)

    def _taken(self, rows: int) -> list[int]:
        """The taken cells of the area, row by row; one that it cuts lies in two of its columns or rows."""
        across, down = _shifts(self.box.x0, self._left), _shifts(self.box.y0, self._top)
        taken = [crossed | boxed for crossed, boxed in zip(self._crossed, self._boxed, strict=True)]
        both = [reduce(or_, (cells >> by for by in across)) for cells in taken]
        return [reduce(or_, (both[row + by] for by in down)) for row in range(rows)]

    def inside(self, rings: Sequence[Line], least: float) -> Point | None:
        """The point inside rings with most free room around it; None if that is less than ``least``.

        What is taken after the first call does not count, so rings must not overlap.
        """
        if not self._free:
            self._free = self._reaches()
        within = self._within(rings)
        for reach in range(len(self._free), floor(least / _COARSE / 2), -1):
            for row, free in enumerate(self._free[reach - 1]):
                if squares := free & within[row]:
                    column = (squares & -squares).bit_length() - 1
                    return self.box.x0 + (column + 0.5) * _COARSE, self.box.y0 + (row + 0.5) * _COARSE
        return None

    def _within(self, rings: Sequence[Line]) -> list[int]:
        """The squares of the area, row by row, whose centres lie inside rings."""
        columns, rows = self._squares
        crossings: list[list[float]] = [[] for _ in range(rows)]
        for ring in rings:
            for (ax, ay), (bx, by) in pairwise([ring[-1], *ring]):
                low, high = ((y - self.box.y0) / _COARSE for y in (min(ay, by), max(ay, by)))
                for row in range(max(int(low) - 1, 0), min(int(high) + 2, rows)):
                    y = self.box.y0 + (row + 0.5) * _COARSE
                    if (ay > y) != (by > y):
                        crossings[row].append(ax + (y - ay) * (bx - ax) / (by - ay))
        within = [0] * rows
        for row, xs in enumerate(crossings):
            xs.sort()
            for low, high in zip(xs[::2], xs[1::2], strict=False):
                first = max(ceil((low - self.box.x0) / _COARSE - 0.5), 0)
                last = min(floor((high - self.box.x0) / _COARSE - 0.5), columns - 1)
                if first <= last:
                    within[row] |= (1 << last + 1) - (1 << first)
        return within

    def _reaches(self) -> list[list[int]]:
        """For each distance from 0, row by row, the squares farther from what is taken and from the edges."""
        columns, rows = self._squares
        whole = (1 << columns) - 1
        free = [0, *[whole & ~1 & whole >> 1] * (rows - 2), 0][:rows]
        for row, cells in enumerate(map(or_, self._crossed, self._boxed)):
            square = int(((row + self._top) * _CELL - self.box.y0) // _COARSE)
            for column in range(cells.bit_length() if 0 <= square < rows else 0):
                if cells >> column & 1:
                    beside = int(((column + self._left) * _CELL - self.box.x0) // _COARSE)
                    free[square] &= ~(1 << beside) if beside >= 0 else -1
        levels = []
        while any(free):
            levels.append(free)
            across = [line & line << 1 & line >> 1 for line in free]
            free = [a & b & c for a, b, c in zip([0, *across], across, [*across[1:], 0], strict=False)]
        return levels

    @property
    def _squares(self) -> tuple[int, int]:
        """How many columns and rows of squares the area has."""
        return int(self.box.width / _COARSE), int(self.box.height / _COARSE)

    def _under(self, box: Box) -> tuple[range, int]:
        """The rows and columns of the cells under a box."""
        first, last = (int(x // _CELL) - self._left for x in (box.x0, box.x1))
        top, bottom = (int(y // _CELL) - self._top for y in (box.y0, box.y1))
        columns = (1 << max(min(last + 1, self._columns), 0)) - (1 << max(first, 0))
        return range(max(top, 0), min(bottom + 1, len(self._boxed))), max(columns, 0)

    def holds(self, box: Box) -> bool:
        """Whether a box lies within the area."""
        outer = self.box
        return outer.x0 <= box.x0 and box.x1 <= outer.x1 and outer.y0 <= box.y0 and box.y1 <= outer.y1


def near_one_of(
    room: OccupancyGrid, points: Sequence[Point], words: str, size: float, gap: float, role: str = "ink"
) -> Text:
    """The label of something with several points, at the point where it hides least; its box is taken."""
    found = [_nearest(room, point, words, size, gap, role) for point in points]
    best = min((each for each in found if each), key=lambda each: each[0], default=None)
    text = best[1] if best else Text(points[0], words, size, role, "middle", bold=True)
    room.add_box(box_of(text))
    return text


def names_beside(
    room: OccupancyGrid, named: Sequence[tuple[Point, str]], size: float, gap: float
) -> list[Text]:
    """The labels of points, each near its own, in the order in which they lie best; their boxes are taken.

    A label farther away costs more than one that crosses a line.
    """
    count = len(named)
    best: tuple[float, dict[int, Text]] = inf, {}
    for first, step in product(range(count), (1, -1)):
        trial, total, texts = deepcopy(room), 0.0, {}
        for k in ((first + step * i) % count for i in range(count)):
            at, words = named[k]
            fallback = _TAKEN, Text(at, words, size, "ink", "middle", bold=True)
            cost, text = _nearest(trial, at, words, size, gap, "ink", _CLOSE) or fallback
            trial.add_box(box_of(text))
            total, texts[k] = total + cost, replace(text, halo="paper")
        best = min(best, (total, texts), key=lambda each: each[0])
    found = [best[1][k] for k in range(count)]
    for text in found:
        room.add_box(box_of(text))
    return found


def names_inside(
    areas: Iterable[tuple[Sequence[Line], str]], room: OccupancyGrid, least: float
) -> Iterator[Text]:
    """The names of areas, each given by its rings, written in those that have room for them."""
    for rings, words in areas:
        spot = room.inside(rings, least)
        if spot is not None:
            text = Text(spot, words, 14, "ink", "middle")
            room.add_box(box_of(text))
            yield text


def _shifts(start: float, first: int) -> set[int]:
    """Where an area begins, counted in cells from the first: at two of them, if it cuts one."""
    return {floor(start / _CELL) - first, ceil(start / _CELL) - first}


def _nearest(
    room: OccupancyGrid, point: Point, words: str, size: float, gap: float, role: str, far: float = _FAR
) -> tuple[float, Text] | None:
    """The label that hides least, with what it costs, distance as well; None if none lies in the area."""
    best: tuple[float, Text] | None = None
    for ring in range(10):
        if best is not None and best[0] < ring * far:
            break
        for k in range(16):
            angle = 2 * pi * (k / 16) - pi / 4
            reach = gap + 5 * ring
            x, y = point[0] + reach * cos(angle), point[1] + reach * sin(angle)
            x += 0.32 * size * len(words) * cos(angle)
            text = Text((x, y + 0.4 * size * sin(angle)), words, size, role, "middle", bold=True)
            box = box_of(text)
            if room.holds(box):
                cost = room.hidden(box.grown(1)) + far * ring + 0.01 * k
                if best is None or cost < best[0]:
                    best = cost, text
    return best
