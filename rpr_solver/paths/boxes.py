"""Boxes of poses: whether J has a sign, and the free legs keep their limits, everywhere in one, or nowhere.

A box is a part of the torus of (α, θ), and of the range of the fixed leg if that is free. Many boxes at once
are judged in balls of doubles (:mod:`rpr_solver.paths.pose_boxes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_HALF_UP
from enum import IntEnum
from fractions import Fraction
from functools import cached_property
from math import degrees, floor, log2, remainder, tau
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes.balls import UP, Balls
from rpr_solver.exact.decimals import quotient
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.pose_boxes import LegsInBalls, PoseBoxes, singularity_over, unit_of
from rpr_solver.paths.proofs import PathLimits
from rpr_solver.paths.routes import DecimalPose

if TYPE_CHECKING:
    from rpr_solver.paths.pose_boxes import Doubles

Box = tuple[int, int, int, int]
"""The level, and the numbers of the box along α, θ and L; a level higher, the box is half as wide."""
PosePoint = tuple[arb, arb, Fraction]
"""α and θ in radians, and the scaled length, exact."""

Spot = tuple[float, float, Fraction]
"""α and θ in radians, not confined to a turn, and the scaled length."""

FIRST_LEVEL = 3
"""At this level eight boxes make a turn, and one the whole range of the fixed leg."""
_NEVER = 1000
"""A level that no box reaches."""
_NEAR_DIGITS = 6
"""Significant digits of a pose that is about where something stays undecided."""
BITS = 80
"""The working precision of places."""
_ALPHA = Fraction(47, 1021)
"""The origin of the boxes in α, in turns: generic, so that no special pose lies on an edge."""
_THETA = Fraction(-31, 877)
"""That in θ."""


class Verdict(IntEnum):
    """What is proved about a box."""

    OUT = -1
    """No pose of it is allowed."""
    UNDECIDED = 0
    IN = 1
    """All its poses are allowed."""


@dataclass(frozen=True)
class Resolution:
    """The size of a box of poses.

    Attributes:
        angle_deg: its width in α and in the fixed leg's angle.
        length: its width in the length of the fixed leg; None if that is held.

    >>> Resolution(Fraction(45, 64)).to_json()
    {'angle_deg': '0.703125', 'length': None}
    """

    angle_deg: Fraction
    length: Fraction | None = None

    def to_json(self) -> dict[str, str | None]:
        """The document's object."""
        return {"angle_deg": exact_str(self.angle_deg), "length": exact_or_none(self.length)}


def decimal_pose(spot: Spot, scale: Fraction | int) -> DecimalPose:
    """About the pose of a spot, by the scale of its length.

    >>> decimal_pose((7.0, -1.25, Fraction(81)), 3).to_json(1)
    {'alpha_deg': '41.0705', 'theta1_deg': '-71.6197', 'l1': '27'}
    """
    alpha, theta = (Fraction(degrees(remainder(angle, tau))) for angle in spot[:2])
    decimals = (quotient(x, _NEAR_DIGITS, ROUND_HALF_UP) for x in (alpha, theta, spot[2] / scale))
    return DecimalPose(*map(Fraction, decimals))


@dataclass(frozen=True)
class Judgement:
    """What balls show of a box.

    Attributes:
        verdict: what is proved about it.
        missing: the numbers of the conditions that are not proved all over it: 0 is the sign of J, and others
            are the limits.
        slopes: the midpoints and radii of the derivatives of all conditions by α, θ and L over the box, times
            its widths.
    """

    verdict: Verdict
    missing: frozenset[int]
    slopes: tuple[Doubles, Doubles]


@dataclass(frozen=True)
class Boxes:
    """The boxes of a slice, or of a range of the fixed leg (scaled), in which J shall have a sign."""

    slice_map: SliceMap
    sign: int
    limits: PathLimits
    low: Fraction
    high: Fraction

    @property
    def axes(self) -> tuple[int, ...]:
        """The coordinates that are cut: 0 is α, 1 is θ, 2 is L."""
        return (0, 1) if self.low == self.high else (0, 1, 2)

    @cached_property
    def _whole(self) -> int:
        """The last level at which the range of L is one, so that boxes are about as long as they are wide."""
        if self.low == self.high:
            return _NEVER
        ratio = self.high / (self.high - self.low)  # maybe beyond the range of floats
        return round(log2(tau) + log2(ratio.numerator) - log2(ratio.denominator))

    def lengths(self, level: int) -> int:
        """Into how many parts the range of the fixed leg is cut at a level."""
        return 1 << max(0, level - self._whole)

    def resolution(self, level: int) -> Resolution:
        """The size of the boxes of a level, in the user's unit."""
        size = (self.high - self.low) / self.slice_map.scale
        return Resolution(Fraction(360, 1 << level), size / self.lengths(level) if size else None)

    def first(self) -> list[Box]:
        """The boxes of the first level."""
        turn, lengths = range(1 << FIRST_LEVEL), range(self.lengths(FIRST_LEVEL))
        return [(FIRST_LEVEL, i, k, m) for i in turn for k in turn for m in lengths]

    def parts(self, box: Box) -> list[Box]:
        """The boxes into which one is cut."""
        level, i, k, m = box
        lengths = (2 * m, 2 * m + 1) if self.lengths(level + 1) > self.lengths(level) else (m,)
        return [(level + 1, x, y, z) for x in (2 * i, 2 * i + 1) for y in (2 * k, 2 * k + 1) for z in lengths]

    def neighbour(self, box: Box, axis: int, step: int) -> Box | None:
        """The box of the same level next to one; None beyond an end of the range."""
        level, *place = box
        place[axis] += step
        if axis < 2:
            place[axis] %= 1 << level
        elif not 0 <= place[axis] < self.lengths(level):
            return None
        return level, place[0], place[1], place[2]

    def middle(self, box: Box) -> tuple[Fraction, Fraction, Fraction]:
        """α and θ in turns, and the scaled length, in the middle of a box."""
        level, i, k, m = box
        half = Fraction(1, 1 << (level + 1))
        length = self.low + (self.high - self.low) * Fraction(2 * m + 1, 2 * self.lengths(level))
        return _ALPHA + (2 * i + 1) * half, _THETA + (2 * k + 1) * half, length

    def sizes(self, box: Box) -> tuple[Fraction, Fraction, Fraction]:
        """The widths of a box, in the same units."""
        turn = Fraction(1, 1 << box[0])
        return turn, turn, (self.high - self.low) / self.lengths(box[0])

    def holding(self, place: PosePoint, level: int) -> Box | None:
        """A box of a level that holds a place; None if it is too near to an edge."""
        with ctx.workprec(BITS):
            i, k = (
                ((angle / (2 * arb.pi()) - ball_of(start)) * (1 << level)).floor().unique_fmpz()
                for angle, start in zip(place[:2], (_ALPHA, _THETA), strict=True)
            )
        if i is None or k is None:
            return None
        parts, m = self.lengths(level), 0
        if 2 in self.axes:
            m = min(floor((place[2] - self.low) / (self.high - self.low) * parts), parts - 1)
        return level, int(i) % (1 << level), int(k) % (1 << level), m

    def judged(self, boxes: Sequence[Box]) -> list[Judgement]:
        """What balls show of boxes, without limits and J beyond them."""
        own = self._poses(boxes)
        signed = Balls.exact(np.full(len(boxes), float(self.sign)))
        j, slopes = own.singularity
        wide = singularity_over(*own.legs)[1]
        rooms, rises = [signed * own.over(j, slopes)], [[signed * x for x in wide]]
        length = own.sides[2]
        middle = Balls.exact(length.mid)
        half_square, mean_length = middle * middle * 0.5, Balls(length.mid, length.rad * (UP / 2))
        for wall, height in zip(self.limits.walls, self._heights, strict=True):
            value, (alpha, theta, by_length) = own.value(wall.leg)
            value = value + self._model.constants[wall.leg] + half_square
            over = own.over(value, (alpha, theta, by_length + mean_length))
            rise = own.legs[wall.leg].rise
            rooms.append((height - over) * wall.side)
            rises.append([x * -wall.side for x in (rise[0], rise[1], rise[2] + length)])
        kept = np.array([room.mid >= room.rad for room in rooms])
        kept[0] = rooms[0].mid > rooms[0].rad
        is_out = np.any([room.mid < -room.rad for room in rooms], axis=0)
        # J / L grows and the rooms grow by these from side to side
        sizes = np.stack([2 * side.rad for side in own.sides])
        mids = np.array([[x.mid for x in rise] for rise in rises]) * sizes
        radii = np.array([[x.rad for x in rise] for rise in rises]) * sizes
        return [
            Judgement(
                Verdict.OUT if is_out[n] else Verdict.IN if kept[:, n].all() else Verdict.UNDECIDED,
                frozenset(np.flatnonzero(~kept[:, n]).tolist()),
                (mids[..., n], radii[..., n]),
            )
            for n in range(len(boxes))
        ]

    def _poses(self, boxes: Sequence[Box]) -> PoseBoxes:
        """Boxes in balls."""
        low, size = (double(x / self._unit) for x in (self.low, self.high - self.low))
        turns = np.array([1 / (1 << level) for level, *_ in boxes])
        parts = np.array([self.lengths(level) for level, *_ in boxes])
        # exact quotients of integers, rounded once
        alpha, theta = (
            tau * (float(origin) + np.array([(2 * box[k] + 1) / (2 << box[0]) for box in boxes]))
            for k, origin in ((1, _ALPHA), (2, _THETA))
        )
        length = low + size * (2 * np.array([box[3] for box in boxes]) + 1) / (2 * parts)
        halves = [tau / 2 * turns * UP] * 2
        return PoseBoxes.of(self._model, [alpha, theta, length], [*halves, size / (2 * parts) * UP])

    @cached_property
    def _unit(self) -> Fraction:
        return unit_of(self.slice_map, self.high)

    @cached_property
    def _model(self) -> LegsInBalls:
        return LegsInBalls.of(self.slice_map, self._unit)

    @cached_property
    def _heights(self) -> list[Balls]:
        with ctx.workprec(BITS):
            return [Balls.of([ball_of(wall.height / self._unit**2)]) for wall in self.limits.walls]


def whole(boxes: Boxes, box: Box) -> Box:
    """The box of which one is a part."""
    level, i, k, m = box
    return level - 1, i >> 1, k >> 1, m * boxes.lengths(level - 1) // boxes.lengths(level)


BoxPoint = tuple[Fraction, Fraction, Fraction]
"""α and θ in turns, and the scaled length."""


def turns(place: PosePoint) -> BoxPoint:
    """About where a place is."""
    alpha, theta = (Fraction(float(angle) / tau) for angle in place[:2])
    return alpha, theta, place[2]


def near(point: BoxPoint, other: BoxPoint) -> BoxPoint:
    """A point, its angles changed by whole turns to be near another."""
    alpha, theta = (x + round(y - x) for x, y in zip(point[:2], other[:2], strict=True))
    return alpha, theta, point[2]


def face(first: BoxPoint, second: BoxPoint, sizes: BoxPoint, other_sizes: BoxPoint) -> BoxPoint:
    """The middle of what two boxes have in common, given by their middles and sizes."""
    middles = []
    for a, b, size, other in zip(first, second, sizes, other_sizes, strict=True):
        low, high = max(a - size / 2, b - other / 2), min(a + size / 2, b + other / 2)
        middles.append((low + high) / 2)
    return middles[0], middles[1], middles[2]
