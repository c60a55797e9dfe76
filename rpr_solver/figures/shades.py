"""The numbers of poses between singular curves, at any magnification.

It is twice the winding number of the singular curves, each run with J > 0 on its left (Theorem 26 in
docs/mathematics.md). Insets are shaded by it, since the outlines of regions in a document are too coarse.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

from rpr_solver.notebook.scene import Box, Line, Point

_NONE = 1e-7
"""Pixels; what is lower is no strip."""

_Side = tuple[Point, Point, int]
"""A segment from its upper end to its lower one, and how much the count grows to its right."""


def areas(lines: Sequence[tuple[Line, int]], box: Box) -> Iterator[tuple[int, list[Point]]]:
    """Yields the numbers of poses in a box, each with a polygon; together the polygons cover the box.

    Args:
        lines: closed in all, each with 1 if J > 0 on its left, and −1 else; precise in the box.
        box: a part of the picture.
    """
    sides = [side for line, sense in lines for side in _sides(line, sense, box)]
    near = [side for side in sides if max(side[0][0], side[1][0]) > box.x0]
    beside = [side for side in sides if max(side[0][0], side[1][0]) <= box.x0]
    strips: dict[tuple[int, float, float], tuple[list[Point], list[Point]]] = {}
    for top, bottom in pairwise(_levels(near, box)):
        lower: dict[tuple[int, float, float], tuple[list[Point], list[Point]]] = {}
        for poses, ((a, b), (c, d)) in _strip(near, beside, box, top, bottom):
            left, right = strips.pop((poses, _key(a), _key(b)), ([(a, top)], [(b, top)]))
            lower[poses, _key(c), _key(d)] = [*left, (c, bottom)], [*right, (d, bottom)]
        yield from _closed(strips)
        strips = lower
    yield from _closed(strips)


def _closed(
    strips: dict[tuple[int, float, float], tuple[list[Point], list[Point]]],
) -> Iterator[tuple[int, list[Point]]]:
    for (poses, _, _), (left, right) in strips.items():
        yield poses, [*left, *reversed(right)]


def _key(x: float) -> float:
    return round(x, 4)


def _sides(line: Line, sense: int, box: Box) -> Iterator[_Side]:
    """Yields the segments of a line beside a box or in it, but not to its right."""
    for a, b in pairwise(line):
        down = a[1] < b[1]
        upper, lower = (a, b) if down else (b, a)
        if upper[1] < box.y1 and lower[1] > box.y0 and upper[1] < lower[1] and min(a[0], b[0]) < box.x1:
            yield upper, lower, sense if down else -sense


def _levels(sides: Sequence[_Side], box: Box) -> list[float]:
    """The heights between which no side in the box begins, ends, or meets another one or an edge."""
    levels = {box.y0, box.y1}
    for upper, lower, _ in sides:
        levels |= {upper[1], lower[1]}
        for x in (box.x0, box.x1):
            if (upper[0] - x) * (lower[0] - x) < 0:
                levels.add(upper[1] + (x - upper[0]) / (lower[0] - upper[0]) * (lower[1] - upper[1]))
    for one, other in combinations(sides, 2):
        top, bottom = max(one[0][1], other[0][1]), min(one[1][1], other[1][1])
        if top < bottom:
            first, last = _at(one, top) - _at(other, top), _at(one, bottom) - _at(other, bottom)
            if first * last < 0:
                levels.add(top + first / (first - last) * (bottom - top))
    inside = sorted(y for y in levels if box.y0 <= y <= box.y1)
    return [y for k, y in enumerate(inside) if k == 0 or y - inside[k - 1] > _NONE]


def _at(side: _Side, y: float) -> float:
    (ax, ay), (bx, by), _ = side
    return ax + (y - ay) / (by - ay) * (bx - ax)


def _strip(
    near: Sequence[_Side], beside: Sequence[_Side], box: Box, top: float, bottom: float
) -> Iterator[tuple[int, tuple[Point, Point]]]:
    """Yields the areas between two levels from left to right: poses, and the ends at both levels."""
    middle = (top + bottom) / 2
    count = sum(grows for upper, lower, grows in beside if upper[1] <= middle < lower[1])
    met = sorted((_at(side, middle), side) for side in near if side[0][1] <= middle < side[1][1])
    start = box.x0, box.x0
    for x, side in met:
        if x >= box.x1:
            break
        if x > box.x0:
            stop = tuple(min(max(_at(side, y), box.x0), box.x1) for y in (top, bottom))
            yield 2 * abs(count), ((start[0], stop[0]), (start[1], stop[1]))
            start = stop[0], stop[1]
        count += side[2]
    yield 2 * abs(count), ((start[0], box.x1), (start[1], box.x1))
