"""Resultants from values modulo primes, against FLINT's resultants over ℤ[t, u, ω]."""

from typing import Any

import pytest
from flint import fmpz, fmpz_mat, fmpz_poly, nmod_poly
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import OMEGA, RING, BiForm, T, U
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.modular import (
    formal_resultant,
    interpolated,
    primes,
    reconstruct,
    simple_and_finite,
    sylvester,
)
from rpr_solver.exact.quadratic import Form, QuadraticPoly

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


@given(pairs(), st.integers(1, 2))
@settings(max_examples=20)
def test_known_factors_are_divided_out(pair: tuple[BiForm, BiForm], exponent: int) -> None:
    """The content of a form in t divides the resultant once for each degree of the other form."""
    first, second = pair
    radicand = first.radicand
    assume(not first.zeros_at_infinity and not resultant(first, second).polynomial.is_zero)
    known = QuadraticPoly.rational([3, 1], radicand) + QuadraticPoly.omega(radicand)
    factor = BiForm.of((U**2 + 1) * (U + 3 + OMEGA) ** exponent, radicand, 0, 2 + exponent)
    form = resultant(first * factor, second, circular=3, known=Form(known, 1), exponent=3 * exponent)
    assert form.degree == 10
    plain = resultant(first, second).polynomial
    assert form.polynomial in (plain, plain * -1)


def test_a_factor_that_is_none_is_refused() -> None:
    first, second = BiForm.of(T + U, 2, 1, 1), BiForm.of(T * OMEGA - U**2, 2, 1, 2)
    with pytest.raises(SolverError, match="known factors"):
        resultant(first, second, known=Form(QuadraticPoly.rational([-7, 1], 2), 1), exponent=1)


def test_a_common_zero_at_infinity_counts() -> None:
    """If both leading terms in t vanish, so does the resultant, for any u."""
    first, second = BiForm.of(T + U, 2, 2, 1), BiForm.of(T - U, 2, 2, 1)
    assert resultant(first, second).polynomial.is_zero
    assert not resultant(BiForm.of(T + U, 2, 1, 1), second).polynomial.is_zero


@given(*[st.lists(st.integers(-9, 9), min_size=2, max_size=4)] * 2)
def test_a_formal_resultant_is_the_sylvester_determinant(j: list[int], e: list[int]) -> None:
    p, _ = next(primes(1))
    determinant = fmpz_mat([[fmpz(x) for x in row] for row in sylvester(j, e, 0)]).det()
    assert formal_resultant([x % p for x in j], [x % p for x in e], p) == determinant % p


@pytest.mark.parametrize("radicand", [1, 2, 1009, 10**40 + 3])
def test_primes_in_which_omega_exists(radicand: int) -> None:
    found = primes(radicand)
    first = [next(found) for _ in range(8)]
    assert len({p for p, _ in first}) == 8
    for p, omega in first:
        assert fmpz(p).is_prime()
        assert p % 4 == 3
        assert p < 2**62
        assert (omega * omega - radicand) % p == 0
    again = primes(radicand)
    assert [next(again) for _ in range(8)] == first


def test_simple_finite_roots_are_proved() -> None:
    p = QuadraticPoly(fmpz_poly([-3, 0, 1]), fmpz_poly([1]), 2)  # x² − 3 + √2
    assert simple_and_finite(p, 2)
    assert not simple_and_finite(p, 3)
    assert not simple_and_finite(p * p, 4)
    assert simple_and_finite(p * p.conjugate, 4)
    assert simple_and_finite(p, 2, apart_from=fmpz_poly([-1, 1]))
    assert not simple_and_finite(p * QuadraticPoly.rational([-1, 1], 2), 3, apart_from=fmpz_poly([-1, 1]))


@given(st.lists(st.lists(st.integers(0, 10**18), min_size=3, max_size=3), min_size=2, max_size=4))
def test_interpolation_leads_back_to_the_coefficients(rows: list[list[int]]) -> None:
    p, _ = next(primes(1))
    us, ls = (2, 5, 7), tuple(range(1, len(rows) + 1))
    in_l = [nmod_poly([row[k] for row in rows], p) for k in range(3)]
    values = [[int(nmod_poly([int(c(length)) for c in in_l], p)(u)) for u in us] for length in ls]
    assert interpolated(values, us, ls, p) == rows


@given(
    st.sampled_from(RADICANDS),
    st.lists(st.tuples(*[st.integers(-(10**30), 10**30)] * 2), min_size=1, max_size=4),
)
def test_coefficients_are_found_from_their_residues(radicand: int, pairs: list[tuple[int, int]]) -> None:
    pairs = [(a, 0 if radicand == 1 else b) for a, b in pairs]
    polynomial = QuadraticPoly(fmpz_poly([a for a, _ in pairs]), fmpz_poly([b for _, b in pairs]), radicand)

    def image(p: int, omega: int, first: bool) -> list[int] | None:
        return None if first and p == next(primes(radicand))[0] else [(a + omega * b) % p for a, b in pairs]

    a, b = reconstruct(radicand, image, 10**30)
    assert QuadraticPoly(fmpz_poly(a), fmpz_poly(b), radicand) == polynomial.primitive()
