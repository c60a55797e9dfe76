"""The widest way between two poses on a grid of a slice, or of a range of slices, in floats and by definition
alone: a witness of clearances.
The zeros of J between neighbours of a grid that is three times finer stand for the singular curve; nodes are
joined in the order of their distances from it, the farthest first, until the two poses are. In a range each
slice has its own grid, and nodes of neighbouring slices at the same angles are joined, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from typing import Any

import numpy as np

from rpr_solver import Manipulator
from tests.support.oracle import free_legs_of, singularity

_FINER = 3
Spot = tuple[float, float]
"""α and θ in degrees."""


@dataclass(frozen=True)
class WidthGrid:
    """A grid of the poses of a slice."""

    manipulator: Manipulator
    leg: int
    length: float
    size: int = 360

    def singularity(self, alpha: Any, theta: Any) -> Any:
        """J / L at angles in degrees."""
        legs = free_legs_of(self.manipulator, self.leg)
        return singularity(legs, self.length, np.deg2rad(alpha), np.deg2rad(theta))

    @property
    def step(self) -> float:
        return 360 / self.size

    @cached_property
    def values(self) -> Any:
        return self.fine[::_FINER, ::_FINER]

    @cached_property
    def fine(self) -> Any:
        angles = np.arange(_FINER * self.size) * self.step / _FINER
        return self.singularity(*np.meshgrid(angles, angles, indexing="ij"))

    @cached_property
    def zeros(self) -> Any:
        """The singular curve, as a tree of points."""
        points, step = [], self.step / _FINER
        for axis in (0, 1):
            beyond = np.roll(self.fine, -1, axis)
            i, k = np.nonzero(self.fine * beyond < 0)
            low, high = np.zeros(len(i)), np.full(len(i), step)
            nodes = np.stack([i, k], -1) * step
            along = np.eye(2)[axis]
            for _ in range(40):
                middle = (low + high) / 2
                spots = nodes + middle[:, None] * along
                is_same = self.singularity(*spots.T) * self.fine[i, k] > 0
                low, high = np.where(is_same, middle, low), np.where(is_same, high, middle)
            points.append(nodes + low[:, None] * along)
        from scipy.spatial import cKDTree  # only here: loading it takes long

        return cKDTree(np.concatenate(points) % 360, boxsize=360)

    def distance(self, spot: Spot) -> float:
        """How far a pose is from the singular curve, in degrees: the least way to a change of sign of J."""
        far = float(self.zeros.query(np.array(spot) % 360)[0])
        angles = np.linspace(0, 2 * np.pi, 721)
        rings = np.linspace(0, far * 1.001, 401)[:, None]
        values = self.singularity(spot[0] + rings * np.cos(angles), spot[1] + rings * np.sin(angles))
        changed = (values * values[:1] < 0).any(axis=1)
        return float(rings[int(changed.argmax()), 0]) if changed.any() else far

    @cached_property
    def rooms(self) -> Any:
        """The distances of all nodes from the singular curve."""
        angles = np.arange(self.size) * self.step
        nodes = np.stack(np.meshgrid(angles, angles, indexing="ij"), -1).reshape(-1, 2)
        return self.zeros.query(nodes)[0]

    def bottleneck(self, start: Spot, stop: Spot) -> float | None:
        """The least distance on the widest way, both ends included; None if no way was found."""
        rooms = self.rooms
        sign = np.sign(self.singularity(*start))
        inside = np.sign(self.values).ravel() == sign
        ends = [self.node(spot, rooms, inside) for spot in (start, stop)]
        if None in ends:
            return None
        roots = list(range(self.size**2))

        def root(n: int) -> int:
            while roots[n] != n:
                roots[n] = n = roots[roots[n]]
            return n

        known: set[int] = set()
        for n in np.argsort(-np.where(inside, rooms, -1)).tolist():
            if not inside[n]:
                return None
            known.add(n)
            i, k = divmod(n, self.size)
            for x, y in ((i - 1, k), (i + 1, k), (i, k - 1), (i, k + 1)):
                other = x % self.size * self.size + y % self.size
                # their discs overlap, so that the line between them is free
                if other in known and rooms[n] + rooms[other] > self.step:
                    roots[root(other)] = root(n)
            if root(ends[0]) == root(ends[1]):
                return min(float(rooms[n]), self.distance(start), self.distance(stop))
        return None

    def node(self, spot: Spot, rooms: Any, inside: Any) -> int | None:
        """The node round a pose that has the most room on its side of the singular curve."""
        low = np.floor(np.array(spot) / self.step).astype(int)
        near = [
            int((low[0] + x) % self.size * self.size + (low[1] + y) % self.size)
            for x in (0, 1)
            for y in (0, 1)
        ]
        free = [n for n in near if inside[n]]
        return max(free, key=lambda n: float(rooms[n])) if free else None


PoseInRange = tuple[float, float, float]
"""α and θ in degrees, and the length of the fixed leg."""


def bottleneck_of_range(
    manipulator: Manipulator,
    leg: int,
    lengths: Sequence[float],
    ends: tuple[PoseInRange, PoseInRange],
    size: int,
) -> float | None:
    """The least distance on the widest way between poses at two of these lengths, which ascend, both ends
    included; None if no way was found."""
    slices = [WidthGrid(manipulator, leg, length, size) for length in lengths]
    own = [slices[lengths.index(length)] for *_, length in ends]
    spots = [(alpha, theta) for alpha, theta, _ in ends]
    sign = np.sign(own[0].singularity(*spots[0]))
    inside = np.concatenate([np.sign(part.values).ravel() == sign for part in slices])
    rooms = np.where(inside, np.concatenate([part.rooms for part in slices]), -1.0)
    places = []
    for part, spot in zip(own, spots, strict=True):
        first = slices.index(part) * size**2
        node = part.node(spot, part.rooms, inside[first : first + size**2])
        if node is None:
            return None
        places.append(first + node)
    level = _level(rooms, places, (len(slices), size), own[0].step)
    return level and min(level, *(part.distance(spot) for part, spot in zip(own, spots, strict=True)))


def _level(rooms: Any, places: Sequence[int], shape: tuple[int, int], step: float) -> float | None:
    """The least room on the widest way between two nodes."""
    best = np.full(len(rooms), -1.0)
    best[places[0]] = rooms[places[0]]
    heap = [(-best[places[0]], places[0])]
    count, size = shape
    while heap:
        least, n = heappop(heap)
        if n == places[1]:
            return float(-least)
        if -least < best[n]:
            continue
        m, i, k = n // size**2, n // size % size, n % size
        beside = [
            (m, (i + 1) % size, k),
            (m, (i - 1) % size, k),
            (m, i, (k + 1) % size),
            (m, i, (k - 1) % size),
        ]
        # where J has one sign in two slices it has it between them, in the whole disc
        beside += [(x, i, k) for x in (m - 1, m + 1) if 0 <= x < count]
        for x, y, z in beside:
            other = (x * size + y) * size + z
            there = min(-least, rooms[other])
            if there > best[other] and (x != m or rooms[n] + rooms[other] > step):
                best[other] = there
                heappush(heap, (-there, other))
    return None
