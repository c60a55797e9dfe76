"""Forms from their values on a circle, and resultants from values in balls, against FLINT's."""

from __future__ import annotations

from typing import Any

import pytest
from flint import arb, arb_mat, ctx, fmpz, fmpz_mat
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import OMEGA, RING, BiForm, T, U
from rpr_solver.exact.elimination import Circle, ball_resultant, recovered, resultant, resultant_bound
from rpr_solver.exact.modular import sylvester
from rpr_solver.exact.quadratic import Form, QuadraticPoly

BITS = 200


def values(circle: Circle, form: list[int]) -> list[arb]:
    return (arb_mat(1, len(form), [fmpz(x) for x in form]) * circle.monomials(len(form) - 1)).entries()


@given(st.lists(st.integers(-(10**9), 10**9), min_size=1, max_size=30), st.integers(1, 4))
@settings(max_examples=40)
def test_coefficients_come_back_from_values(form: list[int], more: int) -> None:
    """Any degree, as many points as coefficients or more."""
    with ctx.workprec(BITS):
        circle = Circle(len(form) - 1 + more, BITS)
        back = circle.coefficients(values(circle, form), len(form) - 1)
        assert back is not None
        assert [x.unique_fmpz() for x in back] == form


@pytest.mark.parametrize("degree", [0, 1, 4, 7])
def test_values_that_are_of_no_such_form_are_noticed(degree: int) -> None:
    with ctx.workprec(BITS):
        circle = Circle(degree + 2, BITS)
        sampled = values(circle, list(range(1, degree + 2)))
        assert circle.coefficients(sampled, degree) is not None
        sampled[0] += arb(2) ** -100
        assert circle.coefficients(sampled, degree) is None


RADICANDS = (1, 2, 12)


def expected(first: BiForm, second: BiForm) -> QuadraticPoly:
    """Res_t by FLINT, for forms that lose no degree in t."""
    whole = first.joined.resultant(second.joined, "t")
    [row] = BiForm.of(whole, first.radicand, 0, first.degree_t * second.degree_u).primitive().rows
    return row


@st.composite
def pairs(draw: st.DrawFn) -> tuple[BiForm, BiForm]:
    """Two forms with leading terms in t."""
    radicand = draw(st.sampled_from(RADICANDS))
    powers = st.tuples(st.integers(0, 2), st.integers(0, 2), st.just(0), st.integers(0, 1))
    terms: Any = st.dictionaries(powers, st.integers(-9, 9).filter(bool), min_size=1, max_size=5)
    first, second = (RING.from_dict(draw(terms)) for _ in range(2))
    return (
        BiForm.of(first + T**2 * (U + 3), radicand, 2, 2),
        BiForm.of(second + T**3 * (OMEGA - 5), radicand, 3, 2),
    )


@given(pairs())
@settings(max_examples=40)
def test_the_resultant(pair: tuple[BiForm, BiForm]) -> None:
    first, second = pair
    assume(not first.zeros_at_infinity)
    form = resultant(first, second)
    assert form.degree == 2 * 2 + 3 * 2
    ours, flint = form.polynomial, expected(first, second)
    assert ours in (flint, flint * -1)


@given(pairs())
@settings(max_examples=20)
def test_the_bound_is_one_of_the_resultant(pair: tuple[BiForm, BiForm]) -> None:
    first, second = pair
    assume(not first.zeros_at_infinity)
    whole = first.joined.resultant(second.joined, "t")
    assert BiForm.of(whole, first.radicand, 0, 10).norm1() <= resultant_bound(first, second)


@given(pairs(), st.integers(1, 2))
@settings(max_examples=20)
def test_known_factors_are_divided_out(pair: tuple[BiForm, BiForm], exponent: int) -> None:
    """The content of a form in t divides the resultant once for each degree of the other form."""
    first, second = pair
    radicand = first.radicand
    assume(not first.zeros_at_infinity and not resultant(first, second).polynomial.is_zero)
    known = QuadraticPoly.rational([3, 1], radicand) + QuadraticPoly.omega(radicand)
    factor = BiForm.of((U**2 + 1) * (U + 3 + OMEGA) ** exponent, radicand, 0, 2 + exponent)
    divisor = Form(QuadraticPoly.rational([1, 0, 1], radicand), 2) * Form(known, 1)
    for _ in range(exponent - 1):
        divisor = divisor * Form(known, 1)
    form = resultant(first * factor, second, divisor * divisor * divisor)
    assert form.degree == 10
    plain = resultant(first, second).polynomial
    assert form.polynomial in (plain, plain * -1)


def test_a_factor_that_is_none_is_refused() -> None:
    first, second = BiForm.of(T + U, 2, 1, 1), BiForm.of(T * OMEGA - U**2, 2, 1, 2)
    with pytest.raises(SolverError, match="known factors"):
        resultant(first, second, Form(QuadraticPoly.rational([-7, 1], 2), 1))


def test_a_common_zero_at_infinity_counts() -> None:
    """If both leading terms in t vanish, so does the resultant, for any u."""
    first, second = BiForm.of(T + U, 2, 2, 1), BiForm.of(T - U, 2, 2, 1)
    assert resultant(first, second).polynomial.is_zero
    assert not resultant(BiForm.of(T + U, 2, 1, 1), second).polynomial.is_zero


FEW = st.lists(st.integers(-2, 3), min_size=1, max_size=6)


@given(FEW, FEW)
@settings(max_examples=200)
def test_resultants_of_balls_are_sylvesters_determinants(f: list[int], g: list[int]) -> None:
    """Whatever leading coefficients and remainders vanish."""
    rows = sylvester(f, g, 0)
    exact = fmpz_mat(rows).det() if rows else 1
    with ctx.workprec(200):
        ball = ball_resultant([arb(x) for x in f], [arb(x) for x in g])
        assert ball.contains(exact)
        assert ball.rad() < 0.25


def test_forms_with_a_common_root_have_a_resultant_near_0() -> None:
    """Not one that is no number: a ball that holds 0 to the power of a degree."""
    with ctx.workprec(200):
        x, y = arb(2).sqrt(), arb(3).sqrt()
        for more in ([], [arb(0)]):
            ball = ball_resultant([arb(0), x, y], [-x, -y, *more])
            assert ball.is_finite()
            assert ball.contains(0)


@pytest.mark.parametrize("value", ["0.5", "1.2"])
def test_balls_without_an_integer_are_refused(value: str) -> None:
    with pytest.raises(SolverError, match="known factors"):
        recovered(1, lambda _omega: [arb(3), arb(value)], 10)
