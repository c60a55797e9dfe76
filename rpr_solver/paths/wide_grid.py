"""Poses of a slice, or of a range of the fixed leg, on a grid: how wide a way may be at each.

J / L is linear in L, so the lengths at which a disc of (α, θ) holds no singular pose of the slice are an
interval. So it is enough to look for a way in (α, θ) that is wide if the best length may be taken at each of
its poses: the lengths follow, from pose to pose in these intervals. The tube round the path in (α, θ, L) is
then proved as that of a slice is (mathematics.md#paths-without-a-singularity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.numerals import double
from rpr_solver.paths.routes import EndPose, Route
from rpr_solver.paths.singular_field import OUTWARDS, SingularField
from rpr_solver.paths.widest import PoseGrid, controls_of, nearest_of, on_arc, zeros_from

if TYPE_CHECKING:
    from fractions import Fraction

    from rpr_solver.paths.singular_field import Doubles

_SLICES = 9
"""Of a range, in which poses are looked at."""
_KEPT, _LOCAL = 0.99, 0.6
"""Which room a length must leave: shares of the least one on the way, and of the greatest one there."""
_SMOOTHINGS = 200
_SAME = 1e-12


@dataclass(frozen=True)
class RangeGrid(PoseGrid):
    """The poses of the slices of a range on a grid: each has the room of the slice where that is greatest.

    Attributes:
        field: of the longest fixed leg.
        lengths: of the slices, in the unit of the field; one, if the length is held.
        ends: the lengths at the first and the last spot of a way.
    """

    lengths: Doubles
    ends: tuple[float, float]

    @classmethod
    def of(cls, poses: Sequence[EndPose], span: tuple[Fraction, Fraction], sign: int) -> RangeGrid:
        """That of two poses and a range of scaled lengths."""
        longest = SingularField.of(poses[0].slice_map, span[1], sign)
        low, high, first, last = (double(x / longest.unit) for x in (*span, *(p.legs[0] for p in poses)))
        if span[0] == span[1]:
            return cls(longest, np.array([high]), (high, high))
        # a little wider, so that what holds between them holds for the exact range
        return cls(longest, np.linspace(low - OUTWARDS, high + OUTWARDS, _SLICES), (first, last))

    @property
    def is_held(self) -> bool:
        """Whether the fixed leg keeps its length."""
        return len(self.lengths) == 1

    @cached_property
    def slices(self) -> list[PoseGrid]:
        """Their grids."""
        if self.is_held:
            return [PoseGrid(self.field)]
        return [self._slice(x) for x in self.lengths.tolist()]

    def slice_at(self, length: float) -> PoseGrid:
        """The grid of the slice of a length, up to what does not matter to floats."""
        near = int(abs(self.lengths - length).argmin())
        return self.slices[near] if abs(self.lengths[near] - length) < _SAME else self._slice(length)

    def _slice(self, length: float) -> PoseGrid:
        own, field = self.field.at(np.array([length])).amplitudes[:, 0], self.field
        return PoseGrid(SingularField(own, field.size, field.sign, field.legs, length, field.unit))

    @cached_property
    def rooms(self) -> Doubles:
        """The distance of each node from J = 0 at the best length; negative where none has the sign."""
        rooms: Doubles = np.max([own.rooms for own in self.slices], axis=0)
        return rooms

    def seen(self, spots: Doubles) -> tuple[Doubles, Doubles]:
        """The rooms of spots in all slices, negative where J has the other sign, and the nearest zeros."""
        found = [own.nearest(spots) for own in self.slices]
        signs = np.array([np.sign(own.field.value(spots)) for own in self.slices])
        return signs * np.array([room for room, _ in found]), np.array([feet for _, feet in found])

    def nearest_at(self, spots: Doubles, lengths: Doubles, feet: Doubles) -> tuple[Doubles, Doubles]:
        """The distances of spots from J = 0 at their own lengths, and the nearest zeros, from zeros of the
        slices."""
        return nearest_of(*zeros_from(self.field.at(lengths), spots, np.concatenate([feet, spots[None]])))

    def rooms_at(self, spots: Doubles) -> Doubles:
        """The distances of spots from J = 0 at their lengths."""
        if self.is_held:
            return self.slices[0].nearest(spots[:, :2])[0]
        return self.nearest_at(spots[:, :2], spots[:, 2], self.seen(spots[:, :2])[1])[0]

    def foot(self, pose: EndPose) -> Doubles:
        """The nearest singular pose of the slice of a pose, in degrees, about."""
        return self.slice_at(double(pose.legs[0] / self.field.unit)).foot(pose)

    def controls(self, route: Route) -> Sequence[Sequence[tuple[float, ...]]]:
        """The control points of the arcs: degrees, and the length in the unit of the field if that varies."""
        if self.is_held:
            return controls_of(route)
        ends, factor = iter(self.ends), route.slice_map.scale / self.field.unit
        lengths = [
            [next(ends) if p is None else double(p.length * factor) for p in arc] for arc in route.arcs
        ]
        return [
            [(*p, length) for p, length in zip(arc, own, strict=True)]
            for arc, own in zip(controls_of(route), lengths, strict=True)
        ]

    def changes(self, arcs: Sequence[Doubles]) -> Sequence[float]:
        """By how much the room may change with the length on each arc, in degrees."""
        if self.is_held:
            return [0.0] * len(arcs)
        steep = self.steepness(np.concatenate([on_arc(p, 4)[:, :2] for p in arcs]))
        return [float(np.ptp(p[:, 2])) * steep for p in arcs]

    def steepness(self, way: Doubles) -> float:
        """By how many degrees the room changes with the length, at most, where it is seen."""
        if self.is_held:
            return 0.0
        low, *_, high = self.lengths.tolist()
        steps = abs(np.diff(self.seen(way)[0], axis=0))
        most: float = max(1.0, float(steps.max())) * (_SLICES - 1) / (high - low)
        return most

    def nearest(self, spots: Doubles) -> tuple[Doubles, Doubles]:
        """As :meth:`PoseGrid.nearest`, for a way, at its lengths."""
        if self.is_held:
            return self.slices[0].nearest(spots)
        rooms, feet = self.seen(spots)
        return self.nearest_at(spots, self.lifted(rooms), feet)

    def lengths_on(self, way: Doubles) -> Doubles:
        """The lengths at the spots of a way."""
        return np.full(len(way), self.ends[0]) if self.is_held else self.lifted(self.seen(way)[0])

    def lifted(self, rooms: Doubles) -> Doubles:
        """A length for each spot of a way, by its rooms, which leaves much room and changes little from spot
        to spot."""
        most = rooms.max(axis=0)
        least = _KEPT * max(float(most.min()), 0.0)
        low, high = self._between(rooms, np.maximum(least, _LOCAL * most))
        best = self.lengths[rooms.argmax(axis=0)]
        low, high = np.minimum(low, best), np.maximum(high, best)
        found: Doubles = best.copy()
        found[0], found[-1] = self.ends
        for _ in range(_SMOOTHINGS):
            inner = (found[2:] + found[:-2]) / 2
            found[1:-1] = np.clip(inner, low[1:-1], high[1:-1])
        return found

    def _between(self, rooms: Doubles, needed: Doubles) -> tuple[Doubles, Doubles]:
        """The least and the greatest length round the best one that leave a room, between slices linearly."""
        columns = np.arange(rooms.shape[1])
        ends = []
        for step in (-1, 1):
            at = rooms.argmax(axis=0)
            found = self.lengths[at]
            is_open = np.ones(len(columns), dtype=bool)
            for _ in range(_SLICES - 1):
                beyond = np.clip(at + step, 0, _SLICES - 1)
                here, there = rooms[at, columns], rooms[beyond, columns]
                fall = np.where(here > there, here - there, np.inf)
                share = np.where(there >= needed, 1.0, np.clip((here - needed) / fall, 0, 1))
                new = self.lengths[at] + share * (self.lengths[beyond] - self.lengths[at])
                found = np.where(is_open, new, found)
                is_open &= there >= needed
                at = np.where(is_open, beyond, at)
            ends.append(found)
        return ends[0], ends[1]
