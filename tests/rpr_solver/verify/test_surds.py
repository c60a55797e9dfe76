"""Arithmetic with a + b ω, against SymPy and floats."""

from __future__ import annotations

import math
import random

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from sympy.polys.matrices import DomainMatrix

from rpr_solver.verify.core.reader import bounded
from rpr_solver.verify.core.surds import (
    Indivisible,
    Poly,
    Ring,
    Surd,
    derivative,
    interpolated,
    primitive,
    rational,
)

RING = Ring(7)
W = sp.sqrt(7)
X = sp.Symbol("x")


def shown(p: Poly) -> sp.Expr:
    return sp.expand(sum((a + b * W) * X**k for k, (a, b) in enumerate(p)))


FIRST: Poly = ((3, 1), (-2, 5), (0, 1))
SECOND: Poly = ((1, -1), (4, 0), (2, 3), (1, 0))


def test_products_quotients_and_signs() -> None:
    product = RING.product(FIRST, SECOND)
    assert sp.expand(shown(product) - shown(FIRST) * shown(SECOND)) == 0
    assert RING.quotient(product, SECOND) == FIRST
    with pytest.raises(Indivisible):
        RING.quotient(SECOND, ((2, 0), (1, 0)))
    for x in ((3, -1), (2, -1), (-3, 1), (-2, 1), (0, 0), (5, 0), (0, -2), (-1, -1)):
        value = x[0] + x[1] * math.sqrt(7)
        assert RING.sign(x) == (value > 0) - (value < 0)


def test_common_factors_and_multiplicities() -> None:
    square = RING.product(FIRST, FIRST)
    whole = RING.product(square, SECOND)
    assert len(RING.gcd(whole, derivative(whole))) == len(FIRST)
    parts = RING.squarefree_parts(whole)
    assert {k: len(p) - 1 for k, p in parts.items()} == {1: 3, 2: 2}
    assert len(RING.field_quotient(parts[2], FIRST)) == 1
    assert RING.gcd(FIRST, SECOND) == ((1, 0),)


def test_rational_polynomials() -> None:
    ring = Ring(1)
    p = ring.product(rational([-2, 0, 1]), rational([1, 2, 1]))
    parts = {
        k: {primitive(part), primitive(rational([-a for a, _ in part]))}
        for k, part in ring.squarefree_parts(p).items()
    }
    assert rational([-2, 0, 1]) in parts[1]
    assert rational([1, 1]) in parts[2]


def test_signs_of_long_numbers_close_to_each_other() -> None:
    for places in (30, 100, 400):
        unit = 10**places
        root = math.isqrt(7 * unit**2)
        for near, sign in ((root, -1), (root + 1, 1), (2 * root, 1), (root // 2, -1)):
            assert RING.sign((near, -unit)) == sign
            assert RING.sign((-near, unit)) == -sign


T, U = sp.symbols("t u")


def test_a_resultant_with_an_irrational_coefficient() -> None:
    p, q = T**2 + sp.sqrt(5) * T - 3, 2 * T**3 - T + sp.sqrt(5)
    a, b = Ring(5).resultant([(-3, 0), (0, 1), (1, 0)], [(0, 1), (-1, 0), (0, 0), (2, 0)])
    assert sp.expand(sp.resultant(p, q, T) - a - b * sp.sqrt(5)) == 0


def test_formal_degrees_and_zero_pivots() -> None:
    assert Ring(1).resultant([(1, 0), (2, 0), (0, 0)], [(3, 0), (1, 0), (0, 0)]) == (0, 0)
    assert Ring(1).resultant([(0, 0), (1, 0)], [(5, 0), (0, 0), (1, 0)]) == (5, 0)


def test_interpolation_in_the_other_variable() -> None:
    p, q = T**2 + U * T - U**2 + 1, U * T**2 + 3
    points = range(-4, 5)
    values = [Ring(1).resultant([(1 - u * u, 0), (u, 0), (1, 0)], [(3, 0), (0, 0), (u, 0)]) for u in points]
    expected = sp.Poly(sp.resultant(p, q, T), U)
    assert [a for a, _ in interpolated(points, values)] == [int(c) for c in reversed(expected.all_coeffs())]
    assert interpolated([0, 1, 2], [(0, 0), (0, 0), (1, 0)]) == ((0, 0), (-1, 0), (1, 0))


def sylvester(p: list[Surd], q: list[Surd], omega: int) -> int:
    """The determinant for the formal degrees, by SymPy, with an integer for ω."""
    m, n = len(p) - 1, len(q) - 1
    rows = [[0] * k + [a + b * omega for a, b in reversed(p)] + [0] * (n - 1 - k) for k in range(n)]
    rows += [[0] * k + [a + b * omega for a, b in reversed(q)] + [0] * (m - 1 - k) for k in range(m)]
    return int(DomainMatrix(rows, (m + n, m + n), sp.ZZ).det())


@given(
    st.lists(st.tuples(st.integers(-3, 3), st.integers(-2, 2)), min_size=2, max_size=5),
    st.lists(st.tuples(st.integers(-3, 3), st.integers(-2, 2)), min_size=2, max_size=4),
)
def test_resultants_of_formal_degrees_are_determinants(p: list[Surd], q: list[Surd]) -> None:
    a, b = Ring(7).resultant(p, q)
    # modulo 10⁶ − 7 the number 1000 is a root of 7
    assert (a + 1000 * b - sylvester(p, q, 1000)) % (10**6 - 7) == 0


def test_the_linear_remainder_has_the_common_root() -> None:
    ring = Ring(1)
    common, p, q = rational([-3, 1]), rational([1, 0, 2, 5]), rational([4, 1, 1])
    rows, whole = ring.chain(ring.product(common, p), ring.product(common, q))
    assert whole == (0, 0)
    [linear] = [row for row in rows if len(row) == 2]
    assert primitive(linear) in (common, rational([3, -1]))


def test_a_multiple_factor_is_found_at_a_price_that_its_length_explains() -> None:
    draw, ring = random.Random(1), Ring(1237)
    twice, once = (
        tuple((draw.getrandbits(30), draw.getrandbits(30)) for _ in range(degree + 1)) for degree in (2, 12)
    )
    with bounded(10**9) as left:
        parts = ring.squarefree_parts(ring.product(ring.product(twice, twice), once))
    assert 10**9 - left[0] < 100_000
    assert {multiplicity: len(part) - 1 for multiplicity, part in parts.items()} == {1: 12, 2: 2}
    own = ring.leading_rational(twice)
    assert own[-1][1] == 0
    for found in (parts[2], ring.gcd(twice, ring.product(twice, once))):
        assert found in (own, tuple((-a, -b) for a, b in own))
