"""The article's eliminant: F1 and E1, its degree 96, its factors in closed form, and Q."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath as mp
import pytest
from flint import fmpz_mpoly_ctx, fmpz_poly
from hypothesis import assume, given

from rpr_solver import EXAMPLES, Manipulator, SolverError
from rpr_solver.article.eliminant import (
    DEGREE,
    ArticleEliminant,
    Legs,
    _equations,
    article_forms,
    coalescence,
)
from rpr_solver.exact.biform import BiForm, L
from rpr_solver.exact.quadratic import Form, QuadraticPoly
from rpr_solver.model.slice_map import SliceMap
from tests.support import constructed
from tests.support.article import pose as article_pose
from tests.support.constructed import Constructed
from tests.support.families import family
from tests.support.shared import eliminant_of
from tests.support.strategies import examples, lengths, manipulators

FLAT = EXAMPLES["zein-flat"]
ISOSCELES = family("isosceles, irrational")


@cache
def eliminant(m: Manipulator, l1: Fraction) -> ArticleEliminant:
    slice_map = SliceMap.of(m)
    return ArticleEliminant.of(slice_map, l1 * slice_map.scale)


def is_multiple(p: QuadraticPoly, q: QuadraticPoly) -> bool:
    """One is the other times a constant of ℚ(ω)."""
    i = p.degree
    if i != q.degree:
        return False
    lead_p, lead_q = (QuadraticPoly(fmpz_poly([x.a[i]]), fmpz_poly([x.b[i]]), x.radicand) for x in (p, q))
    difference = p * lead_q - q * lead_p
    return difference.is_zero


def value(form: BiForm, t: mp.mpf, u: mp.mpf) -> mp.mpf:
    omega = mp.sqrt(form.radicand)
    rows = [
        mp.polyval([int(c) for c in reversed(row.a.coeffs())] or [0], u)
        + omega * mp.polyval([int(c) for c in reversed(row.b.coeffs())] or [0], u)
        for row in form.rows
    ]
    return mp.polyval(rows[::-1], t)


@pytest.mark.parametrize("name", ["innocenti", "zein-flat", "twelve-cusps"])
def test_13_and_14_are_6_and_10_with_half_angles_put_in(name: str) -> None:
    """At any pose, up to one constant each and powers of 1 + t² and 1 + u²."""
    m, l1 = EXAMPLES[name], Fraction("14.98")
    slice_map = SliceMap.of(m)
    f1, e1 = article_forms(slice_map, l1 * slice_map.scale)
    ratios: list[tuple[mp.mpf, mp.mpf]] = []
    with mp.workdps(60):
        for alpha, theta in ((20, 50), (-130, 70), (95, -160)):
            at = article_pose(m, str(l1), str(alpha), str(theta))
            vectors = [(r * c, r * s) for r, c, s in zip(at.lengths, at.cosines, at.sines, strict=True)]
            a2x, a3x, a3y = (mp.mpf(x.numerator) / x.denominator for x in (m.a2x, m.a3x, m.a3y))
            legs = Legs(tuple(vectors), a2x, a3x, a3y)  # type: ignore[arg-type]
            t, u = (mp.tan(mp.radians(x) / 2) for x in (alpha, theta))
            weight = (1 + t * t) * (1 + u * u)
            printed = legs.singularity, coalescence(legs.k, legs.second_derivatives)
            ratios.append(
                (
                    value(f1, t, u) / weight**2 / printed[0],
                    value(e1, t, u) / weight**6 / printed[1],
                )
            )
        for ratio in ratios[1:]:
            assert all(abs(x / y - 1) < mp.mpf(10) ** -30 for x, y in zip(ratio, ratios[0], strict=True))


AT_POSES: list[tuple[Callable[[], Constructed], bool]] = [
    (constructed.cusp, True),
    (constructed.fold, False),
    (constructed.leg_2_closed, True),
    (constructed.leg_3_closed, True),
    (constructed.legs_1_and_3_in_line, True),
    (constructed.lines_meet_in_b1, True),
]


@pytest.mark.parametrize(("construct", "both"), AT_POSES)
def test_13_and_14_hold_where_they_should(construct: Callable[[], Constructed], both: bool) -> None:
    """At exact poses; on a fold only (13) holds."""
    at = construct()
    slice_map = SliceMap.of(at.manipulator)
    assert slice_map.radicand == 1
    t, u = at.pose.t, at.pose.u
    assert t is not None
    assert u is not None
    f1, e1 = article_forms(slice_map, at.pose.l1 * slice_map.scale)
    assert not exact_value(f1, t, u)
    assert (exact_value(e1, t, u) == 0) == both


def exact_value(form: BiForm, t: Fraction, u: Fraction) -> Fraction:
    """Of a form over ℤ."""
    rows = [sum((int(c) * u**k for k, c in enumerate(row.a.coeffs())), Fraction(0)) for row in form.rows]
    return sum((row * t**i for i, row in enumerate(rows)), Fraction(0))


def test_the_eliminant_is_the_resultant() -> None:
    """The modular one against FLINT's own, over ℤ[ω] with ω a symbol."""
    ring = fmpz_mpoly_ctx.get(("t", "u", "omega"), "lex")
    slice_map = SliceMap.of(Manipulator(*map(Fraction, (10, 5, 8, 6, 7, 7))))
    length = Fraction(9) * slice_map.scale
    ours = ArticleEliminant.of(slice_map, length)

    def joined(form: BiForm) -> Any:
        parts = ((i, w, part) for i, row in enumerate(form.rows) for w, part in enumerate((row.a, row.b)))
        return ring.from_dict(
            {(i, k, w): c for i, w, part in parts for k, c in enumerate(part.coeffs()) if c}
        )

    naive = joined(ours.f1).resultant(joined(ours.e1), "t")
    parts: tuple[dict[int, int], dict[int, int]] = ({}, {})
    for (_, k, w), c in naive.to_dict().items():
        parts[w % 2][k] = parts[w % 2].get(k, 0) + int(c) * slice_map.radicand ** (w // 2)
    top = max(parts[0])
    assert top == 96
    a, b = ours.whole.polynomial.a, ours.whole.polynomial.b
    for k in range(97):  # proportional
        assert parts[0].get(k, 0) * int(a[top]) == int(a[k]) * parts[0][top]
        assert parts[1].get(k, 0) * int(a[top]) == int(b[k]) * parts[0][top]


def test_of_a_flat_platform_the_lowest_power_of_h_remains() -> None:
    """Against FLINT's resultants with h a variable, at a few values of u."""
    length = Fraction(29)
    whole = eliminant(FLAT, length).whole
    ring = fmpz_mpoly_ctx.get(("t", "h"), "lex")
    t, h = ring.gens()
    forms = _equations(SliceMap.of(FLAT), length, L)
    orders, ratios = set(), set()
    for u in (-2, 2, 3, 4):
        f1, e1 = (form.joined.compose(t, ring.constant(u), h, ring.constant(1), ctx=ring) for form in forms)
        terms = {height: int(c) for (_, height), c in f1.resultant(e1, "t").to_dict().items()}
        lowest = min(terms)
        ratios.add(Fraction(terms[lowest], int(whole.polynomial.a(u))))
        orders.add(lowest)
    assert len(orders) == len(ratios) == 1
    assert orders != {0}


class TestFactors:
    @given(manipulators(size=6, denominators=(1, 2)), lengths(size=9, denominators=(1, 3)))
    @examples(5)
    def test_the_eliminant_is_their_product(self, m: Manipulator, l1: Fraction) -> None:
        try:
            whole = eliminant(m, l1)
        except SolverError:
            assume(False)
            raise
        product = whole.q
        for factor in whole.known:
            for _ in range(factor.multiplicity):
                product *= factor.form
        assert product.degree == DEGREE
        assert is_multiple(product.polynomial, whole.whole.polynomial)

    @pytest.mark.parametrize("name", ["innocenti", "zein-flat", "isosceles"])
    def test_q_is_that_of_the_other_elimination(self, name: str) -> None:
        """The article's conjecture: what is left is the eliminant of J and E."""
        m, l1 = EXAMPLES.get(name, ISOSCELES), Fraction(29)
        ours, theirs = eliminant(m, l1), eliminant_of(m)
        assert is_multiple(ours.q.polynomial, theirs.at(l1 * theirs.slice_map.scale))

    @pytest.mark.parametrize(
        ("construct", "origins"),
        [
            (constructed.leg_2_closed, {"L2 = 0"}),
            (constructed.leg_3_closed, {"L3 = 0"}),
            (constructed.legs_1_and_3_in_line, {"legs 1 and 3 on line A1A3"}),
            (constructed.legs_2_and_3_in_line, {"legs 2 and 3 on line A2A3"}),
            (constructed.lines_meet_in_b1, {"the three leg lines meet in B1"}),
            (constructed.lines_meet_in_b3, {"the three leg lines meet in B3, |A1B3| = L1 + d3"}),
            (
                lambda: constructed.lines_meet_in_b3(folded=True),
                {"the three leg lines meet in B3, |A1B3| = |L1 - d3|"},
            ),
            (
                constructed.legs_along_both_sides,
                {"legs 1 and 3 on line A1A3", "the three leg lines meet in B1"},
            ),
            (constructed.cusp, {"Q"}),
            (constructed.fold, set()),
            (constructed.ordinary, set()),
        ],
    )
    def test_a_pose_made_for_a_factor_is_a_root_of_it_alone(
        self, construct: Callable[[], Constructed], origins: set[str]
    ) -> None:
        at = construct()
        u = at.pose.u
        assert u is not None
        whole = eliminant(at.manipulator, at.pose.l1)
        forms = {**{factor.origin: factor.form for factor in whole.known}, "Q": whole.q}
        assert {name for name, form in forms.items() if root_of(form, u)} == origins


def root_of(form: Form, u: Fraction) -> bool:
    assert not form.polynomial.b
    return sum(int(c) * u**k for k, c in enumerate(form.polynomial.a.coeffs())) == 0


def test_of_congruent_triangles_nothing_is_left() -> None:
    with pytest.raises(SolverError, match="vanishes identically"):
        eliminant(family("congruent"), Fraction(9))
