"""The motion along a path within limits of speed, acceleration and jerk of each leg.

Where two arcs of a path meet at an angle no leg could go on without a jump of its speed, and where their
curvatures are not the same the acceleration jumps: the motion rests at corners, and with limits of jerk at
all ends of arcs. Arcs that meet with one tangent, by their exact control points, are one run otherwise: one
parameter leads through them, whose share of each arc makes the derivatives of both sides agree.

On a run its parameter τ is a function of time. A law is proposed in floats: on pieces of the run the speed
of τ is as great as bounds of the derivatives of the leg lengths allow, and it rises and falls as fast as they
allow (forwards, then backwards, as in time-optimal path parameterization). It is checked exactly
(mathematics.md#motions-within-limits). With limits of jerk it is averaged
over a window of time, so that the acceleration is continuous.

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

import numpy as np

from rpr_solver.exact.decimals import quotient, rounded_up
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.lengths import MotionLimits
from rpr_solver.paths.rates import PIECES, ArcRates, greatest, multiplied, rates_of
from rpr_solver.paths.routes import DecimalPose, Route
from rpr_solver.paths.timing import NO_DEVIATION, Deviation, Place

_TICKS = 96
"""Of a run of one arc, in which the speed of a law is linear."""
_WINDOWS = (6, 12, 24, 48)
"""The lengths of the windows that are tried."""
_UNIT = 10**6
"""The greatest speed of a law, in its own unit."""
_POWERS = (1, 2, 2, 3, 3, 3)
"""Of the unit of time in the needs."""
_LEAST = Fraction(1, 10**30)
"""The least time of a tick, where nothing moves."""
_NEGLIGIBLE = 1e-60
"""Needs below this share of the greatest are proposed as if they were this share."""
_SHORT = 6
"""The significant digits of the time that a tick takes."""


Needs: TypeAlias = tuple[tuple[Any, ...], ...]
"""For each leg that moves its rates divided by its limits: L′/v; L″/a, L′/a; L‴/j, L″/j, L′/j. Fractions for
proofs, floats for proposals."""


@dataclass(frozen=True)
class Law:
    """τ as a function of time on one run, in ticks: its places, speeds and accelerations at their starts, and
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
class _Needs:
    """What a run needs on each of its pieces: rates relative to limits."""

    rates: ArcRates
    pieces: tuple[Needs, ...]

    @classmethod
    def of(cls, rates: ArcRates, limits: MotionLimits) -> _Needs:
        """Those of the legs that move, exact."""

        def needs(leg: int, first: Fraction, second: Fraction, third: Fraction) -> tuple[Fraction, ...]:
            speed, acceleration = limits.speed[leg], limits.acceleration[leg]
            jerk = () if limits.jerk is None else [x / limits.jerk[leg] for x in (third, second, first)]
            return first / speed, second / acceleration, first / acceleration, *jerk

        return cls(
            rates,
            tuple(
                tuple(needs(leg, *own) for leg, own in enumerate(piece, 1) if any(own))
                for piece in rates.pieces
            ),
        )

    def scaled(self) -> _Needs:
        """The same in floats, and in a unit of time in which none is great."""
        flat = [needs for piece in self.pieces for needs in piece]
        roots = (_root_up(max(needs[k] for needs in flat), n) for k, n in enumerate(_POWERS[: len(flat[0])]))
        unit = max(roots)
        powers = [unit**n for n in _POWERS]
        return _Needs(
            self.rates,
            tuple(tuple(tuple(map(_share, needs, powers)) for needs in piece) for piece in self.pieces),
        )

    def powers(self, peaks: Iterable[Sequence[Any]]) -> list[Any]:
        """The least time of a tick that keeps the speed, its square for the acceleration, its cube."""
        found = [0, 0, 0]
        for low, high, u, a, j in peaks:
            for needs in {own for piece in self.pieces[self.rates.meeting(low, high)] for own in piece}:
                found[0] = max(found[0], needs[0] * u)
                found[1] = max(found[1], needs[1] * u * u + needs[2] * a)
                if len(needs) > 3:
                    found[2] = max(found[2], needs[3] * u**3 + 3 * needs[4] * u * a + needs[5] * j)
        return found

    def speeds(self) -> list[float]:
        """The greatest speeds of τ at the ends of pieces, by floats."""
        squares = [0.0, *([inf] * (len(self.pieces) - 1)), 0.0]
        sizes = self._sizes
        for k, piece in enumerate(self.pieces):
            most = min((_most_square(needs) for needs in piece), default=inf)
            squares[k], squares[k + 1] = min(squares[k], most), min(squares[k + 1], most)
        # on a piece the square is linear in τ; the greater end is bounded by the lesser one
        for order in (range(len(self.pieces)), range(len(self.pieces))[::-1]):
            for k in order:
                before, after = (k, k + 1) if order.step > 0 else (k + 1, k)
                for _, bend, slope, *_ in self.pieces[k]:
                    most = (slope * squares[before] + 2 * sizes[k]) / (slope + 2 * bend * sizes[k])
                    squares[after] = min(squares[after], most)
        return [sqrt(x) for x in squares]

    def law(self) -> Law:
        """A law that goes about as fast as can be."""
        speeds = self.speeds()
        ways = zip(self._sizes, pairwise(speeds), strict=True)
        times = [0.0, *accumulate(2 * size / (x + y) for size, (x, y) in ways)]
        count = _TICKS * ceil(sqrt(len(self.pieces) / PIECES))
        ticks = [times[-1] * k / count for k in range(1, count)]
        chosen: list[float] = [0.0, *np.interp(ticks, times, speeds).tolist(), 0.0]
        whole = tuple(round(_UNIT * x / max(chosen)) for x in chosen)
        if len(self.pieces[0][0]) == len(_POWERS):
            return min((Law(whole, window) for window in _WINDOWS), key=self._time)
        return Law(whole, 1)

    @cached_property
    def _sizes(self) -> list[float]:
        return [double(y - x) for x, y in pairwise(self.rates.marks)]

    def _time(self, law: Law) -> float:
        powers = self.powers(list(map(double, peak)) for peak in law.peaks())
        longest: float = max(x ** (1 / n) for n, x in enumerate(powers, 1))
        return (len(law.nodes) - 1) * longest


def _share(need: Fraction, power: Fraction) -> float:
    return max(double(need / power), _NEGLIGIBLE) if need else 0.0


def _most_square(needs: Sequence[float]) -> float:
    """The greatest square of a speed by the limits of speed, of acceleration and of jerk, each alone."""
    speed, bend, _, *jerk = needs
    most = min(1 / speed**2 if speed else inf, 1 / bend if bend else inf)
    return min(most, (1 / jerk[0]) ** (2 / 3)) if jerk and jerk[0] else most


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
class RunMotion:
    """The motion on one run, from rest to rest.

    Attributes:
        law: its parameter as a function of time.
        tick: the time that a tick takes.
        rates: the bounds of its legs.
        shares: of its arcs in the parameter.
    """

    law: Law
    tick: Fraction
    rates: ArcRates
    shares: tuple[Fraction, ...]

    @classmethod
    def of(cls, arcs: Sequence[ArcRates], shares: Sequence[Fraction], limits: MotionLimits) -> RunMotion:
        """The motion that is proved to keep the limits."""
        rates = ArcRates.joined(arcs, shares)
        needs = _Needs.of(rates, limits)
        law = needs.scaled().law()
        powers = needs.powers(law.peaks())
        return cls(law, max(_root_up(x, n) for n, x in enumerate(powers, 1)), rates, tuple(shares))

    @property
    def duration(self) -> Fraction:
        """The time from rest to rest."""
        return (len(self.law.nodes) - 1) * self.tick

    @cached_property
    def bends(self) -> list[tuple[Fraction, ...]]:
        """For each tick bounds of the accelerations of the legs."""
        return [
            tuple(
                (bend * u * u + slope * a) / self.tick**2 for slope, bend, _ in self.rates.between(low, high)
            )
            for low, high, u, a, _ in self.law.peaks()
        ]

    def place(self, time: Fraction) -> tuple[int, Fraction]:
        """The number of the arc, from 0 in this run, and τ on it."""
        at, arc = self.law.at(time / self.tick), 0
        while arc + 1 < len(self.shares) and at >= self.shares[arc]:
            at -= self.shares[arc]
            arc += 1
        return arc, at / self.shares[arc]


@dataclass(frozen=True)
class Motion:
    """The motion along all arcs of a path, at rest at the ends of each run.

    Attributes:
        limits: those that it is proved to keep.
        rates: bounds of the legs on each arc.
        runs: the motion on each run.
    """

    limits: MotionLimits
    rates: tuple[ArcRates, ...]
    runs: tuple[RunMotion, ...]

    @classmethod
    def of(cls, route: Route, limits: MotionLimits) -> Motion:
        """The motion along a path.

        Raises:
            InputError: a leg that moves has no limit.
            Unproved: a leg is too near to length zero.
        """
        rates, runs, first = rates_of(route), [], 0
        limits.check([leg for leg in (1, 2, 3) if any(any(arc.all[leg - 1]) for arc in rates)])
        for shares in runs_of(route, is_smooth=limits.jerk is not None):
            last = first + len(shares)
            runs.append(RunMotion.of(rates[first:last], shares, limits))
            first = last
        return cls(limits, rates, tuple(runs))

    @cached_property
    def starts(self) -> tuple[Fraction, ...]:
        """The times at which the runs begin, and that at which the last one ends."""
        return Fraction(0), *accumulate(run.duration for run in self.runs)

    @property
    def duration(self) -> Fraction:
        """The time of its end."""
        return self.starts[-1]

    def place(self, time: Fraction) -> tuple[int, Fraction]:
        """The number of the arc and τ at a time."""
        number = min(bisect_right(self.starts, time), len(self.runs)) - 1
        arc, tau = self.runs[number].place(time - self.starts[number])
        return arc + sum(len(run.shares) for run in self.runs[:number]), tau

    def deviation(self, times: tuple[Fraction, Fraction], ends: tuple[Place, Place]) -> Deviation:
        """Bounds of what its legs deviate between two times from linear motion between two places: by the
        accelerations, and by what the places differ from those at the times."""
        bends = []
        for start, run in zip(self.starts, self.runs, strict=False):
            first, last = (max((time - start) / run.tick, Fraction(0)) for time in times)
            bends += run.bends[floor(first) : ceil(last)]
        slips = [NO_DEVIATION]
        for time, (arc, tau) in zip(times, ends, strict=True):
            own, exact = self.place(time)
            if off := abs(own + exact - arc - Fraction(tau)):
                both = greatest([self.rates[k].all for k in (own, arc)])
                slips.append(multiplied([rates[0] for rates in both], [off] * 3))
        share = (times[1] - times[0]) ** 2 / 8
        return tuple(share * max(x[k] for x in bends) + max(x[k] for x in slips) for k in range(3))

    def to_json(self) -> dict[str, Any]:
        """The limits, and the times at which the legs rest on the way."""
        return {**self.limits.to_json(), "stops": [exact_str(time) for time in self.starts[1:-1]]}

    def certificate(self) -> list[dict[str, Any]]:
        """The laws of all runs."""
        return [
            {
                "shares": [exact_str(share) for share in run.shares],
                "tick": exact_str(run.tick),
                "speeds": list(run.law.speeds),
                "window": run.law.window,
            }
            for run in self.runs
        ]


def runs_of(route: Route, *, is_smooth: bool) -> Iterator[list[Fraction]]:
    """The shares of the arcs of each run; each arc is a run if the acceleration must be continuous."""
    widths = [Fraction(1)]
    for arc, following in pairwise(route.arcs):
        ratio = None if is_smooth else _ratio(arc, following)
        if ratio is None:
            yield [width / sum(widths) for width in widths]
            widths = [Fraction(1)]
        else:
            widths.append(widths[-1] * ratio)
    yield [width / sum(widths) for width in widths]


def _ratio(arc: Sequence[DecimalPose | None], following: Sequence[DecimalPose | None]) -> Fraction | None:
    """The derivative at the start of an arc divided by that at the end of the one before, both exact; None if
    they have no common direction, or are not known exactly."""
    if arc[-2] is None or arc[-1] is None or following[1] is None:
        return None
    before, joint, after = ((p.alpha_deg, p.theta_deg, p.length) for p in (arc[-2], arc[-1], following[1]))
    ends = [(len(arc) - 1) * (y - x) for x, y in zip(before, joint, strict=True)]
    starts = [(len(following) - 1) * (y - x) for x, y in zip(joint, after, strict=True)]
    ratio = next((y / x for x, y in zip(ends, starts, strict=True) if x), Fraction(0))
    return ratio if ratio > 0 and starts == [ratio * x for x in ends] else None
