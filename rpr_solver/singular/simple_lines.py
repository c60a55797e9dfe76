"""What happens on the lines of a slice whose critical lines are all simple, read on each line itself.

Generic slices need no separators; where a line is multiple, the sweep has the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import arb, arb_poly, ctx, fmpz_poly

from rpr_solver.exact import decided
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, number_of_real_roots, separated_roots
from rpr_solver.model.jets import common_root
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import Chart, turned_rows, turns_of

_FIRST_BITS = 64
_DEGREE = 4
"""That of J in t and in u."""


def simple_chart(slice_map: SliceMap, length: Fraction) -> Chart | None:
    """The slice of one *scaled* length in the first chart, if all its critical lines are simple there.

    As :func:`chart_of`, without the tests that only multiple lines need.
    """
    parts = _first_chart(slice_map)
    n, d = length.as_integer_ratio()
    rows = tuple(j0 * d + j1 * n for j0, j1 in parts) if parts else ()
    chart = Chart(slice_map, length, *turns_of(slice_map.rho)[0], rows, _DEGREE, rows)
    if not rows or chart.discriminant.polynomial.is_zero:
        return None
    return chart if simple_and_finite(chart.lines, chart.discriminant.degree + _DEGREE) else None


@lru_cache(maxsize=4)
def _first_chart(slice_map: SliceMap) -> Sequence[Sequence[QuadraticPoly]]:
    """The coefficients of J0 and of J1 in the first chart; none if J does not hold L."""
    powers = list(zip(*slice_map.singular.coefficients, strict=True))
    if len(powers) < 2:
        return ()
    turns = turns_of(slice_map.rho)[0]
    return list(zip(*(turned_rows(rows, _DEGREE, *turns) for rows in powers), strict=True))


Gaps = list[tuple[int, int]]
"""Pairs of gaps, before and after a line, that continue each other; gap k follows arc k."""


class LineEvent:
    """What happens on a line of a slice whose critical lines are all simple."""

    def passed(self, arcs: int) -> tuple[int, Gaps]:
        """The number of arcs after the line, from that before it, and what becomes of the gaps."""
        raise NotImplementedError


@dataclass(frozen=True)
class Turning(LineEvent):
    """A simple critical line: two arcs meet; there are ``others``, ``below`` of which lie below these."""

    others: int
    below: int

    def passed(self, arcs: int) -> tuple[int, Gaps]:
        """As for any line."""
        # the gap between the arcs that meet continues nowhere
        gaps = [(k, k if k < self.below else k - 2) for k in range(self.others + 2) if k != self.below]
        pairs = [(k, other % max(self.others, 1)) for k, other in gaps]
        if arcs == self.others:
            return self.others + 2, [(other, k) for k, other in pairs]
        return self.others, pairs


@dataclass(frozen=True)
class Crossing(LineEvent):
    """A line on which one arc passes t = ∞, so that the numbers of all rise or fall by one."""

    by: int

    def passed(self, arcs: int) -> tuple[int, Gaps]:
        """As for any line."""
        return arcs, [(k, (k + self.by) % arcs) for k in range(arcs)]


def line_events(chart: Chart) -> tuple[int, list[LineEvent]]:
    """The number of arcs at u = ∞, and what happens on each line of :func:`simple_chart`, by ascending u."""
    a, b = (
        fmpz_poly([p[_DEGREE] for p in part]) for part in zip(*((x.a, x.b) for x in chart.rows), strict=True)
    )
    beyond = QuadraticPoly(a, b, chart.slice_map.radicand)
    lines = [_line_event(chart, root) for root in separated_roots(chart.lines)]
    return number_of_real_roots(beyond), lines


def _line_event(chart: Chart, root: RealRoot) -> LineEvent:
    def event(bits: int) -> LineEvent | None:
        u = root.ball if bits == _FIRST_BITS else root.refined(bits)
        work = bits + 2 * _FIRST_BITS
        rows = [row.ball(work) for row in chart.rows]
        with ctx.workprec(work):
            form = [row(u) for row in rows]
            if not form[-1].contains(0):
                return _turning(form)
            if chart.discriminant.polynomial.ball(work)(u).contains(0):
                return None
            # the arc is near t = −c₃/c₄
            side = form[-2] * rows[-1].derivative()(u)
            if side.contains(0):
                return None
            return Crossing(1 if side > 0 else -1)

    return decided(event, _FIRST_BITS, GREATEST_BITS, "a critical line could not be decided")


def _turning(form: Sequence[arb]) -> Turning | None:
    """For J on the line, which has one double root and a leading coefficient that is not 0."""
    double = common_root(form, arb_poly(list(form)).derivative().coeffs())
    if double is None or double.denominator.contains(0):
        return None
    t = double.numerator / double.denominator
    # the quotient by the square of the double factor
    lead = form[4]
    slope = form[3] + 2 * t * lead
    rest = form[2] + 2 * t * slope - t * t * lead
    square, side, between = (
        slope * slope - 4 * lead * rest,
        2 * t * lead + slope,
        (t * lead + slope) * t + rest,
    )
    if any(x.contains(0) for x in (square, between)):
        return None
    if square < 0:
        return Turning(0, 0)
    if between * lead < 0:
        return Turning(2, 1)
    return None if side.contains(0) else Turning(2, 2 if side * lead > 0 else 0)
