"""A path in time: where it is at each time, what its legs deviate from linear motion between two times, and
how fast their lengths change along the arcs: proved bounds of their derivatives by τ.

On a piece of half-width r about τ the k-th Taylor coefficient of a leg length lies in
cₖ(τ) + (k + 1) cₖ₊₁(piece) [−r, r], which is narrower than cₖ(piece) (mean value theorem).

Without limits of motion a law of time covers the arc length in joint space. It only chooses points of the
proved path, and floats are enough for that. The deviation is then that of the way: a leg length between
two points of an arc differs from its chord by at most Δτ²/8 |L″|. With limits of motion
(:mod:`rpr_solver.paths.motion`) the law is exact, and the deviation is that at the same time: at most
Δt²/8 |L̈|, also where arcs meet, since their speeds have no jumps
(mathematics.md#linear-motion-between-samples).
"""

from __future__ import annotations

import cmath
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from math import cos, dist, pi
from typing import Protocol, TypeAlias

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.numerals import double
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PROOF_BITS
from rpr_solver.paths.routes import Arc, Route, by_leg, expanded, local_map

_CHORDS = 96
_RAMP = 1 / 3


def cosine(time: float) -> float:
    """The distance covered after a share of the time: speed rises and falls as half a sine wave.

    >>> [round(cosine(time), 3) for time in (0.0, 0.1, 0.5, 1.0)]
    [0.0, 0.024, 0.5, 1.0]
    """
    return (1 - cos(pi * time)) / 2


def trapezoid(time: float) -> float:
    """As :func:`cosine`, with constant acceleration for a third of the time, then constant speed, then
    constant deceleration.

    >>> trapezoid(0.0), trapezoid(0.5), trapezoid(1.0)
    (0.0, 0.5, 1.0)
    """
    if time > 0.5:
        return 1 - trapezoid(1 - time)
    speed = 1 / (1 - _RAMP)
    return speed * (time**2 / (2 * _RAMP) if time < _RAMP else time - _RAMP / 2)


def constant(time: float) -> float:
    """As :func:`cosine`, with constant speed.

    >>> constant(0.25)
    0.25
    """
    return time


TIMINGS: Mapping[str, Callable[[float], float]] = {
    "cosine": cosine,
    "trapezoid": trapezoid,
    "constant": constant,
}
"""The laws of time by name."""

Joint = Callable[[int, float], tuple[float, float, float]]
"""The leg lengths at a parameter of an arc, of which the number is given."""
Place: TypeAlias = tuple[int, "Fraction | float"]
"""The number of an arc, and τ."""
Deviation: TypeAlias = tuple[Fraction, ...]
"""Bounds for L1, L2 and L3, in the user's unit."""
NO_DEVIATION: Deviation = (Fraction(0),) * 3


def joint_of(slice_map: SliceMap, arcs: Sequence[Arc]) -> Joint:
    """The leg lengths along the arcs as floats, in a unit in which none is too large or too small for one.

    All units are powers of two, so that no rounding depends on them.
    """
    legs = slice_map.f, slice_map.g
    size = max(leg.size for leg in legs) + fraction_of(abs(arcs[0].length[0]).mid())
    unit = _power_of_two(size)
    scale = double(slice_map.scale / _power_of_two(Fraction(slice_map.scale)))
    points = [leg.doubles(unit) for leg in legs]
    lengths = [[double(fraction_of(c.mid()) / unit) for c in arc.length] for arc in arcs]
    angles = [[[float(c.mid()) for c in p] for p in (arc.alpha, arc.theta)] for arc in arcs]

    def joint(number: int, tau: float) -> tuple[float, float, float]:
        alpha, theta, length = (
            sum(c * tau**k for k, c in enumerate(p)) for p in (*angles[number], lengths[number])
        )
        tip, turn = cmath.rect(length, theta), cmath.rect(1, alpha)
        first, second = (abs(tip + turn * platform - base) for platform, base in points)
        return length / scale, first / scale, second / scale

    return joint


def _power_of_two(x: Fraction) -> Fraction:
    """A power of two near a number > 0."""
    return Fraction(2) ** (x.numerator.bit_length() - x.denominator.bit_length())


def places(joint: Joint, arcs: int) -> Callable[[float], tuple[int, float]]:
    """The arc and its parameter at which a share of the whole arc length is covered."""
    nodes = [(arc, k / _CHORDS) for arc in range(arcs) for k in range(_CHORDS + 1)]
    points = [joint(*node) for node in nodes]
    lengths = [dist(p, q) for p, q in pairwise(points)]
    covered = [0.0, *accumulate(lengths)]

    def place(share: float) -> tuple[int, float]:
        goal = share * covered[-1]
        k = min(max(bisect_right(covered, goal) - 1, 0), len(nodes) - 2)
        (arc, tau), (next_arc, next_tau) = nodes[k], nodes[k + 1]
        if arc != next_arc:
            return next_arc, next_tau
        part = (goal - covered[k]) / lengths[k] if lengths[k] else 0.0
        return arc, tau + min(max(part, 0.0), 1.0) * (next_tau - tau)

    return place


class Course(Protocol):
    """A path in time."""

    @property
    def duration(self) -> Fraction:
        """The time of its end."""

    def place(self, time: Fraction) -> Place:
        """Where it is at a time."""

    def deviation(self, times: tuple[Fraction, Fraction], ends: tuple[Place, Place]) -> Deviation:
        """Bounds of what its legs deviate between two times from linear motion between their places."""


PIECES = 32
"""The number of equal pieces of τ of each arc."""
_ORDER = 3
_SMALL, _SMALLEST = Fraction(1, 1 << 11), Fraction(1, 1 << 24)
"""Half the width of the smallest pieces, for better bounds and for any."""
_SHARE = 1 / 16

LegRates: TypeAlias = tuple[Fraction, ...]
"""Upper bounds of |dL/dτ|, |d²L/dτ²| and |d³L/dτ³|, in the user's unit."""
Rates: TypeAlias = tuple[LegRates, ...]
"""Those of leg 1, leg 2 and leg 3."""
_STILL: LegRates = (Fraction(0),) * _ORDER
_EVEN = tuple(Fraction(k, PIECES) for k in range(PIECES + 1))


@dataclass(frozen=True)
class ArcRates:
    """The bounds on each piece of one arc, or of arcs that are run through by one parameter from 0 to 1.

    Attributes:
        pieces: the bounds on pieces.
        marks: the parameters at the ends of the pieces.
    """

    pieces: tuple[Rates, ...]
    marks: tuple[Fraction, ...] = _EVEN

    @classmethod
    def of(cls, slice_map: SliceMap, arc: Arc, *, is_held: bool) -> ArcRates:
        """The bounds of an arc, on which the fixed leg keeps its length if ``is_held``.

        Raises:
            Unproved: a leg is too near to length zero.
        """
        half = Fraction(1, 2 * PIECES)
        with ctx.workprec(PROOF_BITS):
            found = [_on(slice_map, arc, (2 * k + 1) * half, half) for k in range(PIECES)]
        leg = slice_map.fixed_leg
        return cls(tuple(by_leg(leg, [_STILL if is_held else legs[0], *legs[1:]]) for legs in found))

    @classmethod
    def joined(cls, arcs: Sequence[ArcRates], shares: Sequence[Fraction]) -> ArcRates:
        """The bounds of arcs one after another, each on its share of the parameter."""
        pieces, marks, start = [], [Fraction(0)], Fraction(0)
        for arc, share in zip(arcs, shares, strict=True):
            factors = 1 / share, 1 / share**2, 1 / share**3
            pieces += [tuple(multiplied(own, factors) for own in rates) for rates in arc.pieces]
            marks += [start + share * mark for mark in arc.marks[1:]]
            start += share
        return cls(tuple(pieces), tuple(marks))

    def meeting(self, low: Fraction, high: Fraction) -> slice:
        """The pieces that the part low ≤ τ ≤ high meets."""
        first = min(bisect_right(self.marks, low), len(self.pieces)) - 1
        return slice(first, max(bisect_left(self.marks, high), first + 1))

    def between(self, low: Fraction, high: Fraction) -> Rates:
        """The bounds for low ≤ τ ≤ high."""
        return greatest(self.pieces[self.meeting(low, high)])

    @cached_property
    def all(self) -> Rates:
        """The bounds on the whole arc."""
        return greatest(self.pieces)


def multiplied(numbers: Sequence[Fraction], factors: Sequence[Fraction]) -> tuple[Fraction, ...]:
    """Numbers, each times its factor."""
    return tuple(x * factor for x, factor in zip(numbers, factors, strict=True))


def greatest(pieces: Sequence[Rates]) -> Rates:
    """The bounds that hold on all of some pieces."""
    if len(pieces) == 1:
        return pieces[0]
    return tuple(tuple(map(max, *legs)) for legs in zip(*pieces, strict=True))


def rates_of(route: Route) -> tuple[ArcRates, ...]:
    """The bounds of all arcs of a path.

    Raises:
        Unproved: a leg is too near to length zero.
    """
    own = [pose.legs[0] / route.slice_map.scale for pose in (route.start, route.stop)]
    lengths = {*own, *(p.length for arc in route.arcs for p in arc if p is not None)}
    arcs = route.at(PROOF_BITS - 64)
    return tuple(ArcRates.of(route.slice_map, arc, is_held=len(lengths) == 1) for arc in arcs)


def _on(slice_map: SliceMap, arc: Arc, tau: Fraction, half: Fraction) -> Rates:
    """The bounds for the fixed leg and both others at a distance of at most ``half`` from a parameter.

    Where they are much greater than in the middle the piece is halved.
    """
    middle, reach = ball_of(tau), arb(0, ball_of(half).abs_upper())
    near, wide = (_series(slice_map, arc, at, _ORDER + k) for k, at in ((0, middle), (1, middle + reach)))
    scale, found = slice_map.scale_ball(), []
    fastest = max(float(abs(x[1])) for x in near)
    for x, y in zip(near, wide, strict=True):
        bounds = [(abs(x[k] + (k + 1) * y[k + 1] * reach)).upper() for k in range(1, _ORDER + 1)]
        is_finite = all(bound.is_finite() for bound in bounds)
        if half > (_SMALL if is_finite else _SMALLEST) and _are_loose(bounds, (x[1], x[2]), fastest):
            return greatest([_on(slice_map, arc, tau + side * half / 2, half / 2) for side in (-1, 1)])
        if not is_finite:
            raise Unproved("a leg is too short to bound its speed")
        sizes = (factorial * bound / scale for factorial, bound in zip((1, 2, 6), bounds, strict=True))
        found.append(tuple(fraction_of(size.upper()) for size in sizes))
    return tuple(found)


def _are_loose(bounds: Sequence[arb], middle: Sequence[arb], fastest: float) -> bool:
    """Whether the first bounds are infinite, or much greater than the values in the middle."""
    return any(
        not bound.is_finite() or float(bound) > 2 * float(abs(at)) + more
        for bound, at, more in zip(bounds, middle, (_SHARE * fastest, fastest), strict=False)
    )


def _series(slice_map: SliceMap, arc: Arc, tau: arb, order: int) -> list[arb_series]:
    """The Taylor series of the fixed leg and of the others, scaled; over a ball, bounds of them."""
    at = expanded(slice_map, arc, tau, order)
    fixed = arb_series(list(arc.length(arb_poly([tau, 1]))), prec=order + 1)
    return [fixed, (2 * at.first).sqrt(), (2 * at.second).sqrt()]


@dataclass(frozen=True)
class TimedCourse:
    """A path whose arc length is covered by a law of time."""

    route: Route
    timing: str
    duration: Fraction

    def place(self, time: Fraction) -> Place:
        """Where it is at a time."""
        return self._places(TIMINGS[self.timing](double(time / self.duration)))

    def deviation(self, _times: tuple[Fraction, Fraction], ends: tuple[Place, Place]) -> Deviation:
        """By the arcs: each differs from its chord by little, and the polyline of chords from the long one by
        most at a corner."""
        (first, start), (last, stop) = ends
        marks = [Fraction(start), *[Fraction(0)] * (last - first), Fraction(stop)]
        parts = [
            (first + k, low, Fraction(1) if first + k < last else marks[-1])
            for k, low in enumerate(marks[:-1])
        ]
        bounds = [_of_chord(self._rates[arc], low, high) for arc, low, high in parts]
        bent = self._corners([(arc, low) for arc, low, _ in parts], (last, Fraction(stop)))
        return tuple(max(x[k] for x in bounds) + bent[k] for k in range(3))

    def _corners(self, starts: Sequence[tuple[int, Fraction]], end: tuple[int, Fraction]) -> Deviation:
        """What the corners of a polyline deviate from its ends' chord, at shares of its length."""
        if len(starts) == 1:
            return NO_DEVIATION
        with ctx.workprec(PROOF_BITS):
            legs = [self._legs(*place) for place in (*starts, end)]
            ways = [
                float(sum((abs(x - y) for x, y in zip(*pair, strict=True)), arb(0)))
                for pair in pairwise(legs)
            ]
            shares = [Fraction(x / sum(ways)) for x in accumulate(ways[:-1])]
            return tuple(
                max(
                    fraction_of(
                        abs(own[k] - legs[0][k] - ball_of(share) * (legs[-1][k] - legs[0][k])).upper()
                    )
                    for share, own in zip(shares, legs[1:-1], strict=True)
                )
                for k in range(3)
            )

    def _legs(self, arc: int, tau: Fraction) -> tuple[arb, arb, arb]:
        alpha, theta, length = self._arcs[arc].at(ball_of(tau))
        slice_map = self.route.slice_map
        squares = local_map(slice_map, length, (alpha, theta), 0).squared_lengths()
        lengths = [length, *(square.sqrt() for square in squares)]
        return by_leg(slice_map.fixed_leg, [x / slice_map.scale_ball() for x in lengths])

    @cached_property
    def _arcs(self) -> list[Arc]:
        return self.route.at(PROOF_BITS - 64)

    @cached_property
    def _rates(self) -> tuple[ArcRates, ...]:
        return rates_of(self.route)

    @cached_property
    def _places(self) -> Callable[[float], tuple[int, float]]:
        rough = self.route.at(64)
        return places(joint_of(self.route.slice_map, rough), len(rough))


def _of_chord(rates: ArcRates, low: Fraction, high: Fraction) -> Deviation:
    return tuple((high - low) ** 2 / 8 * bend for _, bend, _ in rates.between(low, high))
