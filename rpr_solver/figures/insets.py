"""Where a picture needs insets: cusps too close to anything else to be seen, and windows that part them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from rpr_solver.notebook.scene import Box, Line, Point, distance, off_segment

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
    for number, line in enumerate(lines):
        along = _along(own, cusp.index) if number == cusp.line else None
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
