"""A slice in joint space: singular curves, regions by their number of poses, cusps circled and lettered.

Cusps too close to anything else to be seen are magnified in insets.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.insets import FOOT, Inset, Spot, Window, areas, factor, outermost, placed, windows
from rpr_solver.figures.labels import OccupancyGrid, names_inside
from rpr_solver.figures.sheet import (
    EDGE,
    WIDTH,
    Frame,
    listed,
    number,
    sheet,
    short,
    swatches,
    swatches_height,
    ticks,
)
from rpr_solver.figures.strands import CIRCLE, Angles, SliceCurves, cusp_mark, cusp_marks, smooth
from rpr_solver.notebook import Style, counted
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import (
    Box,
    Group,
    Line,
    Paint,
    Path,
    Point,
    Scene,
    Shape,
    Text,
    area,
    clipped,
    distance,
    rectangle,
)

_LEFT, _TOP, _RIGHT = 72.0, 46.0, 24.0
_LOW, _HIGH = 0.45, 1.05
"""The height of the plot, by its width."""
_USUAL = 0.756
_LEGEND = 62.0
"""From the plot to the legend: ticks and the title of the axis."""
_LEVELS = (0, 2, 4, 6)
_LEADER = 22.0


@drawing
def joint_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws the singular curves of a slice in the plane of the free legs.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    return _JointPlane(style, document).scene()


class _JointPlane:
    def __init__(self, style: Style, document: Mapping[str, Any]) -> None:
        self._style, self._document = style, document
        self._width = style.width or WIDTH
        self._curves = SliceCurves.of(document)
        self._names = [f"l{k}" for k in (1, 2, 3) if k != self._curves.leg]
        strands = self._curves.strands
        self._frame = _frame(_range([point for strand in strands for point in strand.points]), self._width)
        self._plot = self._frame.box
        self._lines = [self._frame.line(strand.points) for strand in strands]
        self._posed = [[self._pose(pose) for pose in strand.poses] for strand in strands]
        self._places = [self._frame.place(self._point(cusp)) for cusp in self._curves.cusps]

    def scene(self) -> Scene:
        """The picture."""
        curves = self._curves.lines(self._pose, places=self._posed)
        found = windows(self._lines, self._spots(), self._corners())
        marks = [window.mark for window in outermost(found)]
        room = self._taken(curves, marks)
        regions = list(self._regions())
        legend = _legend({poses for poses, _ in regions})
        labels = list(self._letters(room, found))
        y = self._plot.y1 + _LEGEND + swatches_height(legend, self._width - 16)
        below = Box(_RIGHT, y + 22, self._width - _RIGHT, y + 22)
        insets = placed(found, room, below)
        bottom = max([y, *(inset.area.y1 for inset in insets if inset.is_below)])
        counts = list(self._counts(regions, room))
        names = [title.upper() for title in self._names]
        shapes = [
            Group(tuple(shape for _, shape in regions), clip=self._plot),
            *self._frame.shapes(self._style.axis(names[0]), self._style.axis(names[1])),
            Group((smooth(curves),), "singular curves", self._plot),
            *counts,
            *cusp_marks(self._places),
            *labels,
            *map(_outline, marks),
            *(shape for inset in insets for shape in self._inset(inset, found)),
            *swatches(legend, self._plot.centre[0], y, self._width - 16),
        ]
        leg, cusps = self._curves.leg, counted(len(self._places), "cusp") if self._places else "no cusp"
        title = f"Singular curves at L{leg} = {short(self._document[f'l{leg}'], 8)}: {cusps}"
        size = self._width, bottom + 44
        return sheet(self._style, title, self._document, self._facts(names), shapes, size)

    def _taken(self, curves: Sequence[Line], marks: Sequence[Box]) -> OccupancyGrid:
        """The plot, with what labels and insets must not hide."""
        room = OccupancyGrid(self._plot.grown(-4), curves, self._places)
        for mark in marks:
            room.add_box(mark)
        return room

    def _pose(self, pose: Angles) -> Point:
        """The place of a pose in the picture."""
        return self._frame.place(self._curves.floats.lengths(pose))

    def _point(self, vertex: Mapping[str, str]) -> Point:
        x, y = (number(vertex[name]) for name in self._names)
        return x, y

    def _spots(self) -> list[Spot]:
        found = {
            vertex["cusp"]: Spot(k, vertex["index"])
            for k, strand in enumerate(self._curves.strands)
            for vertex in strand.vertices
            if vertex["kind"] == "cusp"
        }
        return [found[number] for number in sorted(found)]

    def _corners(self) -> list[Point]:
        return [
            self._frame.place(self._point(vertex))
            for strand in self._curves.strands
            for vertex in strand.vertices
            if vertex["kind"] not in ("cusp", "turning")
        ]

    def _letters(self, room: OccupancyGrid, parted: Sequence[Window]) -> Iterator[Shape]:
        """The letters of the cusps; those that share a window are named together, at its box."""
        groups: list[list[int]] = []
        for window in parted:
            joined = [group for group in groups if set(group) & set(window.members)]
            groups = [group for group in groups if group not in joined]
            groups.append(sorted({*window.members, *(k for group in joined for k in group)}))
        single = [[k] for k in range(len(self._places)) if not any(k in group for group in groups)]
        for group in (*single, *groups):
            box = Box.around([self._places[k] for k in group])
            words = ", ".join(letter(k + 1) for k in group)
            yield room.near(box.centre, words, 15, 16 + max(box.width, box.height) / 2, "cusp")

    def _counts(self, regions: Sequence[tuple[int, Path]], room: OccupancyGrid) -> Iterator[Shape]:
        """Yields the numbers of poses in regions that have room for them; beside others, with a leader."""
        hidden = []
        for (poses, path), region in zip(regions, self._document.get("regions", ()), strict=True):
            inside = list(names_inside([(path.lines, str(poses))], room, 26))
            yield from inside
            point = self._frame.place(self._point(region["point"]))
            if not inside and point in self._plot.grown(-2):
                hidden.append((point, str(poses)))
        for point, words in hidden:
            text = room.near_if_free(point, words, 13, _LEADER)
            if text is not None:
                yield Path(([point, text.at],), Paint(stroke="soft", width=0.8))
                yield Text(text.at, text.words, text.size, "ink", "middle", halo="paper")

    def _inset(self, inset: Inset, found: Sequence[Window]) -> Iterator[Shape]:
        """Yields an inset: what is in it, its frame, the line below, and lines to what it magnifies."""
        box, window = inset.box, inset.window
        if not inset.is_below:
            yield Path(tuple(_leaders(window.mark, box)), Paint(stroke="ghost", width=0.9, dash=(4, 3)))
        yield rectangle(inset.area, Paint("paper"))
        places = [[inset.place(place) for place in line] for line in self._posed]
        lines = self._curves.lines(lambda pose: inset.place(self._pose(pose)), box, places)
        curves = [piece for line in lines for piece in clipped(line, box)]
        inside = OccupancyGrid(box.grown(-3), curves)
        if self._document.get("regions"):
            yield Group(tuple(self._shades(lines, box)), clip=box)
        yield smooth(curves)
        yield from _scale_marks(inset, self._frame)
        yield rectangle(box, Paint(stroke="soft", width=1.4))
        for other in found:
            if window.holds(other):
                mark = Window(Box.around(map(inset.place, other.box.corners)), ()).mark
                inside.add_box(mark)
                yield _outline(mark)
        yield from _zoomed_cusps([inset.place(place) for place in self._places], window, box, inside)
        shown = ", ".join(letter(k + 1) for k in window.members)
        words = f"{shown}: {factor(inset.zoom)}"
        yield Text((box.centre[0], box.y1 + FOOT / 2 + 1), words, 11.5, "soft", "middle")

    def _shades(self, lines: Sequence[Line], box: Box) -> Iterator[Shape]:
        """Yields the areas of an inset; outlines of their own colour hide the seams between them."""
        for poses, ring in areas(list(zip(lines, self._curves.senses, strict=True)), box):
            yield Path((ring,), Paint(_role(poses), _role(poses), 0.6), closed=True)

    def _regions(self) -> Iterator[tuple[int, Path]]:
        """Yields the regions with their numbers of poses; rings of holes run the other way."""
        for region in self._document.get("regions", ()):
            rings = [
                self._frame.line(list(zip(*(ring[name] for name in self._names), strict=True)))
                for ring in region["rings"]
            ]
            if not region["bounded"]:
                rings.insert(0, list(self._plot.corners))
            rings = [ring if (area(ring) > 0) == (k == 0) else ring[::-1] for k, ring in enumerate(rings)]
            yield region["poses"], Path(tuple(rings), Paint(_role(region["poses"])), closed=True)

    def _facts(self, names: Sequence[str]) -> str:
        cusps = [
            f"{letter(k)} at {names[0]} = {short(cusp[self._names[0]], 6)}, {names[1]} = "
            f"{short(cusp[self._names[1]], 6)}"
            for k, cusp in enumerate(self._curves.cusps, 1)
        ]
        listing = f" Cusps: {'; '.join(cusps)}." if cusps else ""
        return f"Singular curves in the plane of {listed(names)}.{listing}"


def _zoomed_cusps(places: Sequence[Point], window: Window, box: Box, room: OccupancyGrid) -> Iterator[Shape]:
    """Yields the cusps in an inset; only those that it is for are named if others are too near."""
    spots = [(k, place) for k, place in enumerate(places) if place in box.grown(-CIRCLE)]
    for _, spot in spots:
        room.add_point(spot)
    crowd = {k for k, a in spots for i, b in spots if i != k and distance(a, b) < CIRCLE}
    for k, spot in spots:
        yield cusp_mark(k + 1, spot)
        if k not in crowd or k in window.members:
            yield room.near(spot, letter(k + 1), 14, 14, "cusp")


def _outline(mark: Box) -> Shape:
    """What an inset magnifies."""
    return rectangle(mark, Paint(stroke="soft", width=1.2))


def _legend(numbers: set[int]) -> list[tuple[str, str]]:
    return [(_role(poses), f"{poses} poses" if poses else "no pose") for poses in sorted(numbers)]


def _role(poses: int) -> str:
    """The shade of a number of poses."""
    return f"poses{max(level for level in _LEVELS if level <= poses)}"


def _range(points: Sequence[Point]) -> Box:
    """The values that the frame shows: all points with a margin, from 0 if that is near."""
    box = Box.around(points)
    sides = []
    for low, high in ((box.x0, box.x1), (box.y0, box.y1)):
        wide = (high - low) or high or 1.0
        sides.append((0.0 if low < 0.45 * wide else low - 0.06 * wide, high + 0.05 * wide))
    (x0, x1), (y0, y1) = sides
    return Box(x0, y0, x1, y1)


def _frame(values: Box, width: float) -> Frame:
    """The frame for values, both axes to one scale unless that makes it very flat or high."""
    wide = width - _LEFT - _RIGHT
    share = values.height / values.width
    if share < _LOW / 2 or share > 2 * _HIGH:
        share = _USUAL
    elif share < _LOW:
        values = Box(values.x0, values.y0, values.x1, values.y0 + _LOW * values.width)
        share = _LOW
    elif share > _HIGH:
        values = Box(values.x0, values.y0, values.x0 + values.height / _HIGH, values.y1)
        share = _HIGH
    return Frame.of(Box(_LEFT, _TOP, _LEFT + wide, _TOP + share * wide), values)


def _scale_marks(inset: Inset, frame: Frame) -> Iterator[Shape]:
    """Yields ticks at round lengths on the edges of an inset."""
    box, window = inset.box, inset.window.box
    inside = Frame.of(box, Box(*frame.values((window.x0, window.y1)), *frame.values((window.x1, window.y0))))
    lines = []
    for x in (inside.x(value) for value, _ in ticks(inside.x.low, inside.x.high, 4)):
        lines += [[(x, box.y1), (x, box.y1 - 4)], [(x, box.y0), (x, box.y0 + 4)]]
    for y in (inside.y(value) for value, _ in ticks(inside.y.low, inside.y.high, 4)):
        lines += [[(box.x0, y), (box.x0 + 4, y)], [(box.x1, y), (box.x1 - 4, y)]]
    yield Path(tuple(lines), EDGE)


def _leaders(source: Box, target: Box) -> Iterator[list[Point]]:
    """Yields two lines from a box to the box that magnifies it: those that cross neither."""
    pairs = list(zip(source.corners, target.corners, strict=True))
    inner = source.grown(-0.5), target.grown(-0.5)
    free = [list(pair) for pair in pairs if not any(any(clipped(pair, box)) for box in inner)]
    yield from free[:2]
