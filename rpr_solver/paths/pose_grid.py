"""Poses of a slice, or of slices of a range of the fixed leg, on a grid, in floats: the room round each, and
ways between two of them.

A way is a proposal, which is then proved. J / L is linear in L, so a disc of (α, θ) without a singular pose
in two slices has none in those between them (mathematics.md#paths-without-a-singularity). So a way leads from
node to node of a slice, or to the same angles in the slice beside. A search finds the way whose least room is
greatest, and among those nearly as wide one that is short, and wide elsewhere too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.numerals import double
from rpr_solver.paths.cells import chained
from rpr_solver.paths.proofs import NO_LIMITS, PathLimits
from rpr_solver.paths.routes import EndPose
from rpr_solver.paths.singular_field import SingularField, half_squares, polished

if TYPE_CHECKING:
    from fractions import Fraction

    from numpy.typing import NDArray

    from rpr_solver.paths.singular_field import Doubles

    Places = NDArray[np.intp]

_HELD = 144
"""Nodes in a turn, if the fixed leg is held; answers may depend on it, their truth does not."""
_FREE = 90
"""The same in each slice of a range."""
_SLICES = 9
"""Slices of a range, at equal steps; those of both poses come to them."""
_ENOUGH = 1.5
"""In steps of the grid: with so much room a pose need not climb."""
_CLIMB = 0.6
"""Of the room, by which a climb goes on at most."""
_GAIN = 0.3
"""Of a step, by which it must increase the room."""
_MOST_CLIMBS = 80
_KEPT = 0.93
"""The share of the greatest least room that the shorter way must keep."""
_SAME = 1e-9
"""Lengths in units of the field that differ by less are one."""
_BESIDE = [(i, k) for i in (-1, 0, 1) for k in (-1, 0, 1) if i or k]


@dataclass(frozen=True)
class SliceGrid:
    """The poses of a slice on a grid, with the nearest zero of J seen from each.

    Attributes:
        field: positive where a way may lead.
        parts: the number of nodes in a turn.
    """

    field: SingularField
    parts: int

    @property
    def step(self) -> float:
        """From node to node, in degrees."""
        return 360 / self.parts

    @cached_property
    def nodes(self) -> Doubles:
        """α and θ of all nodes, in degrees."""
        return np.stack(np.meshgrid(*[np.arange(self.parts) * self.step] * 2, indexing="ij"), -1)

    @cached_property
    def values(self) -> Doubles:
        """The field at all nodes, by α and θ."""
        return self.field.value(self.nodes)

    @cached_property
    def feet(self) -> Doubles:
        """From each node to the nearest zero between two nodes, in degrees."""
        found = np.full((self.parts, self.parts, 2), 1e3)
        for axis in (0, 1):
            beyond = np.roll(self.values, -1, axis)
            i, k = np.nonzero(self.values * beyond < 0)
            spots = self.nodes[i, k]
            zeros = spots.copy()
            zeros[:, axis] += self.values[i, k] / (self.values[i, k] - beyond[i, k]) * self.step
            zeros = np.where((better := polished(self.field, zeros, zeros))[1][:, None], better[0], zeros)
            found = self._seeded(found, zeros - spots, i, k)
        # jump flooding: zeros seen from nodes farther and farther apart, then nearer and nearer
        jump = 1 << (self.parts // 2).bit_length() - 1
        for size in (*(jump >> n for n in range(jump.bit_length())), 1):
            for x, y in _BESIDE:
                other = np.roll(found, (-x * size, -y * size), (0, 1)) + np.array([x, y]) * size * self.step
                nearer = (other**2).sum(-1) < (found**2).sum(-1)
                found[nearer] = other[nearer]
        return found

    def _seeded(self, found: Doubles, steps: Doubles, i: Places, k: Places) -> Doubles:
        """The steps to the zeros from the nodes round each, if they are the shortest."""
        for x in (0, 1, -1):
            for y in (0, 1, -1):
                own = steps - np.array([x, y]) * self.step
                where = (i + x) % self.parts, (k + y) % self.parts
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
        """The distances of spots (degrees) from J = 0, about, negative where the field is, and the nearest
        points of it."""
        low = np.floor(spots / self.step).astype(int)
        nodes = [low + corner for corner in ((0, 0), (0, 1), (1, 0), (1, 1))]
        sure = [x * self.step + self.feet[x[:, 0] % self.parts, x[:, 1] % self.parts] for x in nodes]
        # what lies between nodes is seen from spots that are near it; steps that do not arrive show nothing,
        # as between two arcs that nearly meet
        found, arrived = polished(self.field, spots, np.stack([*sure, spots]))
        feet = np.concatenate([found, sure])
        away = np.hypot(*np.moveaxis(feet - spots, -1, 0))
        away[: len(found)][~arrived] = np.inf
        nearest, columns = away.argmin(axis=0), np.arange(len(spots))
        return away[nearest, columns] * np.sign(self.field.value(spots)), feet[nearest, columns]


@dataclass(frozen=True)
class PoseGrid:
    """The poses of a slice, or of slices of a range, on grids.

    Attributes:
        field: of the longest fixed leg; positive where a way may lead.
        lengths: of the slices, in the unit of the field, ascending.
        ends: those of both poses.
        limits: of the free legs.
    """

    field: SingularField
    lengths: Doubles
    ends: tuple[float, float]
    limits: PathLimits

    @classmethod
    def of(
        cls,
        poses: Sequence[EndPose],
        span: tuple[Fraction, Fraction],
        sign: int,
        limits: PathLimits = NO_LIMITS,
    ) -> PoseGrid:
        """That for ways between two poses with this sign of J, in a range of scaled lengths."""
        longest = SingularField.of(poses[0].slice_map, span[1], sign)
        low, high, first, last = (double(x / longest.unit) for x in (*span, *(p.legs[0] for p in poses)))
        if span[0] == span[1]:
            return cls(longest, np.array([high]), (first, last), limits)
        own = np.unique([first, last])
        steps = np.linspace(low, high, _SLICES)
        apart = abs(steps[:, None] - own).min(axis=1) > (high - low) / _SLICES**2
        return cls(longest, np.sort([*steps[apart], *own]), (first, last), limits)

    @property
    def is_held(self) -> bool:
        """Whether the fixed leg keeps its length."""
        return len(self.lengths) == 1

    @cached_property
    def slices(self) -> list[SliceGrid]:
        """Their grids."""
        parts = _HELD if self.is_held else _FREE
        return [SliceGrid(self.field.slice_at(x), parts) for x in self.lengths.tolist()]

    def slice_of(self, end: int) -> int:
        """The number of the slice of a pose."""
        return int(abs(self.lengths - self.ends[end]).argmin())

    def nearest(self, spots: Doubles) -> tuple[Doubles, Doubles]:
        """The distances of spots (α, θ, length) from J = 0 in their own slices, about, negative where J has
        the other sign, and the nearest zeros; between two slices the distances are interpolated."""
        above = np.searchsorted(self.lengths, spots[:, 2] - _SAME).clip(max=len(self.lengths) - 1)
        below = (np.searchsorted(self.lengths, spots[:, 2] + _SAME, "right") - 1).clip(min=0)
        rooms, feet = np.zeros((2, len(spots))), np.zeros((2, len(spots), 2))
        for n, numbers in enumerate((below, above)):
            for k in np.unique(numbers):
                own = numbers == k
                rooms[n, own], feet[n, own] = self.slices[k].nearest(spots[own, :2])
        low, high = self.lengths[below], self.lengths[above]
        share = np.where(low < high, (spots[:, 2] - low) / np.where(low < high, high - low, 1.0), 0.0)
        return rooms[0] + share * (rooms[1] - rooms[0]), feet[rooms.argmin(axis=0), np.arange(len(spots))]

    def steepness(self, spots: Doubles) -> float:
        """By how many degrees the room changes with the length, at most, where it is seen."""
        if self.is_held:
            return 0.0
        steps = abs(np.diff([own.nearest(spots[:, :2])[0] for own in self.slices], axis=0))
        found: float = (np.maximum(1.0, steps.max(axis=1)) / np.diff(self.lengths)).max()
        return found

    def room_within(self, spots: Doubles) -> Doubles:
        """About how much half squares of legs are inside the limits, the least of all limits, relative."""
        rooms: Doubles = np.min([np.full(spots.shape[:-1], np.inf), *self._rooms_within(spots)], axis=0)
        return rooms

    def _rooms_within(self, spots: Doubles) -> list[Doubles]:
        """The same for each of the limits."""
        squares = half_squares(self.field, spots) if self.limits.walls else []
        return [
            (double(wall.height / self.field.unit**2) - squares[wall.leg]) * wall.side
            for wall in self.limits.walls
        ]

    @cached_property
    def _within(self) -> Doubles:
        """About how many degrees of (α, θ) each node is inside the limits."""
        nodes, ones = self.slices[0].nodes, np.ones((*self.slices[0].nodes.shape[:2], 1))
        spots = np.stack([np.concatenate([nodes, x * ones], -1) for x in self.lengths])
        found = np.full(spots.shape[:-1], np.inf)
        for room in self._rooms_within(spots):
            slope = sum(abs(np.roll(room, 1, axis) - np.roll(room, -1, axis)) / 2 for axis in (1, 2))
            found = np.minimum(found, room * self.slices[0].step / (slope + 1e-300))
        return found

    def way(self, poses: Sequence[EndPose], *, is_wide: bool) -> list[Doubles] | None:
        """Spots (α and θ in degrees, and the length) of a way between two poses: those from the first pose to
        a node, those of nodes, and those to the last pose, perhaps some turns further; None if none is found.

        Args:
            poses: they keep the limits.
            is_wide: whether it is to be far from J = 0 alone, within the limits; or from both.
        """
        rooms = np.stack([own.rooms for own in self.slices])
        rooms = np.where(self._within > 0, rooms, -1.0) if is_wide else np.minimum(rooms, self._within)
        climbs = [self._climbed(np.array(degrees_of(pose)), end) for end, pose in enumerate(poses)]
        nodes = [self._node_near(climb[-1], rooms, end) for end, climb in enumerate(climbs)]
        if nodes[0] is None or nodes[1] is None:
            return None
        search = _Search(rooms, self.slices[0].step, is_wide)
        if (way := search.way(nodes[0], nodes[1])) is None:
            return None
        places, step = np.array(way), self.slices[0].step
        steps = (np.diff(places[:, 1:], axis=0) + search.parts // 2) % search.parts - search.parts // 2
        corners = np.array(nodes[0][1:]) + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])
        turns = (corners[-1] - np.array(nodes[1][1:])) * step
        first, last = (
            np.concatenate([climb, np.full((len(climb), 1), length)], axis=1)
            for climb, length in zip((climbs[0], climbs[1] + turns), self.ends, strict=True)
        )
        inner = np.concatenate([corners * step, self.lengths[places[:, :1]]], axis=1)
        return [first, inner, last[::-1]]

    def _climbed(self, spot: Doubles, end: int) -> Doubles:
        """Spots from a pose on, each farther from J = 0 than the one before, until a node sees it well."""
        own, spots = self.slices[self.slice_of(end)], [spot]
        (room,), (foot,) = own.nearest(spot[None])
        while 0 < room < _ENOUGH * own.step and len(spots) < _MOST_CLIMBS:
            step = min(_CLIMB * room, own.step / 2)
            following = spots[-1] + (spots[-1] - foot) * (step / room)
            (farther,), (foot,) = own.nearest(following[None])
            if farther < room + _GAIN * step or self.room_within(np.array([*following, self.ends[end]])) <= 0:
                break
            spots.append(following)
            room = farther
        return np.array(spots)

    def _node_near(self, spot: Doubles, rooms: Doubles, end: int) -> tuple[int, int, int] | None:
        """A node with much room that a straight line seems to join to a spot, in the slice of a pose."""
        number, length = self.slice_of(end), self.ends[end]
        own, shares = self.slices[number], np.linspace(0, 1, 9)[:, None]
        near = np.floor(spot / own.step).astype(int) + np.array([(x, y) for x in _NEAR for y in _NEAR])
        room = rooms[number, near[:, 0] % own.parts, near[:, 1] % own.parts]
        for k in np.argsort(-room):
            line = spot + shares * (near[k] * own.step - spot)
            within = self.room_within(np.concatenate([line, np.full((len(line), 1), length)], axis=1))
            if room[k] > 0 and (own.field.value(line) > 0).all() and (within > 0).all():
                return number, int(near[k, 0]), int(near[k, 1])
        return None


_NEAR = range(-1, 3)
"""Nodes to each side of a pose that are looked at."""


class _Search:
    """The search for ways from node to node."""

    def __init__(self, rooms: Doubles, step: float, is_wide: bool) -> None:
        self.rooms, self.step = rooms, step
        self.parts: int = rooms.shape[1]
        # discs of these radii must overlap, so that the line between two nodes is free
        self.gap = 1.0 if is_wide else 0.0
        self._room: list[float] = rooms.ravel().tolist()

    def way(self, start: tuple[int, int, int], stop: tuple[int, int, int]) -> list[tuple[int, ...]] | None:
        """The widest way, or one nearly as wide and shorter: numbers of slices and of nodes."""
        n = self.parts
        first, last = ((m * n + i % n) * n + k % n for m, i, k in (start, stop))
        widest = self._found(first, last, None)
        if widest is None:
            return None
        least = min(self._room[node] for node in widest)
        shorter = self._found(first, last, least * _KEPT) or widest
        return [tuple(map(int, np.unravel_index(node, self.rooms.shape))) for node in shorter]

    def _found(self, start: int, stop: int, least: float | None) -> list[int] | None:
        """The nodes of the way with the greatest least room; or of one with at least this room that is short,
        where steps count the more the less room there is."""
        room, floor = self._room, least or 1e-300
        heap = [(0.0 if least else -room[start], start, start)]
        before: dict[int, int | None] = {}
        while heap:
            key, node, last = heappop(heap)
            if node in before:
                continue
            before[node] = None if node == start else last
            if node == stop:
                return chained(before, node)[::-1]
            here = room[node]
            for other, size in self._beside(node):
                there = room[other]
                if there >= floor and other not in before and here + there >= size * self.gap:
                    key_there = key + (size or self.step) / (here * there) if least else max(key, -there)
                    heappush(heap, (key_there, other, node))
        return None

    def _beside(self, node: int) -> list[tuple[int, float]]:
        """The nodes beside one, in its slice and in others, each with how far its angles are."""
        parts, nodes, step = self.parts, self.parts**2, self.step
        own = node % nodes
        base, k = node - own, node % parts
        left, right = (k - 1) % parts - k, (k + 1) % parts - k
        up, down, diagonal = base + (own - parts) % nodes, base + (own + parts) % nodes, step * 2**0.5
        found = [(up, step), (down, step), (node + left, step), (node + right, step)]
        found += [(row + side, diagonal) for row in (up, down) for side in (left, right)]
        return found + [(x, 0.0) for x in (node - nodes, node + nodes) if 0 <= x < len(self._room)]


def degrees_of(pose: EndPose) -> tuple[float, float]:
    """α and θ of a pose."""
    alpha, theta = pose.angles
    return degrees(float(alpha)), degrees(float(theta))
