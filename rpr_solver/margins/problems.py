"""Boxes of geometries and lengths of the fixed leg, in doubles: what the proofs of this folder are about."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, nextafter
from typing import TYPE_CHECKING, Any

import numpy as np

from rpr_solver.exact.turns import TURN
from rpr_solver.margins import LENGTHS
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator

if TYPE_CHECKING:
    from rpr_solver.margins.slopes import Doubles

ANGLES = 2


@dataclass(frozen=True)
class Span:
    """Bounds of a number, as doubles."""

    low: float
    high: float

    @classmethod
    def of(cls, low: Fraction, high: Fraction) -> Span:
        """The narrowest span that holds two rationals and those between."""
        below, above = float(low), float(high)
        return cls(
            below if below <= low else nextafter(below, -inf),
            above if above >= high else nextafter(above, inf),
        )

    @property
    def is_one_number(self) -> bool:
        """Whether there is no double between the bounds."""
        return self.high <= nextafter(self.low, inf)

    @property
    def middle(self) -> float:
        """A double between the bounds."""
        return (self.low + self.high) / 2


@dataclass(frozen=True)
class Limit:
    """The least (side −1) or greatest (side 1) length of leg f (0) or g (1), squared."""

    leg: int
    side: int
    square: Span


@dataclass(frozen=True)
class Problem:
    """A box of geometries, and the lengths of the fixed leg; all in a unit that makes them at most 1.

    Attributes:
        fixed_leg: 1, 2 or 3.
        orientation: 1, −1, or 0 for a platform that is flat throughout.
        lengths: bounds of each of LENGTHS.
        fixed: bounds of the fixed leg's length, of its inverse, or of the length where ``drift`` begins.
        inverse: whether ``fixed`` bounds the inverse.
        drift: how fast the fixed leg's length is to change with each of LENGTHS, from their middles.
        limits: lengths of the moving legs that no cusp should pass.
        unit: the unit, in the user's; an inverse is that of the length in it.
    """

    fixed_leg: int
    orientation: int
    lengths: tuple[Span, ...]
    fixed: Span
    inverse: bool = False
    drift: tuple[float, ...] = (0.0,) * 6
    limits: tuple[Limit, ...] = ()
    unit: Fraction = Fraction(1)

    @property
    def spans(self) -> tuple[Span, ...]:
        """Those of the fixed leg and of LENGTHS."""
        return self.fixed, *self.lengths

    @cached_property
    def rows(self) -> dict[int, int]:
        """Place in ``spans`` → row in a box, for those that vary."""
        varying = [place for place, span in enumerate(self.spans) if not span.is_one_number]
        return {place: ANGLES + k for k, place in enumerate(varying)}

    @property
    def size(self) -> int:
        """The number of variables of a box: α, θ, and the others that vary."""
        return ANGLES + len(self.rows)

    def grid(self, parts: int) -> tuple[Doubles, Doubles]:
        """Lower and upper ends of boxes that cover the problem, the torus cut in ``parts`` × ``parts``."""

        step = TURN // parts
        places = np.arange(parts) * float(step)
        low, high = (np.empty((self.size, parts * parts)) for _ in range(2))
        low[0], low[1] = np.repeat(places, parts), np.tile(places, parts)
        high[:ANGLES] = low[:ANGLES] + step
        for place, row in self.rows.items():
            low[row], high[row] = self.spans[place].low, self.spans[place].high
        return low, high

    def systems(self, ring: Any, order: int) -> Systems:
        """The functions in a BoxRing or an ExpansionRing, K with its derivatives up to an order."""
        fixed, *lengths = (ring.number(place) for place in range(len(self.spans)))
        for place, (length, rate) in enumerate(zip(lengths, self.drift, strict=True)):
            if rate:
                middle = ring.constant(self.lengths[place].middle)
                fixed = fixed + (length - middle) * ring.constant(rate)
        legs = moving_legs(lengths, self.orientation, self.fixed_leg, ring.refine_one, ring.named)
        scales = (1, fixed) if self.inverse else (fixed, 1)
        alpha, theta, between = ring.turns()
        return Systems(alpha, theta, between, scales, legs, order, ring.refine)


@dataclass(frozen=True)
class GeometryBox:
    """The geometries within a radius, as problems of exclusion."""

    manipulator: Manipulator
    fixed_leg: int
    radius: Fraction
    weights: Sequence[Fraction]

    def at(self, length: Fraction) -> Problem:
        """Slices of one length."""
        return self._problem(length, (length, length))

    def over(self, start: Fraction, stop: Fraction | None, limits: Mapping[int, Bounds]) -> list[Problem]:
        """Slices of a range of lengths, from a length that exceeds all others on by their inverses."""
        if stop is not None:
            return [self._problem(stop, (start, stop), limits=limits)]
        turn = self.turn(start, limits)
        near = [self._problem(turn, (start, turn), limits=limits)] if start < turn else []
        if any(most is not None for _, most in limits.values()):
            return near  # beyond, all legs are too long
        unit = self._unit(turn)
        return [*near, self._problem(turn, (Fraction(0), unit * unit / turn), inverse=True)]

    def turn(self, start: Fraction, limits: Mapping[int, Bounds]) -> Fraction:
        """A length that exceeds all others so far that beyond it the moving legs do, too."""
        far = 4 * sum((abs(x) + self.radius * w for x, w in self._lengths()), Fraction(0))
        return max(far + sum(bound or 0 for bounds in limits.values() for bound in bounds), start)

    def _lengths(self) -> Iterator[tuple[Fraction, Fraction]]:
        return ((getattr(self.manipulator, g), w) for g, w in zip(LENGTHS, self.weights, strict=True))

    def _unit(self, length: Fraction) -> Fraction:
        """A power of 2 that exceeds all lengths."""
        longest = max(length, *(abs(x) + self.radius * w for x, w in self._lengths()))
        return Fraction(2) ** (longest.numerator.bit_length() - longest.denominator.bit_length() + 1)

    def _problem(
        self,
        longest: Fraction,
        fixed: tuple[Fraction, Fraction],
        *,
        inverse: bool = False,
        limits: Mapping[int, Bounds] | None = None,
    ) -> Problem:
        unit = self._unit(longest)
        spans = tuple(
            Span.of((x - self.radius * w) / unit, (x + self.radius * w) / unit) for x, w in self._lengths()
        )
        free = free_legs(self.fixed_leg)
        bounds = tuple(
            Limit(free.index(leg), side, Span.of(*(((bound / unit) ** 2,) * 2)))
            for leg, both in (limits or {}).items()
            for side, bound in zip((-1, 1), both, strict=True)
            if bound is not None
        )
        return Problem(
            self.fixed_leg,
            orientation_of(self.manipulator),
            spans,
            Span.of(*(x / unit for x in fixed)),
            inverse=inverse,
            limits=bounds,
            unit=unit,
        )


def validity(manipulator: Manipulator, weights: Sequence[Fraction]) -> Fraction | None:
    """The radius at which the first geometry is flat, or no manipulator; None if there is none."""
    w = dict(zip(LENGTHS, weights, strict=True))
    m = manipulator
    sides = ("d1", "d2", "d3")
    whole, weight = m.d1 + m.d2 + m.d3, w["d1"] + w["d2"] + w["d3"]
    radii = [_ratio(whole - 2 * getattr(m, d), weight) for d in sides]
    radii.append(_ratio(abs(m.a2x), w["a2x"]))
    # two base points coincide where both coordinates do
    height = _ratio(abs(m.a3y), w["a3y"])
    for distance, change in ((m.a3x, w["a3x"]), (m.a3x - m.a2x, w["a3x"] + w["a2x"])):
        width = _ratio(abs(distance), change) if distance else Fraction(0)
        radii.append(None if width is None or height is None else max(width, height))
    return min((radius for radius in radii if radius is not None), default=None)


def _ratio(distance: Fraction, weight: Fraction) -> Fraction | None:
    """How often the weight fits into a distance; None if it never covers it."""
    return distance / weight if weight else None
