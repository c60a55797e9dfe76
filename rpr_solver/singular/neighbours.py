"""Drawn curves with points added where others run beside them, so that chords cross only as the curves do.

A chord deviates from its curve by up to the tolerance. Where it is nearer to another one about parallel,
as beside a beak-to-beak, or to the tip of a cusp, chords may cross where the curves do not, or the other way
round. There both are halved, until they deviate by less than what is between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.arrangement import Polyline, boxes_that_meet

_ROUNDS = 16
"""Halvings of one chord, each of which leaves a quarter of its deviation: down to 1e-10 of a first one."""
_ROOM = 0.4
"""A chord deviates by about a quarter of what its ends do from the chords beside it; and some more."""
_RESOLVED = 1e-13
"""By the picture's size: chords that deviate less are not halved."""
_TIMES, _MOST = 8, 1000
"""How many times as many points there may be, and how many more: parts that coincide are halved to no end."""

Floats = NDArray[np.float64]


def separated(
    floats: FloatSlice, curves: Sequence[Polyline], extent: float
) -> tuple[Sequence[Polyline], bool] | None:
    """The curves, with more points where chords might not cross as they do; and whether these cross as often.

    None if whole parts of curves coincide.

    Args:
        floats: the slice.
        curves: with the angles of their points.
        extent: the size of the picture, in the user's unit.
    """
    edges = first = _Edges.of(curves, extent)
    result, most = curves, _MOST + _TIMES * len(first.rooms)
    for _ in range(_ROUNDS):
        near = edges.too_near()
        near = near[edges.rooms[near] > _RESOLVED * extent]
        if not len(near):
            break
        if len(edges.rooms) + len(near) > most:
            return None
        result = _halved(floats, result, near, edges.angles[near])
        edges = _Edges.of(result, extent)
    return result, edges.crossings == first.crossings


def _halved(
    floats: FloatSlice, curves: Sequence[Polyline], numbers: NDArray[np.intp], chords: Floats
) -> list[Polyline]:
    """The curves, with a point more on each of these chords on which one is found."""
    angles = floats.singular_between(chords)
    found = {
        k: place for k, place in zip(numbers.tolist(), angles.tolist(), strict=True) if place[0] == place[0]
    }
    result, first = [], 0
    for curve in curves:
        points, own = [curve.points[0]], [curve.angles[0]]
        for k in range(len(curve.points) - 1):
            if (place := found.get(first + k)) is not None:
                alpha, theta = place
                x, y = floats.joints(alpha, theta)
                points.append((x / floats.unit, y / floats.unit))
                own.append((alpha, theta))
            points.append(curve.points[k + 1])
            own.append(curve.angles[k + 1])
        result.append(Polyline(tuple(points), curve.start, curve.end, tuple(own)))
        first += len(curve.points) - 1
    return result


@dataclass(frozen=True)
class _Edges:
    """The edges of curves, one a row.

    Attributes:
        lines: both ends.
        rooms: by how much each may deviate from its curve.
        turns: by what angle.
        sharp: whether each end is a tip, a corner or the end of a curve.
        angles: the poses of both ends.
    """

    lines: Floats
    rooms: Floats
    turns: Floats
    sharp: NDArray[np.bool_]
    angles: Floats

    @classmethod
    def of(cls, curves: Sequence[Polyline], extent: float) -> _Edges:
        """The edges in the order of the curves."""
        parts = [_bends(np.array(curve.points), closed=curve.start == curve.end) for curve in curves]
        lines, rooms, turns, sharp = (np.concatenate(x) for x in zip(*parts, strict=True))
        poses = [np.array(curve.angles) for curve in curves]
        angles = np.concatenate([np.hstack([x[:-1], x[1:]]) for x in poses])
        return cls(lines, np.minimum(rooms, extent), turns, sharp, angles)

    @cached_property
    def _pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Edges without a common end, the boxes round which meet."""
        lines, rooms = self.lines, self.rooms[:, None]
        low = np.minimum(lines[:, :2], lines[:, 2:]) - rooms
        high = np.maximum(lines[:, :2], lines[:, 2:]) + rooms
        i, j = boxes_that_meet(low, high)
        apart = ~_meet(lines[i], lines[j])
        return i[apart], j[apart]

    @cached_property
    def _ways(self) -> Floats:
        ways = self.lines[:, 2:] - self.lines[:, :2]
        ways /= np.maximum(np.hypot(*ways.T), 1e-300)[:, None]
        return ways

    @property
    def crossings(self) -> int:
        """How often they cross."""
        crossing = [
            np.prod([_cross(self._ways[own], end - self.lines[own, :2]) for end in ends], axis=0) < 0
            for own, other in (self._pairs, self._pairs[::-1])
            for ends in [(self.lines[other, :2], self.lines[other, 2:])]
        ]
        return int((crossing[0] & crossing[1]).sum())

    def too_near(self) -> NDArray[np.intp]:
        """The numbers of edges without a common end that may lie on the wrong sides of each other.

        Either they are about parallel, or one ends in a tip.
        """
        i, j = self._pairs
        parallel = np.abs(_cross(self._ways[i], self._ways[j])) < self.turns[i] + self.turns[j]
        near = np.zeros(len(self.lines), dtype=bool)
        for one, other in ((i, j), (j, i)):
            for end in (0, 1):
                points = self.lines[one, 2 * end : 2 * end + 2]
                gap = _away(points, self.lines[other], self._ways[other])
                close = (parallel | self.sharp[one, end]) & (gap <= self.rooms[one] + self.rooms[other])
                near[one[close]] = near[other[close]] = True
        return np.flatnonzero(near)


def _bends(points: Floats, *, closed: bool) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """The chords of a polyline: both ends, what each may deviate and turn, and which ends are sharp."""
    around = np.vstack([points[-2:-1], points, points[1:2]] if closed else [points[:1], points, points[-1:]])
    before, after = around[1:-1] - around[:-2], around[2:] - around[1:-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        cross = _cross(before, after)
        dot = (before * after).sum(axis=1)
        turn = np.abs(np.arctan2(cross, dot))
        aside = np.abs(cross) / np.hypot(*(before + after).T)
    sharp = ~(dot > 0)  # cusps, corners and ends
    turn, aside = np.where(sharp, 0.0, turn), np.where(sharp, 0.0, aside)
    return (
        np.hstack([points[:-1], points[1:]]),
        _ROOM * np.maximum(aside[:-1], aside[1:]),
        np.maximum(turn[:-1], turn[1:]),
        np.stack([sharp[:-1], sharp[1:]], axis=1),
    )


def _cross(u: Floats, v: Floats) -> Floats:
    product: Floats = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return product


def _away(points: Floats, lines: Floats, ways: Floats) -> Floats:
    """The distances of points from segments with these directions."""
    off = points - lines[:, :2]
    along = np.clip((off * ways).sum(axis=1), 0, np.hypot(*(lines[:, 2:] - lines[:, :2]).T))
    distances: Floats = np.hypot(*(off - along[:, None] * ways).T)
    return distances


def _meet(first: Floats, second: Floats) -> NDArray[np.bool_]:
    """Whether segments have an end in common."""
    ends = ((a, b) for a in (first[:, :2], first[:, 2:]) for b in (second[:, :2], second[:, 2:]))
    found: NDArray[np.bool_] = np.any([(a == b).all(axis=1) for a, b in ends], axis=0)
    return found
