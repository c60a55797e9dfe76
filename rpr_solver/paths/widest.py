"""The way from one pose of a slice to another that stays as far as possible from J = 0, in floats.

It is a proposal, which is then proved. On a grid of poses the distances from the zeros between neighbours are
known; a search finds the way whose least distance is greatest, and among those nearly as wide the one that is
short and wide elsewhere too. Steps away from the nearest zero, shorter and shorter, then move its spots to
the middle of the narrows, which no grid hits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from math import degrees
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from rpr_solver.paths.singular_field import orders

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.paths.routes import EndPose, Route
    from rpr_solver.paths.singular_field import Doubles, SingularField

    Places: TypeAlias = NDArray[np.intp]

_PARTS = 144
_STEP = 360 / _PARTS
_DIAGONAL, _NODES = _STEP * 2**0.5, _PARTS**2
_POLISHINGS = 4
_NEAR = 0.2
_ENOUGH = 1.5 * _STEP
_CLIMB = 0.6
_GAIN = 0.3
_MOST_CLIMBS = 80
_KEPT = 0.93
"""The share of the greatest least distance that the shorter way must keep."""
_ROUNDS, _FIRST_PUSH, _LAST_PUSH = 32, 0.6, 0.01
_SPACING, _LEAST_SPOTS = 1.5, 40
_ZERO = 1e-9
_PARTS_OF_ARC = 40
_BEND = 0.04
"""By which share of the distance from J = 0 the way may be simplified."""
_BESIDE = [(i, k) for i in (-1, 0, 1) for k in (-1, 0, 1) if i or k]


def values(field: SingularField, spots: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """The field, its gradient and its second derivatives (αα, αθ, θθ) by degrees, at spots in degrees."""
    waves = field.waves(spots[..., 0], spots[..., 1])
    parts = [np.einsum("w,w...->...", k, part) for k, part in orders(waves)]
    degree = np.pi / 180
    return parts[0], np.stack(parts[1:3], -1) * degree, np.stack(parts[3:], -1) * degree**2


def polished(field: SingularField, spots: Doubles, feet: Doubles) -> Doubles:
    """The points of J = 0 nearest to spots, from points near them, by Newton's method."""
    for _ in range(_POLISHINGS):
        value, slope, bend = values(field, feet)
        square = (slope**2).sum(-1) + 1e-300
        onto = feet - slope * (value / square)[..., None]
        tangent = np.stack([-slope[..., 1], slope[..., 0]], -1) / np.sqrt(square)[..., None]
        away = spots - onto
        x, y = tangent[..., 0], tangent[..., 1]
        curved = bend[..., 0] * x * x + 2 * bend[..., 1] * x * y + bend[..., 2] * y * y
        factor = np.maximum(1 + (away * slope).sum(-1) / square * curved, _NEAR)
        step = np.clip((away * tangent).sum(-1) / factor, -_STEP, _STEP)
        feet = onto + tangent * step[..., None]
    value, slope, _ = values(field, feet)
    found: Doubles = feet - slope * (value / ((slope**2).sum(-1) + 1e-300))[..., None]
    return found


def _sizes(steps: Doubles) -> Doubles:
    sizes: Doubles = np.hypot(*np.moveaxis(steps, -1, 0))
    return sizes


def zeros_from(field: SingularField, spots: Doubles, starts: Doubles) -> tuple[Doubles, Doubles]:
    """From each start the zero of J nearest to each spot, about, and its distance.

    It is infinite where the steps end at no zero, as between two arcs that nearly meet.
    """
    found = polished(field, spots, starts)
    return found, np.where(abs(field.value(found)) > _ZERO, np.inf, _sizes(found - spots))


def nearest_of(found: Doubles, away: Doubles) -> tuple[Doubles, Doubles]:
    """The least of the distances of each spot, and the place that it is from."""
    nearest, columns = away.argmin(axis=0), np.arange(away.shape[1])
    return away[nearest, columns], found[nearest, columns]


@dataclass(frozen=True)
class PoseGrid:
    """The poses of a slice on a grid, with the nearest zero of J seen from each.

    Attributes:
        field: positive where the way may lead.
    """

    field: SingularField

    @cached_property
    def values(self) -> Doubles:
        """The field at all nodes, by α and θ."""
        angles = np.arange(_PARTS) * _STEP
        return self.field.value(np.stack(np.meshgrid(angles, angles, indexing="ij"), -1))

    @cached_property
    def feet(self) -> Doubles:
        """From each node to the nearest zero between two nodes, in degrees."""
        nodes = np.stack(np.meshgrid(*[np.arange(_PARTS) * _STEP] * 2, indexing="ij"), -1)
        found = np.full((_PARTS, _PARTS, 2), 1e3)
        for axis in (0, 1):
            beyond = np.roll(self.values, -1, axis)
            i, k = np.nonzero(self.values * beyond < 0)
            share = self.values[i, k] / (self.values[i, k] - beyond[i, k])
            spots = nodes[i, k]
            spots[:, axis] += share * _STEP
            zeros = polished(self.field, spots, spots)
            lost = abs(self.field.value(zeros)) > _ZERO
            zeros[lost] = spots[lost]
            found = self._seeded(found, zeros - nodes[i, k], i, k)
        step = 1 << (_PARTS // 2).bit_length() - 1
        for size in (*(step >> n for n in range(step.bit_length())), 1):
            for x, y in _BESIDE:
                other = np.roll(found, (-x * size, -y * size), (0, 1)) + np.array([x, y]) * size * _STEP
                nearer = (other**2).sum(-1) < (found**2).sum(-1)
                found[nearer] = other[nearer]
        return found

    @staticmethod
    def _seeded(found: Doubles, steps: Doubles, i: Places, k: Places) -> Doubles:
        """The steps to the zeros from the four nodes round each, if they are the shortest."""
        for x in (0, 1, -1):
            for y in (0, 1, -1):
                own = steps - np.array([x, y]) * _STEP
                where = (i + x) % _PARTS, (k + y) % _PARTS
                for _ in range(2):  # two zeros may be next to one node
                    nearer = (own**2).sum(-1) < (found[where] ** 2).sum(-1)
                    found[where[0][nearer], where[1][nearer]] = own[nearer]
        return found

    @cached_property
    def rooms(self) -> Doubles:
        """The distance of each node from J = 0; negative where the field is."""
        rooms: Doubles = np.sqrt((self.feet**2).sum(-1)) * np.sign(self.values)
        return rooms

    def nearest(self, spots: Doubles) -> tuple[Doubles, Doubles]:
        """The distances of spots (degrees) from J = 0, about, and the nearest points of it."""
        low = np.floor(spots / _STEP).astype(int)
        nodes = [low + corner for corner in ((0, 0), (0, 1), (1, 0), (1, 1))]
        starts = [node * _STEP + self.feet[node[:, 0] % _PARTS, node[:, 1] % _PARTS] for node in nodes]
        # what lies between nodes is seen from spots that are near it
        found, away = zeros_from(self.field, spots, np.stack([*starts, spots]))
        sure = np.array(starts)
        return nearest_of(np.concatenate([found, sure]), np.concatenate([away, _sizes(sure - spots)]))

    def foot(self, pose: EndPose) -> Doubles:
        """The nearest singular pose of the slice of a pose, in degrees, about."""
        foot: Doubles = self.nearest(np.array(degrees_of(pose))[None])[1][0]
        return foot

    def climbed(self, spot: Doubles) -> Doubles:
        """Spots from one on, each farther from J = 0 than the one before, until a node sees it well."""
        spots = [spot]
        (room,), (foot,) = self.nearest(spot[None])
        while room < _ENOUGH and len(spots) < _MOST_CLIMBS:
            step = min(_CLIMB * room, _STEP / 2)
            following = spots[-1] + (spots[-1] - foot) * (step / room)
            (farther,), (foot,) = self.nearest(following[None])
            if farther < room + _GAIN * step:
                break
            spots.append(following)
            room = farther
        return np.array(spots)

    def node_near(self, spot: Doubles) -> tuple[int, int] | None:
        """A node with much room that a straight line seems to join to a spot."""
        low = np.floor(spot / _STEP).astype(int)
        best: tuple[float, tuple[int, int]] | None = None
        shares = np.linspace(0, 1, 9)[:, None]
        for x in range(-1, 3):
            for y in range(-1, 3):
                i, k = int(low[0] + x), int(low[1] + y)
                line = spot + shares * (np.array([i, k]) * _STEP - spot)
                room = float(self.rooms[i % _PARTS, k % _PARTS])
                if room > 0 and (best is None or room > best[0]) and (self.field.value(line) > 0).all():
                    best = room, (i, k)
        return None if best is None else best[1]

    def way(self, start: tuple[int, int], stop: tuple[int, int]) -> Doubles | None:
        """Spots of nodes from one to another: the widest way, or one nearly as wide and shorter."""
        first, last = (i % _PARTS * _PARTS + k % _PARTS for i, k in (start, stop))
        widest = _search(self.rooms, first, last, None)
        if widest is None:
            return None
        least = float(self.rooms.ravel()[widest].min())
        shorter = _search(self.rooms, first, last, least * _KEPT) or widest
        nodes = np.array([divmod(node, _PARTS) for node in shorter])
        steps = (np.diff(nodes, axis=0) + _PARTS // 2) % _PARTS - _PARTS // 2
        found: Doubles = (np.array(start) + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])) * _STEP
        return found


def _search(rooms: Doubles, start: int, stop: int, least: float | None) -> list[int] | None:
    """The nodes of the way with the greatest least room; or of one with at least this room that is short,
    where steps count the more the less room there is."""
    room: list[float] = rooms.ravel().tolist()
    heap = [(-room[start] if least is None else 0.0, start, start)]
    before: dict[int, int] = {}
    while heap:
        key, node, last = heappop(heap)
        if node in before:
            continue
        before[node] = last
        if node == stop:
            return _back(before, node)
        here, k = room[node], node % _PARTS
        left, right = (k - 1) % _PARTS - k, (k + 1) % _PARTS - k
        for row in ((node - _PARTS) % _NODES, node, (node + _PARTS) % _NODES):
            for other in (row + left, row, row + right):
                there = room[other]
                if other in before or there <= 0:
                    continue
                size = _STEP if row == node or other == row else _DIAGONAL
                # discs of these radii must overlap, so that the line between the nodes is free
                if here + there < size:
                    continue
                if least is None:
                    heappush(heap, (key if key > -there else -there, other, node))
                elif there >= least:
                    heappush(heap, (key + size / (here * there), other, node))
    return None


def _back(before: dict[int, int], node: int) -> list[int]:
    way = [node]
    while (last := before[way[-1]]) != way[-1]:
        way.append(last)
    return way[::-1]


def widened(grid: PoseGrid, way: Doubles) -> Doubles:
    """A way with the same ends, its spots moved away from J = 0 where it is narrow, and evenly spaced."""
    pushes = np.geomspace(_FIRST_PUSH, _LAST_PUSH, _ROUNDS)
    best, best_room = way, -1.0
    spacing = min(_SPACING, float(np.hypot(*np.diff(way, axis=0).T).sum()) / _LEAST_SPOTS)
    for push in pushes:
        way = spaced(way, spacing)
        room, feet = grid.nearest(way)
        least = _inner_least(room)
        narrow = np.clip(1.5 * least / room, 0, 1) ** 2
        away = (way - feet) / room[:, None]
        smooth = np.zeros_like(way)
        smooth[1:-1] = (way[2:] + way[:-2]) / 2 - way[1:-1]
        share = np.minimum(1.0, push / _FIRST_PUSH + 0.1)
        move = away * (np.minimum(push, 0.3 * room) * narrow)[:, None] + 0.5 * share * smooth
        move[0] = move[-1] = 0
        if least > best_room:
            best, best_room = way, least
        way = way + move
    return best


def _inner_least(room: Doubles) -> float:
    """The least room of the spots that are no ends, nor where it only rises from one."""
    rising = np.maximum.accumulate(room) == room
    falling = (np.maximum.accumulate(room[::-1]) == room[::-1])[::-1]
    inner = ~(np.minimum.accumulate(rising) | np.minimum.accumulate(falling[::-1])[::-1])
    return float(room[inner].min()) if inner.any() else float(room.max())


def spaced(way: Doubles, spacing: float) -> Doubles:
    """Spots on the same polyline, about so far apart, its ends included."""
    sizes = np.hypot(*np.diff(way, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(sizes)])
    count = max(2, int(np.ceil(along[-1] / spacing)) + 1)
    at = np.linspace(0, along[-1], count)
    return np.stack([np.interp(at, along, way[:, n]) for n in range(2)], -1)


def simplified(way: Doubles, room: Doubles) -> list[int]:
    """The numbers of few spots, so that the others are near the lines between them, seen from J = 0."""
    kept = {0, len(way) - 1}
    stack = [(0, len(way) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        line, inner = way[last] - way[first], way[first + 1 : last] - way[first]
        share = np.clip(inner @ line / max(line @ line, 1e-30), 0, 1)
        away = np.hypot.reduce(inner - share[:, None] * line, axis=-1) / room[first + 1 : last]
        worst = int(away.argmax())
        if away[worst] > _BEND:
            kept.add(first + 1 + worst)
            stack += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return sorted(kept)


def widest_way(
    grid: PoseGrid, slices: Sequence[PoseGrid], poses: Sequence[EndPose]
) -> tuple[Doubles, Doubles, Doubles] | None:
    """Spots in degrees of the widest way between two poses, which the grid found; None if it found none.

    They are those of the climb from the first pose, in its slice, those between, and those of the descent to
    the last pose, perhaps some turns further.
    """
    climbs = [own.climbed(np.array(degrees_of(pose))) for own, pose in zip(slices, poses, strict=True)]
    nodes = [own.node_near(climb[-1]) for own, climb in zip(slices, climbs, strict=True)]
    if nodes[0] is None or nodes[1] is None or (way := grid.way(nodes[0], nodes[1])) is None:
        return None
    turns = way[-1] - np.array(nodes[1]) * _STEP
    first, last = climbs[0], (climbs[1] + turns)[::-1]
    return first[:-1], widened(grid, np.concatenate([first[-1:], way, last[:1]])), last[1:]


def degrees_of(pose: EndPose) -> tuple[float, float]:
    """α and θ of a pose."""
    alpha, theta = pose.angles
    return degrees(float(alpha)), degrees(float(theta))


def controls_of(route: Route) -> list[list[tuple[float, float]]]:
    """The control points of the arcs of a route in degrees."""
    ends = iter((degrees_of(route.start), degrees_of(route.stop)))
    return [
        [next(ends) if p is None else (float(p.alpha_deg), float(p.theta_deg)) for p in arc]
        for arc in route.arcs
    ]


def on_arc(points: Doubles, parts: int) -> Doubles:
    """Points at equal parameters of a Bézier arc."""
    tau = np.linspace(0, 1, parts + 1)[:, None, None]
    found = np.broadcast_to(points, (parts + 1, *points.shape))
    while found.shape[1] > 1:
        found = found[:, :-1] * (1 - tau) + found[:, 1:] * tau
    return found[:, 0]


def polyline(route: Route) -> Doubles:
    """Spots of a route in degrees."""
    arcs = [on_arc(np.array(controls), _PARTS_OF_ARC) for controls in controls_of(route)]
    return np.concatenate([arcs[0][:1], *(arc[1:] for arc in arcs)])
