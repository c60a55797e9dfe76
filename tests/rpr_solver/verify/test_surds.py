"""Arithmetic with a + b ω, against SymPy and floats."""

import math

import pytest
import sympy as sp

from rpr_solver.verify.core.surds import Indivisible, Poly, Ring, derivative, primitive, rational

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
