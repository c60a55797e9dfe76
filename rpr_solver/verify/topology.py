"""How J = 0 of a slice runs on the torus, found anew: arcs between lines, closed chains of arcs, aspects.

Between two lines, in a *slab*, the arcs keep their number and their order; a component of J = 0 is a closed
chain of arcs, and an aspect a class of the gaps between them (mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import atan, atan2, tan, tau
from typing import TypeVar

from rpr_solver.verify.chart import (
    FAR,
    TURNS,
    UNDECIDED,
    Chart,
    ascending,
    ends,
    short,
    value_at,
    whole_angle,
    without_circle,
)
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Pair
from rpr_solver.verify.core.roots import (
    Root,
    formal_parts,
    has_root,
    real_roots,
    refined,
    simple_and_apart,
)
from rpr_solver.verify.core.surds import Poly, interpolated
from rpr_solver.verify.core.system import System
from rpr_solver.verify.lines import MULTIPLE, Line, Meeting, line_at, multiple_line_at

_APART = 48
T = TypeVar("T", bound=Hashable)
Turns = tuple[tuple[int, int], tuple[int, int]]
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
    """An arc of a strand: whether it is run upwards, and the meeting in which it turns back at its end."""

    arc: Cell
    upwards: bool
    turning: int | None


@dataclass(frozen=True)
class Chain:
    """A strand of J = 0, with J > 0 on its left: a closed curve, or one between points that are not smooth.

    Attributes:
        steps: its arcs; none if it is an isolated point.
        turns: the full turns of a closed one in α and in θ.
        ends: the meetings at its ends; None if it is closed.
    """

    steps: tuple[Step, ...]
    turns: tuple[int, int]
    ends: tuple[int, int] | None = None


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
    def of(cls, system: System, turnings: Iterable[Turns] = TURNS) -> Topology:
        """The topology of a slice, in the first chart that is good.

        Raises:
            OpenError: no chart that is tried has simple lines only, or intervals do not decide what meets.
        """
        for turns in turnings:
            chart = Chart.of(system, *turns)
            if chart.is_whole and (forms := chart.lines) is not None:
                return cls._read(chart, *forms)
        raise OpenError(MULTIPLE)

    @classmethod
    def _read(cls, chart: Chart, form: Poly, multiple: Poly) -> Topology:
        ring, top = chart.ring, [row[-1] for row in chart.rows]
        number, sign = len(real_roots(ring, top)), ring.sign(top[-1])
        roots = ascending(ring, form)
        arcs, signs, lines = [], [], []
        for n, root in enumerate(roots):
            if len(multiple) > 1 and has_root(ring, form, root, multiple):
                line = multiple_line_at(chart, form, root, _beside(roots, n))
            else:
                line = line_at(chart, form, root, -sign, number)
            if line.by:
                sign = -sign
            else:
                number = sum(len(slot[1]) for slot in line.slots)
            lines.append(line)
            arcs.append(number)
            signs.append(sign)
        return cls(chart, form, tuple(lines), tuple(arcs or [number]), tuple(signs or [sign]))

    @cached_property
    def meetings(self) -> list[tuple[int, Meeting]]:
        """All points in which arcs meet, each with the number of its line."""
        return [(n, meeting) for n, line in enumerate(self.lines) for meeting in line.meetings]

    def gap_sign(self, slab: int, gap: int) -> int:
        """The sign of J in a gap; gap k follows arc k, and the last one holds t = ∞."""
        own = (self.arcs[slab] - 1 - gap) % 2 == 0 or not self.arcs[slab]
        return self.signs[slab] if own else -self.signs[slab]

    def is_upward(self, slab: int, arc: int) -> bool:
        """Whether θ grows along an arc that has J > 0 on its left."""
        return self.gap_sign(slab, arc - 1 if arc else self.arcs[slab] - 1) > 0

    def slab_of(self, u: Interval) -> int | None:
        """The slab of all u of an interval; None if it meets a line."""
        below = sum(ends(line.root)[1] < span_of(u)[0] for line in self.lines)
        return None if _near(self.lines, u) else (below - 1) % len(self.arcs)

    def line_of(self, u: Interval) -> int | None:
        """The one line that an interval of u meets; None if there is none, or another."""
        near = _near(self.lines, u)
        return near[0] if len(near) == 1 else None

    def place(self, t: Interval, u: Interval) -> Cell | None:
        """The slab and the arc of a point of J = 0 in a box of t and u; None if the box is too wide."""
        slab, values = self.slab_of(u), self.chart.values(u, inverted=False)
        sides = sides_of(t)
        if slab is None or sides is None or not is_nonzero(values, sides, t.bits):
            return None
        first, second = (self.chart.count_below(x, short(u.middle, u.radius)) for x in sides)
        return (slab, first) if second == first + 1 else None

    def order(self, cell: Cell, u: Interval) -> tuple[bool, Fraction]:
        """What ascends along the arcs of a slab; the last one holds u = ∞."""
        first = ends(self.lines[0].root)[0] if self.lines else Fraction(-FAR)
        return cell[0] == len(self.arcs) - 1 and u.middle < first, u.middle

    def width(self, slab: int) -> tuple[float, float]:
        """About the middle angle of a slab in the chart, and how wide it is."""
        if not self.lines:
            return 0.0, tau
        low, high = (2 * atan(float(ends(self.lines[n % len(self.lines)].root)[0])) for n in (slab, slab + 1))
        width = (high - low) % tau or (0.0 if len(self.lines) > 1 else tau)
        return low + width / 2, width

    def middle_of(self, arc: Cell) -> tuple[float, float]:
        """About α and θ in the middle of an arc.

        Raises:
            OpenError: floats do not tell its slab from a line.
        """
        theta, _ = self.width(arc[0])
        roots = ascending(self.chart.ring, tuple(self.chart.above(Fraction(tan(theta / 2)))))
        if len(roots) != self.arcs[arc[0]]:
            raise OpenError("an arc of the singular curve is too short for floats")
        alpha = 2 * atan(float(sum(ends(roots[arc[1]])) / 2))
        return alpha + 2 * atan2(*self.chart.alpha), theta + 2 * atan2(*self.chart.theta)

    @cached_property
    def _ends(self) -> tuple[dict[End, End], dict[End, int]]:
        """The end that each end of an arc continues as, and the number of the meeting in which one lies."""
        partners: dict[End, End] = {}
        meetings: dict[End, int] = {}
        first = 0
        for n, line in enumerate(self.lines):
            before = (n - 1) % len(self.arcs)
            for pair in line.partners(self.arcs[before]):
                one, other = ((n, k, 0) if side else (before, k, 1) for side, k in pair)
                partners[one], partners[other] = other, one
            for below, above, own in () if line.by else line.slots:
                if own is not None:
                    meetings |= {(before, k, 1): first + own for k in below}
                    meetings |= {(n, k, 0): first + own for k in above}
            first += len(line.meetings)
        return partners, meetings

    def chains(self) -> Iterator[Chain]:
        """The strands of J = 0: those that begin in a meeting that is not smooth, and closed ones."""
        for k, (_, meeting) in enumerate(self.meetings):
            if not any(meeting.arcs):
                yield Chain((), (0, 0), (k, k))
        left = {(slab, arc) for slab, number in enumerate(self.arcs) for arc in range(number)}
        partners, meetings = self._ends
        free = [end for end in sorted(meetings) if end not in partners]
        starts = [end[:2] for end in free if self.is_upward(*end[:2]) != bool(end[2])]
        while left:
            yield self._strand(starts.pop() if starts else min(left), left)

    def _strand(self, here: Cell, left: set[Cell]) -> Chain:
        """The strand that begins with an arc; its arcs are taken from those that are left."""
        partners, meetings = self._ends
        start, last, steps, alpha, theta = here, len(self.arcs) - 1, list[Step](), 0, 0
        while here in left:
            left.discard(here)
            up = self.is_upward(*here)
            if here[0] == last:
                theta += 1 if up else -1
            end = (*here, int(up))
            if end not in partners:
                steps.append(Step(here, up, None))
                if not self.lines:
                    break
                first = meetings[(*start, int(not steps[0].upwards))]
                return Chain(tuple(steps), (0, 0), (first, meetings[end]))
            number, (slab, arc, side) = (here[0] + up) % len(self.lines), partners[end]
            steps.append(Step(here, up, meetings[end] if side == up else None))
            line, top = self.lines[number], self.arcs[slab] - 1
            if line.by and (here[1] if up else arc) == (top if line.by > 0 else 0):
                alpha += line.by if up else -line.by
            here = slab, arc
        return Chain(tuple(steps), (alpha, theta))

    def aspects(self) -> dict[Cell, Cell]:
        """A representative of the aspect of each gap."""
        found = Classes((s, k) for s, n in enumerate(self.arcs) for k in range(max(n, 1)))
        for n, line in enumerate(self.lines):
            before = (n - 1) % len(self.arcs)
            for first, second in line.links(self.arcs[before], self.arcs[n]):
                found.join((before, first), (n, second))
        return {cell: found.root(cell) for cell in found}


def span_of(x: Interval) -> tuple[Fraction, Fraction]:
    """Both ends of an interval."""
    return Fraction(x.lower, 1 << x.bits), Fraction(x.upper, 1 << x.bits)


def _near(lines: Iterable[Line], u: Interval) -> list[int]:
    """The lines that an interval of u meets."""
    least, greatest = span_of(u)
    places = enumerate(ends(line.root) for line in lines)
    return [n for n, (low, high) in places if low <= greatest and least <= high]


def sides_of(t: Interval, least: Fraction = Fraction(0)) -> tuple[Fraction, Fraction] | None:
    """Short fractions on either side of an interval of t, so far at least; None if it is too wide."""
    whole = (t.greatest.numerator // t.greatest.denominator).bit_length()
    radius = max(least, Fraction(1 << whole, 1 << (t.bits // 4)))
    low, high = (short(t.middle + side, radius / 8) for side in (-radius, radius))
    return (low, high) if t.inside(low, high) else None


def is_nonzero(values: Sequence[Interval], places: Iterable[Fraction], bits: int) -> bool:
    """Whether J, with these coefficients, is nowhere 0 at these t."""
    return all(value_at(values, Interval.of(x, bits)).sign for x in places)


def is_one(topology: Topology, number: int, x: Interval, t: Interval, form: Poly) -> bool:
    """Whether a zero of J at t, where u is a root of a form, is the double one of a line, at x.

    It is on the line then, and the second derivative of J is not 0 between both.
    """
    root, chart = topology.lines[number].root, topology.chart
    (low, high), both = ends(root), Interval(min(x.lower, t.lower), max(x.upper, t.upper), t.bits)
    values = chart.values(Interval.of((low + high) / 2, t.bits, high - low), inverted=False)
    bend = value_at([y.scaled(k * (k - 1)) for k, y in enumerate(values)][2:], both)
    return bend.sign != 0 and has_root(chart.ring, topology.form, root, form)


def angles(topology: Topology, number: int, t: Interval) -> tuple[Pair, Pair]:
    """Cosines and sines of α and θ of a point on a line, about."""
    low, high = ends(topology.lines[number].root)
    u, chart = Interval.of((low + high) / 2, t.bits), topology.chart
    alpha, theta = (whole_angle(x, half) for x, half in zip((t, u), (chart.alpha, chart.theta), strict=True))
    return alpha, theta


def _beside(roots: Sequence[Root], n: int) -> tuple[Fraction, Fraction]:
    """Two values of u beside a line, between which is no other."""
    places = [ends(root) for root in roots]
    low, high = places[n]
    least = (places[n - 1][1] + low) / 2 if n else low - 1
    most = (high + places[n + 1][0]) / 2 if n + 1 < len(places) else high + 1
    return short(least, (low - least) / 2), short(most, (most - high) / 2)


_RESULTANT = 32


def joined_aspects(slices: Sequence[System]) -> tuple[list[Topology], Classes[tuple[int, Cell]]]:
    """The aspects of the slices at both ends of a range, classes of gaps, joined where two overlap.

    An overlap is seen on a line between neighbouring ones of both slices and of the resultant of both forms
    (mathematics.md#aspects-of-a-range).

    Raises:
        OpenError: no chart is good for both slices, or intervals do not decide what is neighbouring.
    """
    for turns in TURNS:
        try:
            both = [Topology.of(system, [turns]) for system in slices]
        except OpenError:
            continue
        break
    else:
        raise OpenError(MULTIPLE)
    found = Classes((n, cell) for n, own in enumerate(both) for cell in own.aspects())
    for n, own in enumerate(both):
        for cell, root in own.aspects().items():
            found.join((n, cell), (n, root))
    for u in _between(both) if len(both) > 1 else ():
        for first, second in _overlaps(both, u):
            if both[0].gap_sign(*first) == both[1].gap_sign(*second):
                found.join((0, first), (1, second))
    return both, found


def _between(both: Sequence[Topology]) -> Iterator[Fraction]:
    """A value of u between any two neighbouring lines of both slices, their resultant's among them."""
    ring, (first, second) = both[0].chart.ring, (own.form for own in both)
    points = range(-_RESULTANT // 2, _RESULTANT // 2 + 1)
    rows = ([own.chart.above(Fraction(u)) for own in both] for u in points)
    whole = interpolated(points, [ring.resultant(*pair) for pair in rows])
    if not whole:
        raise OpenError("the singular curves of both slices have a part in common")
    parts = [part for part in formal_parts(ring, without_circle(ring, whole)).values() if len(part) > 1]
    lines, apart = ring.product(first, second), simple_and_apart(ring, first, second)
    if not apart or not all(simple_and_apart(ring, part, lines) for part in parts):
        raise OpenError(UNDECIDED)
    roots = [line.root for own in both for line in own.lines]
    for part in parts:
        for root in real_roots(ring, part):
            roots.append(refined(ring, part, root, Fraction(1, 1 << (4 * _APART))))
    places = sorted(map(ends, roots))
    if any(low <= high for (_, high), (low, _) in pairwise(places)):
        raise OpenError(UNDECIDED)
    yield places[0][0] - 1 if places else Fraction(0)
    for (_, below), (above, _) in pairwise(places):
        yield short((below + above) / 2, (above - below) / 4)
    yield places[-1][1] + 1 if places else Fraction(1)


def _overlaps(both: Sequence[Topology], u: Fraction) -> Iterator[tuple[Cell, Cell]]:
    """The gaps of both slices that overlap on a line of neither."""
    ring, forms = both[0].chart.ring, [own.chart.above(u) for own in both]
    slabs = [own.slab_of(Interval.of(u, 4 * u.denominator.bit_length() + _APART)) for own in both]
    below = [0, 0]
    numbers = [own.arcs[slab] for own, slab in zip(both, slabs, strict=True) if slab is not None]
    if len(numbers) < 2 or [len(real_roots(ring, form)) for form in forms] != numbers:
        raise OpenError(UNDECIDED)
    roots = ascending(ring, ring.product(*map(tuple, forms)))
    for root in (None, *roots):
        if root is not None:
            signs = [[ring.sign(ring.at(form, x)) for x in ends(root)] for form in forms]
            below = [n + (low != high) for n, (low, high) in zip(below, signs, strict=True)]
        first, second = ((n - 1) % max(own, 1) for n, own in zip(below, numbers, strict=True))
        yield (slabs[0], first), (slabs[1], second)  # type: ignore[misc]
    if below != numbers:
        raise OpenError(UNDECIDED)
