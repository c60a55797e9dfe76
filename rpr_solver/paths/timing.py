"""The law of time of a path: where it is at each time, and what its legs deviate between two times from
linear motion.

Without limits of motion a law covers the arc length in joint space. It only chooses points of the
proved path, and floats are enough for that. The deviation is then that of the way: a leg length between
two points of an arc differs from its chord by at most Δτ²/8 |L″|. With limits of motion
(:mod:`rpr_solver.paths.motion`) the law is exact, and the deviation is that at the same time: at most
Δt²/8 |L̈|, also where arcs meet, since their speeds have no jumps
(mathematics.md#linear-motion-between-samples).
"""

from __future__ import annotations

import cmath
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from math import cos, dist, pi
from typing import Protocol, TypeAlias

from flint import arb, ctx

from rpr_solver.exact.numerals import double
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PROOF_BITS
from rpr_solver.paths.rates import ArcRates, legs_near, rates_of
from rpr_solver.paths.routes import Arc, Route, by_leg

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
        slice_map = self.route.slice_map
        lengths = legs_near(slice_map, self._arcs[arc], ball_of(tau), 0)
        return by_leg(slice_map.fixed_leg, [x[0] / slice_map.scale_ball() for x in lengths])

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
