from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.triangles.norms import (
    SquareClass,
    norm_equation,
    point_over,
    ramified,
    split_square,
    splits,
)
from tests.support.strategies import rationals

RHOS = st.integers(1, 1000)
SIDES = rationals(-200, 200, (1, 10, 100, 7))


@given(RHOS, SIDES, SIDES)
def test_a_norm_is_found_again(rho: int, x: Fraction, y: Fraction) -> None:
    if not x and not y:
        return
    k = x * x + rho * y * y
    solution = norm_equation(rho, k)
    assert solution is not None
    u, v = solution
    assert u * u + rho * v * v == k
    # about as short as the given numbers
    assert max(z.denominator for z in solution) < 1000 * rho * x.denominator * y.denominator


@given(st.integers(1, 60), st.integers(1, 60))
def test_there_is_a_solution_where_no_prime_is_ramified(rho: int, k: int) -> None:
    primes = ramified(SquareClass.of(rho), SquareClass.of(k))
    assert len(primes) % 2 == 0
    assert (norm_equation(rho, Fraction(k)) is None) == bool(primes)


@pytest.mark.parametrize(("p", "modulus"), [(2, 16), (3, 9), (5, 25)])
@given(rho=st.integers(1, 60), k=st.integers(1, 60))
def test_a_prime_is_ramified_where_no_residues_are_a_solution(p: int, modulus: int, rho: int, k: int) -> None:
    own, other = SquareClass.of(rho), SquareClass.of(k)
    # residues with a unit among them; for square-free numbers this modulus decides
    residues = [x * x for x in range(modulus)]
    found = any(
        (x + own.free * y - other.free * z) % modulus == 0 and (x % p or y % p or z % p)
        for x, y, z in product(sorted({x % modulus for x in residues}), repeat=3)
    )
    assert (p in ramified(own, other)) == (not found)


@given(st.integers(1, 60), st.integers(2, 60), st.integers(1, 400))
def test_a_point_over_a_quadratic_field_has_the_norm(rho: int, radicand: int, k: int) -> None:
    if split_square(radicand)[1] == 1:
        return
    primes = ramified(SquareClass.of(rho), SquareClass.of(k))
    point = point_over(rho, radicand, Fraction(k))
    assert (point is not None) == splits(primes, radicand)
    if point:
        (x, a), (y, b) = point
        assert x * x + radicand * a * a + rho * (y * y + radicand * b * b) == k
        assert x * a + rho * y * b == 0
