"""Drawn curves with points added where others run beside them, so that chords cross only as the curves do.

A chord deviates from its curve by up to the tolerance. Where two curves are nearer to each other and about
parallel, as beside a beak-to-beak, chords may cross where the curves do not, or the other way round. There
both get points with a coordinate in common: between them the difference of the chords has the signs of that
of the curves. A least difference that floats do not tell from 0 counts as one of the sign on both sides. A
chord that passes the tip of a cusp on the other side than its curve does gets a point beside it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import copysign, isnan, nan

import numpy as np
from numpy.typing import NDArray

from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.arrangement import Point, Polyline

_ROUNDS, _STEPS = 8, 30
_ROOM = 0.75
"""A chord deviates by about a quarter of what its ends do from the chords beside it."""
_STRAIGHT = 0.01
_RESOLVED, APART = 1e-14, 1e-10
"""By the picture's size: what floats cannot tell from 0, and how far apart such points are drawn."""
_GOLDEN = 0.381966
_NARROWINGS, _NARROWER = 12, 0.6

Floats = NDArray[np.float64]
Edge = tuple[int, int]
Added = tuple[float, Point, Point]
"""Where on an edge, from 0 to 1, a point, and its angles."""


def separated(floats: FloatSlice, curves: Sequence[Polyline], extent: float) -> list[Polyline]:
    """The curves, with more points where their chords do not cross as they do.

    Args:
        floats: the slice.
        curves: with the angles of their points.
        extent: the size of the picture, in the user's unit.
    """
    result = list(curves)
    for _ in range(_ROUNDS):
        added: dict[Edge, list[Added]] = defaultdict(list)
        for pair in _near_parallel_edges(result, extent):
            first, second = (Chord.of(result[n], k) for n, k in pair)
            for places in _added(floats, (first, second), extent):
                for edge, place in zip(pair, places, strict=True):
                    added[edge].append(place)
        for edge, place in _passing(floats, result, extent):
            added[edge].append(place)
        if not added:
            break
        result = [
            _with(curve, [added.get((n, k), []) for k in range(len(curve.points) - 1)])
            for n, curve in enumerate(result)
        ]
    return result


def _with(curve: Polyline, added: Sequence[Sequence[Added]]) -> Polyline:
    """A curve with more points on its edges."""
    points, angles = [curve.points[0]], [curve.angles[0]]
    for k, places in enumerate(added):
        last = 0.0
        for part, point, own in sorted(places):
            if last < part < 1:
                points.append(point)
                angles.append(own)
                last = part
        points.append(curve.points[k + 1])
        angles.append(curve.angles[k + 1])
    return Polyline(tuple(points), curve.start, curve.end, tuple(angles))


@dataclass(frozen=True)
class Chord:
    """An edge: its ends, and their angles."""

    ends: tuple[Point, Point]
    angles: tuple[Point, Point]

    @classmethod
    def of(cls, curve: Polyline, k: int) -> Chord:
        """An edge of a curve."""
        return cls((curve.points[k], curve.points[k + 1]), (curve.angles[k], curve.angles[k + 1]))

    def part(self, axis: int, x: float) -> float:
        """Where on it a coordinate has a value, from 0 to 1."""
        low, high = (end[axis] for end in self.ends)
        return min(max((x - low) / (high - low), 0.0), 1.0) if high != low else 0.0

    def other(self, axis: int, x: float) -> float:
        """The other coordinate there."""
        part, (low, high) = self.part(axis, x), (end[1 - axis] for end in self.ends)
        return low + part * (high - low)

    def on_curve(self, floats: FloatSlice, axis: int, x: float, near: float) -> Added | None:
        """The point of its curve there, or an end if it is within ``near``; None if it is not found."""
        for k, end in enumerate(self.ends):
            if abs(end[axis] - x) < near:
                return float(k), end, self.angles[k]
        part, sides = self.part(axis, x), [(k, own) for k, own in zip((0.0, 1.0), self.angles, strict=True)]

        def at(place: float) -> Point | None:
            (low, (a, t)), (high, (b, u)) = sides
            k, value = (
                (place - low) / (high - low),
                self.ends[0][axis] * (1 - place) + self.ends[1][axis] * place,
            )
            way = b - a, u - t
            angles = floats.singular_at((a + k * way[0], t + k * way[1]), way, axis, value * floats.unit)
            if angles is None:
                return None
            ahead = (angles[0] - a) * way[0] + (angles[1] - t) * way[1]
            return angles if 0 < ahead < way[0] ** 2 + way[1] ** 2 else None

        for _ in range(_NARROWINGS):
            angles = at(part)
            if angles is not None:
                first, second = (y / floats.unit for y in floats.joints(*angles))
                return part, (x, second) if axis == 0 else (first, x), angles
            # the chord cuts a corner that is nearer to another curve
            for k in (0, 1):
                place = sides[k][0] + _NARROWER * (part - sides[k][0])
                nearer = at(place)
                if nearer is not None:
                    sides[k] = place, nearer
        return None


def _added(floats: FloatSlice, chords: tuple[Chord, Chord], extent: float) -> list[tuple[Added, Added]]:
    """Points of two edges without which their chords do not cross as the curves do."""
    (ax, ay), (bx, by) = chords[0].ends
    axis = 0 if abs(bx - ax) >= abs(by - ay) else 1
    spans = [sorted(end[axis] for end in chord.ends) for chord in chords]
    low, high = max(x[0] for x in spans), min(x[1] for x in spans)
    found: dict[float, tuple[Added, Added]] = {}
    resolved, apart = _RESOLVED * extent, APART * extent

    def above(x: float) -> float:
        """By how much the second curve is above the first one; NaN if that is not found."""
        first, second = (chord.on_curve(floats, axis, x, apart) for chord in chords)
        if first is None or second is None:
            return nan
        found[x] = first, second
        return second[1][1 - axis] - first[1][1 - axis]

    places = _places(above, low, high, resolved) if low < high else []
    drawn = [(chords[1].other(axis, x) - chords[0].other(axis, x)) * sign for x, _, sign in places]
    if all(y > apart / 2 for y in drawn):
        return []
    return [_moved(found[x], axis, sign * apart if abs(y) < apart else 0.0) for x, y, sign in places]


def _places(
    above: Callable[[float], float], low: float, high: float, resolved: float
) -> list[tuple[float, float, float]]:
    """The ends of an interval, and a place inside it where a function has another sign, if there is one.

    Each place has the value and its sign; at an end where that is not resolved it is that of the other end.
    None where a value is not found, or neither is resolved.
    """
    first, last = above(low), above(high)
    most = max(first, last, key=abs)
    if isnan(first) or isnan(last) or abs(most) < resolved:
        return []
    places = [
        (x, y, copysign(1.0, most if abs(y) < resolved else y)) for x, y in ((low, first), (high, last))
    ]
    sign = places[0][2]
    if sign == places[1][2]:
        x, y = _least(lambda x: above(x) * sign, (low, first * sign), (high, last * sign), resolved)
        if y < -resolved:
            places.append((x, y * sign, -sign))
    return places


def _least(
    function: Callable[[float], float], low: tuple[float, float], high: tuple[float, float], enough: float
) -> tuple[float, float]:
    """Where a function is least between two places, by golden sections, or where it is negative."""
    (a, first), (b, last) = low, high
    x = (a + b) / 2
    middle = function(x)
    slope, bend = last - first, first + last - 2 * middle
    if bend <= 0 or abs(slope) >= 4 * bend or middle - slope * slope / (8 * bend) > min(first, last) / 2:
        return x, middle
    for _ in range(_STEPS):
        if not middle > -enough:
            break
        y = x + _GOLDEN * ((b - x) if b - x > x - a else (a - x))
        value = function(y)
        if value < middle:
            a, b = (x, b) if y > x else (a, x)
            x, middle = y, value
        else:
            a, b = (a, y) if y > x else (y, b)
    return x, middle


def _moved(places: tuple[Added, Added], axis: int, apart: float) -> tuple[Added, Added]:
    """Points of both edges at one coordinate, the second ``apart`` above the first; ends of edges stay."""
    if not apart:
        return places
    (part, low, own), (other, high, its) = places
    if 0 < part < 1:
        low = moved_to(low, axis, high[1 - axis] - apart)
    else:
        high = moved_to(high, axis, low[1 - axis] + apart)
    return (part, low, own), (other, high, its)


def moved_to(point: Point, axis: int, other: float) -> Point:
    """A point with another value of the coordinate that is not that of the axis."""
    return (point[0], other) if axis == 0 else (other, point[1])


def _near_parallel_edges(curves: Sequence[Polyline], extent: float) -> list[tuple[Edge, Edge]]:
    """Edges without a common end that are about parallel, and nearer to each other than they may deviate."""
    edges, lines, rooms, turns = [], [], [], []
    for n, curve in enumerate(curves):
        points = np.array(curve.points)
        closed = curve.start == curve.end
        room, turn = _bends(points, closed=closed)
        edges += [(n, k) for k in range(len(points) - 1)]
        lines.append(np.hstack([points[:-1], points[1:]]))
        rooms.append(room)
        turns.append(turn)
    if not edges:
        return []
    line, room, turn = np.vstack(lines), np.minimum(np.concatenate(rooms), extent), np.concatenate(turns)
    low = np.minimum(line[:, :2], line[:, 2:]) - room[:, None]
    high = np.maximum(line[:, :2], line[:, 2:]) + room[:, None]
    order = np.argsort(low[:, 0])
    starts = low[order, 0]
    ends = np.searchsorted(starts, high[order, 0], side="right")
    counts = ends - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), counts)
    second = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts) + first + 1
    i, j = order[first], order[second]
    keep = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
    i, j = i[keep], j[keep]
    way = line[:, 2:] - line[:, :2]
    way /= np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-300)[:, None]
    sine = np.abs(way[i, 0] * way[j, 1] - way[i, 1] * way[j, 0])
    keep = sine < turn[i] + turn[j] + _STRAIGHT
    i, j = i[keep], j[keep]
    gap = np.full(len(i), np.inf)
    for own, point in ((i, line[j, :2]), (i, line[j, 2:]), (j, line[i, :2]), (j, line[i, 2:])):
        gap = np.minimum(gap, _away(point, line[own], way[own]))
    keep = (gap <= room[i] + room[j]) & ~_meet(line[i], line[j])
    return [(edges[a], edges[b]) for a, b in zip(i[keep].tolist(), j[keep].tolist(), strict=True)]


def _passing(floats: FloatSlice, curves: Sequence[Polyline], extent: float) -> Iterator[tuple[Edge, Added]]:
    """Points of edges that pass the tip of a cusp, or a corner, on the other side than their curves do."""
    tips = [
        y
        for own in curves
        for x, y, z in zip(own.points, own.points[1:], (*own.points[2:], own.points[1]), strict=False)
        if (y[0] - x[0]) * (z[0] - y[0]) + (y[1] - x[1]) * (z[1] - y[1]) <= 0
    ]
    for n, curve in enumerate(curves):
        points = np.array(curve.points)
        lines, (room, _) = (
            np.hstack([points[:-1], points[1:]]),
            _bends(points, closed=curve.start == curve.end),
        )
        ways = lines[:, 2:] - lines[:, :2]
        ways /= np.maximum(np.hypot(*ways.T), 1e-300)[:, None]
        for tip in tips:
            for k in np.flatnonzero(_away(np.array([tip]), lines, ways) <= room).tolist():
                chord, axis = Chord.of(curve, k), int(abs(ways[k, 1]) > abs(ways[k, 0]))
                own = chord.on_curve(floats, axis, tip[axis], APART * extent)
                if own is not None and tip not in chord.ends:
                    off = own[1][1 - axis] - tip[1 - axis]
                    drawn = chord.other(axis, tip[axis]) - tip[1 - axis]
                    if off * drawn < 0 and abs(off) > _RESOLVED * extent:
                        yield (n, k), own


def _bends(points: Floats, *, closed: bool) -> tuple[Floats, Floats]:
    """By how much each chord of a polyline may deviate, and by what angle it may turn."""
    around = np.vstack([points[-2:-1], points, points[1:2]] if closed else [points[:1], points, points[-1:]])
    before, after = around[1:-1] - around[:-2], around[2:] - around[1:-1]
    sizes = np.hypot(*before.T), np.hypot(*after.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        dot = (before * after).sum(axis=1)
        turn = np.abs(np.arctan2(cross, dot))
        aside = np.abs(cross) / np.hypot(*(before + after).T)
    sharp = ~(dot > 0) | (sizes[0] == 0) | (sizes[1] == 0)  # cusps, corners and ends
    turn, aside = np.where(sharp, 0.0, turn), np.where(sharp, 0.0, aside)
    return _ROOM * np.maximum(aside[:-1], aside[1:]), np.maximum(turn[:-1], turn[1:])


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
