"""How J = 0 of a slice runs on the torus, found anew: arcs between lines, closed chains of arcs, aspects.

Between two lines, in a *slab*, the arcs keep their number and their order; a component of J = 0 is a closed
chain of arcs, and an aspect a class of the gaps between them (mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan, atan2, tan, tau
from typing import TypeVar

from rpr_solver.verify.chart import (
    FAR,
    TURNS,
    UNDECIDED,
    Chart,
    Line,
    ascending,
    ends,
    line_at,
    short,
    value_at,
    whole_angle,
)
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Pair
from rpr_solver.verify.core.roots import real_roots, refined
from rpr_solver.verify.core.surds import Poly
from rpr_solver.verify.core.system import System

_APART = 48
MULTIPLE = "a line of constant angle meets the singular curve in several special points, or in a node"

T = TypeVar("T", bound=Hashable)
Cell = tuple[int, int]
"""A slab, and the number of a gap in it; or of an arc."""
End = tuple[int, int, int]
"""A slab, an arc, and 0 for its end at the lower line, 1 for the other."""


class Classes(dict[T, T]):
    """Things, first each in a class of its own, and for each another one of its class."""

    def __init__(self, things: Iterable[T]) -> None:
        super().__init__((thing, thing) for thing in things)

    def root(self, thing: T) -> T:
        """The representative of a class."""
        while self[thing] != thing:
            self[thing] = thing = self[self[thing]]
        return thing

    def join(self, first: T, second: T) -> None:
        """Makes one class of two, with the representative of the second."""
        self[self.root(first)] = self.root(second)

    @property
    def number(self) -> int:
        """How many classes there are."""
        return sum(thing == above for thing, above in self.items())


@dataclass(frozen=True)
class Step:
    """An arc of a component: whether it is run upwards, and the line on which it turns back at its end."""

    arc: Cell
    upwards: bool
    turning: int | None


@dataclass(frozen=True)
class Chain:
    """A component of J = 0, a closed curve with J > 0 on its left; its full turns in α and in θ."""

    steps: tuple[Step, ...]
    turns: tuple[int, int]


@dataclass(frozen=True)
class Topology:
    """The lines by ascending u, and the slabs; slab i follows line i, the last one holds u = ∞.

    Attributes:
        chart: the chart.
        form: its form whose roots are the lines.
        lines: the lines.
        arcs: the number of arcs in each slab; without lines there is one.
        signs: the sign of J at t = ∞ in each slab.
    """

    chart: Chart
    form: Poly
    lines: tuple[Line, ...]
    arcs: tuple[int, ...]
    signs: tuple[int, ...]

    @classmethod
    def of(cls, system: System) -> Topology:
        """The topology of a slice.

        Raises:
            OpenError: no chart that is tried has simple lines only, or intervals do not decide what meets.
        """
        for turns in TURNS:
            chart = Chart.of(system, *turns)
            if chart.is_whole and (form := chart.lines) is not None:
                return cls._read(chart, form)
        raise OpenError(MULTIPLE)

    @classmethod
    def _read(cls, chart: Chart, form: Poly) -> Topology:
        ring, top = chart.ring, [row[-1] for row in chart.rows]
        number, sign = len(real_roots(ring, top)), ring.sign(top[-1])
        roots = ascending(ring, form)
        arcs, signs, lines = [], [], []
        for root in roots:
            line = line_at(chart, form, root, -sign)
            if line.by:
                sign = -sign
            elif number not in (line.others, line.others + 2):
                raise OpenError(UNDECIDED)
            else:
                number = 2 * line.others + 2 - number
            lines.append(line)
            arcs.append(number)
            signs.append(sign)
        return cls(chart, form, tuple(lines), tuple(arcs or [number]), tuple(signs or [sign]))

    def gap_sign(self, slab: int, gap: int) -> int:
        """The sign of J in a gap; gap k follows arc k, and the last one holds t = ∞."""
        own = (self.arcs[slab] - 1 - gap) % 2 == 0 or not self.arcs[slab]
        return self.signs[slab] if own else -self.signs[slab]

    def is_upward(self, slab: int, arc: int) -> bool:
        """Whether θ grows along an arc that has J > 0 on its left."""
        return self.gap_sign(slab, arc - 1 if arc else self.arcs[slab] - 1) > 0

    def slab_of(self, u: Interval) -> int | None:
        """The slab of all u of an interval; None if it meets a line."""
        least, greatest = Fraction(u.lower, 1 << u.bits), Fraction(u.upper, 1 << u.bits)
        below = 0
        for line in self.lines:
            low, high = ends(line.root)
            if low <= greatest and least <= high:
                return None
            below += high < least
        return (below - 1) % len(self.arcs)

    def count_below(self, t: Fraction, u: Fraction) -> int:
        """How many arcs have a smaller t at a point with J ≠ 0 that is on no line."""
        ring, form = self.chart.ring, self.chart.above(u)
        number = 0
        for root in real_roots(ring, form):
            width = Fraction(1, 1 << _APART)
            low, high = ends(root)
            while low < t < high:
                root = refined(ring, form, root, width)
                low, high = ends(root)
                width /= 1 << _APART
            number += high <= t
        return number

    def place(self, t: Interval, u: Interval) -> Cell | None:
        """The slab and the arc of a point of J = 0 in a box of t and u; None if the box is too wide."""
        slab, values = self.slab_of(u), self.chart.values(u, inverted=False)
        radius = Fraction(
            1 << (t.greatest.numerator // t.greatest.denominator).bit_length(), 1 << (t.bits // 4)
        )
        low, high = (short(t.middle + side, radius / 8) for side in (-radius, radius))
        if slab is None or not t.inside(low, high):
            return None
        if any(not value_at(values, Interval.of(x, t.bits)).sign for x in (low, high)):
            return None
        first, second = (self.count_below(x, short(u.middle, u.radius)) for x in (low, high))
        return (slab, first) if second == first + 1 else None

    def line_of(self, u: Interval) -> int | None:
        """The one line that an interval of u meets; None if there is none, or another."""
        least, greatest = Fraction(u.lower, 1 << u.bits), Fraction(u.upper, 1 << u.bits)
        near = [
            n
            for n, (low, high) in enumerate(ends(line.root) for line in self.lines)
            if low <= greatest and least <= high
        ]
        return near[0] if len(near) == 1 else None

    def order(self, cell: Cell, u: Interval) -> tuple[bool, Fraction]:
        """What ascends along the arcs of a slab; the last one holds u = ∞."""
        first = ends(self.lines[0].root)[0] if self.lines else Fraction(-FAR)
        return cell[0] == len(self.arcs) - 1 and u.middle < first, u.middle

    def angles(self, number: int) -> tuple[Pair, Pair]:
        """Cosines and sines of α and θ where two arcs meet on a line, about."""
        line = self.lines[number]
        assert line.t is not None
        low, high = ends(line.root)
        u = Interval.of((low + high) / 2, line.t.bits)
        alpha, theta = (
            whole_angle(x, half)
            for x, half in zip((line.t, u), (self.chart.alpha, self.chart.theta), strict=True)
        )
        return alpha, theta

    def width(self, slab: int) -> tuple[float, float]:
        """About the middle angle of a slab in the chart, and how wide it is."""
        if not self.lines:
            return 0.0, tau
        low, high = (2 * atan(float(ends(self.lines[n % len(self.lines)].root)[0])) for n in (slab, slab + 1))
        width = (high - low) % tau or tau
        return low + width / 2, width

    def middle_of(self, arc: Cell) -> tuple[float, float]:
        """About α and θ in the middle of an arc."""
        theta, _ = self.width(arc[0])
        roots = ascending(self.chart.ring, tuple(self.chart.above(Fraction(tan(theta / 2)))))
        alpha = 2 * atan(float(sum(ends(roots[arc[1]])) / 2))
        return alpha + 2 * atan2(*self.chart.alpha), theta + 2 * atan2(*self.chart.theta)

    @cached_property
    def _partners(self) -> dict[End, End]:
        """The end that each end of an arc continues as."""
        result: dict[End, End] = {}
        for n, line in enumerate(self.lines):
            before = (n - 1) % len(self.arcs)
            for pair in line.partners(self.arcs[before], self.arcs[n]):
                first, second = ((n, k, 0) if side else (before, k, 1) for side, k in pair)
                result[first], result[second] = second, first
        return result

    def chains(self) -> Iterator[Chain]:
        """The components of J = 0."""
        left = {(slab, arc) for slab, number in enumerate(self.arcs) for arc in range(number)}
        last = len(self.arcs) - 1
        while left:
            here, steps, alpha, theta = min(left), [], 0, 0
            while here in left:
                left.discard(here)
                up = self.is_upward(*here)
                if here[0] == last:
                    theta += 1 if up else -1
                number = ((here[0] + up) % len(self.lines)) if self.lines else None
                if number is None:
                    steps.append(Step(here, up, None))
                    break
                slab, arc, end = self._partners[(*here, int(up))]
                steps.append(Step(here, up, number if end == up else None))
                line, top = self.lines[number], self.arcs[slab] - 1
                if line.by and (here[1] if up else arc) == (top if line.by > 0 else 0):
                    alpha += line.by if up else -line.by
                here = slab, arc
            yield Chain(tuple(steps), (alpha, theta))

    def aspects(self) -> dict[Cell, Cell]:
        """A representative of the aspect of each gap."""
        found = Classes((s, k) for s, n in enumerate(self.arcs) for k in range(max(n, 1)))
        for n, line in enumerate(self.lines):
            before = (n - 1) % len(self.arcs)
            for first, second in line.links(self.arcs[before], self.arcs[n]):
                found.join((before, first), (n, second))
        return {cell: found.root(cell) for cell in found}
