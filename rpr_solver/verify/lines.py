"""The lines of a chart of J = 0: where arcs meet, where one passes t = ∞, and how arcs and gaps continue.

On a simple root of the discriminant two arcs turn back. On a multiple one that is done by the numbers of arcs
beside it: two branches, or none, pass a point where J = 0 is not smooth (mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.chart import UNDECIDED, Chart, ascending, ends, short, value_at
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval, halved
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, formal_parts, real_roots, refined
from rpr_solver.verify.core.surds import ZERO, Poly, Ring

_TRIES, _SPARE_BITS = 6, 64
MULTIPLE = "the singular curve is not smooth on a part of it, or a line has several special points"


@dataclass(frozen=True)
class Meeting:
    """A point where two arcs meet on a line: a turning point, or a point where J = 0 is not smooth.

    Attributes:
        below: how many of the arcs that cross the line do so at smaller t.
        arcs: how many meet there from before the line, and from after it; 0 or 2.
        t: half tangent of α′.
    """

    below: int
    arcs: tuple[int, int]
    t: Interval

    @property
    def is_turning(self) -> bool:
        """Whether both arcs are on one side, so that they continue each other."""
        return sum(self.arcs) == 2


Slot = tuple[range, range, int | None]
"""The arcs before and after a line that are at one point of it, and the number of the meeting there."""


@dataclass(frozen=True)
class Line:
    """A line u = const.

    Attributes:
        root: u, in a narrow interval.
        others: how many arcs cross the line alone.
        meetings: where arcs meet, by ascending t.
        by: ±1 where one arc passes t = ∞, by which the numbers of all change; 0 on other lines.
    """

    root: Root
    others: int
    meetings: tuple[Meeting, ...]
    by: int = 0

    @cached_property
    def slots(self) -> list[Slot]:
        """What is on a line that no arc crosses at t = ∞, by ascending t."""
        found: list[Slot] = []
        first = last = 0
        places = [(meeting.below, 0, n) for n, meeting in enumerate(self.meetings)]
        for _, alone, n in sorted(places + [(k, 1, k) for k in range(self.others)]):
            x, y = (1, 1) if alone else self.meetings[n].arcs
            found.append((range(first, first + x), range(last, last + y), None if alone else n))
            first, last = first + x, last + y
        return found

    def partners(self, before: int) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
        """Pairs of arcs that continue each other: each as a side, 1 after the line, and a number."""
        if self.by:
            yield from (((0, k), (1, (k + self.by) % before)) for k in range(before))
        for own in () if self.by else self.slots:
            sides = [(side, k) for side in (0, 1) for k in own[side]]  # type: ignore[union-attr]
            if len(sides) == 2:
                yield sides[0], sides[1]

    def links(self, before: int, after: int) -> Iterator[tuple[int, int]]:
        """Pairs of gaps, before and after the line, that continue each other; gap k follows arc k."""
        if self.by:
            yield from ((k, (k + self.by) % before) for k in range(before))
        elif not self.slots:
            yield 0, 0
        for first, last, _ in () if self.by else self.slots:
            yield (first.stop - 1) % max(before, 1), (last.stop - 1) % max(after, 1)


def line_at(chart: Chart, form: Poly, root: Root, sign: int, before: int) -> Line:
    """What happens on a simple line after ``before`` arcs; ``sign`` is that of J at t = ∞ after it, if it
    changes there."""
    ring, lead = chart.ring, chart.rows[-1]
    own = lead[::-1] if root.inverted else lead
    at_ends = [ring.sign(ring.at(own, x)) for x in (root.lower, root.upper)]
    crosses = at_ends[0] != at_ends[1] or at_ends == [0, 0]
    for narrow, values in _near(chart, form, root):
        if crosses and (side := values[-2].sign):
            return Line(narrow, 0, (), side * sign)
        found = None if crosses else _meeting(values)
        if found is not None:
            others, below, t = found
            return _joined(narrow, others, below, t, (before, 2 * others + 2 - before))
    raise OpenError(UNDECIDED)


def multiple_line_at(chart: Chart, form: Poly, root: Root, sides: tuple[Fraction, Fraction]) -> Line:
    """What happens on a line where J = 0 is not smooth, or arcs meet in two points.

    ``sides`` are values of u beside it, between which is no other line.
    """
    exact = _exact(chart.ring, form, root)
    if exact is not None:
        parts = formal_parts(chart.ring, chart.above(exact))
        if [*parts] == [2] and len(parts[2]) == 3:
            return _smooth_elsewhere(_twofold(chart, root, parts[2], exact, sides))
    for narrow, values in _near(chart, form, root):
        if (found := _meeting(values)) is not None:
            first, last = (len(real_roots(chart.ring, chart.above(u))) for u in sides)
            return _smooth_elsewhere(_joined(narrow, *found, (first, last)))
    raise OpenError(UNDECIDED)


def _smooth_elsewhere(line: Line) -> Line:
    """The line, if two branches or none pass each meeting; where arcs turn back, it is not told how."""
    if any(meeting.is_turning for meeting in line.meetings):
        raise OpenError(MULTIPLE)
    return line


def _near(chart: Chart, form: Poly, root: Root) -> Iterator[tuple[Root, list[Interval]]]:
    """A line in ever narrower intervals, and the coefficients of J on it."""
    bits = 4 * _SPARE_BITS
    for _ in range(_TRIES):
        root = refined(chart.ring, form, root, Fraction(1, 1 << bits))
        x = Interval.of((root.lower + root.upper) / 2, bits, root.width / 2)
        values = chart.values(x, inverted=root.inverted)
        size = max(max(abs(v.lower), abs(v.upper)).bit_length() for v in values) - bits
        yield root, [halved(v, size) if size > 0 else v for v in values]
        bits *= 2


def _joined(root: Root, others: int, below: int, t: Interval, numbers: tuple[int, int]) -> Line:
    """The line on which arcs meet in one point, if the numbers of arcs beside it say so."""
    arcs = numbers[0] - others, numbers[1] - others
    if not set(arcs) <= {0, 2}:
        raise OpenError(UNDECIDED)
    return Line(root, others, (Meeting(below, arcs, t),))


def _exact(ring: Ring, form: Poly, root: Root) -> Fraction | None:
    """A root that is a short rational number; None if it is none."""
    narrow = refined(ring, form, root, Fraction(1, 1 << (4 * _SPARE_BITS)))
    near = ((narrow.lower + narrow.upper) / 2).limit_denominator(1 << _SPARE_BITS)
    if not narrow.lower <= near <= narrow.upper or (narrow.inverted and not near):
        return None
    u = 1 / near if narrow.inverted else near
    return u if ring.at(form, u) == ZERO else None


def _twofold(chart: Chart, root: Root, form: Poly, u: Fraction, sides: Sequence[Fraction]) -> Line:
    """A line on which J is the square of a form of degree 2, but for a factor.

    Between both roots J has no zero on the lines from one side to the other, so that the arcs below meet in
    the first root.
    """
    if not (roots := ascending(chart.ring, form)):
        return Line(root, 0, ())
    (_, low), (high, _) = map(ends, roots)
    between, bits = short((low + high) / 2, (high - low) / 4), 4 * _SPARE_BITS
    for _ in range(_SPARE_BITS):
        strip = Interval.of((sides[0] + sides[1]) / 2, bits, abs(sides[1] - sides[0]) / 2)
        if value_at(chart.values(strip, inverted=False), Interval.of(between, bits)).sign:
            break
        sides = [(u + 3 * side) / 4 for side in sides]
    else:
        raise OpenError(UNDECIDED)
    below = [chart.count_below(between, side) for side in sides]
    above = [len(real_roots(chart.ring, chart.above(side))) - n for side, n in zip(sides, below, strict=True)]
    if not {*below, *above} <= {0, 2}:
        raise OpenError(UNDECIDED)
    meetings = []
    for one, arcs in zip(roots, (below, above), strict=True):
        narrow = ends(refined(chart.ring, form, one, Fraction(1, 1 << bits)))
        t = Interval.of((narrow[0] + narrow[1]) / 2, bits, narrow[1] - narrow[0])
        meetings.append(Meeting(0, (arcs[0], arcs[1]), t))
    return Line(root, 0, tuple(meetings))


def _meeting(values: Sequence[Interval]) -> tuple[int, int, Interval] | None:
    """How many other roots, and how many of them below the double one, and this; None if that is open.

    (t − t₀)² divides the form; its quotient is c t² + s t + r.
    """
    spend(200, values[0].bits)
    c0, c1, c2, c3, c4 = values
    form, slope = [c0, c1, c2, c3, c4], [c1, c2.scaled(2), c3.scaled(3), c4.scaled(4)]
    linear = _remainder(slope, _remainder(form, slope))
    if not linear[1].sign or not c4.sign:
        return None
    t = linear[0].scaled(-1).over(linear[1])
    s = c3 + (c4 * t).scaled(2)
    r = c2 + (t * s).scaled(2) - t * t * c4
    square, between = s * s - (c4 * r).scaled(4), (t * c4 + s) * t + r
    if square.sign < 0:
        return 0, 0, t
    side = s + (c4 * t).scaled(2)
    if not square.sign or not between.sign or (between.sign == c4.sign and not side.sign):
        return None
    return 2, 1 if between.sign != c4.sign else 2 if side.sign == c4.sign else 0, t


def _remainder(p: list[Interval], q: list[Interval]) -> list[Interval]:
    """A multiple of p modulo q, by pseudo-division."""
    rest = list(p)
    while len(rest) >= len(q):
        lead, shift = rest.pop(), len(rest) - len(q) + 1
        rest = [x * q[-1] for x in rest]
        for k, y in enumerate(q[:-1], shift):
            rest[k] = rest[k] - lead * y
    return rest
