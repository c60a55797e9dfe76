"""A critical line of a sweep: which arcs meet on it, and which gaps between arcs continue through it.

Across a line, arcs are matched in *cells* of the circle of t: the separators of neighbouring cells are values
of t at which J has no zero for any u of an interval that contains the line and lies in both slabs otherwise.
So an arc that enters a cell stays in it, and the numbers of arcs that enter from both sides decide what
happens there. The separators also decide which regions of J ≠ 0 continue through the line
(mathematics.md#the-sweep).

On a simple line at most one cell has two arcs on one side and none on the other, which meet in a turning
point. On a multiple one, the distinct roots are isolated over a number field, and each gets its own cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import atan, pi, tan

from flint import arb, arb_poly, ctx

from rpr_solver.errors import SolverError
from rpr_solver.exact import decided
from rpr_solver.exact.factors import ExactRoot
from rpr_solver.exact.number_field import real_balls, squarefree_part, trimmed
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.real_roots import RealRoot, ball_of, fraction_of, real_roots
from rpr_solver.singular.charts import Chart

_FIRST_BITS = 64
_STEP = 256  # bits
_CLOSE = 1e-8
"""Angles that are closer than this are separated by balls."""
_GRID = 1 << 40
"""Separators are multiples of its inverse, unless arcs are close."""
_NARROWER = 8
"""A first interval round a line is this many bits narrower than the slabs beside it."""
_UNMATCHED = "the arcs beside a critical line could not be matched"


@dataclass(frozen=True)
class Meeting:
    """What happens in one cell of a line: the arcs, by number, that end there from the left and the right."""

    left: tuple[int, ...]
    right: tuple[int, ...]
    point: arb | None = None
    """t at the line, isolated from other points, on a multiple line."""

    @property
    def passes(self) -> bool:
        """Whether one arc goes through."""
        return len(self.left) == len(self.right) == 1

    @property
    def turns(self) -> bool:
        """Whether two arcs of one side end in each other."""
        return {len(self.left), len(self.right)} == {0, 2}


@dataclass(frozen=True)
class Line:
    """A line θ = const where arcs meet, or cross t = ∞.

    Attributes:
        root: u.
        exact: the same root in a number field, if the line is a multiple root of the discriminant.
        meetings: of its cells.
        links: the numbers of the gaps, to the left and to the right, that continue each other.
        around: two rational u, in the slabs to the left and to the right.
        sides: the arcs at these u.
    """

    root: RealRoot
    exact: ExactRoot | None
    meetings: tuple[Meeting, ...]
    links: tuple[tuple[int, int], ...]
    around: tuple[Fraction, Fraction]
    sides: tuple[tuple[RealRoot, ...], tuple[RealRoot, ...]]


def _around(root: RealRoot, left: arb, right: arb, bits: int) -> tuple[Fraction, Fraction]:
    """Two rationals, with few digits, 2^-bits of the way to the limits on both sides."""
    ends = []
    # the ball of a large root, or of one near others, is as small beside the limits as that of any other
    more = max(0, _size(root.ball.abs_upper())) + max(0, -_size(left), -_size(right))
    ball = root.refined(bits + more + _FIRST_BITS)
    with ctx.workprec(bits + more + 2 * _FIRST_BITS):
        for width, sign in ((left, -1), (right, 1)):
            step = width * arb(2) ** -bits
            unit = arb(2) ** (_size(step.mid()) - 4)
            whole = ((ball + sign * step) / unit).mid().floor().unique_fmpz()
            assert whole is not None, "the floor of an exact number"
            ends.append(Fraction(int(whole)) * fraction_of(unit))
    return ends[0], ends[1]


def _size(x: arb) -> int:
    """The exponent of the power of two just above a positive number without error."""
    mantissa, exponent = x.man_exp()
    return int(exponent) + int(mantissa).bit_length()


@dataclass(frozen=True)
class Candidate:
    """A line that is cut in cells, of which is not yet known whether arcs stay in them.

    Attributes:
        chart: of the sweep.
        around: two rational u, in the slabs to the left and to the right.
        sides: the arcs at these u.
        separators: of the cells, ascending; the first cell holds t = ∞ and begins beyond the last one.
    """

    chart: Chart
    around: tuple[Fraction, Fraction]
    sides: tuple[tuple[RealRoot, ...], tuple[RealRoot, ...]]
    separators: tuple[Fraction, ...] = ()

    @classmethod
    def near(cls, chart: Chart, root: RealRoot, limits: tuple[arb, arb], bits: int) -> Candidate:
        """Without separators, so near a line as bits tell (see :func:`_around`)."""
        around = _around(root, *limits, bits)
        before, after = (tuple(real_roots(chart.above(u))) for u in around)
        return cls(chart, around, (before, after))

    def is_separated(self) -> bool:
        """Proof that J has no zero on a separator for any u between the two."""
        with ctx.workprec(_FIRST_BITS + 2 * max(u.denominator.bit_length() for u in self.around)):
            interval = ball_of(self.around[0]).union(ball_of(self.around[1]))
        return free_of_zeros(self.chart, interval, self.separators)

    @cached_property
    def _positions(self) -> tuple[list[int], list[int]]:
        """How many separators are below each arc, on both sides."""
        before, after = ([position(arc, self.separators) for arc in arcs] for arcs in self.sides)
        return before, after

    def meetings(self) -> list[Meeting]:
        """The arcs of each cell."""
        before, after = self._positions
        size = len(self.separators)
        return [Meeting(_inside(before, cell, size), _inside(after, cell, size)) for cell in range(size)]

    def line(self, root: RealRoot, meetings: Iterable[Meeting], exact: ExactRoot | None = None) -> Line:
        """The line with these meetings."""
        # the gap that holds a separator begins with the last arc below it
        before, after = (
            [(sum(at <= k for at in own) - 1) % max(len(own), 1) for k in range(len(self.separators))]
            for own in self._positions
        )
        return Line(
            root, exact, tuple(meetings), tuple(zip(before, after, strict=True)), self.around, self.sides
        )


def simple_line(chart: Chart, root: RealRoot, limits: tuple[arb, arb]) -> Line:
    """A line with one turning point, or with none where an arc crosses t = ∞.

    Args:
        chart: of the sweep.
        root: u.
        limits: the largest distances from it, to the left and to the right, that an interval may have.

    Raises:
        Unproved: the arcs beside it could not be matched.
    """

    def attempt(bits: int) -> Line | None:
        beside = Candidate.near(chart, root, limits, bits)
        longer = max(beside.sides, key=len)
        gaps = _gaps([_End(float(arc.ball.mid()), arc.refined) for arc in longer])
        closing: Sequence[_Gap | None] = [None]
        if abs(len(beside.sides[0]) - len(beside.sides[1])) == 2:
            gaps.sort(key=lambda gap: gap.width)
            closing = gaps[: max(1, sum(gap.is_close for gap in gaps))]
        for closed in closing:
            cut = replace(beside, separators=_separators(gap for gap in gaps if gap is not closed))
            if cut.is_separated():
                meetings = [m for m in cut.meetings() if m.left or m.right]
                others = [m for m in meetings if not m.passes]
                if len(others) <= 1 and all(m.turns for m in others):
                    return cut.line(root, meetings)
        return None

    return decided(attempt, _NARROWER, GREATEST_BITS, _UNMATCHED)


def exact_line(chart: Chart, root: RealRoot, exact: ExactRoot, limits: tuple[arb, arb]) -> Line:
    """A line that is a multiple root of the discriminant, ``exact``; else as :func:`simple_line`.

    Raises:
        SolverError: J vanishes on the whole line.
        Unproved: the arcs beside it could not be matched.
    """
    u, omega = exact.in_field()
    form = trimmed([row(u, omega) for row in chart.rows])
    if len(form) != len(chart.rows):
        raise SolverError("the singular curve has a whole line theta = const, which is not drawn")
    distinct = squarefree_part(form)

    roots = real_balls(distinct) if len(distinct) > 1 else []
    points = [root(2 * _FIRST_BITS) for root in roots]
    gaps = _gaps([_End(float(x.mid()), root) for x, root in zip(points, roots, strict=True)])
    separators = _separators(gaps)
    if gaps and separators[0] == gaps[-1].separator:  # the first cell holds t = ∞ and the last point
        points = [points[-1], *points[:-1]]

    def attempt(bits: int) -> Line | None:
        cut = replace(Candidate.near(chart, root, limits, bits), separators=separators)
        if not cut.is_separated() or (not points and any(cut.sides)):
            return None
        meetings = zip(cut.meetings(), points, strict=True) if points else ()
        return cut.line(root, (replace(x, point=point) for x, point in meetings), exact)

    return decided(attempt, _NARROWER, GREATEST_BITS, _UNMATCHED)


@dataclass(frozen=True)
class _End:
    """A half tangent: a float, and balls to any precision."""

    near: float
    ball: Callable[[int], arb]


@dataclass(frozen=True)
class _Gap:
    """A gap of the circle of t, between the angles of two neighbours."""

    low: float
    high: float
    ends: tuple[_End, _End]

    @property
    def is_close(self) -> bool:
        """Whether floats barely separate its ends."""
        return self.high - self.low < _CLOSE

    @cached_property
    def width(self) -> float:
        """Its width, to a few digits."""
        if not self.is_close:
            return self.high - self.low

        def narrow(bits: int) -> float | None:
            first, second = (end.ball(bits) for end in self.ends)
            with ctx.workprec(2 * bits):
                width: arb = 2 * (second - first) / (1 + first * first)
            return float(width.mid()) if width > 0 and width.rel_accuracy_bits() > 8 else None

        return decided(narrow, _FIRST_BITS, GREATEST_BITS, "two arcs could not be told apart")

    @cached_property
    def separator(self) -> Fraction:
        """A rational half tangent in it, near the middle."""
        if self.is_close:
            return _between(*(end.ball for end in self.ends))
        return Fraction(round(_GRID * tan((self.low + self.high) / 4)), _GRID)


def _gaps(ends: Sequence[_End]) -> list[_Gap]:
    """The gaps after ascending half tangents, the last one round t = ∞."""
    angles = [2 * atan(end.near) for end in ends]
    after = zip([*angles[1:], *(a + 2 * pi for a in angles[:1])], [*ends[1:], *ends[:1]], strict=True)
    return [_Gap(a, b, (x, y)) for a, x, (b, y) in zip(angles, ends, after, strict=True)]


def _separators(gaps: Iterable[_Gap]) -> tuple[Fraction, ...]:
    """Those of all gaps, ascending; where there is none, t = 0 is one."""
    return tuple(sorted(gap.separator for gap in gaps)) or (Fraction(0),)


def _inside(positions: Sequence[int], cell: int, size: int) -> tuple[int, ...]:
    """The arcs in a cell, in the order of angles; the first cell holds t = ∞ and begins beyond the last."""
    beyond = [i for i, at in enumerate(positions) if at == size] if cell == 0 else []
    return (*beyond, *(i for i, at in enumerate(positions) if at == cell))


def position(arc: RealRoot, separators: Sequence[Fraction]) -> int:
    """How many separators are below a root."""

    def below(bits: int) -> int | None:
        ball = arc.ball if bits == _FIRST_BITS else arc.refined(bits)
        with ctx.workprec(bits + _FIRST_BITS):
            compared = [ball_of(x) - ball for x in separators]
        return None if any(x.contains(0) for x in compared) else sum(bool(x < 0) for x in compared)

    return decided(below, _FIRST_BITS, GREATEST_BITS, "an arc could not be told from a separator")


def free_of_zeros(chart: Chart, interval: arb, separators: Sequence[Fraction]) -> bool:
    """Proof that J has no zero at any of these t, for any u of an interval."""
    bits = 2 * max(0, -int(interval.rad().man_exp()[1])) + 2 * interval.mid().bits()
    bits = _STEP * (bits // _STEP + 2)  # so that the balls of the rows serve many lines
    with ctx.workprec(bits):
        form = arb_poly([row.ball(bits)(interval) for row in chart.rows])
        return not any(form(ball_of(t)).contains(0) for t in separators)


def between(first: RealRoot, second: RealRoot) -> Fraction:
    """A rational between two neighbouring roots."""
    return _between(first.refined, second.refined)


def _between(first: Callable[[int], arb], second: Callable[[int], arb]) -> Fraction:
    def middle(bits: int) -> Fraction | None:
        low, high = first(bits), second(bits)
        with ctx.workprec(2 * bits):
            cut = ((low.upper() + high.lower()) / 2).mid()
        # roots may be known better than asked for, and nearer each other than this precision tells
        return fraction_of(cut) if low < cut < high else None

    return decided(middle, _FIRST_BITS, GREATEST_BITS, "two arcs could not be told apart")
