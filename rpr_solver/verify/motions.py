"""The motion along a path: that its legs keep their limits at all times.

A law has τ as a function of time in ticks, by whole numbers s₀ = 0, …, sₙ = 0 and a window w: the speed is in
proportion to the piecewise linear function of the values sₖ, or to its mean over the last w ticks. On parts
of ticks the derivatives of the legs by time follow from those by τ (mathematics.md#motions-within-limits).
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

from rpr_solver.verify.arcs import RATE_BITS, LegRates, Series
from rpr_solver.verify.claims import Finding, OpenError, finding
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.numbers import sums
from rpr_solver.verify.core.reader import Record, bits_in, spend, spend_by_digits, spend_exact

KINDS = ("speed", "acceleration", "jerk")
_FIRST_DEPTH, _DEEPEST, _SHORTEST = 4, 20, 1 << 16


class Part(NamedTuple):
    """A part of a tick, between two shares of it."""

    tick: int
    low: Fraction
    high: Fraction
    depth: int

    def finer(self, law: Law) -> tuple[Part, ...]:
        """The part with the legs on pieces half as long; both halves of it, if the pieces are as short as it.

        Raises:
            OpenError: it is too small.
        """
        low, high = (law.at(self.tick, share)[0] for share in (self.low, self.high))
        if (high - low) * (1 << self.depth) < 1:
            if self.depth >= _DEEPEST:
                raise OpenError("pieces of the arcs are so small that it is not decided")
            return (self._replace(depth=self.depth + 1),)
        if (self.high - self.low) * _SHORTEST < 1:
            raise OpenError("parts of ticks are so small that it is not decided")
        middle = (self.low + self.high) / 2
        return self._replace(high=middle), self._replace(low=middle)


@dataclass(frozen=True)
class Law:
    """τ as a function of time in ticks, from rest at 0 to rest at 1, exact."""

    speeds: tuple[int, ...]
    window: int

    @cached_property
    def ticks(self) -> tuple[tuple[Fraction, Fraction, Fraction, Fraction], ...]:
        """At the start of each tick τ, its speed and its acceleration, and its jerk during the tick."""
        width = self.window
        spend(60 * (len(self.speeds) + width), 64)
        if width == 1:
            raw = [(6 * x, 6 * (y - x), 0) for x, y in pairwise(self.speeds)]
        else:
            rest = [0] * width
            values = [*rest, *self.speeds, *rest]
            covered = [0, *accumulate(x + y for x, y in pairwise(values))]
            rises = [values[k + width] - values[k] for k in range(len(values) - width)]
            means = [3 * (covered[k + width] - covered[k]) for k in range(len(rises))]
            raw = [(means[k], 6 * x, 6 * (y - x)) for k, (x, y) in enumerate(pairwise(rises))]
        places = [0, *accumulate(6 * u + 3 * a + j for u, a, j in raw)]
        whole = places[-1]
        return tuple(
            (Fraction(s, whole), Fraction(6 * u, whole), Fraction(6 * a, whole), Fraction(6 * j, whole))
            for s, (u, a, j) in zip(places, raw, strict=False)
        )

    def at(self, tick: int, share: Fraction) -> tuple[Fraction, Fraction, Fraction]:
        """τ, its speed and its acceleration after a share of a tick."""
        s, u, a, j = self.ticks[tick]
        speed, acceleration = u + share * (a + share * j / 2), a + share * j
        return s + share * (u + share * (a / 2 + share * j / 6)), speed, acceleration

    def within(self, part: Part) -> tuple[Fraction, Fraction, Interval, Interval, Interval]:
        """τ at both ends of a part of a tick, and all speeds, accelerations and the jerk in it."""
        size = 3 * bits_in(part.low, part.high)
        spend_by_digits(200, size, size)
        low, high = (self.at(part.tick, share) for share in (part.low, part.high))
        jerk = self.ticks[part.tick][3]
        beyond = abs(jerk) * (part.high - part.low) ** 2 / 8
        return (
            *(low[0], high[0]),
            _between(low[1], high[1], beyond),
            _between(low[2], high[2], Fraction(0)),
            Interval.of(jerk, RATE_BITS),
        )


def _between(x: Fraction, y: Fraction, beyond: Fraction) -> Interval:
    """All numbers between two others, and a little beyond."""
    return Interval.of((x + y) / 2, RATE_BITS, abs(x - y) / 2 + beyond)


@dataclass(frozen=True)
class Run:
    """A part of a path from rest to rest: arcs that follow each other with one parameter.

    Attributes:
        first: the number of the first arc.
        shares: of the arcs in the parameter.
        tick: the time that a tick takes.
    """

    rates: LegRates
    first: int
    shares: tuple[Fraction, ...]
    law: Law
    tick: Fraction

    @property
    def duration(self) -> Fraction:
        """The time from rest to rest."""
        return len(self.law.ticks) * self.tick

    @cached_property
    def marks(self) -> tuple[Fraction, ...]:
        """The parameters at the ends of the arcs."""
        return tuple(sums(self.shares))

    @cached_property
    def size(self) -> int:
        """In bits, of its longest number."""
        return bits_in(self.tick, *self.marks)

    @cached_property
    def factors(self) -> list[list[Interval]]:
        """For each arc the factors that make derivatives by the run's parameter of those by τ."""
        spend_exact(20 * len(self.shares), *self.shares)
        return [[Interval.of(1 / share**k, RATE_BITS) for k in (1, 2, 3)] for share in self.shares]

    def place(self, time: Fraction) -> Fraction:
        """Where it is after a time: the number of the arc plus τ on it."""
        size = bits_in(time) + self.size
        spend_by_digits(60, size, size)
        ticks = time / self.tick
        tick = min(int(ticks), len(self.law.ticks) - 1)
        at = self.law.at(tick, ticks - tick)[0]
        arc = min(bisect_right(self.marks, at), len(self.shares)) - 1
        return self.first + arc + (at - self.marks[arc]) / self.shares[arc]

    def changes(self, part: Part, order: int) -> Iterator[Series | None]:
        """The derivatives of legs 1, 2 and 3 by time, in ticks, on each arc of a part; None if unknown."""
        low, high, u, a, j = self.law.within(part)
        spend_by_digits(2 * len(self.shares), size := bits_in(low, high) + self.size, size)
        for arc, ((start, stop), share) in enumerate(zip(pairwise(self.marks), self.shares, strict=True)):
            if stop < low or start > high or (start == high and low < high) or (stop == low and low < high):
                continue
            own = [(min(max(x, start), stop) - start) / share for x in (low, high)]
            rates = self.rates.on(self.first + arc, own[0], own[1], part.depth)
            spend(80, RATE_BITS)
            factors = self.factors[arc]
            yield None if rates is None else [_change(x, factors, (u, a, j), order) for x in rates]

    def parts(self, low: Fraction, high: Fraction, depth: int) -> Iterator[Part]:
        """The parts of ticks between two times."""
        size = bits_in(low, high) + self.size
        spend_by_digits(8, size, size)
        first, last = low / self.tick, high / self.tick
        for tick in range(int(first), -int(-last // 1)):
            yield Part(tick, max(first - tick, Fraction(0)), min(last - tick, Fraction(1)), depth)

    def keeps(self, order: int, limits: Record) -> bool:
        """Whether all legs keep limits of their derivatives of an order.

        Raises:
            OpenError: it is not decided.
        """
        spend_exact(20, self.tick, *limits.values())
        most = {
            int(name[1]): Interval.of(limit * self.tick**order, RATE_BITS) for name, limit in limits.items()
        }
        # the longest parts first, so that an excess is found before a part is too small
        queue = deque(self.parts(Fraction(0), self.duration, _FIRST_DEPTH))
        while queue:
            part = queue.popleft()
            found = [*self.changes(part, order)]
            pairs = [(x[leg - 1], limit) for x in found if x is not None for leg, limit in most.items()]
            if any(min(abs(x.lower), abs(x.upper)) > limit.upper for x, limit in pairs if x.sign):
                return False
            if None in found or any(max(-x.lower, x.upper) > limit.lower for x, limit in pairs):
                queue += part.finer(self.law)
        return True


def _change(rates: Series, factors: Series, of: tuple[Interval, Interval, Interval], order: int) -> Interval:
    """A derivative by time from those by τ, with their factors, and from those of the parameter."""
    first, second, third = (x * y for x, y in zip(rates, factors, strict=True))
    u, a, j = of
    if order == 1:
        return first * u
    if order == 2:
        return second * u * u + first * a
    return third * u * u * u + (second * u * a).scaled(3) + first * j


@dataclass(frozen=True)
class Motion:
    """The motion along all arcs of a path, at rest at the ends of each run."""

    runs: tuple[Run, ...]

    @classmethod
    def of(cls, certificate: Sequence[Record], rates: LegRates) -> Motion:
        """The motion with the laws of a certificate."""
        first, runs = 0, []
        for own in certificate:
            law = Law(own["speeds"], own["window"])
            runs.append(Run(rates, first, own["shares"], law, own["tick"]))
            first += len(own["shares"])
        return cls(tuple(runs))

    @cached_property
    def starts(self) -> tuple[Fraction, ...]:
        """The times at which the runs begin, and that at which the last one ends."""
        return tuple(sums(run.duration for run in self.runs))

    def place(self, time: Fraction) -> Fraction:
        """Where it is at a time: the number of the arc plus τ on it."""
        run = min(bisect_right(self.starts, time), len(self.runs)) - 1
        return self.runs[run].place(time - self.starts[run])

    def keeps(self, kind: str, limits: Record) -> Finding:
        """Whether all legs keep their limits of a kind at all times."""
        right = all(run.keeps(1 + KINDS.index(kind), limits) for run in self.runs)
        return finding(right, "by intervals on parts of ticks", "a leg exceeds its limit")

    def bends(self, low: Fraction, high: Fraction, depth: int) -> list[Fraction] | None:
        """Bounds of the accelerations of the legs between two times; None if unknown."""
        most = [Fraction(0)] * 3
        spend(len(self.runs))
        for start, stop, run in zip(self.starts, self.starts[1:], self.runs, strict=False):
            if stop <= low or start >= high:
                continue
            times, own = (max(low, start) - start, min(high, stop) - start), [Fraction(0)] * 3
            for part in run.parts(*times, depth):
                for found in run.changes(part, 2):
                    if found is None:
                        return None
                    own = [max(x, y.greatest) for x, y in zip(own, found, strict=True)]
            spend_exact(20, run.tick)
            most = [max(x, y / run.tick**2) for x, y in zip(most, own, strict=True)]
        return most
