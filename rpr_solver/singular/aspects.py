"""Aspects: the connected regions of the torus of poses on which J has one sign.

Inside an aspect two poses are joined by a motion without a singular pose; between aspects there is none. They
are classes of *cells*, the gaps between the arcs of each slab, joined where a gap continues through a line
(mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import degrees
from typing import Any

from rpr_solver.model.joint_points import coordinate_names
from rpr_solver.singular.floats import drawn
from rpr_solver.singular.strands import UnionFind
from rpr_solver.singular.sweep import Sweep
from rpr_solver.singular.tracing import TURN, Sample

Cell = tuple[int, int]
"""A slab and the number of a gap in it."""
Point = tuple[float, float]


@dataclass(frozen=True)
class Aspect:
    """A connected region of the torus of poses (α, θ) on which J has one sign.

    Attributes:
        sign: that of J.
        share: the part of the torus that it covers, about.
        polygons: closed polygons of (α, θ) in degrees, from −180 to 180, for drawing; together they cover
            the aspect, and they meet only along their edges.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> [aspect.sign for aspect in singular_curves(EXAMPLES["innocenti"], 27).aspects]
    [1, 1, -1]
    >>> singular_curves(EXAMPLES["innocenti"], 27).aspects[0]
    <Aspect of J > 0: 47.6% of the poses>
    """

    sign: int
    share: float
    polygons: tuple[tuple[Point, ...], ...]

    def __repr__(self) -> str:
        return f"<Aspect of J {'>' if self.sign > 0 else '<'} 0: {self.share:.1%} of the poses>"

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's aspect object."""
        alpha, theta, *_ = coordinate_names(fixed_leg)
        return {
            "sign": self.sign,
            "share": round(self.share, 6),
            "polygons": [
                dict(zip((alpha, theta), map(drawn, zip(*polygon, strict=True)), strict=True))
                for polygon in self.polygons
            ],
        }


def aspect_cells(sweep: Sweep) -> list[tuple[int, list[Cell]]]:
    """The sign and the cells of each aspect: first those with J > 0; exact."""
    cells = UnionFind((k, gap) for k, slab in enumerate(sweep.slabs) for gap in range(slab.gaps))
    for line, part in enumerate(sweep.lines):
        for left, right in part.links:
            cells.join((line, right), ((line - 1) % len(sweep.slabs), left))
    signed = [(sweep.slabs[group[0][0]].signs[group[0][1]], group) for group in cells.classes()]
    return sorted(signed, key=lambda x: -x[0])


def drawn_aspects(
    sweep: Sweep, course: Callable[[int, int], Sequence[Sample]], span: Callable[[int], Point]
) -> list[Aspect]:
    """The aspects with their polygons, by sign, then by falling size.

    Args:
        sweep: the topology.
        course: the samples of an arc.
        span: the angles θ, in radians, at the ends of a slab.
    """
    drawn = []
    for sign, cells in aspect_cells(sweep):
        polygons = [p for cell in cells for p in _polygons(sweep, cell, course, span)]
        share = sum(abs(_area(polygon)) for polygon in polygons) / 360**2
        drawn.append(Aspect(sign, share, tuple(polygons)))
    return sorted(drawn, key=lambda aspect: (-aspect.sign, -aspect.share))


def _polygons(
    sweep: Sweep, cell: Cell, course: Callable[[int, int], Sequence[Sample]], span: Callable[[int], Point]
) -> Iterator[tuple[Point, ...]]:
    """A cell as polygons within the square."""
    slab, gap = cell
    arcs = len(sweep.slabs[slab].arcs)
    if arcs:
        low = [(x.alpha, x.theta) for x in course(slab, gap)]
        high = [(x.alpha + (TURN if gap == arcs - 1 else 0), x.theta) for x in course(slab, (gap + 1) % arcs)]
    else:
        start, stop = span(slab)
        low, high = [(-TURN / 2, start), (-TURN / 2, stop)], [(TURN / 2, start), (TURN / 2, stop)]
    outline = [(degrees(x), degrees(y)) for x, y in (*low, *reversed(high))]
    for alphas in _strips(outline, 0):
        yield from (tuple(polygon) for polygon in _strips(alphas, 1) if abs(_area(polygon)) > 0)


def _strips(polygon: Sequence[Point], axis: int) -> Iterator[list[Point]]:
    """A polygon cut at odd multiples of 180° of one coordinate, its parts moved between −180° and 180°."""
    values = [p[axis] for p in polygon]
    turn = round(min(values) / 360)
    while 360 * turn - 180 < max(values):
        below = _clipped(polygon, axis, 360 * turn - 180, 1)
        part = _clipped(below, axis, 360 * turn + 180, -1)
        if len(part) > 2:
            yield [(x - 360 * turn, y) if axis == 0 else (x, y - 360 * turn) for x, y in part]
        turn += 1


def _clipped(polygon: Sequence[Point], axis: int, bound: float, side: int) -> list[Point]:
    """The part of a polygon on one side of a line, by Sutherland and Hodgman."""
    result: list[Point] = []
    if not polygon:
        return result
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


def _area(polygon: Sequence[Point]) -> float:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise([*polygon, polygon[0]])) / 2
