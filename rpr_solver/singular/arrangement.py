"""The faces of a plane cut by directed polylines, with their winding numbers: exact, on an integer grid.

Points are rounded to a fine grid and displaced on it by a few units, in a fixed pseudo-random way, so that no
vertex lies on another polyline and no edges overlap; if one still does, other displacements are tried. From
there on all is decided by integers and fractions. A winding number is that of the sum of all polylines: the
face on the left of an edge has one more than the face on its right, and the unbounded face has 0.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rpr_solver.errors import ControlFlow, SolverError

_GRID, FINER_GRID = 1 << 46, 1 << 56
_DISPLACEMENT = 1 << 6
_TRIALS = 8

Point = tuple[float, float]
Vector = tuple[int, int]
Number = int | Fraction
Exact = tuple[Number, Number]


@dataclass(frozen=True)
class Polyline:
    """A directed polyline between two named ends; it is closed if they have one name.

    Attributes:
        angles: of its points, α and θ in radians; none where they are not used.
    """

    points: tuple[Point, ...]
    start: Hashable
    end: Hashable
    angles: tuple[Point, ...] = ()


@dataclass(frozen=True)
class Face:
    """A face of the arrangement.

    Attributes:
        winding: the winding number about its points.
        rings: closed rings of points, the first one round the face and the others round holes in it; the
            unbounded face has only holes.
        bounded: whether it is bounded.
    """

    winding: int
    rings: tuple[tuple[Point, ...], ...]
    bounded: bool

    def holds(self, point: Point) -> bool:
        """Whether a point lies inside: within the first ring, and in no hole."""
        return sum(_holds(ring, point) for ring in self.rings) % 2 == 1


def faces(polylines: Sequence[Polyline], grid: int = _GRID) -> list[Face]:
    """The faces, in no particular order.

    Raises:
        SolverError: no displacement puts the polylines into general position.
    """
    if not polylines:
        return [Face(0, (), False)]
    size = max(abs(x) for line in polylines for point in line.points for x in point) or 1.0
    for seed in range(_TRIALS):
        try:
            return _Arrangement(polylines, grid / size, seed).faces()
        except _Degenerate:
            continue
    raise SolverError("the regions of the joint plane could not be told apart in double precision")


class _Degenerate(ControlFlow):
    """A vertex lies on an edge, or two edges overlap."""


@dataclass(frozen=True)
class _Chain:
    """A directed piece of a polyline between two junctions, without a crossing inside."""

    start: Hashable
    end: Hashable
    points: tuple[Exact, ...]
    out: Vector
    back: Vector
    """The directions in which it leaves its start, and its end backwards."""


Half = tuple[int, bool]
"""A chain by its number, and whether it is followed forwards."""


class _Arrangement:
    def __init__(self, polylines: Sequence[Polyline], scale: float, seed: int) -> None:
        self._scale = scale
        self._state = 0x9E3779B97F4A7C15 * (seed + 1)
        self._named: dict[Hashable, Vector] = {}
        self._lines = [self._rounded(line, seed) for line in polylines]
        for line in self._lines:
            for p, q, r in zip(line, line[1:], line[2:], strict=False):
                _check_apart(q, p, r)
        self._chains = list(self._cut(polylines, self._crossings()))

    def faces(self) -> list[Face]:
        """Every face with its winding number."""
        cycles = list(self._cycles())
        cycle_of = {half: k for k, cycle in enumerate(cycles) for half in cycle}
        outlines = [self._outline(cycle) for cycle in cycles]
        areas = [_area(outline) for outline in outlines]
        if not all(areas):
            raise _Degenerate
        outer = [k for k, area in enumerate(areas) if area > 0]
        holes = [k for k, area in enumerate(areas) if area < 0]
        home: dict[int, int | None] = {k: k for k in outer}
        home |= {k: self._home(outlines[k], outlines, areas, outer) for k in holes}
        windings = _windings(cycle_of, home)
        rings: dict[int | None, list[int]] = defaultdict(list)
        for k, face in home.items():
            rings[face].append(k)
        rings.setdefault(None, [])
        return [
            Face(windings[face], tuple(self._drawn(outlines[k]) for k in parts), face is not None)
            for face, parts in rings.items()
        ]

    def _rounded(self, line: Polyline, seed: int) -> list[Vector]:
        """The grid points of a polyline, without what runs there and back; one alone if that is all."""
        first = self._named.get(line.start) or self._named.setdefault(
            line.start, self._vector_of(line.points[0])
        )
        inner = line.points[1:-1]
        if seed and not inner:  # two straight lines between the same ends would overlap
            (ax, ay), (bx, by) = line.points[0], line.points[-1]
            inner = (((ax + bx) / 2, (ay + by) / 2),)
        points = [first, *map(self._vector_of, inner)]
        last = self._named.get(line.end) or self._named.setdefault(line.end, self._vector_of(line.points[-1]))
        if points[-1] != last:
            points.append(last)
        return points[:1] if len(points) == 3 and first == last else points

    def _vector_of(self, point: Point) -> Vector:
        x, y = (round(c * self._scale) + self._jitter() for c in point)
        return x, y

    def _jitter(self) -> int:
        self._state = (self._state * 6364136223846793005 + 1442695040888963407) % (1 << 64)
        return (self._state >> 33) % (2 * _DISPLACEMENT) - _DISPLACEMENT

    def _crossings(self) -> dict[tuple[int, int], list[tuple[Fraction, Hashable, Exact]]]:
        """By polyline and edge: where on it, the name of the crossing, and the point."""
        found: dict[tuple[int, int], list[tuple[Fraction, Hashable, Exact]]] = defaultdict(list)
        for first, second in self._near():
            (a, b), (c, d) = self._edge(first), self._edge(second)
            crossing = _crossing(a, b, c, d)
            if crossing is None:
                continue
            s, t = crossing
            point = a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])
            found[first].append((s, (first, second), point))
            found[second].append((t, (first, second), point))
        for places in found.values():
            places.sort(key=lambda x: x[0])
            if any(x[0] == y[0] for x, y in pairwise(places)):
                raise _Degenerate
        return found

    def _edge(self, edge: tuple[int, int]) -> tuple[Vector, Vector]:
        line = self._lines[edge[0]]
        return line[edge[1]], line[edge[1] + 1]

    def _near(self) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
        """Pairs of edges whose boxes meet, except those that have an end in common."""
        edges = [(k, i) for k, line in enumerate(self._lines) for i in range(len(line) - 1)]
        corners = np.array([pair for line in self._lines for pair in pairwise(line)], dtype=np.int64)
        pairs = boxes_that_meet(corners.min(axis=1), corners.max(axis=1)) if edges else ()
        for ends in zip(*(numbers.tolist() for numbers in pairs), strict=True):
            first, second = (edges[k] for k in sorted(ends))
            if second != (first[0], first[1] + 1) and not self._joined(first, second):
                yield first, second

    def _joined(self, first: tuple[int, int], second: tuple[int, int]) -> bool:
        """Whether two edges have an end in common; then they must not overlap."""
        (a, b), (c, d) = self._edge(first), self._edge(second)
        shared = [(p, q, r) for p, q in ((a, b), (b, a)) for s, r in ((c, d), (d, c)) if p == s]
        for places in shared:
            _check_apart(*places)
        return bool(shared)

    def _cut(
        self,
        polylines: Sequence[Polyline],
        crossings: Mapping[tuple[int, int], Sequence[tuple[Fraction, Hashable, Exact]]],
    ) -> Iterator[_Chain]:
        """The pieces of all polylines between junctions."""
        for k, (line, polyline) in enumerate(zip(self._lines, polylines, strict=True)):
            if len(line) == 1:
                continue
            name: Hashable = ("end", polyline.start)
            points: list[Exact] = [line[0]]
            out = _difference(line[1], line[0])
            for i, (a, b) in enumerate(pairwise(line)):
                along = _difference(b, a)
                if along == (0, 0):
                    raise _Degenerate
                for _, crossing, point in crossings.get((k, i), ()):
                    points.append(point)
                    yield _Chain(name, ("crossing", crossing), tuple(points), out, (-along[0], -along[1]))
                    name, points, out = ("crossing", crossing), [point], along
                points.append(b)
            back = _difference(line[-2], line[-1])
            yield _Chain(name, ("end", polyline.end), tuple(points), out, back)

    def _cycles(self) -> Iterator[list[Half]]:
        """The boundaries of faces: cycles of half edges with the face on their left."""
        leaving: dict[Hashable, list[tuple[Vector, Half]]] = defaultdict(list)
        for k, chain in enumerate(self._chains):
            leaving[chain.start].append((chain.out, (k, True)))
            leaving[chain.end].append((chain.back, (k, False)))
        following: dict[Half, Half] = {}
        for around in leaving.values():
            around.sort(key=cmp_to_key(_turn_order))
            for (_, half), (_, after) in pairwise([*around, around[0]]):
                # arriving by the reverse of ``after``, the next edge clockwise keeps the face on the left
                following[after[0], not after[1]] = half
        todo = set(following)
        for first in following:
            if first in todo:
                cycle, half = [], first
                while half in todo:
                    todo.remove(half)
                    cycle.append(half)
                    half = following[half]
                yield cycle

    def _outline(self, cycle: Sequence[Half]) -> list[Exact]:
        points: list[Exact] = []
        for k, forwards in cycle:
            own = self._chains[k].points
            points += own[:-1] if forwards else own[:0:-1]
        return points

    def _home(
        self,
        hole: Sequence[Exact],
        outlines: Sequence[Sequence[Exact]],
        areas: Sequence[Number],
        outer: Iterable[int],
    ) -> int | None:
        """The smallest face round a hole, or None for the unbounded one."""
        own = set(hole)
        point = min(hole)
        around = [k for k in outer if own.isdisjoint(outlines[k]) and _holds(outlines[k], point)]
        return min(around, key=lambda k: areas[k], default=None)

    def _drawn(self, outline: Sequence[Exact]) -> tuple[Point, ...]:
        points = [(float(x) / self._scale, float(y) / self._scale) for x, y in outline]
        return (*points, points[0])


def _check_apart(p: Vector, q: Vector, r: Vector) -> None:
    """Raises `_Degenerate` if the edges from p to q and to r overlap."""
    ux, uy, vx, vy = q[0] - p[0], q[1] - p[1], r[0] - p[0], r[1] - p[1]
    if ux * vy == uy * vx and ux * vx + uy * vy > 0:
        raise _Degenerate


def boxes_that_meet(low: NDArray[Any], high: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """All pairs of boxes that meet, by their numbers, from their lowest and highest corners, a row each."""
    order = np.argsort(low[:, 0], kind="stable")
    stops = np.searchsorted(low[order, 0], high[order, 0], side="right")
    counts = stops - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), counts)
    second = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts) + first + 1
    i, j = order[first], order[second]
    keep = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
    return i[keep], j[keep]


def _windings(cycle_of: Mapping[Half, int], home: Mapping[int, int | None]) -> dict[int | None, int]:
    """The winding number of each face, from the unbounded one inwards."""
    beside: dict[int | None, list[tuple[int | None, int]]] = defaultdict(list)
    for (chain, forwards), cycle in cycle_of.items():
        other = home[cycle_of[chain, not forwards]]
        beside[home[cycle]].append((other, -1 if forwards else 1))
    result: dict[int | None, int] = {None: 0}
    todo: list[int | None] = [None]
    while todo:
        face = todo.pop()
        for other, step in beside[face]:
            if other not in result:
                result[other] = result[face] + step
                todo.append(other)
            elif result[other] != result[face] + step:
                raise SolverError("the singular curves do not close in the joint plane, in double precision")
    return result


def _crossing(a: Vector, b: Vector, c: Vector, d: Vector) -> tuple[Fraction, Fraction] | None:
    """The parameters at which two edges cross, or None; a touching end is degenerate."""
    ux, uy, vx, vy, wx, wy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1], c[0] - a[0], c[1] - a[1]
    bottom = ux * vy - uy * vx
    if not bottom:
        if ux * wy == uy * wx:
            raise _Degenerate
        return None
    s, t = wx * vy - wy * vx, wx * uy - wy * ux
    if bottom < 0:
        s, t, bottom = -s, -t, -bottom
    if s < 0 or s > bottom or t < 0 or t > bottom:
        return None
    if s in (0, bottom) or t in (0, bottom):
        raise _Degenerate
    return Fraction(s, bottom), Fraction(t, bottom)


def _turn_order(x: tuple[Vector, Half], y: tuple[Vector, Half]) -> int:
    """The order of half edges by their directions, from the positive x-axis counter-clockwise.

    Raises:
        _Degenerate: they are equal.
    """
    u, v = x[0], y[0]
    upper_u, upper_v = ((w[1], w[0]) > (0, 0) for w in (u, v))
    if upper_u != upper_v:
        return -1 if upper_u else 1
    cross = u[0] * v[1] - u[1] * v[0]
    if not cross:
        raise _Degenerate
    return -1 if cross > 0 else 1


def _area(outline: Sequence[Exact]) -> Number:
    """Twice the signed area."""
    whole, parts = 0, Fraction(0)  # apart, since most vertices are whole, and sums of fractions are slow
    for a, b in zip(outline, [*outline[1:], outline[0]], strict=True):
        term = a[0] * b[1] - a[1] * b[0]
        if isinstance(term, int):
            whole += term
        else:
            parts += term
    return whole + parts


def _holds(outline: Sequence[Exact] | Sequence[Point], point: Exact | Point) -> bool:
    """Whether a point lies inside an outline, by the crossings of a ray."""
    x, y = point
    inside = False
    for (ax, ay), (bx, by) in zip(outline, [*outline[1:], outline[0]], strict=True):
        if (ay > y) != (by > y):
            cross = (bx - ax) * (y - ay) - (x - ax) * (by - ay)
            if (cross > 0) == (by > ay):
                inside = not inside
    return inside


def _difference(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1]
