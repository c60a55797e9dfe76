"""The cusp locus in three plane projections, which share their axes as in a technical drawing.

Above left the plane of the fixed leg and the second, below it that of the fixed leg and the third, to the
right of the first that of the third and the second. In a column of a journal they stand below each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from rpr_solver.figures.census import mark
from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.figures.locus import Locus, Spot, curve_paint, kinds_legend
from rpr_solver.figures.sheet import (
    SMALL,
    WIDTH,
    Frame,
    Ticks,
    number,
    sheet,
    ticks,
    width,
)
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Group, Path, Point, Scene, Shape, Text, distance, simplified

_LEFT, _TOP, _RIGHT = 72.0, 74.0, 22.0
_GAP, _AXIS = 18.0, 50.0
"""Between planes that share an axis, and for an axis with its ticks and title."""
_NARROW = 480.0
"""Narrower pictures have the planes below each other."""
_FLAT, _SQUARE, _HIGH = 0.62, 0.85, 1.4
"""Heights by widths: of a plane in a column, of all without a common scale, and of all at most."""
_LEAST = 110.0
"""The least side of a plane with a common scale."""
_ROW, _SAMPLE, _NAME = 18.0, 30.0, 12.0
"""The legend: the height of a row, the length of a line in it, the size of a name."""
_SPOTS = (0.5, 0.3, 0.7, 0.15, 0.85, 0.02, 0.98)
"""Where along a curve its name is tried."""
_MOST = 1.6
"""How much a name may hide, in cells of lines, and how far it may be, in 17 pixels."""


@drawing
def projections_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws curves of cusps in the planes of any two lengths.

    Args:
        document: as :meth:`CuspCurves.to_json` gives it, with several points on each curve.
    """
    locus = Locus.of(document)
    wide = style.width or WIDTH
    planes, legend, bottom = _planes(locus, number(document["range"]["from"]), wide)
    titles = [style.axis(title) for title in locus.titles]
    shapes: list[Shape] = [*kinds_legend(document["curves"], wide)]
    for plane in planes:
        shapes += plane.shapes(locus, titles)
    shapes += legend.shapes()
    first, second, third = locus.titles
    how = f"in the planes of {first} and {second}, {first} and {third}, and {third} and {second}"
    title = f"{locus.title}, in three planes"
    return sheet(style, title, document, locus.facts(how), shapes, (wide, bottom + 44))


@dataclass(frozen=True)
class _Plane:
    """One projection.

    Attributes:
        frame: where it is drawn.
        axes: the numbers of the coordinates to the right and upwards, from 0.
        has_axes: whether the axis below, and that on the left, have ticks and titles.
    """

    frame: Frame
    axes: tuple[int, int]
    has_axes: tuple[bool, bool]

    def line(self, spots: Sequence[Spot]) -> list[Point]:
        """The places of points."""
        return self.frame.line([(spot[self.axes[0]], spot[self.axes[1]]) for spot in spots])

    def shapes(self, locus: Locus, titles: Sequence[str]) -> Iterator[Shape]:
        """Yields axes, curves, their ends and names."""
        box = self.frame.box
        yield from self._axes(titles)
        drawn = [(name, self.line(spots)) for name, spots in locus.curves]
        for k, (name, line) in enumerate(drawn):
            yield Group((Path((simplified(line, 0.1),), curve_paint(k, 1.6)),), f"curve {name}", box)
        for spot, kind, words in locus.ends:
            yield Group((mark(kind, self.line([spot])[0], 4),), words)
        yield from _names(drawn, [self.line([spot])[0] for spot, _, _ in locus.ends], box)

    def _axes(self, titles: Sequence[str]) -> Iterator[Shape]:
        """Yields grid and edge, and the ticks and titles of the axes that have them."""
        box = self.frame.box
        scales = (self.frame.x, box.width, 60), (self.frame.y, box.height, 40)
        across, up = (
            ticks(scale.low, scale.high, max(int(room / least), 2)) for scale, room, least in scales
        )
        has_across, has_up = self.has_axes
        across = self._apart(across) if has_across else [(value, "") for value, _ in across]
        up = [(y, words if has_up and width(words, SMALL) < box.x0 - 10 else "") for y, words in up]
        names = [titles[k] if has else "" for k, has in zip(self.axes, self.has_axes, strict=True)]
        for shape in self.frame.shapes(names[0], names[1], across, up):
            if not isinstance(shape, Text) or shape.words:
                yield shape

    def _apart(self, marks: Ticks) -> list[tuple[float, str]]:
        """Ticks of the lower axis without those words that would cover others, or leave the picture."""
        box, end = self.frame.box, 4.0
        kept = []
        for value, words in marks:
            x, half = self.frame.x(value), width(words, SMALL) / 2
            fits = x - half > end and x + half < box.x1 + _RIGHT - 2
            end = x + half + 6 if fits else end
            kept.append((value, words if fits else ""))
        return kept


def _names(drawn: Sequence[tuple[str, Sequence[Point]]], ends: Sequence[Point], box: Box) -> Iterator[Text]:
    """Yields the names of curves that are long enough, where they hide nothing."""
    room = OccupancyGrid(box.grown(-2), (line for _, line in drawn))
    for end in ends:
        room.add_box(Box.around([end]).grown(4))
    for k, (name, line) in enumerate(drawn):
        if sum(map(distance, line, line[1:])) < 24:
            continue
        for share in _SPOTS:
            at = line[round(share * (len(line) - 1))]
            text = room.near_if_free(at, name, _NAME, 9, curve_paint(k).stroke, _MOST)
            if text is not None:
                yield text
                break


def _planes(locus: Locus, start: float, wide: float) -> tuple[list[_Plane], _Legend, float]:
    """The planes, the legend, and how far down they reach."""
    spans = _spans(locus, start)
    names = [name for name, _ in locus.curves]
    if wide < _NARROW:
        high = _FLAT * (wide - _LEFT - _RIGHT)
        tops = _TOP, _TOP + high + _GAP, _TOP + 2 * high + _GAP + _AXIS + _GAP
        boxes = [Box(_LEFT, top, wide - _RIGHT, top + high) for top in tops]
    else:
        boxes = _quadrants(spans, wide)
    legend = _Legend(names, Box(16, max(box.y1 for box in boxes) + _AXIS + 4, wide - 16, 0))
    free = Box(boxes[2].x0 + 6, boxes[2].y1 + _AXIS + 10, boxes[2].x1, boxes[1].y1)
    ranged = [
        f"{name}: {locus.titles[0]} from {span}" for name, span in zip(names, locus.ranges, strict=True)
    ]
    for words in (names, ranged) if wide >= _NARROW else ():
        legend = _Legend(words, free) if _Legend(words, free).fits else legend
    bottom = max(*(box.y1 + _AXIS for box in boxes[1:]), legend.box.y0 + legend.height)
    axes = (0, 1), (0, 2), (2, 1)
    shown = (False, True), (True, True), (True, wide < _NARROW)
    planes = [
        _Plane(Frame.of(box, Box(spans[i][0], spans[k][0], spans[i][1], spans[k][1])), (i, k), has)
        for box, (i, k), has in zip(boxes, axes, shown, strict=True)
    ]
    return planes, legend, bottom


def _quadrants(spans: Sequence[tuple[float, float]], wide: float) -> list[Box]:
    """The boxes of the planes, with one scale for all lengths unless that makes one of them too small."""
    across = wide - _LEFT - _RIGHT - _GAP
    first, second, third = (high - low for low, high in spans)
    scale = across / (first + third)
    sides = [scale * first, scale * third, scale * second, scale * third]
    if min(sides) < _LEAST or sides[2] + sides[3] > _HIGH * across:
        sides = [across / 2, across / 2, _SQUARE * across / 2, _SQUARE * across / 2]
    left, right, upper, lower = sides
    x, y = _LEFT + left + _GAP, _TOP + upper + _GAP
    return [
        Box(_LEFT, _TOP, _LEFT + left, _TOP + upper),
        Box(_LEFT, y, _LEFT + left, y + lower),
        Box(x, _TOP, x + right, _TOP + upper),
    ]


def _spans(locus: Locus, start: float) -> list[tuple[float, float]]:
    """The range of each length, with a margin above."""
    spots = [spot for _, spots in locus.curves for spot in spots] or [(start, 0.0, 0.0)]
    lows = [min(start, *(spot[0] for spot in spots)), *(min(spot[k] for spot in spots) for k in (1, 2))]
    spans = []
    for k, low in enumerate(lows):
        high = max(spot[k] for spot in spots)
        far = (high - low) or high or 1.0
        low = low if k == 0 else 0.0 if low < 0.45 * far else low - 0.04 * far
        spans.append((low, high + 0.04 * far))
    return spans


@dataclass(frozen=True)
class _Legend:
    """How each curve is drawn, in columns.

    Attributes:
        words: for each curve.
        box: where it begins, and how wide it may be.
    """

    words: Sequence[str]
    box: Box

    @property
    def height(self) -> float:
        """Of all rows."""
        return _ROW * self._rows

    @property
    def fits(self) -> bool:
        """Whether the box has room for all."""
        return self._column <= self.box.width and self.height <= self.box.height

    @property
    def _column(self) -> float:
        return _SAMPLE + 18 + max((width(words, SMALL) for words in self.words), default=0.0)

    @property
    def _rows(self) -> int:
        return ceil(len(self.words) / max(int(self.box.width / self._column), 1))

    def shapes(self) -> Iterator[Shape]:
        """Yields a line and the words of each curve."""
        for k, words in enumerate(self.words):
            x = self.box.x0 + k // self._rows * self._column
            y = self.box.y0 + (k % self._rows + 0.5) * _ROW
            yield Path(([(x, y), (x + _SAMPLE, y)],), curve_paint(k, 1.8))
            yield Text((x + _SAMPLE + 6, y), words, SMALL, "soft")
