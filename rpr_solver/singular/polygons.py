"""Polygons in floats: their areas, and their parts in one turn of both angles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

Point = tuple[float, float]
"""Two coordinates; angles are in degrees."""


def strips(polygon: Sequence[Point], axis: int) -> Iterator[list[Point]]:
    """A polygon cut at odd multiples of 180° of one coordinate, its parts moved between −180° and 180°."""
    values = [p[axis] for p in polygon]
    turn = round(min(values) / 360)
    if 360 * turn - 180 <= min(values) and max(values) <= 360 * turn + 180:
        if len(polygon) > 2:
            yield (
                list(polygon)
                if not turn
                else [(x - 360 * turn, y) if axis == 0 else (x, y - 360 * turn) for x, y in polygon]
            )
        return
    while 360 * turn - 180 < max(values):
        below = _clipped(polygon, axis, 360 * turn - 180, 1)
        part = _clipped(below, axis, 360 * turn + 180, -1)
        if len(part) > 2:
            yield [(x - 360 * turn, y) if axis == 0 else (x, y - 360 * turn) for x, y in part]
        turn += 1


def _clipped(polygon: Sequence[Point], axis: int, bound: float, side: int) -> list[Point]:
    """The part of a polygon on one side of a line, by Sutherland and Hodgman."""
    result: list[Point] = []
    if all(side * (point[axis] - bound) >= 0 for point in polygon):
        return list(polygon)
    for a, b in pairwise([polygon[-1], *polygon]):
        inside = side * (a[axis] - bound) >= 0, side * (b[axis] - bound) >= 0
        if inside[0] != inside[1]:
            part = (bound - a[axis]) / (b[axis] - a[axis])
            cut = [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
            cut[axis] = bound
            result.append((cut[0], cut[1]))
        if inside[1]:
            result.append(b)
    return result


def polygon_area(polygon: Sequence[Point]) -> float:
    """The area, negative if the corners go clockwise."""
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise([*polygon, polygon[0]])) / 2
