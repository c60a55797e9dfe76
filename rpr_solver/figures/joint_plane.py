"""A slice in joint space: singular curves, regions by their number of poses, cusps circled and lettered.

Cusps too close to anything else to be seen are magnified in insets.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.axes import Frame
from rpr_solver.figures.labels import OccupancyGrid, names_inside
from rpr_solver.figures.sheet import WIDTH, listed, number, sheet, short, swatches
from rpr_solver.figures.strands import CIRCLE, Angles, SliceCurves, cusp_mark, cusp_marks, smooth
from rpr_solver.notebook import counted
from rpr_solver.notebook.figure import Figure
from rpr_solver.notebook.scene import (
    Box,
    Group,
    Line,
    Paint,
    Path,
    Point,
    Shape,
    Text,
    area,
    clipped,
    distance,
    off_segment,
)

CLEAR = 13.0
"""How far, in pixels, a cusp must be from other cusps and corners to be seen."""
_ASIDE = 7.0
"""How far it must be from other pieces of curve."""
_REACH = 34.0
"""Crowded cusps not farther than this from each other share an inset."""
_OWN, _BEGIN = 2.5, 14.0
_LEAST, _DEEPEST = 1e-9, 4


@dataclass(frozen=True)
class Spot:
    """A cusp in the picture: its curve, the number of its point on it."""

    line: int
    index: int


@dataclass(frozen=True)
class Window:
    """A part of the picture to be magnified.

    Attributes:
        box: in pixels of the picture.
        members: the numbers, from 0, of the cusps that the inset shows.
    """

    box: Box
    members: tuple[int, ...]


def windows(
    lines: Sequence[Line], cusps: Sequence[Spot], corners: Sequence[Point], size: float
) -> list[Window]:
    """The windows that are needed to see every cusp, for insets of a size in pixels.

    Args:
        lines: the curves in the picture.
        cusps: the cusps on them.
        corners: the places of other corners of the curves.
        size: the side of an inset.
    """
    places = [lines[cusp.line][cusp.index] for cusp in cusps]
    rooms = [
        max(min([_room(lines, cusp), *(distance(place, p) for p in corners), *_apart(places, k)]), _LEAST)
        for k, (cusp, place) in enumerate(zip(cusps, places, strict=True))
    ]
    crowded = [k for k, room in enumerate(rooms) if room < CLEAR]
    return list(_parted(crowded, places, rooms, size, _REACH, 0))


def _parted(
    crowded: Sequence[int],
    places: Sequence[Point],
    rooms: Sequence[float],
    size: float,
    reach: float,
    depth: int,
) -> Iterator[Window]:
    """Yields windows for crowded cusps, then narrower ones for those that these do not part."""
    for members in _chains(crowded, places, reach):
        extent = Box.around([places[k] for k in members])
        half = max(0.75 * max(extent.width, extent.height), 2.6 * min(rooms[k] for k in members))
        still = [k for k in members if rooms[k] * size / (2 * half) < CLEAR] if depth < _DEEPEST else []
        if len(still) < len(members):
            (x, y) = extent.centre
            yield Window(Box(x - half, y - half, x + half, y + half), tuple(members))
        if still:
            yield from _parted(still, places, rooms, size, 3 * max(rooms[k] for k in still), depth + 1)


def _chains(members: Sequence[int], places: Sequence[Point], reach: float) -> list[list[int]]:
    """The members in groups, each a chain of points not farther than ``reach`` from one another."""
    left, groups = list(members), []
    while left:
        group = [left.pop(0)]
        for k in group:
            near = [other for other in left if distance(places[k], places[other]) <= reach]
            group += near
            left = [other for other in left if other not in near]
        groups.append(sorted(group))
    return groups


def _apart(places: Sequence[Point], k: int) -> list[float]:
    return [distance(places[k], other) for i, other in enumerate(places) if i != k]


def _room(lines: Sequence[Line], cusp: Spot) -> float:
    """The room of a cusp between pieces of curve other than its own two branches: ``CLEAR`` is enough."""
    own = lines[cusp.line]
    place = own[cusp.index]
    best = _ASIDE
    for i, line in enumerate(lines):
        along = _along(own, cusp.index) if i == cusp.line else None
        for k, (a, b) in enumerate(pairwise(line)):
            if min(abs(a[0] - place[0]), abs(b[0] - place[0])) > best + abs(a[0] - b[0]):
                continue
            off = off_segment(place, a, b)
            if off < best and (along is None or min(along[k], along[k + 1]) > _OWN * off + _BEGIN):
                best = off
    return best * CLEAR / _ASIDE


def _along(line: Line, index: int) -> list[float]:
    """The length of the line between one of its points and each other, the shorter way if it is closed."""
    lengths = list(accumulate((distance(a, b) for a, b in pairwise(line)), initial=0.0))
    whole = lengths[-1]
    ways = [abs(x - lengths[index]) for x in lengths]
    is_closed = distance(line[0], line[-1]) < 0.01
    return [min(way, whole - way) for way in ways] if is_closed else ways


HEIGHT = 656.0
_PLOT = Box(72, 46, WIDTH - 24, HEIGHT - 108)
_INSET, _COLUMN = 168.0, 200.0
_LEVELS = (0, 2, 4, 6)


def joint_figure(document: Mapping[str, Any]) -> Figure:
    """Draws the singular curves of a slice in the plane of the free legs.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    return _JointPlane(document).figure()


class _JointPlane:
    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = document
        self._curves = SliceCurves.of(document)
        self._names = [f"l{k}" for k in (1, 2, 3) if k != self._curves.leg]
        strands = self._curves.strands
        self._frame = Frame.of(_PLOT, _range([point for strand in strands for point in strand.points]))
        self._lines = [self._frame.line(strand.points) for strand in strands]
        self._posed = [[self._pose(pose) for pose in strand.poses] for strand in strands]
        self._places = [self._frame.place(self._point(cusp)) for cusp in self._curves.cusps]

    def figure(self) -> Figure:
        """The picture."""
        curves = self._curves.lines(self._pose, places=self._posed)
        room = OccupancyGrid(_PLOT.grown(-4))
        for line in curves:
            room.add_line(line)
        for place in self._places:
            room.add_point(place)
        parted = windows(self._lines, self._spots(), self._corners(), _INSET)
        labels = list(self._letters(room, parted))
        insets, wide = self._placed(parted, room)
        regions = list(self._regions())
        counts = list(names_inside(((path.lines, str(poses)) for poses, path in regions), room, 26))
        legend = [
            (_role(poses), f"{poses} poses" if poses else "no pose")
            for poses in sorted({poses for poses, _ in regions})
        ]
        names = [title.upper() for title in self._names]
        shapes = [
            Group(tuple(shape for _, shape in regions), clip=_PLOT),
            *self._frame.shapes(names[0], names[1]),
            Group((smooth(curves),), "singular curves", _PLOT),
            *counts,
            *cusp_marks(self._places),
            *labels,
            *(shape for inset in insets for shape in inset),
            *swatches(legend, _PLOT.centre[0], HEIGHT - 44),
        ]
        leg, cusps = self._curves.leg, counted(len(self._places), "cusp") if self._places else "no cusp"
        title = f"Singular curves at L{leg} = {short(self._document[f'l{leg}'], 8)}: {cusps}"
        return sheet(title, self._document["geometry"], self._facts(names), shapes, HEIGHT, wide)

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

    def _placed(self, parted: Sequence[Window], room: OccupancyGrid) -> tuple[list[list[Shape]], float]:
        """The insets, in the plot where they hide nothing, else beside it; and the picture's width."""
        insets, column = [], 0
        for window in parted:
            room.add_box(_marked(window))
        for window in parted:
            target = window.box.centre
            free = [room.free_box(share * _INSET, share * _INSET, target) for share in (1, 0.85, 0.7)]
            box = min(filter(None, free), key=lambda box: _far(box, target), default=None)
            if box is None:
                top = _PLOT.y0 + column * (_INSET + 16)
                box = Box(WIDTH, top, WIDTH + _INSET, top + _INSET)
                column += 1
            room.add_box(box.grown(4))
            insets.append(list(self._inset(window, box)))
        return insets, WIDTH + (_COLUMN if column else 0)

    def _inset(self, window: Window, box: Box) -> Iterator[Shape]:
        """Yields an inset: its frame, what is in it, and lines to the part that it magnifies."""
        zoom = box.width / window.box.width
        x0, y0 = window.box.x0, window.box.y0

        def zoomed(place: Point) -> Point:
            return box.x0 + (place[0] - x0) * zoom, box.y0 + (place[1] - y0) * zoom

        marked = _marked(window)
        yield Path(tuple(_leaders(marked, box)), Paint(stroke="ghost", width=0.9, dash=(4, 3)))
        yield Path((marked.corners,), Paint(stroke="soft", width=1.2), closed=True)
        yield Path((box.corners,), Paint("paper"), closed=True)
        places = [[zoomed(place) for place in line] for line in self._posed]
        lines = self._curves.lines(lambda pose: zoomed(self._pose(pose)), box, places)
        curves = [piece for line in lines for piece in clipped(line, box)]
        inside = OccupancyGrid(box.grown(-3))
        for line in curves:
            inside.add_line(line)
        yield smooth(curves)
        yield Path((box.corners,), Paint(stroke="soft", width=1.4), closed=True)
        yield from _zoomed_cusps([zoomed(place) for place in self._places], window, box, inside)
        scale = Text((box.x0 + 6, box.y1 - 10), f"× {short(zoom, 2)}", 11.5, "soft", halo="paper")
        corner = inside.near((box.x1 - 26, box.y1 - 10), scale.words, 11.5, 0, "soft")
        yield Text(corner.at, scale.words, 11.5, "soft", "middle", halo="paper")

    def _regions(self) -> Iterator[tuple[int, Path]]:
        """Yields the regions with their numbers of poses; rings of holes run the other way."""
        for region in self._document.get("regions", ()):
            rings = [
                self._frame.line(list(zip(*(ring[name] for name in self._names), strict=True)))
                for ring in region["rings"]
            ]
            if not region["bounded"]:
                rings.insert(0, list(_PLOT.corners))
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


def _far(box: Box, target: Point) -> float:
    """How unsuitable a box is for an inset: its distance, and what it lacks in size."""
    return distance(box.centre, target) + 2 * (_INSET - box.width)


def _marked(window: Window) -> Box:
    """The box in the picture that stands for a window, which may be too small to be seen."""
    (x, y), half = window.box.centre, max(window.box.width / 2, 11)
    return Box(x - half, y - half, x + half, y + half)


def _leaders(source: Box, target: Box) -> Iterator[list[Point]]:
    """Yields two lines from a box to the box that magnifies it: those that cross neither."""
    pairs = list(zip(source.corners, target.corners, strict=True))
    free = [pair for pair in pairs if not any(_crosses(*pair, box.grown(-0.5)) for box in (source, target))]
    yield from ([a, b] for a, b in free[:2])


def _crosses(a: Point, b: Point, box: Box) -> bool:
    return any(True for _ in clipped([a, b], box))
