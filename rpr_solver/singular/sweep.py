"""The topology of J = 0, exactly: a sweep over the lines θ = const of a chart.

Between neighbouring *lines*, the real roots of the discriminant and of the leading coefficient, J has a
constant number of simple real roots t on each θ: the *arcs* of a *slab*, in constant order. Across a line,
arcs are matched in *cells* of the circle of t: the separators of neighbouring cells are values of t at which
J has no zero for any u of an interval that contains the line and lies in both slabs otherwise. So an arc that
enters a cell stays in it, and the numbers of arcs that enter from both sides decide what happens there. The
separators also decide which regions of J ≠ 0 continue through the line (mathematics.md#the-sweep).

On a simple line exactly one cell has two arcs on one side and none on the other, which meet in a turning
point. On a multiple one, the distinct roots are isolated over a number field, and each gets its own cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise
from math import atan, pi, tan

from flint import arb, arb_poly, ctx

from rpr_solver.errors import SolverError
from rpr_solver.exact import decided
from rpr_solver.exact.factors import ExactRoot, simple_and_other_roots
from rpr_solver.exact.number_field import real_balls, squarefree_part, trimmed
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.real_roots import RealRoot, ball_of, fraction_of, real_roots
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import Chart, Turn, chart_of

_FIRST_BITS = 64
_STEP = 256  # bits
_CLOSE = 1e-8
"""Angles that are closer than this are separated by balls."""
_GRID = 1 << 40
"""Separators are multiples of its inverse, unless arcs are close."""
_NARROWER = 8
"""A first interval round a line is this many bits narrower than the slabs beside it."""


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


@dataclass(frozen=True)
class Slab:
    """The lines between two neighbouring ones.

    Attributes:
        arcs: the real roots t at ``sample``, ascending.
        signs: the sign of J in each gap: gap k follows arc k, and the last one holds t = ∞.
        sample: a rational u in the slab.
    """

    arcs: tuple[RealRoot, ...]
    signs: tuple[int, ...]
    sample: Fraction

    @property
    def gaps(self) -> int:
        """The number of gaps between arcs."""
        return len(self.signs)


@dataclass(frozen=True)
class Sweep:
    """Lines by ascending u; slab i follows line i, and the last one holds u = ∞. Without lines it is one."""

    chart: Chart
    lines: tuple[Line, ...]
    slabs: tuple[Slab, ...]

    @cached_property
    def line_balls(self) -> Callable[[int], list[arb]]:
        """u of each line as a ball of this many bits, kept for all points that are placed between them."""
        return cache(lambda bits: [line.root.refined(bits) for line in self.lines])

    def line_after(self, slab: int) -> int:
        """The number of the line at the end of a slab; there must be lines."""
        return (slab + 1) % len(self.lines)


def sweep(
    slice_map: SliceMap,
    length: Fraction | None,
    turns: Sequence[tuple[Turn, Turn]] | None = None,
    *,
    transposed: bool = False,
) -> Sweep:
    """The topology of the singular curves of the slice of one *scaled* length.

    Length 0 is the limit of J / L, None that of J / L² as L grows beyond all bounds. ``transposed`` sweeps
    over the lines α = const instead.

    Raises:
        SolverError: the curves have a component that is not supported.
        Unproved: lines or arcs could not be separated.
    """
    chart, simple = chart_of(slice_map, length, turns, transposed=transposed)
    roots = _line_roots(chart, simple=simple)
    if not roots:
        at = Fraction(0)
        return Sweep(chart, (), (_slab(chart, at, tuple(real_roots(chart.above(at)))),))
    ends = _intervals([root for root, _ in roots])
    lines = [
        _exact_line(chart, root, exact, *limits) if exact else _simple_line(chart, root, *limits)
        for (root, exact), limits in zip(roots, ends, strict=True)
    ]
    return Sweep(chart, tuple(lines), tuple(_slab(chart, line.around[1], line.sides[1]) for line in lines))


def _line_roots(chart: Chart, *, simple: bool) -> list[tuple[RealRoot, ExactRoot | None]]:
    if simple:
        return [(root, None) for root in real_roots(chart.lines)]
    simple_roots, others = simple_and_other_roots(chart.discriminant.polynomial)
    exact = {id(other.root): other for other in others}
    found = [*simple_roots, *real_roots(chart.lead), *(other.root for other in others)]
    return [(root, exact.get(id(root))) for root in in_order(found)]


def in_order(roots: Sequence[RealRoot]) -> list[RealRoot]:
    """Different roots of several polynomials, ascending.

    Raises:
        Unproved: two of them could not be separated.
    """

    def ascending(bits: int) -> list[RealRoot] | None:
        balls = [(root.refined(bits), root) for root in roots]
        balls.sort(key=lambda x: x[0].mid())
        return [root for _, root in balls] if all(x < y for (x, _), (y, _) in pairwise(balls)) else None

    return decided(ascending, _FIRST_BITS, GREATEST_BITS, "two critical lines could not be told apart")


def _intervals(roots: Sequence[RealRoot]) -> list[tuple[arb, arb]]:
    """For each root the largest distances that an interval round it may have to the left and right."""

    def attempt(bits: int) -> list[tuple[arb, arb]] | None:
        with ctx.workprec(bits):
            balls = [root.refined(bits) for root in roots]
            low, high = balls[0] - 1 - abs(balls[0]), balls[-1] + 1 + abs(balls[-1])
            widths = [(b - a) / 2 for a, b in pairwise([low, *balls, high])]
            if any(w.rel_accuracy_bits() < 16 or not w > 0 for w in widths):
                return None
            return [(a.lower(), b.lower()) for a, b in pairwise(widths)]

    return decided(attempt, _FIRST_BITS, GREATEST_BITS, "two critical lines could not be told apart")


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


def _simple_line(chart: Chart, root: RealRoot, left: arb, right: arb) -> Line:
    """A line with one turning point, or with none where a branch crosses t = ∞."""

    def attempt(bits: int) -> Line | None:
        around = _around(root, left, right, bits)
        sides = [real_roots(chart.above(u)) for u in around]
        longer = max(sides, key=len)
        turning = abs(len(sides[0]) - len(sides[1])) == 2
        gaps = _gaps([_End(float(arc.ball.mid()), arc.refined) for arc in longer])
        if not turning:
            return _line(chart, root, None, around, sides, _separators(gaps), len(longer))
        gaps.sort(key=lambda gap: gap.width)
        for closed in gaps[: max(1, sum(gap.is_close for gap in gaps))]:
            others = _separators(gap for gap in gaps if gap is not closed)
            line = _line(chart, root, None, around, sides, others, len(longer) - 1)
            if line is not None:
                return line
        return None

    message = "the arcs beside a critical line could not be matched"
    return decided(attempt, _NARROWER, GREATEST_BITS, message)


def _exact_line(chart: Chart, root: RealRoot, exact: ExactRoot, left: arb, right: arb) -> Line:
    """A line that is a multiple root of the discriminant."""
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
        around = _around(root, left, right, bits)
        sides = [real_roots(chart.above(u)) for u in around]
        return _line(chart, root, exact, around, sides, separators, 0, points)

    return decided(attempt, _NARROWER, GREATEST_BITS, "the arcs beside a critical line could not be matched")


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


def _separators(gaps: Iterable[_Gap]) -> list[Fraction]:
    return sorted(gap.separator for gap in gaps)


def _line(
    chart: Chart,
    root: RealRoot,
    exact: ExactRoot | None,
    around: tuple[Fraction, Fraction],
    sides: Sequence[Sequence[RealRoot]],
    separators: list[Fraction],
    cells: int,
    points: Sequence[arb] = (),
) -> Line | None:
    """The line with these separators, if J has no zero on them and the arcs beside it are as expected."""
    separators = separators or [Fraction(0)]
    with ctx.workprec(_FIRST_BITS + 2 * max(u.denominator.bit_length() for u in around)):
        interval = ball_of(around[0]).union(ball_of(around[1]))
    if not free_of_zeros(chart, interval, separators):
        return None
    positions = [[position(arc, separators) for arc in arcs] for arcs in sides]
    size = len(separators)
    left, right = positions
    meetings = [Meeting(_inside(left, cell, size), _inside(right, cell, size)) for cell in range(size)]
    if exact is None:
        shapes = sorted((len(m.left), len(m.right)) for m in meetings if m.left or m.right)
        turning = {(2, 0), (0, 2)} & set(shapes)
        if len(shapes) != cells or any(s != (1, 1) and s not in turning for s in shapes) or len(turning) > 1:
            return None
        meetings = [m for m in meetings if m.left or m.right]
    elif not points:
        if sides[0] or sides[1]:
            return None
        meetings = []
    else:
        meetings = [replace(x, point=point) for x, point in zip(meetings, points, strict=True)]
    before, after = (
        [(sum(at <= k for at in side) - 1) % max(len(side), 1) for k in range(size)] for side in positions
    )
    links = tuple(zip(before, after, strict=True))
    return Line(root, exact, tuple(meetings), links, around, (tuple(sides[0]), tuple(sides[1])))


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


def _slab(chart: Chart, sample: Fraction, arcs: tuple[RealRoot, ...]) -> Slab:
    if not chart.repeated:
        last = _sign(chart, None, sample)
        return Slab(
            arcs, tuple(last * (-1) ** (len(arcs) - 1 - k) for k in range(len(arcs))) or (last,), sample
        )
    inner = [between(x, y) for x, y in pairwise(arcs)]
    return Slab(arcs, tuple(_sign(chart, t, sample) for t in (*inner, None)), sample)


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


def _sign(chart: Chart, t: Fraction | None, u: Fraction) -> int:
    """The sign of J at a point of a slab that is on no arc; None is t = ∞."""
    top = len(chart.whole) - 1

    def sign(bits: int) -> int | None:
        with ctx.workprec(bits):
            values = [row.ball(bits)(ball_of(u)) for row in chart.whole]
            total = values[top] if t is None else arb_poly(values)(ball_of(t))
            return None if total.contains(0) else 1 if total > 0 else -1

    return decided(sign, 2 * _FIRST_BITS, GREATEST_BITS, "the sign of J could not be decided")
