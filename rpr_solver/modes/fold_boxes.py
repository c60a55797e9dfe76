"""Boxes of singular poses in doubles, and whether two of them may hold folds of one joint vector.

A box is a rectangle of (α, θ), and all boxes of a batch share an interval of L, the *slab*; long lengths have
a slab of their inverses. Values in the middle, and slopes over the box, bound what is asked for
(:mod:`rpr_solver.paths.pose_boxes`, mathematics.md#folds-apart).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from rpr_solver.boxes.balls import Balls, padded
from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import RADIANS, TURN, UP
from rpr_solver.legs import SINGULAR_WAVES, singular_waves
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.pose_boxes import LegsInBalls, PoseBoxes, singularity_over, unit_of
from rpr_solver.paths.proofs import PathLimits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles: TypeAlias = NDArray[np.float64]
    Integers: TypeAlias = NDArray[np.int64]
    Truths: TypeAlias = NDArray[np.bool_]

ROUNDING = 2.0**-38
"""A bound of the total rounding error of any quantity here (mathematics.md#folds-apart)."""
_UNIT = 2 * np.pi / TURN
"""A unit of angles in radians, rounded."""
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
        return self.wide_alpha * np.float64(RADIANS), self.wide_theta * np.float64(RADIANS)

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

    def hulls(self, first: Integers, second: Integers) -> Boxes:
        """Boxes that hold both boxes of pairs with these numbers, the shorter way round, and with them the
        segments between their poses; both have the same half widths."""
        sides = []
        for middle, wide in zip(*self.sides, strict=True):
            step = (middle[second] - middle[first] + TURN // 2) % TURN - TURN // 2
            sides.append((middle[first] + step // 2, (abs(step) + 1) // 2 + wide[first] + 1))
        (alpha, wide_alpha), (theta, wide_theta) = sides
        return Boxes(alpha, theta, wide_alpha, wide_theta)


def _wider(ball: Balls, second: Doubles) -> Balls:
    """Means along segments, from balls in their middles and second derivatives along them."""
    return Balls(ball.mid, (ball.rad + second / 24) * UP)


@dataclass(frozen=True)
class FoldBoxes:
    """A manipulator with one leg fixed, and limits of the free legs, in doubles.

    Attributes:
        unit: of lengths, in scaled ones.
        legs: the free legs.
        limits: the free leg and the side of each wall, and its height less the constant of the leg.
    """

    unit: Fraction
    legs: LegsInBalls
    limits: tuple[tuple[int, int, float], ...]

    @classmethod
    def of(
        cls,
        slice_map: SliceMap,
        bounds: Mapping[int, Bounds],
        high: Fraction,
        around: tuple[Fraction, LegsInBalls] | None = None,
    ) -> FoldBoxes:
        """For scaled lengths of the fixed leg up to ``high``, and limits in the user's unit.

        ``around``: a unit, and all manipulators round the given one, instead of that alone.
        """
        unit, legs = unit_of(slice_map, high), (slice_map.f, slice_map.g)
        if around is not None:
            unit = around[0]
        constants = [Fraction(leg.platform2 + leg.base2) / 2 for leg in legs]
        limits = tuple(
            (wall.leg, wall.side, double((wall.height - constants[wall.leg]) / unit**2))
            for wall in PathLimits.of(slice_map, bounds).walls
        )
        return cls(unit, LegsInBalls.of(slice_map, unit) if around is None else around[1], limits)

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
            own = self.poses(boxes, slab)
            j, slopes = own.singularity
            keep &= ~own.over(j, slopes).excludes_zero & self.within(own)
            x, y, z = (side.rad for side in own.sides)
            by_alpha, by_theta, by_number = slopes
            rest = j.rad + (abs(by_number.mid) + by_number.rad) * z + by_alpha.rad * x + by_theta.rad * y
            rests = abs(by_theta.mid) * y + rest, abs(by_alpha.mid) * x + rest
            sides = zip((by_alpha, by_theta), rests, *boxes.sides, strict=True)
            (alpha, wide_alpha), (theta, wide_theta) = (
                _narrowed(j.mid, slope.mid, padded(away), *side) for slope, away, *side in sides
            )
            boxes = Boxes(alpha, theta, wide_alpha, wide_theta)
        return boxes, keep

    def within(self, own: PoseBoxes) -> Truths:
        """Where no joint limit is exceeded everywhere."""
        inside = np.ones(own.sides[0].mid.shape, dtype=bool)
        number = own.sides[2]
        square = number.mid * number.mid * 0.5
        for leg, side, height in () if own.inverse else self.limits:
            value, (alpha, theta, by_length) = own.value(leg)
            # the height of a limit is less the constant of the leg, that of the given manipulator
            value = Balls(value.mid + square, value.rad + ROUNDING + self._loose(leg))
            least, most = own.over(value, (alpha, theta, by_length + number)).ends()
            inside &= ~(least > height if side > 0 else most < height)
        return inside

    def _loose(self, leg: int) -> float:
        """By how much the constant of a leg differs between manipulators, at most."""
        return 0.0 if self.legs.is_one else float(2 * self.legs.constants[leg].rad[0])

    def apart(self, boxes: Boxes, slab: Slab, first: Integers, second: Integers) -> Truths:
        """Which pairs of boxes, by their numbers, have no two poses of one joint vector."""
        own = self.poses(boxes, slab)
        x, y, z = (side.rad for side in own.sides)
        values = [own.value(leg) for leg in (0, 1)]
        loose = [v.rad + a.rad * x + t.rad * y + n.rad * z for v, (a, t, n) in values]
        (fv, fa, ft, fl), (gv, ga, gt, gl) = ([w.mid for w in (v, *slopes)] for v, slopes in values)
        done, ones = np.zeros(len(first), dtype=bool), np.ones(len(first))
        normals = [(ones, 0 * ones), (0 * ones, ones)]
        normals += [_normals((fa, ft), (ga, gt), side) for side in (first, second)]
        for c, s in normals:
            gap = c * (fv[first] - fv[second]) + s * (gv[first] - gv[second])
            drift = c * (fl[first] - fl[second]) + s * (gl[first] - gl[second])
            reach = abs(drift) * slab.half + 4 * ROUNDING
            for k in (first, second):
                reach = reach + abs(c * fa[k] + s * ga[k]) * x[k] + abs(c * ft[k] + s * gt[k]) * y[k]
                reach = reach + abs(c) * loose[0][k] + abs(s) * loose[1][k]
            done |= abs(gap) > reach * UP
        return done

    def regular(self, boxes: Boxes, spans: tuple[Doubles, Doubles], slab: Slab) -> Truths:
        """Which boxes hold no middle between two singular poses of one joint vector, at most so far apart.

        The mean of a derivative along the segment between them is that in the middle, but for 1/24 of its
        greatest second derivative along the segment.
        """
        own, (x, y) = self.poses(boxes, slab), spans
        f, g = own.legs
        _, (by_alpha, by_theta, _) = singularity_over(f, g)
        by_alpha, by_theta = map(_wider, (by_alpha, by_theta), self._third(spans, slab))
        # the image of the tangent of J = 0
        along = [leg.rise[1].mid * by_alpha.mid - leg.rise[0].mid * by_theta.mid for leg in (f, g)]
        size = np.maximum(np.hypot(*along), 1e-300)
        c, s = (Balls.exact(part / size) for part in along)
        long, short = (1.0, slab.top) if slab.is_inverse else (slab.top, 1.0)
        alpha, phi = [], []
        for (m, a), over in zip(self.legs.sizes, (f, g), strict=True):
            alpha.append(_wider(over.slopes[0][0], long * m * (x + y) ** 2 + short * m * a * x * x))
            phi.append(_wider(over.slopes[0][1], m * (x + y) ** 2 + a * y * y))
        theta = c * phi[0] + s * phi[1]
        theta = theta if slab.is_inverse else own.sides[2] * theta
        return (by_alpha * theta - by_theta * (c * alpha[0] + s * alpha[1])).excludes_zero

    def _third(self, spans: tuple[Doubles, Doubles], slab: Slab) -> list[Doubles]:
        """Bounds of the second derivatives of J_α / L and J_θ / L along steps, by the waves of J."""
        waves = singular_waves(*self.legs.waves, Balls.exact(np.ones(1)))
        sizes = np.array([sum(abs(x.mid[0]) + x.rad[0] for x in (w.real, w.imag)) / 2 for w in waves])
        short = slice(4) if slab.is_inverse else slice(4, 6)
        sizes[short] *= slab.top
        turns = abs(np.array(SINGULAR_WAVES, dtype=np.float64))
        steps = sizes[:, None] * (turns @ np.stack(spans)) ** 2
        return list(turns.T @ steps)

    def poses(self, boxes: Boxes, slab: Slab) -> PoseBoxes:
        """The free legs over boxes, for all lengths of a slab."""
        ones = np.ones(len(boxes))
        middles: list[Doubles] = [x * np.float64(_UNIT) for x in (boxes.alpha % TURN, boxes.theta % TURN)]
        halves = [*boxes.reach, slab.half * ones]
        return PoseBoxes.of(self.legs, [*middles, slab.middle * ones], halves, inverse=slab.is_inverse)


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


def _normals(
    f: tuple[Doubles, Doubles], g: tuple[Doubles, Doubles], which: Integers
) -> tuple[Doubles, Doubles]:
    """Unit vectors across the images of boxes, from the slopes of both legs by α and θ."""
    steep = abs(f[0]) + abs(g[0]) > abs(f[1]) + abs(g[1])
    x, y = (np.where(steep, *leg)[which] for leg in (f, g))
    size = np.maximum(np.hypot(x, y), 1e-300)
    return -y / size, x / size
