"""The widest path between two poses while the fixed leg may vary, and a bound of all such paths.

J / L is linear in L, so the lengths at which a disc of (α, θ) holds no singular pose of the slice are an
interval. So it is enough to look for a way in (α, θ) that is wide if the best length may be taken at each of
its poses: the lengths follow, from pose to pose in these intervals. The tube round the path in (α, θ, L) is
then proved as that of a slice is, and so is the bound, by two poses for each box: J has the other sign at one
of them or at the other for each length (mathematics.md#paths-without-a-singularity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.decimals import rounded_near
from rpr_solver.exact.numerals import double
from rpr_solver.paths.corridors import BEYOND, Bars, Corridors
from rpr_solver.paths.proofs import NO_LIMITS, PathLimits
from rpr_solver.paths.routes import EndPose, Route
from rpr_solver.paths.singular_field import DEGREE, OUTWARDS, ROUNDING, SingularField, units
from rpr_solver.paths.widest import PoseGrid, controls_of, on_arc, polished, simplified, widest_way

if TYPE_CHECKING:
    from rpr_solver.paths.singular_field import Doubles, Integers, Truths

_SLICES = 9
"""Of the range, in which poses are looked at."""
_KEPT, _LOCAL = 0.99, 0.6
"""Which room a length must leave: shares of the least one on the way, and of the greatest one there."""
_SMOOTHINGS = 200
_ZERO, _SAME = 1e-9, 1e-12


@dataclass(frozen=True)
class RangeGrid(PoseGrid):
    """The poses of the slices of a range on a grid: each has the room of the slice where that is greatest.

    Attributes:
        field: of the longest fixed leg.
        span: the least and the greatest length, in the unit of the field.
        ends: the lengths at the first and the last spot of a way.
    """

    span: tuple[float, float]
    ends: tuple[float, float]

    @cached_property
    def lengths(self) -> Doubles:
        """Those of the slices."""
        found: Doubles = np.linspace(*self.span, _SLICES)
        return found

    @cached_property
    def slices(self) -> list[PoseGrid]:
        """Their grids."""
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
        signs = np.array([np.sign(own.signs(spots)) for own in self.slices])
        return signs * np.array([room for room, _ in found]), np.array([feet for _, feet in found])

    def nearest_at(self, spots: Doubles, lengths: Doubles, feet: Doubles) -> tuple[Doubles, Doubles]:
        """The distances of spots from J = 0 at their own lengths, and the nearest zeros, from zeros of the
        slices."""
        field = self.field.at(lengths)
        starts = np.concatenate([feet, spots[None]])
        found = polished(field, spots, starts)
        away = np.hypot(*np.moveaxis(found - spots, -1, 0))
        values = np.einsum("w...->...", field.waves(found[..., 0], found[..., 1])).real
        away[abs(values) > _ZERO] = np.inf
        best, columns = away.argmin(axis=0), np.arange(len(spots))
        return away[best, columns], found[best, columns]

    def rooms_at(self, spots: Doubles) -> Doubles:
        """The distances of spots from J = 0 at their lengths."""
        return self.nearest_at(spots[:, :2], spots[:, 2], self.seen(spots[:, :2])[1])[0]

    def foot(self, pose: EndPose) -> Doubles:
        """The nearest singular pose of the slice of a pose, in degrees, about."""
        return self.slice_at(double(pose.legs[0] / self.field.unit)).foot(pose)

    def controls(self, route: Route) -> list[list[tuple[float, ...]]]:
        """The control points of the arcs: degrees, and the length in the unit of the field."""
        ends, factor = iter(self.ends), route.slice_map.scale / self.field.unit
        lengths = [
            [next(ends) if p is None else double(p.length * factor) for p in arc] for arc in route.arcs
        ]
        return [
            [(*p, length) for p, length in zip(arc, own, strict=True)]
            for arc, own in zip(controls_of(route), lengths, strict=True)
        ]

    def changes(self, arcs: Sequence[Doubles]) -> Sequence[float]:
        """By the lengths at the ends of each arc."""
        steep = self.steepness(np.concatenate([on_arc(p, 4)[:, :2] for p in arcs]))
        return [float(np.ptp(p[:, 2])) * steep for p in arcs]

    def steepness(self, way: Doubles) -> float:
        """By how many degrees the room changes with the length, at most, where it is seen."""
        rooms, (low, high) = self.seen(way)[0], self.span
        return max(1.0, float(abs(np.diff(rooms, axis=0)).max())) * (_SLICES - 1) / (high - low)

    def nearest(self, spots: Doubles) -> tuple[Doubles, Doubles]:
        """As :meth:`PoseGrid.nearest`, for a way, at its lengths."""
        rooms, feet = self.seen(spots)
        return self.nearest_at(spots, self.lifted(rooms), feet)

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


@dataclass(frozen=True)
class RangeCorridors(Corridors):
    """Paths with this sign of J on which the fixed leg varies.

    Attributes:
        span: the scaled lengths between which it does.
    """

    span: tuple[Fraction, Fraction] = field(kw_only=True)

    @classmethod
    def between(
        cls,
        ends: tuple[EndPose, EndPose],
        span: tuple[Fraction, Fraction],
        sign: int,
        limits: PathLimits = NO_LIMITS,
        asked: Fraction = Fraction(0),
    ) -> RangeCorridors:
        """Those between two poses, between two scaled lengths."""
        longest = SingularField.of(ends[0].slice_map, span[1], sign)
        low, high, first, last = (double(x / longest.unit) for x in (*span, ends[0].legs[0], ends[1].legs[0]))
        # a little wider, so that what holds between them holds for the exact range
        grid = RangeGrid(longest, (low - OUTWARDS, high + OUTWARDS), (first, last))
        return cls(*ends, grid, limits, asked, span=span)

    @property
    def ranges(self) -> RangeGrid:
        """The grid of the slices."""
        assert isinstance(self.grid, RangeGrid)
        return self.grid

    def way(self) -> Doubles | None:
        """Corners of the widest way that the grid found, with the lengths there; None if it found none."""
        grid = self.ranges
        slices = [grid.slice_at(length) for length in grid.ends]
        parts = widest_way(grid, slices, (self.start, self.stop))
        if parts is None:
            return None
        whole, inner = np.concatenate(parts), parts[1]
        held = [np.full(len(part), x) for part, x in zip(parts[::2], grid.ends, strict=True)]
        lengths = np.concatenate([held[0], grid.lifted(grid.seen(inner)[0]), held[1]])
        room, _ = grid.nearest_at(whole, lengths, grid.seen(whole)[1])
        corners = np.concatenate([whole, lengths[:, None] * grid.steepness(whole)], axis=1)
        kept = simplified(corners, room)
        return np.concatenate([whole, lengths[:, None]], axis=1)[kept]

    def length_at(self, spot: Sequence[float]) -> Fraction:
        """The length at a spot, a short decimal in the range."""
        scale = self.start.slice_map.scale
        near = rounded_near(Fraction(spot[2]) * self.field.unit / scale, 10)
        return min(max(near, self.span[0] / scale), self.span[1] / scale)

    def bars(self, most: Fraction) -> Bars:
        """The boxes that bar all ways with more than a clearance."""
        length = self.start.legs[0]
        return _RangeBars(
            self.start.slice_map, self.sign, NO_LIMITS, length, length, corridors=self, most=most
        )


@dataclass(frozen=True)
class _RangeBars(Bars):
    """Out are the boxes that lie, for each length, within a distance of poses where J has the other sign."""

    def _room_and_verdicts(
        self, spots: Doubles, reach: Doubles, most: float
    ) -> tuple[Doubles, Truths, Truths]:
        """As :meth:`Bars._judged`, with the rooms at the best length."""
        assert isinstance(self.corridors, RangeCorridors)
        grid = self.corridors.ranges
        rooms, feet = grid.seen(spots)
        steps = feet - spots
        away = np.hypot(steps[..., 0], steps[..., 1])
        farthest = np.maximum(most * (1 - 1e-6) - reach, 0.0)
        # the pose itself; the nearest zeros, and some beyond them
        sizes = [np.zeros_like(away), away * (1 + BEYOND), np.broadcast_to(farthest, away.shape)]
        shares = np.concatenate([x / np.maximum(away, 1e-12) for x in sizes])
        found = spots + np.tile(steps, (3, 1, 1)) * shares[..., None]
        is_out = self._are_out(found, spots, reach, most)
        room = rooms.max(axis=0)
        return room, is_out, room - reach > most

    def _are_out(self, found: Doubles, spots: Doubles, reach: Doubles, most: float) -> Truths:
        """Whether for each length one of some poses is near a whole box and has the other sign of J.

        That J, which is linear in the length, is below 0 holds from one end of the range up to some share of
        it. So two poses are enough, one for each end, if both do at a share between.
        """
        alpha, theta = units(found.reshape(-1, 2))
        away = np.hypot(
            alpha / DEGREE - np.tile(spots[:, 0], len(found)),
            theta / DEGREE - np.tile(spots[:, 1], len(found)),
        )
        is_near = away.reshape(found.shape[:2]) + reach < most * (1 - 1e-9)
        low, high = (self._values(alpha, theta, end).reshape(found.shape[:2]) for end in (0, 1))
        # how far from the first end, and to the last one, J is below 0
        with np.errstate(all="ignore"):
            share = low / (low - high)
        first = np.where(is_near & (low < 0), np.where(high < 0, 2.0, share), -1.0)
        last = np.where(is_near & (high < 0), np.where(low < 0, -1.0, share), 2.0)
        one, other, columns = first.argmax(axis=0), last.argmin(axis=0), np.arange(len(spots))
        middle = np.clip((first[one, columns] + last[other, columns]) / 2, 0, 1)
        at_middle = [
            (1 - middle) * low[n, columns] + middle * high[n, columns] < -ROUNDING for n in (one, other)
        ]
        ends = (first[one, columns] >= 0) & (last[other, columns] <= 1)
        found_out: Truths = ends & at_middle[0] & at_middle[1]
        return found_out

    def _values(self, alpha: Integers, theta: Integers, end: int) -> Doubles:
        """Upper bounds of the field in the slice at an end of the range."""
        assert isinstance(self.corridors, RangeCorridors)
        grid = self.corridors.ranges
        value, slack = grid.slices[-end].field.bounds(alpha, theta, 0.0)
        return value + slack
