"""Arithmetic modulo primes, against the integers and the roots that it stands for."""

from itertools import islice
from math import prod
from typing import Any

import pytest
from flint import fmpz, fmpz_mat, fmpz_poly, nmod_poly
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver.exact.modular import (
    formal_resultant,
    interpolated,
    primes,
    reconstruct,
    resultants,
    simple_and_finite,
    sylvester,
)
from rpr_solver.exact.quadratic import QuadraticPoly

RADICANDS = (1, 2, 12)
P = next(primes(1))[0]
COEFFICIENTS = st.integers(-9, 9)
FORMS = st.lists(COEFFICIENTS, min_size=2, max_size=5)


def poly(*coefficients: int) -> fmpz_poly:
    return fmpz_poly(list(coefficients))


def rational(*coefficients: int, radicand: int = 2) -> QuadraticPoly:
    return QuadraticPoly.rational(list(coefficients), radicand)


@pytest.mark.parametrize("radicand", [1, 2, 1009, 10**40 + 3])
def test_primes_in_which_omega_exists(radicand: int) -> None:
    first = list(islice(primes(radicand), 8))
    assert [p for p, _ in first] == sorted({p for p, _ in first}, reverse=True)
    for p, omega in first:
        assert fmpz(p).is_prime()
        assert p < 2**62
        assert (omega * omega - radicand) % p == 0
    assert list(islice(primes(radicand), 8)) == first


def test_no_prime_has_a_root_of_minus_one() -> None:
    """So no value of an integer u makes u² + 1 vanish, and both square roots of ω² are told apart."""
    for p, _ in islice(primes(2), 8):
        assert fmpz(p - 1).jacobi(fmpz(p)) == -1


def test_for_a_rational_height_omega_is_one() -> None:
    assert all(omega == 1 for _, omega in islice(primes(1), 8))


# simple_and_finite


@given(st.sampled_from(RADICANDS), FORMS, FORMS, st.integers(0, 1))
@example(2, [0, 1, 0], [1, 0, 0], 0)
def test_a_form_with_simple_finite_roots_is_told_from_others(
    radicand: int, a: list[int], b: list[int], spare: int
) -> None:
    """The discriminant of A + √r B vanishes with its norm, which is an integer."""
    polynomial = QuadraticPoly(fmpz_poly(a), fmpz_poly(b) * (radicand != 1), radicand)
    assume(polynomial.degree > 0)
    x = discriminant(polynomial)
    degree = polynomial.degree + spare
    assert simple_and_finite(polynomial, degree) == (spare == 0 and x != (0, 0))


def discriminant(polynomial: QuadraticPoly) -> tuple[int, int]:
    """Res(P, P′) by fraction-free expansion of Sylvester's determinant over ℤ[ω]."""
    r, n = polynomial.radicand, polynomial.degree
    pairs = [(int(polynomial.a[k]), int(polynomial.b[k])) for k in range(n + 1)]
    slopes = [(k * x, k * y) for k, (x, y) in enumerate(pairs)][1:]
    matrix = sylvester(pairs, slopes, (0, 0))

    def determinant(rows: list[list[tuple[int, int]]]) -> tuple[int, int]:
        if not rows:
            return 1, 0
        total = [0, 0]
        for i, row in enumerate(rows):
            x, y = row[0]
            if x or y:
                a, b = determinant([other[1:] for k, other in enumerate(rows) if k != i])
                sign = -1 if i % 2 else 1
                total[0] += sign * (x * a + r * y * b)
                total[1] += sign * (x * b + y * a)
        return total[0], total[1]

    return determinant(matrix)


def test_a_conjugate_pair_is_simple_and_a_square_is_not() -> None:
    p = QuadraticPoly(poly(-3, 0, 1), poly(1), 2)  # x² − 3 + √2
    assert simple_and_finite(p, 2)
    assert not simple_and_finite(p * p, 4)
    assert simple_and_finite(p * p.conjugate, 4)


def test_a_zero_at_infinity_is_not_finite() -> None:
    p = rational(-3, 0, 1)
    assert simple_and_finite(p, 2)
    assert not simple_and_finite(p, 3)
    assert not simple_and_finite(p * 0, 0)


def test_roots_to_stay_apart_from() -> None:
    p = QuadraticPoly(poly(-3, 0, 1), poly(1), 2)
    assert simple_and_finite(p, 2, apart_from=poly(-1, 1))
    assert not simple_and_finite(p * rational(-1, 1), 3, apart_from=poly(-1, 1))
    assert not simple_and_finite(p * rational(-1, 1), 3, apart_from=poly(-2, 1, 1))
    assert not simple_and_finite(p, 2, apart_from=poly(0))


def test_a_prime_that_divides_the_discriminant_is_not_the_last_word() -> None:
    """x² − p and x² + p x have double roots modulo p, and p x² − 1 one at infinity; other primes tell."""
    p = next(primes(2))[0]
    assert simple_and_finite(rational(-p, 0, 1), 2)
    assert simple_and_finite(rational(0, p, 1), 2)
    assert simple_and_finite(rational(-1, 0, p), 2)
    assert simple_and_finite(rational(p - 1, 1), 1, apart_from=poly(-1, 1))


# resultants and their matrices


@given(FORMS, FORMS)
@example([0, 1, 0], [3, 1, 0])
def test_a_formal_resultant_is_the_sylvester_determinant(j: list[int], e: list[int]) -> None:
    determinant = fmpz_mat([[fmpz(x) for x in row] for row in sylvester(j, e, 0)]).det()
    assert formal_resultant([x % P for x in j], [x % P for x in e], P) == determinant % P


@given(
    st.integers(1, 9), st.lists(COEFFICIENTS, min_size=1, max_size=4),
    st.integers(1, 9), st.lists(COEFFICIENTS, min_size=1, max_size=4),
    st.integers(0, 2), st.integers(0, 2),
)  # fmt: skip
def test_a_formal_resultant_is_a_product_over_pairs_of_roots(
    a: int, xs: list[int], b: int, ys: list[int], more: int, others: int
) -> None:
    """aⁿ bᵐ Π (xᵢ − yₖ); zeros at infinity give leading coefficients, and 0 where both forms have one."""
    m, n = len(xs), len(ys)
    expected = a**n * b**m * prod(x - y for x in xs for y in ys)
    if more and others:
        expected = 0
    elif more:
        # Sylvester's determinant with zeros in front of J: one factor b and a sign (−1)ⁿ for each
        expected *= ((-1) ** n * b) ** more
    elif others:
        expected *= a**others
    j, e = ([int(c) for c in from_roots(lead, roots).coeffs()] for lead, roots in ((a, xs), (b, ys)))
    j, e = j + [0] * more, e + [0] * others
    assert formal_resultant([c % P for c in j], [c % P for c in e], P) == expected % P


def from_roots(lead: int, roots: list[int]) -> fmpz_poly:
    return prod((poly(-x, 1) for x in roots), start=poly(lead))


def test_resultants_are_taken_at_each_point() -> None:
    """t − u and t² − 2u − 3 meet where u² − 2u − 3 = 0."""
    first, second = ([nmod_poly(c, P) for c in form] for form in ([[0, -1], [1]], [[-3, -2], [0], [1]]))
    us = [-1 % P, 0, 1, 3, 7]
    assert [(x + P // 2) % P - P // 2 for x in resultants(first, second, us)] == [0, -3, -4, 0, 32]


# interpolation and reconstruction


@given(st.lists(st.lists(st.integers(0, 10**18), min_size=3, max_size=3), min_size=2, max_size=4))
def test_interpolation_leads_back_to_the_coefficients(rows: list[list[int]]) -> None:
    us, ls = (2, 5, 7), tuple(range(1, len(rows) + 1))
    values = [
        [sum(c * length**i * u**k for i, row in enumerate(rows) for k, c in enumerate(row)) % P for u in us]
        for length in ls
    ]
    assert interpolated(values, us, ls, P) == rows


INTEGERS = st.integers(-(10**30), 10**30)


@given(
    st.sampled_from(RADICANDS),
    st.lists(st.tuples(INTEGERS, INTEGERS), min_size=1, max_size=4),
    st.sets(st.integers(0, 3), max_size=2),
)
@example(2, [(0, 0)], {0})
@example(12, [(10**30, -(10**30)), (1, 0)], set())
@example(1, [(-(10**30), 0), (1, 0)], set())
def test_coefficients_are_reconstructed_from_their_residues(
    radicand: int, pairs: list[tuple[int, int]], unsuitable: set[int]
) -> None:
    """Whatever primes are unsuitable; the common content is removed."""
    pairs = [(a, 0 if radicand == 1 else b) for a, b in pairs]
    polynomial = QuadraticPoly(fmpz_poly([a for a, _ in pairs]), fmpz_poly([b for _, b in pairs]), radicand)
    refused = {p for i, (p, _) in enumerate(islice(primes(radicand), 4)) if i in unsuitable}

    def image(p: int, omega: int, _first: bool) -> list[int] | None:
        return None if p in refused else [(a + omega * b) % p for a, b in pairs]

    a, b = reconstruct(radicand, image, 10**30)
    assert (len(a), len(b)) == (len(pairs), len(pairs))
    assert QuadraticPoly(fmpz_poly(a), fmpz_poly(b), radicand) == polynomial.primitive()


@pytest.mark.parametrize("radicand", RADICANDS)
@pytest.mark.parametrize("count", [1, 2, 5])
def test_as_many_primes_are_taken_as_the_bound_asks_for(radicand: int, count: int) -> None:
    """The largest coefficients that so many primes tell apart; one more takes a prime more."""
    modulus = prod(p for p, _ in islice(primes(radicand), count))
    largest = (modulus - 1) // 2
    for bound, expected in ((largest, count), (largest + 1, count + 1)):
        seen: set[int] = set()
        pairs = [(bound, 0), (-bound, 0), (1, 0)]

        def image(p: int, omega: int, _first: bool, known: Any = pairs, seen: set[int] = seen) -> list[int]:
            seen.add(p)
            return [(a + omega * b) % p for a, b in known]

        a, b = reconstruct(radicand, image, bound)
        assert (a, b) == ([bound, -bound, 1], [0, 0, 0])
        assert len(seen) == expected


def test_only_the_first_image_of_all_is_marked_as_the_first() -> None:
    """An unsuitable prime gives no image, so the mark stays; the conjugate's image never has it."""
    marks: list[tuple[int, bool]] = []
    skipped = next(primes(2))[0]

    def image(p: int, omega: int, first: bool) -> list[int] | None:
        marks.append((p, first))
        return None if p == skipped else [omega]

    assert reconstruct(2, image, 2**100) == ([0], [1])
    _, second, third = (p for p, _ in islice(primes(2), 3))
    assert marks == [(skipped, True), (second, True), (second, False), (third, False), (third, False)]
