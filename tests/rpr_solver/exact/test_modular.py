"""Arithmetic modulo primes, against the integers and the roots that it stands for."""

from itertools import islice

import pytest
from flint import fmpz, fmpz_poly
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver.exact.modular import primes, simple_and_finite, sylvester
from rpr_solver.exact.quadratic import QuadraticPoly

RADICANDS = (1, 2, 12)
COEFFICIENTS = st.integers(-9, 9)
FORMS = st.lists(COEFFICIENTS, min_size=2, max_size=5)


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


def test_roots_to_stay_apart_from() -> None:
    p = QuadraticPoly(fmpz_poly([-3, 0, 1]), fmpz_poly([1]), 2)
    assert simple_and_finite(p, 2, apart_from=[rational(-1, 1)])
    assert not simple_and_finite(p * rational(-1, 1), 3, apart_from=[rational(-1, 1)])
    assert not simple_and_finite(p * rational(-1, 1), 3, apart_from=[rational(-2, 1, 1)])
    assert not simple_and_finite(p, 2, apart_from=[rational(0)])


def test_a_prime_that_divides_the_discriminant_is_not_the_last_word() -> None:
    """x² − p and x² + p x have double roots modulo p, and p x² − 1 one at infinity; other primes tell."""
    p = next(primes(2))[0]
    assert simple_and_finite(rational(-p, 0, 1), 2)
    assert simple_and_finite(rational(0, p, 1), 2)
    assert simple_and_finite(rational(-1, 0, p), 2)
    assert simple_and_finite(rational(p - 1, 1), 1, apart_from=[rational(-1, 1)])
