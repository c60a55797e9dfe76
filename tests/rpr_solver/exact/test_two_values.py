"""Polynomials from their values at two numbers, and the bound on which it rests."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from flint import arb, fmpz, fmpz_mpoly, fmpz_poly
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.two_values import Size, from_two_values, resultant_bits

COEFFICIENTS = st.lists(st.integers(-(10**12), 10**12), min_size=1, max_size=26)


def values(p: QuadraticPoly) -> Callable[[int], Callable[[arb], arb]]:
    return lambda x: lambda omega: arb(p.a(fmpz(x))) + omega * arb(p.b(fmpz(x)))


@given(COEFFICIENTS, COEFFICIENTS, st.sampled_from([1, 2, 12]), st.integers(0, 3))
@settings(max_examples=60)
def test_a_polynomial_comes_back(a: list[int], b: list[int], radicand: int, more: int) -> None:
    """Of any degree, even with coefficients that just have so many bits."""
    p = QuadraticPoly(fmpz_poly(a), fmpz_poly([] if radicand == 1 else b), radicand)
    bits = max([x.bit_length() for x in a + b])
    assert from_two_values(radicand, max(len(a), len(b)) - 1 + more, bits, values(p)) == p


@pytest.mark.parametrize("p", [[2**40], [0, 0, 0, 1]])
def test_a_polynomial_that_is_too_large_is_refused(p: list[int]) -> None:
    """A coefficient that is too long, or a degree that is too high."""
    with pytest.raises(SolverError, match="known factors"):
        from_two_values(1, 1, 10, values(QuadraticPoly.rational(p)))


def test_a_number_that_is_none_of_the_ring_is_refused() -> None:
    with pytest.raises(SolverError, match="known factors"):
        from_two_values(1, 1, 10, lambda _x: lambda _omega: arb(1) / 3)


FORMS = st.lists(st.lists(st.integers(-99, 99), min_size=3, max_size=3), min_size=3, max_size=3)


def size(form: fmpz_mpoly) -> Size:
    return Size(2, sum((c * c for c in form.coeffs()), fmpz(0)))


@given(FORMS, FORMS, st.lists(st.integers(-99, 99), min_size=1, max_size=3))
@settings(max_examples=60)
def test_no_coefficient_of_a_resultant_is_longer(
    first: list[list[int]], second: list[list[int]], factor: list[int]
) -> None:
    """Also once a factor of one of the forms is divided out of it."""
    f, g = (
        sum((c * T**i * U**k for i, row in enumerate(form) for k, c in enumerate(row)), 0 * T)
        for form in (first, second)
    )
    known = QuadraticPoly.rational(factor)
    assume(not known.is_zero and all(form.degrees()[0] == 2 for form in (f, g)))
    [row] = BiForm.of(f.resultant(g, "t"), 1, 0, 8).rows
    assert row.a.height_bits() <= resultant_bits(size(f), size(g), [], 1, 8, 1)
    larger = size(f * sum((c * U**k for k, c in enumerate(factor)), 0 * T))
    assert row.a.height_bits() <= resultant_bits(larger, size(g), [known, known], 1, 8, 1)


def test_known_factors_and_a_divisor_shorten_the_bound() -> None:
    size = Size(2, fmpz(10) ** 6)
    bits = resultant_bits(size, size, [], 1, 8, 1)
    assert resultant_bits(size, size, [QuadraticPoly.rational([1, 1 << 20])], 1, 8, 1) <= bits - 19
    assert resultant_bits(size, size, [], 1 << 20, 8, 1) <= bits - 19
    # 1000 + 707 ω with ω² = 2 is 2000, and its conjugate 1/7
    long = QuadraticPoly(fmpz_poly([1000]), fmpz_poly([707]), 2)
    assert bits <= resultant_bits(size, size, [long], 1, 8, 1) <= bits + 3


def test_rho_is_measured_away() -> None:
    """t² − 2u² and t² + u² have the resultant 9u⁴, and 3t² − 6u² and 3t² + 3u² with ρ = 3 the one 9·3⁴ u⁴."""
    plain = resultant_bits(Size(2, fmpz(5)), Size(2, fmpz(2)), [], 1, 4, 1)
    assert (9).bit_length() <= plain
    # the coefficients in √3 t and √3 u are the same
    assert plain + 6 <= resultant_bits(Size(2, fmpz(5)), Size(2, fmpz(2)), [], 1, 4, 3) <= plain + 8
