"""Forms as functions on the torus: their derivatives against differences, and their factors."""

from fractions import Fraction

import pytest

from rpr_solver.exact.biform import BiForm, L, T, U
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.torus_forms import (
    along_alpha,
    along_theta,
    by_length,
    curves,
    divides,
    form_sum,
    negative,
    rational_form,
    value,
)

ONE = Field.rationals()(1)
COS, SIN = rational_form(1 - T**2, 2, 0), rational_form(2 * T, 2, 0)


def same(x: BiForm, y: BiForm) -> bool:
    return form_sum(x, negative(y)).is_zero and (x.degree_t, x.degree_u) == (y.degree_t, y.degree_u)


def test_the_derivatives_of_cosine_and_sine() -> None:
    assert same(along_alpha(COS), negative(form_sum(SIN, SIN)))
    assert same(along_alpha(SIN), form_sum(COS, COS))
    assert along_theta(COS).is_zero
    half = rational_form(1 + 0 * T, 1, 0)  # cos(α/2)
    assert along_alpha(half).a == -T


def test_the_product_rule() -> None:
    x, y = rational_form(T * U**2 - T + 2 * U, 1, 2), rational_form(3 * T**2 - U, 2, 2)
    for along in (along_alpha, along_theta):
        assert same(along(x * y), form_sum(along(x) * y, x * along(y)))


def test_powers_of_the_length() -> None:
    zeroth, first = by_length(rational_form(T**2 - U + L * (T - 2), 2, 1))
    assert (zeroth.a, first.a) == (T**2 - U, T - 2)


def test_factors_with_those_at_infinity_and_without_imaginary_ones() -> None:
    form = rational_form((T**2 + 1) * (U**2 + 1) * (T - U) ** 2 * L, 5, 6)
    found = [(str(x.a), x.degree_t, x.degree_u, n) for x, n in curves(form)]
    assert found == [("t - u", 1, 1, 2), ("1", 1, 0, 1), ("1", 0, 1, 2)]
    assert all(divides(curve, form) for curve, _ in curves(form))
    at_infinity = [rational_form(T**0, *degrees) for degrees in ((1, 0), (0, 1))]
    exact = rational_form(T * U + 1, 1, 1)
    assert not any(divides(curve, exact) for curve in at_infinity)
    assert all(divides(curve, negative(form_sum(exact, negative(exact)))) for curve in at_infinity)


@pytest.mark.parametrize(
    ("t", "u", "expected"), [(2, 3, 17), (None, 3, 3), (2, None, 8), (None, None, 1), (0, 5, -7)]
)
def test_values_at_infinity_are_leading_coefficients(t: int | None, u: int | None, expected: int) -> None:
    form = rational_form(T**2 * U + 2 * T * U - 7, 2, 1)
    at = [None if x is None else ONE.field(Fraction(x)) for x in (t, u)]
    assert value(form, *at, ONE).rational == expected
