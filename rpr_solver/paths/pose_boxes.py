"""The free legs and J / L over boxes of poses, thousands at once, in balls of doubles.

A box is given by its middle and half widths in α, θ and a number: L, or its inverse ε = 1 / L, where all is
divided by L, so that ε = 0 is nothing special. Values at the middle and slopes over the whole box bound what
is asked for (mean value theorem; mathematics.md#functions-on-boxes). Lengths are in a unit in which none
exceeds 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes.balls import UP, Balls, padded
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Gradient, LegSlopes, Waves, cross, singularity
from rpr_solver.model.slice_map import Leg, SliceMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles: TypeAlias = NDArray[np.float64]

_BITS = 128
"""The precision of what becomes doubles."""


def unit_of(slice_map: SliceMap, most: Fraction) -> Fraction:
    """A power of two that no vector of a leg exceeds, nor this scaled length."""
    squares = [x for leg in (slice_map.f, slice_map.g) for x in (leg.platform2, leg.base2)]
    size = max(Fraction(max(squares)), most**2)
    bits = size.numerator.bit_length() - size.denominator.bit_length() + 1
    return Fraction(2) ** -(-bits // 2)


_ERROR = 2.0**-48
"""More than the rounding of an angle in radians, or of a number, in units of 1."""
_ROUNDING = 2.0**-42
"""More than the rounding of a value at a middle, in units of what bounds it anywhere: each of at most seven
factors is right to 2⁻⁴⁷ of its bound, and less than 2⁷ operations follow."""

Slopes: TypeAlias = tuple[Balls, Balls, Balls]
"""Derivatives by α, θ and the number."""


@dataclass(frozen=True)
class LegOver:
    """A leg over boxes; midpoints are values at the middles of boxes.

    Attributes:
        value: half the squared length, less (L² + |m|² + |a|²) / 2; or that divided by L.
        slopes: f_α and φ, with their derivatives by α and θ.
        rise: the derivatives of the value.
        by_number: the derivative of J / L by the number is the cross product of these for both legs.
    """

    value: Balls
    slopes: LegSlopes
    rise: Slopes
    by_number: Gradient

    @classmethod
    def of(cls, leg: Waves, turns: Sequence[PlaneNumber[Balls]], number: Balls, inverse: bool) -> LegOver:
        """A leg where its waves turn so, and the number is L or its inverse."""
        own = leg.turned(*turns)
        if inverse:
            small = own.shrunk(number)
            slopes = small.slopes()
            return cls(small.value(), slopes, (*slopes[0], -own.r), (own.w, own.q + own.d))
        slopes = own.slopes(number)
        rise = slopes[0][0], number * slopes[0][1], own.by_length
        return cls(own.value(number), slopes, rise, own.slopes_by_length)


def singularity_over(f: LegOver, g: LegOver) -> tuple[Balls, Slopes]:
    """J / L over boxes, and its derivatives."""
    j, by_alpha, by_theta = singularity(f.slopes, g.slopes)
    return j, (by_alpha, by_theta, cross(f.by_number, g.by_number))


@dataclass(frozen=True)
class LegsInBalls:
    """The free legs of a manipulator, and for lengths or inverse lengths up to 1 bounds of what follows from
    them.

    Attributes:
        waves: of both, at α = θ = 0.
        constants: (|m|² + |a|²) / 2.
        sizes: bounds of |m| and |a|.
        is_one: whether it is one manipulator; else all those with waves in the balls.
    """

    waves: tuple[Waves, Waves]
    constants: tuple[Balls, Balls]
    sizes: tuple[tuple[float, float], tuple[float, float]]
    is_one: bool = True

    @classmethod
    def around(cls, points: Sequence[tuple[PlaneNumber[arb], PlaneNumber[arb]]]) -> LegsInBalls:
        """All manipulators whose m and a, for both legs, are in these balls; in a unit that none exceeds."""
        waves, constants, sizes = [], [], []
        for m, a in points:
            squares = [z.real * z.real + z.imag * z.imag for z in (m, a)]
            own = [PlaneNumber(Balls.of([z.real]), Balls.of([z.imag])) for z in (m, a)]
            waves.append(Waves.of(*own))
            constants.append(Balls.of([(squares[0] + squares[1]) / 2]))
            platform, base = (float(square.upper().sqrt().upper()) * UP for square in squares)
            sizes.append((platform, base))
        return cls((waves[0], waves[1]), (constants[0], constants[1]), (sizes[0], sizes[1]), is_one=False)

    @classmethod
    def of(cls, slice_map: SliceMap, unit: Fraction) -> LegsInBalls:
        """Those in a unit of scaled lengths."""
        with ctx.workprec(_BITS):
            omega, unit_ball = omega_ball(slice_map.radicand, ctx.prec), ball_of(unit)
            own = [_leg(leg, omega, unit, unit_ball) for leg in (slice_map.f, slice_map.g)]
        waves, constants, sizes = zip(*own, strict=True)
        return cls(waves, constants, sizes)

    @cached_property
    def bounds(self) -> dict[bool, tuple[LegOver, LegOver]]:
        """Balls about 0 that hold all that follows from the legs, for lengths, and for their inverses."""
        one = Balls(np.zeros(1), np.ones(1))
        turns = [PlaneNumber(one, one)] * 3
        found = {}
        for inverse in (False, True):
            f, g = (LegOver.of(waves, turns, one, inverse) for waves in self.waves)
            found[inverse] = f, g
        return found


def _leg(leg: Leg, omega: arb, unit: Fraction, size: arb) -> tuple[Waves, Balls, tuple[float, float]]:
    m, a = (PlaneNumber(Balls.of([x.real / size]), Balls.of([x.imag / size])) for x in leg.points(omega))
    constant = Balls.of([ball_of((leg.platform2 + leg.base2) / (2 * unit**2))])
    platform, base = ((arb(x).sqrt() / size).upper() for x in (leg.platform2, leg.base2))
    return Waves.of(m, a), constant, (float(platform) * UP, float(base) * UP)


@dataclass(frozen=True)
class PoseBoxes:
    """Boxes of poses.

    Attributes:
        model: the legs.
        sides: for each coordinate a ball that holds all of it.
        inverse: whether the numbers are those of 1 / L.
    """

    model: LegsInBalls
    sides: tuple[Balls, Balls, Balls]
    inverse: bool = False

    @classmethod
    def of(
        cls,
        model: LegsInBalls,
        middles: Sequence[Doubles],
        halves: Sequence[Doubles],
        *,
        inverse: bool = False,
    ) -> PoseBoxes:
        """Boxes by their middles and half widths."""
        x, y, z = (Balls(a, padded(b + _ERROR)) for a, b in zip(middles, halves, strict=True))
        return cls(model, (x, y, z), inverse)

    @cached_property
    def legs(self) -> tuple[LegOver, LegOver]:
        """Both legs over the boxes."""
        return self._legs_over(self.sides)

    @cached_property
    def _at_middles(self) -> tuple[LegOver, LegOver] | None:
        """Both legs at the middles, for all manipulators; None if there is one, of which they are known."""
        if self.model.is_one:
            return None
        x, y, z = (Balls.exact(side.mid) for side in self.sides)
        return self._legs_over((x, y, z))

    def _legs_over(self, sides: tuple[Balls, Balls, Balls]) -> tuple[LegOver, LegOver]:
        alpha, theta, number = sides
        turns = [PlaneNumber(*x.sin_cos()[::-1]) for x in (alpha - theta, theta, alpha)]
        f, g = (LegOver.of(waves, turns, number, self.inverse) for waves in self.model.waves)
        return f, g

    @cached_property
    def singularity(self) -> tuple[Balls, Slopes]:
        """J / L at the middles, and means of its derivatives between them and any point of their boxes."""
        middles = self._at_middles
        return self._from_middles(
            singularity_over(*self.legs),
            singularity_over(*self.model.bounds[self.inverse]),
            None if middles is None else singularity_over(*middles),
        )

    def value(self, leg: int) -> tuple[Balls, Slopes]:
        """The same for the value of a leg."""
        own, most = self.legs[leg], self.model.bounds[self.inverse][leg]
        middle = None if self._at_middles is None else self._at_middles[leg]
        return self._from_middles(
            (own.value, own.rise),
            (most.value, most.rise),
            None if middle is None else (middle.value, middle.rise),
        )

    @staticmethod
    def _from_middles(
        over: tuple[Balls, Slopes], bounds: tuple[Balls, Slopes], middles: tuple[Balls, Slopes] | None
    ) -> tuple[Balls, Slopes]:
        """Values and means from balls over boxes.

        The radius over boxes with half widths times t is a polynomial in t without negative coefficients,
        plus roundings, so that its mean for 0 ≤ t ≤ 1 is at most half of what it is at the ends together. At
        t = 0 it is 0 for one manipulator.
        """
        (value, slopes), (most, steepest) = over, bounds
        first, starts = np.zeros(1), [np.zeros(1)] * 3
        if middles is not None:
            first, starts = middles[0].rad, [x.rad for x in middles[1]]
        x, y, z = (
            Balls(own.mid, padded(0.5 * own.rad + 0.5 * start + _ROUNDING * bound.rad))
            for own, bound, start in zip(slopes, steepest, starts, strict=True)
        )
        return Balls(value.mid, padded(first + _ROUNDING * most.rad + 0 * value.mid)), (x, y, z)

    def over(self, value: Balls, slopes: Slopes) -> Balls:
        """All values on the boxes, from those at the middles and the means of derivatives."""
        far = [padded((abs(s.mid) + s.rad) * side.rad) for s, side in zip(slopes, self.sides, strict=True)]
        return Balls(value.mid, padded(value.rad + far[0] + far[1] + far[2]))
