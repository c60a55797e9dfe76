"""The motion along a path within limits of speed, acceleration and jerk of each leg.

Two arcs of a path meet at an angle, where no leg could go on without a jump of its speed: the motion rests
there, and at both ends. On an arc, τ is a function of time. A law is proposed in floats: on pieces of the
arc the speed of τ is as great as bounds of the derivatives of the leg lengths allow, and it rises and falls
as fast as they allow (forwards, then backwards, as in time-optimal path parameterization). With limits of
jerk it is averaged over a window of time, so that the acceleration is continuous.

The proof is of the law as it is written, in ticks of equal time: with u, a, j for the derivatives of τ,

    |L̇| ≤ |L′| u,    |L̈| ≤ |L″| u² + |L′| |a|,    |L⃛| ≤ |L‴| u³ + 3 |L″| u |a| + |L′| |j|,

by the bounds of :mod:`rpr_solver.paths.rates` between the places of a tick's ends. A tick takes as long as
the strictest of these needs.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import ROUND_UP
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from math import ceil, floor, inf, sqrt
from typing import Any, TypeAlias

from rpr_solver.exact.decimals import quotient, rounded_up
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.motion_limits import MotionLimits
from rpr_solver.paths.rates import PIECES, ArcRates, pieces_between

_TICKS = 96
"""Of an arc, in which the speed of a law is linear."""
_WINDOWS = (6, 12, 24, 48)
"""The lengths of the windows that are tried."""
_UNIT = 10**6
"""The greatest speed of a law, in its own unit."""
_POWERS = (1, 2, 2, 3, 3, 3)
"""Of the unit of time in the needs."""
_LEAST = Fraction(1, 10**30)
"""The least time of a tick, where nothing moves."""
_SHORT = 6
"""The significant digits of the time that a tick takes."""


Needs: TypeAlias = tuple[tuple[Any, ...], ...]
"""For each leg that moves its rates divided by its limits: L′/v; L″/a, L′/a; L‴/j, L″/j, L′/j. Fractions for
proofs, floats for proposals."""


@dataclass(frozen=True)
class Law:
    """τ as a function of time on one arc, in ticks: its places, speeds and accelerations at their starts, and
    jerks during them; the unit of time is a tick.

    Attributes:
        speeds: those that were proposed, whole numbers, at all ticks; the law is in proportion to them.
        window: the number of ticks over which they are averaged; 1 without limits of jerk.
    """

    speeds: tuple[int, ...]
    window: int

    @cached_property
    def nodes(self) -> tuple[tuple[Fraction, Fraction, Fraction, Fraction], ...]:
        """τ, its speed, its acceleration and its jerk, exact; the last node is at rest at τ = 1."""
        if self.window == 1:
            rises = [y - x for x, y in pairwise(self.speeds)]
            ticks = [(6 * u, 6 * a, 0) for u, a in zip(self.speeds, rises, strict=False)]
        else:
            ticks = list(self._averaged())
        places = [0, *accumulate(u + a // 2 + j // 6 for u, a, j in ticks)]
        whole = places[-1]
        return (
            *(
                (Fraction(s, whole), Fraction(u, whole), Fraction(a, whole), Fraction(j, whole))
                for s, (u, a, j) in zip(places, ticks, strict=False)
            ),
            (Fraction(1), Fraction(0), Fraction(0), Fraction(0)),
        )

    def _averaged(self) -> Iterator[tuple[int, int, int]]:
        """Speed, acceleration and jerk on each tick, times 6 and the window's length."""
        width = self.window
        padded = [*[0] * width, *self.speeds, *[0] * width]
        ways = [0, *accumulate(x + y for x, y in pairwise(padded))]
        rises = [y - x for x, y in zip(padded, padded[width:], strict=False)]
        for k in range(len(self.speeds) - 1 + width):
            yield 3 * (ways[k + width] - ways[k]), 6 * rises[k], 6 * (rises[k + 1] - rises[k])

    def at(self, ticks: Fraction) -> Fraction:
        """τ after a time."""
        k = min(int(ticks), len(self.nodes) - 2)
        x = ticks - k
        s, u, a, j = self.nodes[k]
        return s + x * (u + x * (a / 2 + x * j / 6))

    def peaks(self) -> Iterator[tuple[Fraction, Fraction, Fraction, Fraction, Fraction]]:
        """For each tick the places of its ends, and bounds of speed, acceleration and jerk."""
        for (s, u, a, j), (end, u_end, _, _) in pairwise(self.nodes):
            yield s, end, max(u, u_end) + abs(j) / 8, max(abs(a), abs(a + j)), abs(j)


@dataclass(frozen=True)
class _ArcNeeds:
    """What an arc needs on each of its pieces: rates relative to limits."""

    pieces: tuple[Needs, ...]

    @classmethod
    def of(cls, rates: ArcRates, limits: MotionLimits) -> _ArcNeeds:
        """Those of the legs that move, exact."""

        def needs(leg: int, first: Fraction, second: Fraction, third: Fraction) -> tuple[Fraction, ...]:
            speed, acceleration = limits.speed[leg], limits.acceleration[leg]
            jerk = () if limits.jerk is None else [x / limits.jerk[leg] for x in (third, second, first)]
            return first / speed, second / acceleration, first / acceleration, *jerk

        return cls(
            tuple(
                tuple(needs(leg, *own) for leg, own in enumerate(piece, 1) if any(own))
                for piece in rates.pieces
            )
        )

    def scaled(self) -> _ArcNeeds:
        """The same in floats, and in a unit of time in which none is great."""
        flat = [needs for piece in self.pieces for needs in piece]
        roots = (_root_up(max(needs[k] for needs in flat), n) for k, n in enumerate(_POWERS[: len(flat[0])]))
        unit = max(roots)
        powers = [unit**n for n in _POWERS]
        return _ArcNeeds(
            tuple(
                tuple(tuple(float(x / p) for x, p in zip(needs, powers, strict=False)) for needs in piece)
                for piece in self.pieces
            )
        )

    def powers(self, peaks: Iterable[Sequence[Any]]) -> list[Any]:
        """The least time of a tick that keeps the speed, its square for the acceleration, its cube."""
        found = [0, 0, 0]
        for low, high, u, a, j in peaks:
            for needs in {own for piece in self.pieces[pieces_between(low, high)] for own in piece}:
                found[0] = max(found[0], needs[0] * u)
                found[1] = max(found[1], needs[1] * u * u + needs[2] * a)
                if len(needs) > 3:
                    found[2] = max(found[2], needs[3] * u**3 + 3 * needs[4] * u * a + needs[5] * j)
        return found

    def speeds(self) -> list[float]:
        """The greatest speeds of τ at the ends of pieces, by floats."""
        squares = [0.0, *([inf] * (len(self.pieces) - 1)), 0.0]
        for k, piece in enumerate(self.pieces):
            most = min((_most_square(needs) for needs in piece), default=inf)
            squares[k], squares[k + 1] = min(squares[k], most), min(squares[k + 1], most)
        # on a piece the square is linear in τ; the greater end is bounded by the lesser one
        for order in (range(len(self.pieces)), range(len(self.pieces))[::-1]):
            for k in order:
                before, after = (k, k + 1) if order.step > 0 else (k + 1, k)
                for _, bend, slope, *_ in self.pieces[k]:
                    most = (slope * squares[before] + 2 / PIECES) / (slope + 2 * bend / PIECES)
                    squares[after] = min(squares[after], most)
        return [sqrt(x) for x in squares]

    def law(self) -> Law:
        """A law that goes about as fast as can be."""
        speeds = self.speeds()
        times = [0.0, *accumulate(2 / (PIECES * (x + y)) for x, y in pairwise(speeds))]
        ticks = [times[-1] * k / _TICKS for k in range(1, _TICKS)]
        chosen = [0.0, *(_interpolated(times, speeds, time) for time in ticks), 0.0]
        whole = tuple(round(_UNIT * x / max(chosen)) for x in chosen)
        if len(self.pieces[0][0]) == len(_POWERS):
            return min((Law(whole, window) for window in _WINDOWS), key=self._time)
        return Law(whole, 1)

    def _time(self, law: Law) -> float:
        powers = self.powers([float(x) for x in peak] for peak in law.peaks())
        longest: float = max(x ** (1 / n) for n, x in enumerate(powers, 1))
        return (len(law.nodes) - 1) * longest


def _most_square(needs: Sequence[float]) -> float:
    """The greatest square of a speed by the limits of speed, of acceleration and of jerk, each alone."""
    speed, bend, _, *jerk = needs
    most = min(1 / speed**2 if speed else inf, 1 / bend if bend else inf)
    return min(most, (1 / jerk[0]) ** (2 / 3)) if jerk and jerk[0] else most


def _interpolated(times: Sequence[float], speeds: Sequence[float], time: float) -> float:
    k = min(bisect_right(times, time) - 1, len(times) - 2)
    return speeds[k] + (speeds[k + 1] - speeds[k]) * (time - times[k]) / (times[k + 1] - times[k])


def _root_up(x: Fraction, n: int) -> Fraction:
    """A short number that is not less than the n-th root."""
    if not x:
        return _LEAST
    near = Fraction((quotient(x, 2 * _SHORT, ROUND_UP).ln() / n).exp())
    root = rounded_up(near, _SHORT)
    while root**n < x:
        root = rounded_up(root * (1 + Fraction(1, 10**_SHORT)), _SHORT)
    return root


@dataclass(frozen=True)
class ArcMotion:
    """The motion on one arc: its law, the time that a tick takes, and the bounds of its legs."""

    law: Law
    tick: Fraction
    rates: ArcRates

    @classmethod
    def of(cls, rates: ArcRates, limits: MotionLimits) -> ArcMotion:
        """The motion from rest to rest that is proved to keep the limits."""
        needs = _ArcNeeds.of(rates, limits)
        law = needs.scaled().law()
        powers = needs.powers(law.peaks())
        return cls(law, max(_root_up(x, n) for n, x in enumerate(powers, 1)), rates)

    @property
    def duration(self) -> Fraction:
        """The time from rest to rest."""
        return (len(self.law.nodes) - 1) * self.tick

    @cached_property
    def bends(self) -> list[tuple[Fraction, Fraction, Fraction]]:
        """For each tick bounds of the accelerations of the legs."""
        found = []
        for low, high, u, a, _ in self.law.peaks():
            first, second, third = (
                (bend * u * u + slope * a) / self.tick**2 for slope, bend, _ in self.rates.between(low, high)
            )
            found.append((first, second, third))
        return found


@dataclass(frozen=True)
class Motion:
    """The motion along all arcs of a path, at rest at the ends of each.

    Attributes:
        limits: those that it is proved to keep.
        arcs: the motion on each arc.
    """

    limits: MotionLimits
    arcs: tuple[ArcMotion, ...]

    @classmethod
    def of(cls, rates: Sequence[ArcRates], limits: MotionLimits) -> Motion:
        """The motion on arcs.

        Raises:
            InputError: a leg that moves has no limit.
        """
        limits.check([leg for leg in (1, 2, 3) if any(any(arc.all[leg - 1]) for arc in rates)])
        return cls(limits, tuple(ArcMotion.of(arc, limits) for arc in rates))

    @cached_property
    def starts(self) -> tuple[Fraction, ...]:
        """The times at which the arcs begin, and that at which the last one ends."""
        return Fraction(0), *accumulate(arc.duration for arc in self.arcs)

    def place(self, time: Fraction) -> tuple[int, Fraction]:
        """The number of the arc and τ at a time."""
        arc = min(bisect_right(self.starts, time), len(self.arcs)) - 1
        own = self.arcs[arc]
        return arc, own.law.at((time - self.starts[arc]) / own.tick)

    def bends(self, low: Fraction, high: Fraction) -> tuple[Fraction, Fraction, Fraction]:
        """Bounds of the accelerations of the legs between two times."""
        found = []
        for start, arc in zip(self.starts, self.arcs, strict=False):
            first, last = (max((time - start) / arc.tick, Fraction(0)) for time in (low, high))
            found += arc.bends[floor(first) : ceil(last)]
        one, two, three = (max(bends[k] for bends in found) for k in range(3))
        return one, two, three

    def to_json(self) -> dict[str, Any]:
        """The limits, and the times at which the legs rest between arcs."""
        return {**self.limits.to_json(), "stops": [exact_str(time) for time in self.starts[1:-1]]}

    def certificate(self) -> list[dict[str, Any]]:
        """The laws of all arcs."""
        return [
            {"tick": exact_str(arc.tick), "speeds": list(arc.law.speeds), "window": arc.law.window}
            for arc in self.arcs
        ]
