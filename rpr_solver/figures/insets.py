"""Insets: which parts of a slice must be magnified to tell its cusps apart, where they are drawn, and shades.

The number of poses between singular curves, at any magnification, is twice the winding number of the
singular curves, each run with J > 0 on its left (Theorem 26 in docs/mathematics.md). Insets are shaded by it,
since the outlines of regions in a document are too coarse.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, combinations, pairwise
from math import floor, log10

from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.notebook.scene import Box, Line, Point, distance, off_segment

_NONE = 1e-7
"""In pixels: lower strips are left out."""

_Side = tuple[Point, Point, int]
"""A segment from its upper end to its lower one, and how much the count grows to its right."""


def areas(lines: Sequence[tuple[Line, int]], box: Box) -> Iterator[tuple[int, list[Point]]]:
    """Yields the numbers of poses in a box, each with a polygon; together the polygons cover the box.

    Args:
        lines: together they are closed; each with 1 if J > 0 on its left, else −1; precise in the box.
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


CLEAR = 14.0
"""How far, in pixels, a cusp must be from other cusps and corners to be seen."""
_ASIDE = 7.0
"""How far it must be from other pieces of curve."""
_REACH = 34.0
"""Crowded cusps not farther than this from each other share an inset."""
_OWN, _BEGIN = 2.5, 14.0
_LEAST, _DEEPEST = 1e-9, 4

_SIDE, _SMALLEST = 168.0, 120.0
_GAP = 12.0
FOOT = 17.0
"""The height of the line below an inset."""
_MARK = 11.0


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

    @property
    def mark(self) -> Box:
        """The box in the picture that stands for it, large enough to be seen."""
        return Box.around([self.box.centre]).grown(max(self.box.width / 2, _MARK))

    def holds(self, other: Window) -> bool:
        """Whether another window is a part of this one."""
        return other.box.width < self.box.width and other.box.centre in self.box


@dataclass(frozen=True)
class Inset:
    """A window and the box in which it is magnified.

    Attributes:
        window: the part of the picture.
        box: where it is drawn; the line below belongs to it.
        is_below: whether that is below the picture.
    """

    window: Window
    box: Box
    is_below: bool

    @property
    def zoom(self) -> float:
        """The factor by which it magnifies."""
        return self.box.width / self.window.box.width

    def place(self, point: Point) -> Point:
        """The place in the inset of a place in the picture."""
        (x, y), k = point, self.zoom
        return self.box.x0 + (x - self.window.box.x0) * k, self.box.y0 + (y - self.window.box.y0) * k

    @property
    def area(self) -> Box:
        """The box with the line below."""
        return Box(self.box.x0, self.box.y0, self.box.x1, self.box.y1 + FOOT)


def windows(
    lines: Sequence[Line], cusps: Sequence[Spot], corners: Sequence[Point], size: float = _SIDE
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
            yield Window(Box.around([extent.centre]).grown(half), tuple(members))
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


def outermost(found: Sequence[Window]) -> list[Window]:
    """The windows that are not parts of others."""
    return [window for window in found if not any(other.holds(window) for other in found)]


def placed(found: Sequence[Window], room: OccupancyGrid, below: Box) -> list[Inset]:
    """The insets: in the plot where they hide nothing and are near, else in rows below it.

    Args:
        found: the windows.
        room: the plot, where the marks of windows are taken already.
        below: where rows begin; its height does not matter.
    """
    within: dict[int, Inset] = {}
    outer = outermost(found)  # the marks of the others are in insets, not in the picture
    for k, window in enumerate(found):
        if window not in outer:
            continue
        target = window.box.centre
        sides = [side for side in (1.0, 0.85, _SMALLEST / _SIDE) if side * _SIDE < 0.4 * room.box.width]
        free = [room.free_box(side * _SIDE, side * _SIDE + FOOT, target) for side in sides]
        box = min(filter(None, free), key=lambda box: _unfit(box, target), default=None)
        if box is not None and distance(box.centre, target) < _NEAR * box.width:
            room.add_box(box.grown(4))
            within[k] = Inset(window, Box(box.x0, box.y0, box.x1, box.y1 - FOOT), is_below=False)
    rest = [window for k, window in enumerate(found) if k not in within]
    return [*within.values(), *_rows(rest, below)]


_NEAR = 1.6
"""How far an inset in the plot may be from what it magnifies, in its own sides."""


def _unfit(box: Box, target: Point) -> float:
    """How unsuitable a box is for an inset: its distance, and what it lacks in size."""
    return distance(box.centre, target) + 2 * (_SIDE - box.width)


def _rows(found: Sequence[Window], below: Box) -> Iterator[Inset]:
    """Yields insets in rows, as many in each as there is room for."""
    wide, narrow = (floor((below.width + _GAP) / (side + _GAP)) for side in (_SIDE, _SMALLEST))
    columns = max(1, wide, min(2, narrow))
    side = min(_SIDE, (below.width - (columns - 1) * _GAP) / columns)
    columns = min(columns, len(found)) or 1
    start = below.centre[0] - (columns * side + (columns - 1) * _GAP) / 2
    for k, window in enumerate(found):
        x, y = start + k % columns * (side + _GAP), below.y0 + k // columns * (side + FOOT + _GAP)
        yield Inset(window, Box(x, y, x + side, y + side), is_below=True)


def factor(zoom: float) -> str:
    """A factor of magnification in words.

    >>> factor(2.71), factor(457), factor(15606), factor(3.2e6)
    ('× 2.7', '× 460', '× 1.6·10⁴', '× 3.2·10⁶')
    """
    power = floor(log10(zoom))
    rounded = round(zoom, 1 - power)
    if power < 4:
        return f"× {rounded:g}"
    return f"× {rounded / 10**power:g}·10{str(power).translate(_RAISED)}"


_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
