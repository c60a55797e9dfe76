"""Charts: turned forms have the turned zeros, and the discriminant is that of the definition."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
import sympy as sp

from rpr_solver import EXAMPLES, SolverError
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import chart_of
from tests.support.singular import SLICES, manipulator


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_the_form_of_a_chart_is_j_at_the_turned_angles(name: str, leg: int, length: str) -> None:
    slice_map = SliceMap.of(manipulator(name), leg)
    scaled = Fraction(length) * slice_map.scale
    chart, _ = chart_of(slice_map, scaled)
    whole = slice_map.singular.sliced(scaled)
    omega = Fraction(1) if slice_map.radicand == 1 else Fraction(7, 3)
    ratios = set()
    for t, u in ((Fraction(1, 5), Fraction(3)), (Fraction(-3), Fraction(1, 7)), (Fraction(4), Fraction(-5))):
        own = sum(_at(row, u, omega) * t**i for i, row in enumerate(chart.rows))
        t0, u0 = (
            (x * turn.cos + turn.sin) / (turn.cos - x * turn.sin)
            for x, turn in ((t, chart.alpha), (u, chart.theta))
        )
        value = sum(_at(row, u0, omega) * t0**i for i, row in enumerate(whole.rows))
        weight = (chart.alpha.cos - t * chart.alpha.sin) ** 4 * (chart.theta.cos - u * chart.theta.sin) ** 4
        circular = (1 + u * u) ** ((4 - chart.degree_u) // 2)
        ratios.add(value * weight / circular / own)
    assert len(ratios) == 1
    assert ratios.pop() > 0


def _at(row: QuadraticPoly, u: Fraction, omega: Fraction) -> Fraction:
    """The value with any number in the place of ω, for an identity of polynomials."""
    a, b = (sum(int(c) * u**k for k, c in enumerate(part.coeffs())) for part in (row.a, row.b))
    return a + b * omega


@pytest.mark.parametrize("name", ["zein-flat", "similar"])
def test_the_discriminant_is_that_of_the_definition(name: str) -> None:
    slice_map = SliceMap.of(manipulator(name))
    chart, _ = chart_of(slice_map, 3 * slice_map.scale)
    t, u = sp.symbols("t u")
    form = sum(int(c) * u**k * t**i for i, row in enumerate(chart.rows) for k, c in enumerate(row.a.coeffs()))
    expected = sp.Poly(sp.discriminant(form, t), u).primitive()[1]
    own = sp.Poly([int(c) for c in reversed(chart.discriminant.polynomial.a.coeffs())], u)
    quotient, rest = sp.div(expected, own)
    assert rest == 0
    while quotient.degree() > 0:
        quotient, rest = sp.div(quotient, sp.Poly(u**2 + 1, u))
        assert rest == 0


def test_a_slice_of_singular_poses_alone_is_refused() -> None:
    slice_map = replace(SliceMap.of(EXAMPLES["zein-flat"]))  # a copy, which is changed
    form = slice_map.singular
    vars(slice_map)["singular"] = replace(form, a=form.a * 0, b=form.b * 0)
    with pytest.raises(SolverError, match="every pose of this slice is singular"):
        chart_of(slice_map, slice_map.scale)
