"""Singular curves, straight where floats do not tell them apart: beside a beak-to-beak, a swallowtail, lips.

Right beside a transition special points are so near each other that drawn curves cross there by chance. The
images of parts of J = 0 that lead through one small box of poses do not cross, however near they are, if no
swallowtail is in it (mathematics.md#regions-of-the-joint-plane). So their order on both sides, where floats
tell it, and their cusps decide how they divide the plane: with an odd number of cusps a part turns back, and
else it leads through. It is drawn so, with room between parts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import copysign, inf, remainder, tau

import numpy as np

from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.arrangement import Point, Polyline
from rpr_solver.singular.neighbours import APART, Added, Chord, moved_to

_NEAR, _RADII = 1e-4, (1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 1e-3)
"""How near special points of a cluster are, in radians; radii of strips about it, by the picture's size."""
_TOLD, _ROOM = 1e-13, 1e-9
"""By the picture's size: distances that are surely not 0, and the room that is made between parts."""
_SLAB = 1e-9
"""Floats do not tell where an arc is between lines that are nearer to each other, in radians."""


def straightened(floats: FloatSlice, curves: Sequence[Polyline], extent: float) -> list[Polyline]:
    """The curves, straight near clusters of special points.

    Past both cusps of a swallowtail a curve goes straight on, and lips are left out: these regions have no
    width. The curves stay as they are where their order is not that of parts that do not cross.

    Args:
        floats: the slice.
        curves: with their special points, and the angles of all points.
        extent: the size of the picture, in the user's unit.
    """
    result = list(curves)
    for pose in _clusters(curves):
        strips = (_Strip(floats, pose, axis, r * extent, extent) for r in _RADII for axis in (0, 1))
        result = next((x for strip in strips if (x := strip.straightened(result)) is not None), result)
    return result


def _clusters(curves: Sequence[Polyline]) -> Iterator[Point]:
    """The angles of the first point of each cluster."""
    poses = np.array([curve.angles[k] for curve in curves for k in curve.special]).reshape(-1, 2)
    near = np.abs(np.sin((poses[:, None] - poses) / 2)).max(axis=2, initial=0) < _NEAR / 2
    for n in np.flatnonzero(np.triu(near, 1).any(axis=1)).tolist():
        if not near[:n, n].any():
            alpha, theta = poses[n].tolist()
            yield alpha, theta


@dataclass
class _Part:
    """A part of a curve in a strip.

    Attributes:
        ends: the numbers of the points before it, of a special point in it, and of the point after it.
        entries: where it enters and leaves.
        sides: of the strip, on which it does so: −1 or 1.
        rank: among all parts, as it is drawn in the middle.
    """

    ends: tuple[int, int, int]
    entries: list[Added]
    sides: list[float]
    rank: float = -inf

    @property
    def turns_back(self) -> bool:
        """Whether it leaves where it enters."""
        return self.sides[0] == self.sides[1]


@dataclass(frozen=True)
class _Strip:
    """The joints with a coordinate within ``radius`` of that of a cluster."""

    floats: FloatSlice
    cluster: Point
    axis: int
    radius: float
    extent: float

    def straightened(self, curves: Sequence[Polyline]) -> list[Polyline] | None:
        """The curves, straight in the strip; None if they are not known to divide the plane alike."""
        result: list[tuple[Polyline, list[_Part]]] = []
        for curve in curves:
            if not any(self._holds(curve, k) for k in curve.special):
                result.append((curve, []))
                continue
            turned = self._begun_far(curve)
            if abs(self._off(turned.points[0])) < self.radius:
                continue  # lips
            parts = self._parts(turned)
            if parts is None:
                return None
            result.append((turned, parts))
        every = [part for _, parts in result for part in parts]
        if not all(self._is_ranked(every, side) for side in (-1.0, 1.0)):
            return None
        return [self._through(curve, parts) if parts else curve for curve, parts in result]

    @cached_property
    def _middle(self) -> Point:
        """The joints of the cluster."""
        first, second = self.floats.joints(*self.cluster)
        return first / self.floats.unit, second / self.floats.unit

    def _off(self, point: Point) -> float:
        return point[self.axis] - self._middle[self.axis]

    def _height(self, place: Added) -> float:
        return place[1][1 - self.axis] - self._middle[1 - self.axis]

    def _holds(self, curve: Polyline, k: int) -> bool:
        """Whether a point is of the cluster."""
        pairs = zip(curve.angles[k], self.cluster, strict=True)
        return all(abs(remainder(x - y, tau)) < _NEAR for x, y in pairs)

    def _begun_far(self, curve: Polyline) -> Polyline:
        """A closed curve, begun where it is farthest away."""
        if curve.start != curve.end:
            return curve
        last = len(curve.points) - 1
        k = max(range(last), key=lambda k: abs(self._off(curve.points[k])))
        (a, b), (c, d) = curve.angles[0], curve.angles[-1]
        again = ((x + c - a, y + d - b) for x, y in curve.angles[1 : k + 1])
        points, angles = (*curve.points[k:], *curve.points[1 : k + 1]), (*curve.angles[k:], *again)
        special = sorted(((n - k) % last, is_cusp) for n, is_cusp in curve.special.items())
        return Polyline(points, curve.start, curve.end, angles, dict(special))

    def _parts(self, curve: Polyline) -> list[_Part] | None:
        """The parts of a curve that lead to the cluster; None if one is not known."""
        parts: list[_Part] = []
        for k in curve.special:
            if self._holds(curve, k) and not (parts and k < parts[-1].ends[2]):
                part = self._part(curve, k)
                if part is None:
                    return None
                parts.append(part)
        return parts

    def _part(self, curve: Polyline, k: int) -> _Part | None:
        """The part with a point; None if its ends are not found, or steep, or not as its cusps tell."""
        last = len(curve.points) - 1
        low = next((n for n in range(k - 1, -1, -1) if self._is_beyond(curve, n)), None)
        high = next((n for n in range(k + 1, last + 1) if self._is_beyond(curve, n)), None)
        if low is None or high is None:
            return None
        first, second = self._entry(curve, low, low), self._entry(curve, high - 1, high)
        if first is None or second is None:
            return None
        sides = [copysign(1.0, self._off(point)) for _, point, _ in (first, second)]
        part = _Part((low, k, high), [first, second], sides)
        cusps = sum(is_cusp for n, is_cusp in curve.special.items() if low < n < high)
        return part if part.turns_back == (cusps % 2 == 1) else None

    def _is_beyond(self, curve: Polyline, n: int) -> bool:
        """Whether a point of a curve is known to be out of the strip."""
        away = abs(remainder(curve.angles[n][1] - self.cluster[1], tau))
        return abs(self._off(curve.points[n])) >= self.radius and away > _SLAB

    def _entry(self, curve: Polyline, edge: int, beyond: int) -> Added | None:
        """Where an edge leads into the strip, from a point beyond it; None if it is not found, or steep."""
        x = self._middle[self.axis] + copysign(self.radius, self._off(curve.points[beyond]))
        place = Chord.of(curve, edge).on_curve(self.floats, self.axis, x, APART * self.extent)
        return None if place is None or abs(self._height(place)) > 2 * self.radius else place

    def _is_ranked(self, parts: Sequence[_Part], side: float) -> bool:
        """Whether parts are apart on a side, and those that lead through are in the order of the other one.

        Those have ranks 0, 1, …; one that turns back is between two of them, alone on its side.
        """
        order = sorted(
            (self._height(part.entries[k]), n, k)
            for n, part in enumerate(parts)
            for k in (0, 1)
            if part.sides[k] == side
        )
        through, ranks, last, drawn = 0, dict[float, int](), -inf, -inf
        for height, n, k in order:
            if height - last < _TOLD * self.extent:
                return False
            part, last, drawn = parts[n], height, max(height, drawn + APART * self.extent)
            where, point, angles = part.entries[k]
            part.entries[k] = where, moved_to(point, self.axis, self._middle[1 - self.axis] + drawn), angles
            rank = through - 0.5 if part.turns_back else float(through)
            through += not part.turns_back
            if part.rank not in (-inf, rank) or ranks.setdefault(rank, n) != n:
                return False
            part.rank = rank
        return True

    def _through(self, curve: Polyline, parts: Sequence[_Part]) -> Polyline:
        """A curve each part of which leads straight to the middle, and from there straight on or back."""
        own = [(*x, curve.special.get(k)) for k, x in enumerate(zip(curve.points, curve.angles, strict=True))]
        nodes: list[tuple[Point, Point, bool | None]] = []
        done, room = 0, _ROOM * self.extent
        for part in parts:
            (low, k, high), (first, last) = part.ends, part.entries
            place = moved_to(self._middle, self.axis, self._middle[1 - self.axis] + part.rank * room)
            tip = moved_to(place, 1 - self.axis, place[self.axis] + sum(part.sides) / 2 * room)
            nodes += own[done : low + 1]
            nodes += [(*first[1:], None), (tip, curve.angles[k], None), (*last[1:], None)]
            done = high
        points, angles, marks = zip(*nodes, *own[done:], strict=True)
        special = {k: mark for k, mark in enumerate(marks) if mark is not None}
        return Polyline(points, curve.start, curve.end, angles, special)
