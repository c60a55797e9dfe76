"""A + ω B in two half tangents and L, and rational forms as functions on the torus."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import fmpz_mpoly
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.exact.biform import (
    OMEGA,
    RING,
    BiForm,
    L,
    T,
    U,
    curves,
    divides,
    omega_parts,
    rational_form,
    without_common_factors,
)
from rpr_solver.exact.modular import primes
from rpr_solver.exact.quadratic import DivisionError

RADICANDS = (1, 2, 12, 1009)
powers = st.tuples(*(st.integers(0, top) for top in (3, 3, 2, 5)))
terms = st.dictionaries(powers, st.integers(-20, 20).filter(bool), max_size=6)
polynomials = terms.map(RING.from_dict)


@st.composite
def forms(draw: st.DrawFn, count: int, *, with_length: bool = True) -> list[BiForm]:
    """Several forms over one ring ℤ[ω]."""
    radicand = draw(st.sampled_from(RADICANDS))
    drawn = [draw(polynomials) for _ in range(count)]
    if not with_length:
        drawn = [p.compose(T, U, RING.constant(1), OMEGA) for p in drawn]
    return [BiForm.of(p, radicand, 3, 4) for p in drawn]


def at(p: fmpz_mpoly, t: int, u: int, length: int, omega: int, modulus: int) -> int:
    """A polynomial's value modulo an integer."""
    return int(p(t, u, length, omega)) % modulus


@given(polynomials, st.sampled_from(RADICANDS))
def test_the_square_of_omega_is_put_in(p: fmpz_mpoly, radicand: int) -> None:
    a, b = omega_parts(p, radicand)
    assert a.degrees()[3] <= 0
    assert b.degrees()[3] <= 0
    relation = OMEGA**2 - radicand if radicand != 1 else OMEGA - 1
    assert not (p - a - OMEGA * b) % relation
    assert radicand != 1 or not b


@given(forms(1), st.fractions(-9, 9, max_denominator=9))
def test_one_length_is_put_in(single: list[BiForm], length: Fraction) -> None:
    [form] = single
    top = max(0, form.joined.degrees()[2])
    rows = form.sliced(length)
    n, d = length.numerator, length.denominator
    whole = {p: c * n ** p[2] * d ** (top - p[2]) for p, c in form.joined.to_dict().items()}
    expected = RING.from_dict({p: c for p, c in whole.items() if c}).compose(T, U, RING.constant(1), OMEGA)
    assert rows.joined == expected


@given(forms(2))
def test_a_product_divided_by_a_factor(pair: list[BiForm]) -> None:
    p, q = pair
    assume(not q.is_zero)
    quotient = (p * q).quotient(q)
    primitive = p.primitive()
    assert (quotient.degree_t, quotient.degree_u) == (p.degree_t, p.degree_u)
    assert quotient.joined in (primitive.joined, -primitive.joined)


def test_a_remainder_is_refused() -> None:
    with pytest.raises(DivisionError):
        BiForm.of(T * U + 1, 2, 1, 1).quotient(BiForm.of(T + OMEGA, 2, 1, 0))


@given(forms(1), st.integers(-9, 9), st.integers(-9, 9), st.integers(-9, 9))
def test_a_residue_is_the_value_modulo_p(single: list[BiForm], t: int, u: int, length: int) -> None:
    [form] = single
    p, omega = next(primes(form.radicand))
    for w in {omega, -omega % p} if form.radicand != 1 else {omega}:
        in_t = [int(row.residue(p, w)(u % p)) for row in form.at(Fraction(length))]
        assert sum(c * t**i for i, c in enumerate(in_t)) % p == at(form.joined, t, u, length, w, p)


@given(forms(1))
def test_the_1_norm_bounds_all_coefficients(single: list[BiForm]) -> None:
    [form] = single
    largest = sum(abs(int(c)) for c in form.a.coeffs()) ** 2
    assert largest <= form.norm1() ** 2
    assert form.radicand * sum(abs(int(c)) for c in form.b.coeffs()) ** 2 <= form.norm1() ** 2


def test_common_factors_leave_both_forms() -> None:
    """J is divided by every power, so that no point of the shared curve remains as an isolated zero."""
    j = BiForm.of((T - U) ** 3 * (OMEGA * T + U), 2, 4, 4)
    e = BiForm.of((T - U) * (T * U + OMEGA), 2, 2, 2)
    rest_j, rest_e, common = without_common_factors(j, e)
    assert (rest_j.joined, rest_e.joined) in [
        (sign * (OMEGA * T + U), other * (T * U + OMEGA)) for sign in (1, -1) for other in (1, -1)
    ]
    assert common in ([T - U], [U - T])
    assert without_common_factors(rest_j, rest_e) == (rest_j, rest_e, [])


COS, SIN = rational_form(1 - T**2, 2, 0), rational_form(2 * T, 2, 0)


def test_factors_with_those_at_infinity_and_without_imaginary_ones() -> None:
    form = rational_form((T**2 + 1) * (U**2 + 1) * (T - U) ** 2 * L, 5, 6)
    found = [(str(x.a), x.degree_t, x.degree_u, n) for x, n in curves(form, 1)]
    assert found == [("t - u", 1, 1, 2), ("1", 1, 0, 1), ("1", 0, 1, 2)]
    assert all(divides(curve, form) for curve, _ in curves(form, 1))
    at_infinity = [rational_form(T**0, *degrees) for degrees in ((1, 0), (0, 1))]
    exact = rational_form(T * U + 1, 1, 1)
    assert not any(divides(curve, exact) for curve in at_infinity)
    assert all(divides(curve, -(exact - exact)) for curve in at_infinity)
