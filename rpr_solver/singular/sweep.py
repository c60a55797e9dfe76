"""The topology of J = 0, exactly: a sweep over the lines θ = const of a chart.

Between neighbouring *lines*, the real roots of the discriminant and of the leading coefficient, J has a
constant number of simple real roots t on each θ: the *arcs* of a *slab*, in constant order. What happens on
the lines is decided in line.py (mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise

from flint import arb, arb_poly, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.factors import ExactRoot, simple_and_other_roots
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import Chart, Turn, chart_of
from rpr_solver.singular.line import Line, between, exact_line, simple_line

_FIRST_BITS = 64


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
        exact_line(chart, root, exact, limits) if exact else simple_line(chart, root, limits)
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


def _slab(chart: Chart, sample: Fraction, arcs: tuple[RealRoot, ...]) -> Slab:
    if not chart.repeated:
        last = _sign(chart, None, sample)
        return Slab(
            arcs, tuple(last * (-1) ** (len(arcs) - 1 - k) for k in range(len(arcs))) or (last,), sample
        )
    inner = [between(x, y) for x, y in pairwise(arcs)]
    return Slab(arcs, tuple(_sign(chart, t, sample) for t in (*inner, None)), sample)


def _sign(chart: Chart, t: Fraction | None, u: Fraction) -> int:
    """The sign of J at a point of a slab that is on no arc; None is t = ∞."""
    top = len(chart.whole) - 1

    def sign(bits: int) -> int | None:
        with ctx.workprec(bits):
            values = [row.ball(bits)(ball_of(u)) for row in chart.whole]
            total = values[top] if t is None else arb_poly(values)(ball_of(t))
            return None if total.contains(0) else 1 if total > 0 else -1

    return decided(sign, 2 * _FIRST_BITS, GREATEST_BITS, "the sign of J could not be decided")
