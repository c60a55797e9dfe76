"""Boxes of singular poses in doubles, and whether two of them may hold folds of one joint vector.

Lengths are in a unit, a power of two, in which none exceeds 1. A box is a rectangle of (α, θ), and all boxes
of a batch share an interval of L, the *slab*. Half the squared length of a leg and J / L are of legs.py.
Values and slopes in the middle, and bounds of second derivatives over the box, bound what is asked for
(mathematics.md#folds-apart).

Long lengths have a slab of their inverse ε = 1 / L. There all is divided by L; so ε = 0 is nothing special.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes.balls import Balls
from rpr_solver.exact.numerals import double
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.exact.turns import RADIANS, TURN, UP, cos_sin
from rpr_solver.legs import (
    SINGULAR_WAVES,
    LegSlopes,
    Sinusoids,
    Waves,
    cross,
    singular_waves,
    singularity,
    turns,
)
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import Leg, SliceMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles: TypeAlias = NDArray[np.float64]
    Integers: TypeAlias = NDArray[np.int64]
    Truths: TypeAlias = NDArray[np.bool_]

ROUNDING = 2.0**-38
"""A bound of the total rounding error of any quantity here (mathematics.md#folds-apart)."""
_UNIT = 2 * np.pi / TURN
"""A unit of angles in radians, rounded."""
_BITS = 128
"""The precision of what becomes doubles."""
_FLAT = 2.0**-30
"""A slope below narrows no box; what rounding does to a greater one is within ROUNDING."""
_SLACK = 2.0**-52
"""A bound of the rounding error of the middle of a slab, which is below 1."""
_ROUNDS = 2
"""How often a box is narrowed before it is cut; answers do not depend on it."""


@dataclass(frozen=True)
class Slab:
    """An interval of lengths of the fixed leg, or of inverse ones: its middle, and its half width, which is
    rounded up."""

    middle: float
    half: float
    is_inverse: bool = False

    @property
    def top(self) -> float:
        """Its greatest number."""
        return (self.middle + self.half) * UP

    @property
    def length(self) -> float:
        """A length in it."""
        return 1 / self.middle if self.is_inverse else self.middle

    @property
    def scale(self) -> float:
        """The length in its middle, or 1 for inverse lengths, by which all is divided there."""
        return 1.0 if self.is_inverse else self.middle

    def halves(self) -> tuple[Slab, Slab]:
        """Two slabs that cover it."""
        quarter = self.half / 2
        half = quarter * UP + _SLACK
        return replace(self, middle=self.middle - quarter, half=half), replace(
            self, middle=self.middle + quarter, half=half
        )


@dataclass(frozen=True)
class Boxes:
    """Rectangles of (α, θ): middles and half widths, in units of a turn over :data:`TURN`."""

    alpha: Integers
    theta: Integers
    wide_alpha: Integers
    wide_theta: Integers

    @classmethod
    def all(cls, parts: int) -> Boxes:
        """The torus, cut into this many parts both ways."""
        half = TURN // (2 * parts)
        middles = (2 * np.arange(parts, dtype=np.int64) + 1) * half
        alpha, theta = (part.ravel() for part in np.meshgrid(middles, middles))
        return cls(alpha, theta, np.full(alpha.shape, half), np.full(alpha.shape, half))

    def __len__(self) -> int:
        return len(self.alpha)

    def __getitem__(self, which: Integers | Truths) -> Boxes:
        return Boxes(self.alpha[which], self.theta[which], self.wide_alpha[which], self.wide_theta[which])

    @property
    def sides(self) -> tuple[tuple[Integers, Integers], tuple[Integers, Integers]]:
        """The middles by α and θ, and the half widths."""
        return (self.alpha, self.theta), (self.wide_alpha, self.wide_theta)

    @property
    def reach(self) -> tuple[Doubles, Doubles]:
        """The half widths in radians."""
        return self.wide_alpha.astype(np.float64) * RADIANS, self.wide_theta.astype(np.float64) * RADIANS

    def cut(self) -> Boxes:
        """The halves of all boxes, each cut across its longer side: the first ones, then the others."""
        upright = self.wide_theta > self.wide_alpha
        alpha = np.where(upright, self.wide_alpha, (self.wide_alpha + 1) // 2)
        theta = np.where(upright, (self.wide_theta + 1) // 2, self.wide_theta)
        moves = np.where(upright, 0, self.wide_alpha // 2), np.where(upright, self.wide_theta // 2, 0)
        middles = [
            np.concatenate([x - y, x + y]) for x, y in zip((self.alpha, self.theta), moves, strict=True)
        ]
        return Boxes(middles[0], middles[1], np.tile(alpha, 2), np.tile(theta, 2))

    def between(self, first: Integers, second: Integers) -> tuple[Boxes, tuple[Doubles, Doubles]]:
        """The boxes of the middles between poses of pairs of boxes with these numbers, the shorter way round;
        and how far both are apart at most, in radians."""
        sides, spans = [], []
        for middle, wide in zip(*self.sides, strict=True):
            step = (middle[second] - middle[first] + TURN // 2) % TURN - TURN // 2
            both = wide[first] + wide[second]
            sides.append((middle[first] + step // 2, both // 2 + 2))
            spans.append((abs(step) + both) * RADIANS)
        (alpha, wide_alpha), (theta, wide_theta) = sides
        return Boxes(alpha, theta, wide_alpha, wide_theta), (spans[0], spans[1])


@dataclass(frozen=True)
class _Leg:
    """A free leg in doubles: its waves, bounds of |m| and |a|, and the limits of the half square, less the
    constant (|m|² + |a|²) / 2."""

    waves: Waves
    platform: float
    base: float
    low: float
    high: float

    @classmethod
    def of(cls, leg: Leg, unit: Fraction, bounds: Bounds, scale: Fraction) -> _Leg:
        with ctx.workprec(_BITS):
            platform, base = (float(arb(x).sqrt() / ball_of(unit)) * UP for x in (leg.platform2, leg.base2))
        constant = (leg.platform2 + leg.base2) / unit**2
        low, high = (None if b is None else double(((b * scale / unit) ** 2 - constant) / 2) for b in bounds)
        low, high = -np.inf if low is None else low, np.inf if high is None else high
        return cls(Waves.of(*leg.doubles(unit)), platform, base, low, high)


class _OnBoxes:
    """A leg in the middles of boxes, with bounds over them."""

    def __init__(self, leg: _Leg, at: tuple[Any, ...], boxes: Boxes, slab: Slab) -> None:
        self.leg, self.slab, self.reach = leg, slab, boxes.reach
        self.own = own = leg.waves.turned(*at)
        # by the number of the slab
        self.by_length, self.slopes_by_length = own.by_length, own.slopes_by_length
        if slab.is_inverse:
            self.by_length, self.slopes_by_length = -own.r, (own.w, own.q + own.d)
            own = own.shrunk(slab.middle)
        self.value, self.slopes = own.value(slab.scale), own.slopes(slab.scale)
        (self.alpha, self.phi), (alpha_alpha, phi_alpha), (alpha_theta, phi_theta) = self.slopes
        self.theta = self.phi * slab.scale
        x, y = self.reach
        self.bend_alpha, self.bend_phi = self.bend_of_alpha(x, y), self.bend_of_phi(x, y)
        self.step_alpha = abs(alpha_alpha) * x + abs(alpha_theta) * y
        self.step_alpha = self.step_alpha + abs(self.slopes_by_length[0]) * slab.half
        self.step_phi = abs(phi_alpha) * x + abs(phi_theta) * y

    def bend_of_alpha(self, x: Doubles, y: Doubles) -> Doubles:
        """A bound of the second derivative of f_α along steps of this size, anywhere."""
        own = self._bend(self.leg.platform, x + y, is_long=True)
        return own + self._bend(self.leg.platform * self.leg.base, x, is_long=False)

    def bend_of_phi(self, x: Doubles, y: Doubles) -> Doubles:
        """The same for φ."""
        return self.leg.platform * (x + y) ** 2 + self.leg.base * y * y

    def _bend(self, size: float, reach: Doubles, *, is_long: bool) -> Doubles:
        """A bound of the second derivative of a part of this size that turns by an angle, times its factor;
        ``is_long``: that of p and b."""
        if self.slab.is_inverse == is_long:
            return size * reach * reach
        return size * reach * (self.slab.top * reach + 2 * self.slab.half)

    @property
    def bend(self) -> Doubles:
        """A bound of the second derivative of the value, less L²/2, along the box."""
        y, base = self.reach[1], self.leg.base
        return self.bend_alpha + self._bend(base, y, is_long=True)

    def within(self) -> Truths:
        """Where a joint limit is not exceeded everywhere."""
        if self.slab.is_inverse or (self.leg.low == -np.inf and self.leg.high == np.inf):
            return np.ones(self.value.shape, dtype=bool)
        (x, y), slab = self.reach, self.slab
        value = self.value + slab.middle**2 / 2
        away = abs(self.alpha) * x + abs(self.theta) * y + abs(self.by_length + slab.middle) * slab.half
        away = away + (self.bend + slab.half**2) / 2 + ROUNDING
        inside: Truths = (value + away >= self.leg.low) & (value - away <= self.leg.high)
        return inside

    def slopes_over(self) -> LegSlopes:
        """f_α and φ over the boxes, and their derivatives."""
        (x, y), own = self.reach, self.own
        m, a = self.leg.platform, self.leg.base
        over = Sinusoids(
            _around(own.p, own.q, m, x + y),
            _around(own.q, own.p, m, x + y),
            _around(own.b, own.d, a, y),
            _around(own.d, own.b, a, y),
            _around(own.r, own.w, m * a, x),
            _around(own.w, own.r, m * a, x),
        )
        number = _number(self.slab, x.shape)
        _, by_alpha, by_theta = over.shrunk(number).slopes() if self.slab.is_inverse else over.slopes(number)
        alpha = Balls(self.alpha, self.step_alpha + self.bend_alpha / 2)
        phi = Balls(self.phi, self.step_phi + self.bend_phi / 2)
        return (alpha, phi), by_alpha, by_theta


def _around(value: Doubles, slope: Doubles, size: float, reach: Doubles) -> Balls:
    """A sinusoid of an amplitude over all angles within a reach, from its value and slope in the middle."""
    return Balls(value, abs(slope) * reach + size * reach**2 / 2)


def _wider(ball: Balls, second: Doubles) -> Balls:
    """Means along segments, from balls in their middles and second derivatives along them."""
    return Balls(ball.mid, (ball.rad + second / 24) * UP)


def _number(slab: Slab, shape: tuple[int, ...]) -> Balls:
    """The numbers of a slab."""
    return Balls(np.full(shape, slab.middle), np.full(shape, slab.half))


@dataclass(frozen=True)
class FoldBoxes:
    """A manipulator with one leg fixed, and limits of the free legs, in doubles.

    Attributes:
        unit: of lengths, in scaled ones.
        legs: the free legs.
    """

    unit: Fraction
    legs: tuple[_Leg, _Leg]

    @classmethod
    def of(cls, slice_map: SliceMap, bounds: Mapping[int, Bounds], high: Fraction) -> FoldBoxes:
        """For scaled lengths of the fixed leg up to ``high``, and limits in the user's unit."""
        squares = [x for leg in (slice_map.f, slice_map.g) for x in (leg.platform2, leg.base2)]
        size = max(Fraction(max(squares)), high**2)
        bits = size.numerator.bit_length() - size.denominator.bit_length() + 1
        unit = Fraction(2) ** -(-bits // 2)
        f, g = (
            _Leg.of(leg, unit, bounds.get(number, (None, None)), slice_map.scale)
            for leg, number in zip((slice_map.f, slice_map.g), free_legs(slice_map.fixed_leg), strict=True)
        )
        return cls(unit, (f, g))

    def slab(self, low: Fraction, high: Fraction) -> Slab:
        """The slab of a range of scaled lengths."""
        first, last = double(low / self.unit), double(high / self.unit)
        return Slab((first + last) / 2, (last - first) / 2 * UP + 4 * _SLACK)

    def beyond(self) -> Slab:
        """The slab of the inverses of all scaled lengths from the unit on."""
        return Slab(0.5, 0.5 + 4 * _SLACK, is_inverse=True)

    def contracted(self, boxes: Boxes, slab: Slab) -> tuple[Boxes, Truths]:
        """Boxes that hold the same singular poses, and which of them may hold one within the limits."""
        keep = np.ones(len(boxes), dtype=bool)
        for _ in range(_ROUNDS):
            f, g = self._on(boxes, slab)
            j, by_alpha, by_theta, by_length = _singularity(f, g)
            x, y = boxes.reach
            rest = abs(by_length) * slab.half + _bend(f, g) / 2 + ROUNDING
            keep &= (abs(j) <= abs(by_alpha) * x + abs(by_theta) * y + rest) & f.within() & g.within()
            rests = abs(by_theta) * y + rest, abs(by_alpha) * x + rest
            sides = zip((by_alpha, by_theta), rests, *boxes.sides, strict=True)
            (alpha, wide_alpha), (theta, wide_theta) = (_narrowed(j, *side) for side in sides)
            boxes = Boxes(alpha, theta, wide_alpha, wide_theta)
        return boxes, keep

    def apart(self, boxes: Boxes, slab: Slab, first: Integers, second: Integers) -> Truths:
        """Which pairs of boxes, by their numbers, have no two poses of one joint vector."""
        f, g = self._on(boxes, slab)
        x, y = boxes.reach
        done = np.zeros(len(first), dtype=bool)
        ones = np.ones(len(first))
        normals = [(ones, 0 * ones), (0 * ones, ones), *(_normals(f, g, side) for side in (first, second))]
        for c, s in normals:
            gap = abs(c * (f.value[first] - f.value[second]) + s * (g.value[first] - g.value[second]))
            drift = c * (f.by_length[first] - f.by_length[second])
            drift = drift + s * (g.by_length[first] - g.by_length[second])
            reach = abs(drift) * slab.half + 4 * ROUNDING
            for k in (first, second):
                reach = reach + abs(c * f.alpha[k] + s * g.alpha[k]) * x[k]
                reach = reach + abs(c * f.theta[k] + s * g.theta[k]) * y[k]
                reach = reach + (abs(c) * f.bend[k] + abs(s) * g.bend[k]) / 2
            done |= gap > reach * UP
        return done

    def regular(self, boxes: Boxes, spans: tuple[Doubles, Doubles], slab: Slab) -> Truths:
        """Which boxes hold no middle between two singular poses of one joint vector, at most so far apart.

        The mean of a derivative along the segment between them is that in the middle, but for 1/24 of its
        greatest second derivative along the segment.
        """
        f, g = self._on(boxes, slab)
        f_over, g_over = f.slopes_over(), g.slopes_over()
        _, by_alpha, by_theta = singularity(f_over, g_over)
        (x, y), third = spans, self._third(spans, slab)
        by_alpha, by_theta = (
            _wider(ball, rest) for ball, rest in zip((by_alpha, by_theta), third, strict=True)
        )
        # the image of the tangent of J = 0
        along = [leg.theta * by_alpha.mid - leg.alpha * by_theta.mid for leg in (f, g)]
        size = np.maximum(np.hypot(*along), 1e-300)
        c, s = (Balls(part / size, np.zeros(size.shape)) for part in along)
        (f_alpha, f_phi), (g_alpha, g_phi) = (
            (_wider(leg_alpha, leg.bend_of_alpha(x, y)), _wider(leg_phi, leg.bend_of_phi(x, y)))
            for leg, ((leg_alpha, leg_phi), *_) in ((f, f_over), (g, g_over))
        )
        theta = c * f_phi + s * g_phi
        theta = theta if slab.is_inverse else _number(slab, size.shape) * theta
        turn = by_alpha * theta - by_theta * (c * f_alpha + s * g_alpha)
        free: Truths = abs(turn.mid) > (turn.rad + 8 * ROUNDING) * UP
        return free

    def _third(self, spans: tuple[Doubles, Doubles], slab: Slab) -> list[Doubles]:
        """Bounds of the second derivatives of J_α / L and J_θ / L along steps, by the waves of J."""
        first, second = (leg.waves for leg in self.legs)
        sizes = abs(np.array(singular_waves(first, second, 1.0))) / 2
        short = slice(4) if slab.is_inverse else slice(4, 6)
        sizes[short] *= slab.top
        waves = abs(np.array(SINGULAR_WAVES))
        steps = sizes[:, None] * (waves @ np.stack(spans)) ** 2
        return list(waves.T @ steps)

    def _on(self, boxes: Boxes, slab: Slab) -> tuple[_OnBoxes, _OnBoxes]:
        z, e = (x + 1j * y for x, y in map(cos_sin, (boxes.alpha, boxes.theta)))
        at = turns(z, e)
        f, g = (_OnBoxes(leg, at, boxes, slab) for leg in self.legs)
        return f, g


def _singularity(f: _OnBoxes, g: _OnBoxes) -> tuple[Doubles, Doubles, Doubles, Doubles]:
    """J / L in the middles of boxes, and its derivatives by α, θ and L."""
    return *singularity(f.slopes, g.slopes), cross(f.slopes_by_length, g.slopes_by_length)


def _bend(f: _OnBoxes, g: _OnBoxes) -> Doubles:
    """A bound of the second derivative of J / L along the boxes."""

    def bounds(leg: _OnBoxes) -> tuple[tuple[Doubles, Doubles, Doubles], ...]:
        return (
            (
                abs(leg.alpha) + leg.step_alpha + leg.bend_alpha / 2,
                leg.step_alpha + leg.bend_alpha,
                leg.bend_alpha,
            ),
            (abs(leg.phi) + leg.step_phi + leg.bend_phi / 2, leg.step_phi + leg.bend_phi, leg.bend_phi),
        )

    (f_alpha, f_phi), (g_alpha, g_phi) = bounds(f), bounds(g)
    first, second = (
        x[0] * y[2] + 2 * x[1] * y[1] + x[2] * y[0] for x, y in ((f_alpha, g_phi), (f_phi, g_alpha))
    )
    return first + second


def _narrowed(
    value: Doubles, slope: Doubles, rest: Doubles, middle: Integers, wide: Integers
) -> tuple[Integers, Integers]:
    """The middles and half widths of intervals round the zeros of value + slope · x ± rest, within the old
    ones; where there is none, what is left means nothing."""
    size = np.maximum(abs(slope), _FLAT)
    centre, radius = -value / np.copysign(size, slope), np.where(abs(slope) < _FLAT, np.inf, rest / size * UP)
    low = np.maximum(np.floor((centre - radius) / _UNIT), 2 - wide) - 2
    high = np.minimum(np.ceil((centre + radius) / _UNIT), wide - 2) + 2
    low, high = (np.where(low <= high, end, 0).astype(np.int64) for end in (low, high))
    new = middle + (low + high) // 2, (high - low) // 2 + 1
    narrower = new[1] < wide
    return np.where(narrower, new[0], middle), np.where(narrower, new[1], wide)


def _normals(f: _OnBoxes, g: _OnBoxes, which: Integers) -> tuple[Doubles, Doubles]:
    """Unit vectors across the images of boxes."""
    steep = abs(f.alpha) + abs(g.alpha) > abs(f.theta) + abs(g.theta)
    x, y = (np.where(steep, leg.alpha, leg.theta)[which] for leg in (f, g))
    size = np.maximum(np.hypot(x, y), 1e-300)
    return -y / size, x / size
