"""The motion along a path: how fast its legs change, in intervals, and that they keep their limits.

On a piece of an arc, whose parameter runs from 0 to 1, the k-th Taylor coefficient of a leg lies in
cₖ(middle) + (k + 1) cₖ₊₁(piece) [−1/2, 1/2]. Those of α, θ and L are in the hulls of differences of control
points; those of sines, products and roots follow from them.

A law has τ as a function of time in ticks, by whole numbers s₀ = 0, …, sₙ = 0 and a window w: the speed is in
proportion to the piecewise linear function of the values sₖ, or to its mean over the last w ticks. On parts
of ticks the derivatives of the legs by time follow from those by τ (mathematics.md#motions-within-limits).
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from math import comb, factorial
from typing import NamedTuple

from rpr_solver.verify.arcs import Controls, Piece, halves_of, hull_of, in_radians, mean
from rpr_solver.verify.claims import Finding, OpenError, finding
from rpr_solver.verify.core.intervals import Interval, cos_sin
from rpr_solver.verify.core.reader import Record, spend
from rpr_solver.verify.core.system import Surface

KINDS = ("speed", "acceleration", "jerk")
_FIRST_DEPTH, _DEEPEST, _SHORTEST = 4, 20, 1 << 16
ORDERS = 3
BITS = 128
Series = list[Interval]
"""Taylor coefficients, from that of order 0."""
Rates = list[Series]
"""Of legs 1, 2 and 3 the derivatives of order 1, 2 and 3, in the user's unit."""
_MIDDLE = Interval(-1, 1, 1).at(BITS)


@dataclass(frozen=True)
class LegRates:
    """The derivatives of the legs on dyadic pieces of the arcs.

    Attributes:
        pieces: the arcs.
        lengths: the exact lengths of the fixed leg at their control points, in the user's unit.
    """

    surface: Surface
    pieces: Sequence[Piece]
    lengths: Sequence[Sequence[Fraction]]
    known: dict[tuple[int, int, int], Rates | None] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, pieces: Sequence[Piece], lengths: Sequence[Sequence[Fraction]]) -> LegRates:
        """Those of arcs, at a precision that is enough for rates."""
        rounded = (tuple((a.at(BITS), t.at(BITS), z.at(BITS)) for a, t, z in x.controls) for x in pieces)
        forms = pieces[0].forms
        return cls(forms.surface, [Piece(forms, controls) for controls in rounded], lengths)

    def on(self, arc: int, low: Fraction, high: Fraction, depth: int) -> Rates | None:
        """All derivatives for low ≤ τ ≤ high on an arc, by pieces of length 2^−depth; None if a leg may be
        closed on one."""
        size = 1 << depth
        first = min(int(low * size), size - 1)
        found = [self._known(arc, depth, n) for n in range(first, max(-int(-high * size // 1), first + 1))]
        if len(found) == 1 or None in found:
            return found[0] if len(found) == 1 else None
        return [[hull_of(x) for x in zip(*legs, strict=True)] for legs in zip(*found, strict=True)]

    def _known(self, arc: int, depth: int, number: int) -> Rates | None:
        key = arc, depth, number
        if key not in self.known:
            piece, lengths = self.pieces[arc], self.lengths[arc]
            for n in reversed(range(depth)):
                side = number >> n & 1
                piece, lengths = piece.halves[side], halves_of(lengths, mean)[side]
            self.known[key] = self._found(piece, lengths, depth)
        return self.known[key]

    def _found(self, piece: Piece, lengths: Sequence[Fraction], depth: int) -> Rates | None:
        # the left half ends in the middle; read from there, its parameter runs back, and twice as fast
        back = _coefficients(piece.halves[0].controls[::-1], ORDERS, lambda column: column[0])
        near = [[x.scaled((-2) ** k) for k, x in enumerate(row)] for row in back]
        middles = self._free(near, ORDERS)
        around = self._free(_coefficients(piece.controls, ORDERS + 1, hull_of), ORDERS + 1)
        if not middles or not around:
            return None
        unit, rates = Interval.of(self.surface.unit, BITS), {}
        for leg, middle, wide in zip(self.surface.free, middles, around, strict=True):
            rates[leg] = [
                (middle[k] + wide[k + 1].scaled(k + 1) * _MIDDLE).scaled(factorial(k) << depth * k).over(unit)
                for k in range(1, ORDERS + 1)
            ]
        rates[self.surface.fixed] = _of_polynomial(lengths, depth)
        return [rates[leg] for leg in (1, 2, 3)]

    def _free(self, point: Sequence[Series], order: int) -> list[Series]:
        """The series of both free legs from those of α, θ and L; none if one may be closed."""
        spend(120 * order**2, BITS)
        omega = Interval.of(self.surface.ring.radicand, BITS).root()
        directions = [*_cos_sin(point[0]), *_cos_sin(point[1])]
        products = {(0, 0, 0, 0): _constant(1, order)}

        def product(key: tuple[int, ...]) -> Series:
            if key not in products:
                place = next(n for n in range(4) if key[n])
                lesser = (*key[:place], key[place] - 1, *key[place + 1 :])
                products[key] = _times(product(lesser), directions[place])  # type: ignore[index]
            return products[key]  # type: ignore[index]

        found = []
        for leg in self.surface.legs:
            square = _constant(0, order)
            for row in reversed(leg.squared):
                square = _times(square, point[2])
                for key, (a, b) in row.items():
                    size = Interval.of(a, BITS) + omega.scaled(b)
                    square = [x + y * size for x, y in zip(square, product(key), strict=True)]
            if square[0].lower <= 0:
                return []
            found.append(_root(square))
        return found


def _of_polynomial(lengths: Sequence[Fraction], depth: int) -> Series:
    """The derivatives of a polynomial on a piece, by the differences of its control points."""
    row, factor, found = list(lengths), 1, []
    for _ in range(ORDERS):
        factor *= max(len(row) - 1, 0) << depth
        row = [y - x for x, y in pairwise(row)]
        found.append(hull_of([Interval.of(x * factor, BITS) for x in row or [Fraction(0)]]))
    return found


def _coefficients(
    controls: Controls, order: int, of: Callable[[Sequence[Interval]], Interval]
) -> list[Series]:
    """Series of α and θ in radians and of L, by what is made of the differences of control points."""
    degree, found = len(controls) - 1, []
    for n, column in enumerate(zip(*controls, strict=True)):
        row, series = list(column), []
        for k in range(order + 1):
            x = of(row).scaled(comb(degree, k)) if row else Interval(0, 0, BITS)
            series.append(in_radians(x) if n < 2 else x)
            row = [y - x for x, y in pairwise(row)]
        found.append(series)
    return found


def _constant(x: int, order: int) -> Series:
    return [Interval.of(x, BITS), *[Interval(0, 0, BITS)] * order]


def _times(p: Series, q: Series) -> Series:
    return [_sum([p[i] * q[k - i] for i in range(k + 1)]) for k in range(len(p))]


def _sum(terms: Sequence[Interval]) -> Interval:
    return Interval(sum(x.lower for x in terms), sum(x.upper for x in terms), BITS)


def _cos_sin(angle: Series) -> tuple[Series, Series]:
    """Cosine and sine of a series: c′ = −s a′ and s′ = c a′."""
    cos, sin = ([x] for x in cos_sin(angle[0]))
    for k in range(1, len(angle)):
        steps = [angle[i].scaled(i) for i in range(1, k + 1)]
        back = range(k - 1, -1, -1)
        one, two = (_sum([row[n] * x for n, x in zip(back, steps, strict=True)]) for row in (sin, cos))
        whole = Interval.of(k, BITS)
        cos.append(Interval(-one.upper, -one.lower, BITS).over(whole))
        sin.append(two.over(whole))
    return cos, sin


def _root(square: Series) -> Series:
    """The root of a series: S = L², so 2 L₀ Lₖ = Sₖ − Σ Lᵢ Lₖ₋ᵢ over 0 < i < k."""
    root = [square[0].root()]
    twice = root[0].scaled(2)
    for k in range(1, len(square)):
        root.append((square[k] - _sum([root[i] * root[k - i] for i in range(1, k)])).over(twice))
    return root


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
        spend(200, 128)
        low, high = (self.at(part.tick, share) for share in (part.low, part.high))
        jerk = self.ticks[part.tick][3]
        beyond = abs(jerk) * (part.high - part.low) ** 2 / 8
        return (
            *(low[0], high[0]),
            _between(low[1], high[1], beyond),
            _between(low[2], high[2], Fraction(0)),
            Interval.of(jerk, BITS),
        )


def _between(x: Fraction, y: Fraction, beyond: Fraction) -> Interval:
    """All numbers between two others, and a little beyond."""
    return Interval.of((x + y) / 2, BITS, abs(x - y) / 2 + beyond)


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
        return Fraction(0), *accumulate(self.shares)

    def place(self, time: Fraction) -> Fraction:
        """Where it is after a time: the number of the arc plus τ on it."""
        ticks = time / self.tick
        tick = min(int(ticks), len(self.law.ticks) - 1)
        at = self.law.at(tick, ticks - tick)[0]
        arc = min(bisect_right(self.marks, at), len(self.shares)) - 1
        return self.first + arc + (at - self.marks[arc]) / self.shares[arc]

    def changes(self, part: Part, order: int) -> Iterator[Series | None]:
        """The derivatives of legs 1, 2 and 3 by time, in ticks, on each arc of a part; None if unknown."""
        low, high, u, a, j = self.law.within(part)
        spend(2 * len(self.shares))
        for arc, ((start, stop), share) in enumerate(zip(pairwise(self.marks), self.shares, strict=True)):
            if stop < low or start > high or (start == high and low < high) or (stop == low and low < high):
                continue
            own = [(min(max(x, start), stop) - start) / share for x in (low, high)]
            rates = self.rates.on(self.first + arc, own[0], own[1], part.depth)
            spend(80, BITS)
            yield None if rates is None else [_change(x, share, (u, a, j), order) for x in rates]

    def parts(self, low: Fraction, high: Fraction, depth: int) -> Iterator[Part]:
        """The parts of ticks between two times."""
        first, last = low / self.tick, high / self.tick
        for tick in range(int(first), -int(-last // 1)):
            yield Part(tick, max(first - tick, Fraction(0)), min(last - tick, Fraction(1)), depth)

    def keeps(self, order: int, limits: Record) -> bool:
        """Whether all legs keep limits of their derivatives of an order.

        Raises:
            OpenError: it is not decided.
        """
        most = {int(name[1]): limit * self.tick**order for name, limit in limits.items()}
        # the longest parts first, so that an excess is found before a part is too small
        queue = deque(self.parts(Fraction(0), self.duration, _FIRST_DEPTH))
        while queue:
            part = queue.popleft()
            found = [*self.changes(part, order)]
            pairs = [(x[leg - 1], limit) for x in found if x is not None for leg, limit in most.items()]
            if any(min(abs(x.lower), abs(x.upper)) > limit * (1 << BITS) for x, limit in pairs if x.sign):
                return False
            if None in found or any(x.greatest > limit for x, limit in pairs):
                queue += part.finer(self.law)
        return True


def _change(rates: Series, share: Fraction, of: tuple[Interval, Interval, Interval], order: int) -> Interval:
    """A derivative by time from those by τ, and from those of the parameter, of which an arc has a share."""
    factors = [Interval.of(1 / share**k, BITS) for k in (1, 2, 3)] if share != 1 else None
    first, second, third = (x * y for x, y in zip(rates, factors, strict=True)) if factors else rates
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
        return Fraction(0), *accumulate(run.duration for run in self.runs)

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
            times = max(low, start) - start, min(high, stop) - start
            for part in run.parts(*times, depth):
                for found in run.changes(part, 2):
                    if found is None:
                        return None
                    most = [max(x, y.greatest / run.tick**2) for x, y in zip(most, found, strict=True)]
        return most
