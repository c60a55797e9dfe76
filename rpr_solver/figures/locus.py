"""The cusp locus: the curves of cusps in joint space (L1, L2, L3), seen from a corner."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import ceil, cos, inf, radians, sin
from typing import Any

from rpr_solver.figures.census import mark
from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.figures.sheet import (
    EDGE,
    GRID,
    SMALL,
    WIDTH,
    box_of,
    number,
    sheet,
    short,
    ticks,
    width,
)
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Group, Paint, Path, Point, Scene, Shape, Text, simplified

_SHARE = 640 / WIDTH
_USUAL = 310.0
"""Pixels of the shortest side of the box in a picture of the usual width, about."""
_TURN, _TILT = radians(32), radians(24)
_SIDES = (1.5, 1.0, 0.95)
"""The sides of the box in which the locus is drawn: along the fixed leg, and the two others."""
_COLOURS = ("line1", "line2", "line3", "line4", "line5")
_DASHES: Sequence[tuple[float, ...]] = ((), (7, 3), (2, 2), (9, 3, 2, 3), (4, 2, 1, 2, 1, 2))

Spot = tuple[float, float, float]


@drawing
def locus_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws curves of cusps.

    Args:
        document: as :meth:`CuspCurves.to_json` gives it, with several points on each curve.
    """
    locus = Locus.of(document)
    wide = style.width or WIDTH
    size = wide, _SHARE * wide
    view = _View.of([spots for _, spots in locus.curves], number(document["range"]["from"]), size)
    drawn = [(name, view.line(spots)) for name, spots in locus.curves]
    walls = list(_walls(view, [style.axis(title) for title in locus.titles]))
    shapes = [
        *walls,
        *(_shadow(view, spots) for _, spots in locus.curves),
        *_lines(view, locus.curves),
        *(Group((mark(kind, view.place(spot), 5),), words) for spot, kind, words in locus.ends),
        *_names(drawn, walls, Box(10, 70, wide - 10, size[1] - 40)),
        *kinds_legend(document["curves"], wide),
    ]
    text = locus.facts("with their shadows on the floor")
    return sheet(style, locus.title, document, text, shapes, size)


@dataclass(frozen=True)
class Locus:
    """The curves of a document in floats.

    Attributes:
        titles: of the axes: the fixed leg, and the two others.
        curves: each with its name and its points in (fixed leg, others).
        ends: the transitions at which curves begin and end: the point, the kind, and both in words.
        notes: where each curve begins and ends.
        ranges: the same as a range of lengths, in short.
    """

    titles: tuple[str, ...]
    curves: tuple[tuple[str, tuple[Spot, ...]], ...]
    ends: tuple[tuple[Spot, str, str], ...]
    notes: tuple[str, ...]
    ranges: tuple[str, ...]

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Locus:
        """The curves, as far as they are drawn."""
        leg = document["fixed_leg"]
        titles = tuple(f"L{k}" for k in (leg, *sorted({1, 2, 3} - {leg})))
        names = [title.lower() for title in titles]
        stop = _stop(document, names[0])
        curves = tuple(
            (curve["name"], tuple(spot for spot in _spots(curve, names) if spot[0] <= stop))
            for curve in document["curves"]
        )
        notes = tuple(_note(curve, titles[0], names[0]) for curve in document["curves"])
        ranges = tuple(_range(curve["from"][names[0]], curve["to"][names[0]]) for curve in document["curves"])
        return cls(titles, curves, tuple(dict.fromkeys(_ends(document["curves"], names))), notes, ranges)

    @property
    def title(self) -> str:
        """How many curves there are."""
        count = len(self.curves)
        return f"Cusp locus: {'one curve' if count == 1 else f'{count} curves'} of cusps"

    def facts(self, how: str) -> str:
        """What is drawn, and where each curve begins and ends."""
        return f"Curves of cusps in ({', '.join(self.titles)}), {how}. {'; '.join(self.notes)}."


def _note(curve: Mapping[str, Any], title: str, name: str) -> str:
    """Where a curve begins and ends."""
    start, stop = curve["from"], curve["to"]
    begins = f"{curve['name']} from {title} = {_end(start, name)} ({start['kind']})"
    return f"{begins} to {_end(stop, name)} ({stop['kind']})"


def _spots(curve: Mapping[str, Any], names: Sequence[str]) -> list[Spot]:
    """The points of a curve, with its ends where a single pose is known there."""
    start, stop = (_end_spot(curve[end], names) for end in ("from", "to"))
    spots = [start, *(_spot(point, names) for point in curve["points"]), stop]
    return [spot for spot in spots if spot is not None]


def _end_spot(end: Mapping[str, Any], names: Sequence[str]) -> Spot | None:
    """Where a curve begins or ends, if it is a single pose."""
    if end[names[0]] is None or len(end["events"]) != 1:
        return None
    return _spot({**end["events"][0], names[0]: end[names[0]]}, names)


def _spot(point: Mapping[str, str], names: Sequence[str]) -> Spot:
    a, b, c = (number(point[name]) for name in names)
    return a, b, c


def _stop(document: Mapping[str, Any], name: str) -> float:
    """The greatest length that is drawn: that of the range, or not far from the last end of a curve."""
    if document["range"]["to"] is not None:
        return number(document["range"]["to"])
    ends = [end[name] for curve in document["curves"] for end in (curve["from"], curve["to"])]
    return 1.3 * max((number(end) for end in ends if end is not None), default=0.0) or inf


def _range(start: str | None, stop: str | None) -> str:
    """A range with enough digits to distinguish its ends.

    >>> _range("9.18680657065541", "9.18688909674875"), _range("20.5551", None)
    ('9.1868 to 9.1869', '20.56 to ∞')
    """
    ends = [end for end in (start, stop) if end is not None]
    digits = next((n for n in range(4, 12) if len({short(end, n) for end in ends}) == len(ends)), 12)
    first, last = ("∞" if end is None else short(end, digits) for end in (start, stop))
    return f"{first} to {last}"


def _end(end: Mapping[str, Any], name: str) -> str:
    return "∞" if end[name] is None else f"{number(end[name]):.5g}"


@dataclass(frozen=True)
class _View:
    """A parallel projection of the box of values onto the picture."""

    low: Spot
    high: Spot
    scale: float
    shift: Point

    @classmethod
    def of(cls, curves: Sequence[Sequence[Spot]], start: float, size: Point) -> _View:
        """The view, in a picture of a size, of all points of curves in a range that begins at ``start``."""
        spots = [spot for curve in curves for spot in curve] or [(0.0, 0.0, 0.0)]
        low = min(spot[0] for spot in spots)
        span = [(min(low, start), max(spot[0] for spot in spots))]
        span += [(0.0, max(spot[k] for spot in spots)) for k in (1, 2)]
        rounded = [_rounded(a, b) for a, b in span]
        (a, d), (b, e), (c, f) = rounded
        draft = cls((a, b, c), (d, e, f), 1.0, (0.0, 0.0))
        box = Box.around([draft.place(corner) for corner in draft.corners()])
        room = Box(64, 78, size[0] - 40, size[1] - 84)
        scale = min(room.width / box.width, room.height / box.height)
        (x, y), (u, v) = box.centre, room.centre
        return cls((a, b, c), (d, e, f), scale, (u - scale * x, v - scale * y))

    def corners(self) -> Iterator[Spot]:
        """The corners of the box of values."""
        (x0, y0, z0), (x1, y1, z1) = self.low, self.high
        return product((x0, x1), (y0, y1), (z0, z1))

    def _cube(self, spot: Spot) -> Spot:
        x, y, z = (
            side * ((value - low) / (high - low) - 0.5)
            for value, low, high, side in zip(spot, self.low, self.high, _SIDES, strict=True)
        )
        return x, y, z

    def place(self, spot: Spot) -> Point:
        """The place of a point in the picture."""
        x, y, z = self._cube(spot)
        across = x * cos(_TURN) + y * sin(_TURN)
        up = z * cos(_TILT) + (y * cos(_TURN) - x * sin(_TURN)) * sin(_TILT)
        return self.shift[0] + self.scale * across, self.shift[1] - self.scale * up

    def depth(self, spot: Spot) -> float:
        """How far away a point is."""
        x, y, z = self._cube(spot)
        return (y * cos(_TURN) - x * sin(_TURN)) * cos(_TILT) - z * sin(_TILT)

    def line(self, spots: Sequence[Spot]) -> list[Point]:
        """The places of points."""
        return [self.place(spot) for spot in spots]


def _rounded(low: float, high: float) -> tuple[float, float]:
    """A range that ends at a tick."""
    if high <= low:
        high = low + 1
    [first, second, *_] = ticks(low, low + 2 * (high - low), 10)
    step = second[0] - first[0]
    return low if low == 0 else step * (low // step), step * ceil(high / step - 1e-9)


def _walls(view: _View, titles: Sequence[str]) -> Iterator[Shape]:
    """The floor and the two walls behind, with grids, ticks and titles."""
    (x0, y0, z0), (x1, y1, z1) = view.low, view.high
    share = min(view.scale / _USUAL, 1)
    most = (max(int(n * share), 2) for n in (8, 5, 5))
    scales = [ticks(a, b, n) for a, b, n in zip(view.low, view.high, most, strict=True)]
    grid: list[list[Spot]] = []
    for x, _ in scales[0]:
        grid += [[(x, y0, z0), (x, y1, z0)], [(x, y1, z0), (x, y1, z1)]]
    for y, _ in scales[1]:
        grid += [[(x0, y, z0), (x1, y, z0)], [(x0, y, z0), (x0, y, z1)]]
    for z, _ in scales[2]:
        grid += [[(x0, y1, z), (x1, y1, z)], [(x0, y0, z), (x0, y1, z)]]
    floor: list[Spot] = [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)]
    yield Path((view.line(floor),), Paint("tint"), closed=True)
    yield Path(tuple(view.line(line) for line in grid), GRID)
    yield Path((view.line([(x0, y0, z1), *floor[:3]]),), EDGE)
    corners: tuple[Spot, ...] = ((x0, y0, z0), (x1, y0, z0), (x0, y0, z0))
    texts = ((4, 15, "end"), (8, 9, "start"), (-8, 0, "end"))
    for axis, (right, down, anchor) in enumerate(texts):
        for value, words in scales[axis]:
            px, py = view.place(_moved(corners[axis], axis, value))
            yield Text((px + right, py + down), words, SMALL, "soft", anchor)
    for axis, (right, down, turn) in enumerate(((-32, 42, 0), (44, 48, 0), (-44, 0, -90))):
        middle = (view.low[axis] + view.high[axis]) / 2
        px, py = view.place(_moved(corners[axis], axis, middle))
        yield Text((px + right, py + down), titles[axis], 15, "ink", "middle", turn=turn)


def _moved(spot: Spot, axis: int, value: float) -> Spot:
    """A spot with another coordinate along one axis."""
    x, y, z = (value if k == axis else own for k, own in enumerate(spot))
    return x, y, z


def _shadow(view: _View, spots: Sequence[Spot]) -> Shape:
    floor = view.low[2]
    line = simplified(view.line([(x, y, floor) for x, y, _ in spots]), 0.2)
    return Path((line,), Paint(stroke="faint", width=1.6))


def _lines(view: _View, curves: Sequence[tuple[str, Sequence[Spot]]]) -> Iterator[Shape]:
    """The curves from the farthest to the nearest, each with a border where it passes before another."""
    pieces = []
    for number_, (_, spots) in enumerate(curves):
        paint = curve_paint(number_)
        for start in range(0, max(len(spots) - 1, 0), 6):
            piece = spots[start : start + 7]
            pieces.append((view.depth(piece[len(piece) // 2]), view.line(piece), paint))
    for _, line, paint in sorted(pieces, key=lambda piece: -piece[0]):
        yield Path((simplified(line, 0.1),), paint)


def curve_paint(number_: int, width: float = 2) -> Paint:
    """How a curve is drawn: its colour, and its dashes."""
    colours = len(_COLOURS)
    dash = _DASHES[number_ // colours % len(_DASHES)]
    return Paint(stroke=_COLOURS[number_ % colours], width=width, dash=dash)


def _ends(curves: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Iterator[tuple[Spot, str, str]]:
    """Yields the transitions at which curves begin and end, for each of them."""
    for curve in curves:
        for end in (curve["from"], curve["to"]):
            if (spot := _end_spot(end, names)) is not None:
                yield spot, end["kind"], f"{end['kind']} at {end[names[0]]}"


def _names(drawn: Sequence[tuple[str, Sequence[Point]]], walls: Sequence[Shape], box: Box) -> Iterator[Shape]:
    """Yields the names of curves that are long enough, beside the numbers of axes."""
    room = OccupancyGrid(box, (line for _, line in drawn))
    for text in walls:
        if isinstance(text, Text) and not text.turn:
            room.add_box(box_of(text))
    for k, (name, line) in enumerate(drawn):
        far = sum(abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in pairwise(line))
        if far > 40:
            yield room.near(line[len(line) // 2], name, 12, 11, _COLOURS[k % len(_COLOURS)])


def kinds_legend(curves: Sequence[Mapping[str, Any]], wide: float) -> Iterator[Shape]:
    """Yields the marks of the transitions at which curves begin and end, above the picture."""
    kinds = {end["kind"] for curve in curves for end in (curve["from"], curve["to"])}
    known = [kind for kind in ("swallowtail", "beak-to-beak", "lips") if kind in kinds]
    x = wide / 2 - sum(36 + width(kind, SMALL) for kind in known) / 2
    for kind in known:
        yield mark(kind, (x + 6, 52))
        yield Text((x + 17, 52), kind, SMALL, "soft")
        x += 36 + width(kind, SMALL)
