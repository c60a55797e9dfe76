"""Boxes of poses: whether J has a sign, and the free legs keep their limits, everywhere in one, or nowhere.

A box is a part of the torus of (α, θ), and of the range of the fixed leg if that is free. Values at the
middle and slopes over the whole box bound what is asked for (mean value theorem). The waves of a leg
(legs.py) depend on one index each, and are kept.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import ROUND_HALF_UP
from enum import IntEnum
from fractions import Fraction
from functools import cached_property
from math import degrees, floor, log2, remainder, tau

from flint import acb, arb, ctx

from rpr_solver.exact.decimals import quotient
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Gradient, LegSlopes, Sinusoids, Waves, cross, cross_slope
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PathLimits
from rpr_solver.paths.routes import DecimalPose

Box = tuple[int, int, int, int]
"""The level, and the numbers of the box along α, θ and L; a level higher, the box is half as wide."""
PosePoint = tuple[arb, arb, Fraction]
"""α and θ in radians, and the scaled length, exact."""

Reach = tuple[arb, arb]
Pair = tuple[arb, arb]
"""The real and the imaginary part of a wave."""
Spot = tuple[float, float, Fraction]
"""α and θ in radians, not confined to a turn, and the scaled length."""

FIRST_LEVEL = 3
"""At this level eight boxes make a turn, and one the whole range of the fixed leg."""
_NEVER = 1000
"""A level that no box reaches."""
_NEAR_DIGITS = 6
"""Significant digits of a pose that is about where something stays undecided."""
BITS = 80
"""The working precision: what is bounded here is far coarser."""
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
class Boxes:
    """The boxes of a slice, or of a range of the fixed leg (scaled), in which J shall have a sign.

    All at the working precision :data:`BITS`.
    """

    slice_map: SliceMap
    sign: int
    limits: PathLimits
    low: Fraction
    high: Fraction
    _known: dict[tuple[int, int, int, int], tuple[Pair, Pair]] = field(default_factory=dict, repr=False)

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
        numbers = []
        for angle, start in ((place[0], _ALPHA), (place[1], _THETA)):
            share = (angle / (2 * arb.pi()) - ball_of(start)) * (1 << level)
            numbers.append(share.floor().unique_fmpz())
        i, k = numbers
        if i is None or k is None:
            return None
        parts, m = self.lengths(level), 0
        if 2 in self.axes:
            m = min(floor((place[2] - self.low) / (self.high - self.low) * parts), parts - 1)
        return level, int(i) % (1 << level), int(k) % (1 << level), m

    def verdict(self, box: Box) -> Verdict:
        """What balls prove about a box."""
        legs, reach = self._legs(box)
        image = [leg.value for leg in legs]
        if self.limits.exclude(image):
            return Verdict.OUT
        j, _ = _singularity(legs, reach, self.sign)
        if j < 0:
            return Verdict.OUT
        flat = arb(0), arb(0)
        return Verdict.IN if j > 0 and self.limits.hold(image, flat) else Verdict.UNDECIDED

    def slopes(self, box: Box) -> list[tuple[bool, list[arb]]]:
        """For J / L with its sign, and for the room that each limit leaves: whether it is proved to be
        allowed all over a box, and its derivatives by α, θ and L over it."""
        legs, reach = self._legs(box)
        j, slopes = _singularity(legs, reach, self.sign)
        found = [(bool(j > 0), slopes)]
        for wall in self.limits.walls:
            leg = legs[wall.leg]
            found.append((bool(wall.room(leg.value) >= 0), [-wall.side * x for x in leg.rise]))
        return found

    def _legs(self, box: Box) -> tuple[tuple[_LegOnBox, _LegOnBox], Reach]:
        """Both legs over a box, and half its widths in angles and in length."""
        *_, length_at = self.middle(box)
        turn, _, size = self.sizes(box)
        length = ball_of(length_at)
        reach = (
            arb(0, (arb.pi() * ball_of(turn)).abs_upper()),
            arb(0, ball_of(size / 2).abs_upper()),
        )
        lengths = length, length + reach[1]
        return (self._leg(0, box, lengths, reach), self._leg(1, box, lengths, reach)), reach

    def _leg(self, number: int, box: Box, lengths: tuple[arb, arb], reach: Reach) -> _LegOnBox:
        level, i, k, _ = box
        turn = (1 << level) - 1
        (a, wide_a), (b, wide_b), (c, wide_c) = (
            self._turned(number, which, level, index)
            for which, index in ((0, (i - k) & turn), (1, k), (2, i))
        )
        (length, wide_length), own = lengths, (self.slice_map.f, self.slice_map.g)[number]
        near, wide = Sinusoids(*a, *b, *c), Sinusoids(*wide_a, *wide_b, *wide_c)
        slopes = wide.slopes(wide_length)
        alpha, phi = slopes[0]
        rise = alpha, wide_length * phi, wide_length + wide.by_length
        value = (length * length + (own.platform2 + own.base2)) / 2 + near.value(length)
        value += rise[0] * reach[0] + rise[1] * reach[0]
        value += rise[2] * reach[1]
        return _LegOnBox(value, near.gradient(length), slopes, wide.slopes_by_length, rise)

    def _turned(self, number: int, which: int, level: int, index: int) -> tuple[Pair, Pair]:
        """One of the waves of a leg in the middle of boxes with an index, and over all of them."""
        key = number, which, level, index
        if key not in self._known:
            centre = Fraction(index, 1 << level) + (_ALPHA - _THETA, _THETA, _ALPHA)[which]
            half = Fraction(1, 1 << (level + 1))
            centre += 0 if which == 0 else half
            angle = 2 * arb.pi() * ball_of(centre)
            radius = (2 * arb.pi() * ball_of(2 * half if which == 0 else half)).abs_upper()
            wave = self._waves[number][which]
            near, wide = wave * _circle(angle), wave * _circle(arb(angle, radius + angle.rad()))
            self._known[key] = (near.real, near.imag), (wide.real, wide.imag)
        return self._known[key]

    @cached_property
    def _waves(self) -> list[Waves]:
        omega = omega_ball(self.slice_map.radicand, ctx.prec)
        return [leg.waves(omega) for leg in (self.slice_map.f, self.slice_map.g)]


@dataclass(frozen=True)
class _LegOnBox:
    """A leg over a box.

    Attributes:
        value: half the squared length.
        near: its slope by α, and that by θ divided by L, in the middle.
        wide: both over the box, with their derivatives by α and θ.
        by_length: the derivative by L of J / L is the cross product of these for both legs.
        rise: the derivatives of the value by α, θ and L over the box.
    """

    value: arb
    near: Gradient
    wide: LegSlopes
    by_length: Gradient
    rise: tuple[arb, arb, arb]


def whole(boxes: Boxes, box: Box) -> Box:
    """The box of which one is a part."""
    level, i, k, m = box
    return level - 1, i >> 1, k >> 1, m * boxes.lengths(level - 1) // boxes.lengths(level)


def _singularity(legs: tuple[_LegOnBox, _LegOnBox], reach: Reach, sign: int) -> tuple[arb, list[arb]]:
    """J / L over a box, times the sign, and its derivatives, likewise."""
    f, g = legs
    (f_slopes, f_alpha, f_theta), (g_slopes, g_alpha, g_theta) = f.wide, g.wide
    slopes = (
        cross_slope(f_slopes, f_alpha, g_slopes, g_alpha),
        cross_slope(f_slopes, f_theta, g_slopes, g_theta),
        cross(f.by_length, g.by_length),
    )
    j = cross(f.near, g.near) + slopes[0] * reach[0] + slopes[1] * reach[0] + slopes[2] * reach[1]
    j *= sign
    return j, [slope * sign for slope in slopes]


def _circle(angle: arb) -> acb:
    sine, cosine = angle.sin_cos()
    return acb(cosine, sine)


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
