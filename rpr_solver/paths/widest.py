"""A way of poses made wider, in floats: its spots move away from J = 0 in the narrows, which no grid hits.

Spots have α and θ in degrees and the length of the fixed leg, in the unit of the field. Steps away from the
nearest zero, shorter and shorter, move them to the middle of the narrows; few of them are then enough.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rpr_solver.paths.pose_grid import PoseGrid
    from rpr_solver.paths.singular_field import Doubles

_ROUNDS = 32
_FIRST_PUSH = 0.6
"""Degrees by which the first round moves a spot at most; answers may depend on all these, their truth does
not."""
_LAST_PUSH = 0.01
"""The same of the last one."""
_SPACING = 1.5
"""Degrees between spots."""
_LEAST_SPOTS = 40
_BEND = 0.04
"""By which share of the distance from J = 0 the way may be simplified."""


def widened(grid: PoseGrid, way: Doubles) -> Doubles:
    """Few spots of a way with the same ends, which is wider than it."""
    tall = np.array([1.0, 1.0, grid.steepness(way)])
    best, best_room = way, -1.0
    spacing = min(_SPACING, float(_sizes(np.diff(way * tall, axis=0)).sum()) / _LEAST_SPOTS)
    for push in np.geomspace(_FIRST_PUSH, _LAST_PUSH, _ROUNDS):
        way = _spaced(way, tall, spacing)
        room, feet = grid.nearest(way)
        least = _inner_least(room)
        if least > best_room:
            best, best_room = way, least
        far = np.copysign(np.maximum(abs(room), 1e-9), room)
        narrow = np.where(room > 0, np.clip(1.5 * least / far, 0, 1) ** 2, 1.0)
        move = np.zeros_like(way)
        move[:, :2] = (
            (way[:, :2] - feet) / far[:, None] * (np.minimum(push, 0.3 * abs(far)) * narrow)[:, None]
        )
        share = min(1.0, push / _FIRST_PUSH + 0.1)
        move[1:-1] += 0.5 * share * ((way[2:] + way[:-2]) / 2 - way[1:-1])
        move[0] = move[-1] = 0
        way = np.where((grid.room_within(way + move) > 0)[:, None], way + move, way)
    return best


def _sizes(steps: Doubles) -> Doubles:
    sizes: Doubles = np.sqrt((steps**2).sum(-1))
    return sizes


def _inner_least(room: Doubles) -> float:
    """The least room of the spots that are no ends, nor where it only rises from one."""
    rising = np.maximum.accumulate(room) == room
    falling = (np.maximum.accumulate(room[::-1]) == room[::-1])[::-1]
    inner = ~(np.minimum.accumulate(rising) | np.minimum.accumulate(falling[::-1])[::-1])
    return float(room[inner].min()) if inner.any() else float(room.max())


def _spaced(way: Doubles, tall: Doubles, spacing: float) -> Doubles:
    """Spots on the same polyline, about so far apart, its ends included."""
    along = np.concatenate([[0.0], np.cumsum(_sizes(np.diff(way * tall, axis=0)))])
    at = np.linspace(0, along[-1], max(2, int(np.ceil(along[-1] / spacing)) + 1))
    return np.stack([np.interp(at, along, column) for column in way.T], -1)


def simplified(grid: PoseGrid, way: Doubles) -> Doubles:
    """Few spots of a way, so that the others are near the lines between them, seen from J = 0."""
    room, tall = abs(grid.nearest(way)[0]), way * [1.0, 1.0, grid.steepness(way)]
    kept = {0, len(way) - 1}
    stack = [(0, len(way) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        line, inner = tall[last] - tall[first], tall[first + 1 : last] - tall[first]
        share = np.clip(inner @ line / max(line @ line, 1e-30), 0, 1)
        away = _sizes(inner - share[:, None] * line) / (room[first + 1 : last] + 1e-300)
        worst = int(away.argmax())
        if away[worst] > _BEND:
            kept.add(first + 1 + worst)
            stack += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return way[sorted(kept)]


def on_arc(points: Doubles, parts: int) -> Doubles:
    """Points at equal parameters of a Bézier arc."""
    tau = np.linspace(0, 1, parts + 1)[:, None, None]
    found = np.broadcast_to(points, (parts + 1, *np.shape(points)))
    while found.shape[1] > 1:
        found = found[:, :-1] * (1 - tau) + found[:, 1:] * tau
    return found[:, 0]
