"""Boxes of geometries and lengths of the fixed leg, in doubles: what the proofs of this folder are about; and
the functions of systems.py on boxes of poses and geometries, by expansions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, nextafter
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.boxes.sieve import Boxes
from rpr_solver.contract import LENGTHS
from rpr_solver.exact.numerals import double
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.turns import TURN, cos_sin
from rpr_solver.legs import Waves
from rpr_solver.margins.expansions import ANGLES, BY_ANGLES, BY_OTHERS, UNIT, UP, Expansion, layout_of
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of, third_corner
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.expansions import Places
    from rpr_solver.margins.systems import Choice

    Integers = NDArray[np.int64]

_BASE = 3
"""a2x, a3x and a3y come before the sides of the platform."""


@dataclass(frozen=True)
class Span:
    """Bounds of a number, as doubles."""

    low: float
    high: float

    @classmethod
    def of(cls, low: Fraction, high: Fraction) -> Span:
        """The narrowest span that holds two rationals and those between."""
        below, above = double(low), double(high)
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

    def grid(self, parts: int) -> Boxes:
        """Boxes that cover the problem, the torus cut in ``parts`` × ``parts``."""
        step = TURN // parts
        places = np.arange(parts) * float(step)
        low, high = (np.empty((self.size, parts * parts)) for _ in range(2))
        low[0], low[1] = np.repeat(places, parts), np.tile(places, parts)
        high[:ANGLES] = low[:ANGLES] + step
        for place, row in self.rows.items():
            low[row], high[row] = self.spans[place].low, self.spans[place].high
        return Boxes(low, high)

    def systems(self, ring: BoxRing, order: int) -> Systems:
        """The functions in a ring, K with its derivatives up to an order."""
        fixed = ring.number(0)
        for place, rate in enumerate(self.drift):
            if rate:
                change = ring.number(1 + place) - ring.constant(self.lengths[place].middle)
                fixed = fixed + change * ring.constant(rate)
        alike, own = ring.geometries()
        lengths = [alike.number(1 + place) for place in range(len(self.lengths))]
        # what the expansions of the third corner leave out is the same in all functions
        x, y = third_corner(lengths[_BASE:], self.orientation)
        legs = tuple(
            Waves(*(PlaneNumber(z.real.of(own), z.imag.of(own)) for z in leg))
            for leg in moving_legs(lengths, (x.named(0), y.named(1)), self.fixed_leg)
        )
        scales = (1, fixed) if self.inverse else (fixed, 1)
        return Systems(ring.turns(), scales, legs, order, bool(self.limits))

    def tests(
        self, systems: Systems, leg: Choice, constant: Callable[[float], Expansion]
    ) -> list[list[Expansion]]:
        """What should have no zero, with v of one leg: (K, E, S), (K, K_α, K_θ), and (K, E, |leg|² − bound²)
        for each of the limits."""
        tests = [[jet.value for jet in jets] for jets in (systems.swallowtails(leg), systems.critical)]
        k, e, _ = tests[0]
        for limit in self.limits:
            tests.append([k, e, systems.excess(limit.leg, constant(limit.square.low))])
        return tests


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
        far = 4 * sum(self._greatest(), Fraction(0))
        return max(far + sum(bound or 0 for bounds in limits.values() for bound in bounds), start)

    def _lengths(self) -> Iterator[tuple[Fraction, Fraction]]:
        """Bounds of all lengths."""
        for (low, high), w in zip(self.manipulator.bounds(), self.weights, strict=True):
            yield low - self.radius * w, high + self.radius * w

    def _greatest(self) -> Iterator[Fraction]:
        return (max(-low, high) for low, high in self._lengths())

    def _unit(self, length: Fraction) -> Fraction:
        """A power of 2 that exceeds all lengths."""
        longest = max(length, *self._greatest())
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
        spans = tuple(Span.of(low / unit, high / unit) for low, high in self._lengths())
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
    """The radius at which the first geometry is flat, or no manipulator; None if there is none.

    It is a lower bound, which is exact where the lengths are rational.
    """
    w = dict(zip(LENGTHS, weights, strict=True))
    a2x, a3x, a3y, *sides = manipulator.bounds()
    least, weight = sum(low for low, _ in sides), w["d1"] + w["d2"] + w["d3"]
    gaps = [max(least - low - high, Fraction(0)) for low, high in sides]
    if manipulator.area16 == 0:
        gaps[gaps.index(min(gaps))] = Fraction(0)
    radii = [_ratio(gap, weight) for gap in gaps]
    radii.append(_ratio(_least(a2x), w["a2x"]))
    # two base points coincide where both coordinates do
    height = _reach(_least(a3y), w["a3y"])
    between = a3x[0] - a2x[1], a3x[1] - a2x[0]
    for distance, change in ((_least(a3x), w["a3x"]), (_least(between), w["a3x"] + w["a2x"])):
        width = _reach(distance, change)
        radii.append(None if width is None or height is None else max(width, height))
    return min((radius for radius in radii if radius is not None), default=None)


def _least(bounds: tuple[Fraction, Fraction]) -> Fraction:
    """The least absolute value between two bounds."""
    low, high = bounds
    return max(low, -high, Fraction(0))


def _ratio(distance: Fraction, weight: Fraction) -> Fraction | None:
    """How often the weight fits into a distance; None if it never covers it."""
    return distance / weight if weight else None


def _reach(coordinate: Fraction, weight: Fraction) -> Fraction | None:
    """The radius from which on a coordinate may be 0, which it may be already; None if there is none."""
    return _ratio(coordinate, weight) if coordinate else Fraction(0)


_TRIG_ERROR = 16 * UNIT
_FACTORS = np.sin(np.arange(1.0, 2 * len(LENGTHS) + 1))


class BoxRing:
    """The ring of functions with expansions on boxes.

    Attributes:
        middle, half: middles and half widths of the boxes; half widths of angles are in radians.
    """

    def __init__(self, problem: Problem, boxes: Boxes) -> None:
        self._problem = problem
        self.middle = boxes.middle
        self.half = np.maximum(boxes.high - self.middle, self.middle - boxes.low) * UP
        self.half[:ANGLES] *= 2 * np.pi / TURN
        self._layout = layout_of(problem.size)

    def geometries(self) -> tuple[BoxRing, Places]:
        """The ring on boxes with different lengths alone, and which of them each box has."""
        rows = [row for place, row in self._problem.rows.items() if place]
        sides = np.concatenate([self.middle[rows], self.half[rows]])
        # boxes with the same sum are compared, so that any factors will do
        _, first, own = np.unique(_FACTORS[: len(sides)] @ sides, return_index=True, return_inverse=True)
        if not (sides[:, first[own]] == sides).all():
            return self, np.arange(sides.shape[1])
        alike = copy(self)
        alike.middle, alike.half = self.middle[:, first], self.half[:, first]
        return alike, own

    def number(self, place: int) -> Expansion:
        """One of the problem's spans as a function."""
        row = self._problem.rows.get(place)
        if row is None:
            return self.constant(self._problem.spans[place].low)
        function = self._blank(BY_OTHERS)
        function.terms[0], function.terms[1 + row] = self.middle[row], self.half[row]
        return function

    def constant(self, value: float) -> Expansion:
        """A number on all boxes, right to two units of its last place."""
        function = self._blank()
        function.terms[0] = value
        function.rest[:] = 4 * UNIT * abs(value)
        return function

    def turns(self) -> tuple[PlaneNumber[Expansion], ...]:
        """The turns by α, θ and α − θ."""
        alpha, theta = self.middle[:ANGLES].astype(np.int64)
        angles = (alpha, (1, 0)), (theta, (0, 1)), (alpha - theta, (1, -1))
        return tuple(PlaneNumber(*self._turn(angle, signs)) for angle, signs in angles)

    def _turn(self, angle: Integers, signs: tuple[int, int]) -> tuple[Expansion, Expansion]:
        """Cosine and sine of an angle, to which α and θ contribute with these signs."""
        cos, sin = cos_sin(angle)
        a, b = (sign * half for sign, half in zip(signs, self.half, strict=False))
        whole = abs(a) + abs(b)
        functions = []
        for value, slope in ((cos, -sin), (sin, cos)):
            function = self._blank(BY_ANGLES)
            terms, bends = function.terms, function.terms[self._layout.bends]
            terms[0], terms[1], terms[2] = value, slope * a, slope * b
            # the squares of α and θ are where their rows begin, and αθ is after the first
            bends[0], bends[1], bends[self._layout.variables] = (
                -value * a * a / 2,
                -value * a * b,
                -value * b * b / 2,
            )
            function.rest[:] = (whole**3 / 6 + 2 * _TRIG_ERROR * (1 + whole) ** 2) * UP
            functions.append(function)
        return functions[0], functions[1]

    def _blank(self, depends: int = 0) -> Expansion:
        boxes = self.middle.shape[1]
        terms = np.zeros((self._layout.rows, boxes))
        return Expansion(terms, np.zeros(boxes), self._layout, depends=depends)
