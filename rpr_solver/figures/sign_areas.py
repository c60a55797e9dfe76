"""The areas of the torus between singular curves, as polygons, connected to aspects.

The torus is a rectangle of the picture with opposite sides glued. Vertical lines through turning points, and
through points where curves pass the upper or lower side, cut it into slabs in which curves run side by side.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, floor

from rpr_solver.figures.plane import Box, Line, Point

_STEP, _EPSILON, _OVERLAP, _SEEN = 4.0, 1e-3, 0.05, 0.5


@dataclass(frozen=True)
class Area:
    """A connected area of the torus in which J has one sign.

    Attributes:
        sign: 1 or −1.
        rings: polygons that cover it.
        size: the sum of their areas, in square pixels.
        middle: a point with much of the area around it.
    """

    sign: int
    rings: tuple[tuple[Point, ...], ...]
    size: float
    middle: Point


@dataclass(frozen=True)
class _Cell:
    """A part of a slab between neighbouring curves, from the lower one to the upper one."""

    slab: int
    sign: int
    lower: tuple[Point, ...]
    upper: tuple[Point, ...]

    @property
    def ring(self) -> tuple[Point, ...]:
        return (*self.lower, *reversed(self.upper))

    @property
    def size(self) -> float:
        xs = [x for x, _ in self.lower]
        steps = zip(pairwise(self._heights), pairwise(xs), strict=True)
        return sum((a + b) / 2 * (q - p) for (a, b), (p, q) in steps)

    @property
    def middle(self) -> tuple[float, Point]:
        """The point with the greatest room to all sides, and that room."""
        xs = [x for x, _ in self.lower]
        rooms = [min(h, x - xs[0], xs[-1] - x) for h, x in zip(self._heights, xs, strict=True)]
        k = rooms.index(max(rooms))
        return rooms[k], (xs[k], (self.lower[k][1] + self.upper[k][1]) / 2)

    @property
    def _heights(self) -> list[float]:
        return [u[1] - v[1] for u, v in zip(self.upper, self.lower, strict=True)]


def areas(
    lines: Sequence[Line], turns: Sequence[float], box: Box, sign: Callable[[Point], int]
) -> list[Area]:
    """The areas between curves, the greatest first; those too small to be seen are left out.

    Args:
        lines: the curves, which may run beyond the box and are to be brought back by its sides.
        turns: the abscissas of turning points and nodes, likewise.
        box: the rectangle.
        sign: the sign of J at a point of it.
    """
    borders = sorted({box.x0, box.x1, *(_into(x, box.x0, box.width) for x in turns), *_seams(lines, box)})
    borders = [x for k, x in enumerate(borders) if k == 0 or x - borders[k - 1] > 4 * _EPSILON]
    columns = sorted({x for low, high in pairwise(borders) for x in _columns(low, high)})
    crossed = _crossings(lines, columns, box)
    slabs = [
        list(_cells(k, low, high, crossed, box, sign)) for k, (low, high) in enumerate(pairwise(borders))
    ]
    cells = [cell for slab in slabs for cell in slab]
    groups = _connected(slabs)
    found: dict[int, list[_Cell]] = {}
    for cell in cells:
        found.setdefault(groups[id(cell)], []).append(cell)
    result = [
        Area(
            group[0].sign,
            tuple(cell.ring for cell in group),
            sum(cell.size for cell in group),
            max(cell.middle for cell in group)[1],
        )
        for group in found.values()
    ]
    return sorted((area for area in result if area.size > _SEEN), key=lambda area: -area.size)


def _into(value: float, start: float, period: float) -> float:
    return start + (value - start) % period


def _seams(lines: Sequence[Line], box: Box) -> Iterator[float]:
    """Yields the abscissas at which curves pass the upper or lower side."""
    for line in lines:
        for (ax, ay), (bx, by) in pairwise(line):
            a, b = (ay - box.y0) / box.height, (by - box.y0) / box.height
            for level in range(ceil(min(a, b)), ceil(max(a, b))):
                yield _into(ax + (level - a) / (b - a) * (bx - ax), box.x0, box.width)


def _columns(low: float, high: float) -> Iterator[float]:
    """Yields the abscissas in a slab at which its cells have corners."""
    count = ceil((high - low) / _STEP)
    yield low + _EPSILON
    yield from (low + (high - low) * k / count for k in range(1, count))
    yield high - _EPSILON


def _crossings(lines: Sequence[Line], columns: Sequence[float], box: Box) -> dict[float, list[float]]:
    """The ordinates at which curves cross each column, ascending."""
    crossed: dict[float, list[float]] = {x: [] for x in columns}
    for line in lines:
        for (ax, ay), (bx, by) in pairwise(line):
            low, high = min(ax, bx), max(ax, bx)
            for turn in range(floor((low - box.x0) / box.width), floor((high - box.x0) / box.width) + 1):
                shift = turn * box.width
                for k in range(bisect_left(columns, low - shift), bisect_left(columns, high - shift)):
                    y = ay + (columns[k] + shift - ax) / (bx - ax) * (by - ay)
                    crossed[columns[k]].append(_into(y, box.y0, box.height))
    return {x: sorted(values) for x, values in crossed.items()}


def _cells(
    slab: int,
    low: float,
    high: float,
    crossed: dict[float, list[float]],
    box: Box,
    sign: Callable[[Point], int],
) -> Iterator[_Cell]:
    xs = [x for x in crossed if low < x < high]
    usual = sorted(len(crossed[x]) for x in xs)[len(xs) // 2]
    xs = [x for x in xs if len(crossed[x]) == usual]
    levels = [[box.y0, *crossed[x], box.y1] for x in xs]
    outer = [low, *xs[1:-1], high] if len(xs) > 1 else [low, high]
    levels = levels if len(xs) > 1 else levels * 2
    for k in range(usual + 1):
        widest = max(range(len(xs)), key=lambda i: levels[i][k + 1] - levels[i][k])
        at = xs[widest], (levels[widest][k] + levels[widest][k + 1]) / 2
        lower, upper = (
            tuple((x, level[i]) for x, level in zip(outer, levels, strict=True)) for i in (k, k + 1)
        )
        yield _Cell(slab, sign(at), lower, upper)


def _connected(slabs: Sequence[Sequence[_Cell]]) -> dict[int, int]:
    """The number of the connected area of each cell, by the cell's identity."""
    parent = {id(cell): id(cell) for slab in slabs for cell in slab}

    def root(name: int) -> int:
        while parent[name] != name:
            name = parent[name]
        return name

    def join(a: _Cell, b: _Cell) -> None:
        if a.sign == b.sign:
            parent[root(id(a))] = root(id(b))

    for slab, after in zip(slabs, [*slabs[1:], slabs[0]], strict=True):
        join(slab[0], slab[-1])  # over the upper and lower side
        for a in slab:
            for b in after:
                low, high = max(a.lower[-1][1], b.lower[0][1]), min(a.upper[-1][1], b.upper[0][1])
                if high - low > _OVERLAP:
                    join(a, b)
    return {name: root(name) for name in parent}
