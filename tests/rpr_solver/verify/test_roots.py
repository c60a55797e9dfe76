"""Real roots by Descartes' rule, against SymPy's Sturm sequences."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
import sympy as sp

from rpr_solver.verify.core.roots import real_roots, refined, shifted, simple_and_apart
from rpr_solver.verify.core.surds import Poly, Ring, rational

X = sp.Symbol("x")


def test_as_many_roots_as_sturm_counts() -> None:
    drawn = random.Random(2)
    for _ in range(20):
        coefficients = [drawn.randint(-9, 9) for _ in range(8)]
        p = sp.Poly(list(reversed(coefficients)), X)
        if p.degree() == 7 and p.is_sqf:
            assert len(real_roots(Ring(1), rational(coefficients))) == p.count_roots()


def test_roots_at_the_ends_and_at_infinity() -> None:
    # u (u − 1) (u + 1) (2u − 1) (u − 3), a form of degree 6: one root is infinite
    coefficients: list[int] = [
        int(c) for c in reversed(sp.Poly(X * (X**2 - 1) * (2 * X - 1) * (X - 3)).all_coeffs())
    ]
    form: Poly = (*((c, 0) for c in coefficients), (0, 0))
    roots = [refined(Ring(1), form, root, Fraction(1, 1000)) for root in real_roots(Ring(1), form)]
    values = sorted(
        None if r.inverted and not r.lower else float(1 / r.lower if r.inverted else r.lower)
        for r in roots
        if not (r.inverted and not r.lower)
    )  # type: ignore[type-var]
    assert [round(v, 2) for v in values if v is not None] == [-1, 0, 0.5, 1, 3]
    assert len(roots) == 6


def test_irrational_coefficients() -> None:
    # (u − √3) (u² + 1)
    roots = real_roots(Ring(3), ((0, -1), (1, 0), (0, -1), (1, 0)))
    [root] = [
        refined(Ring(3), ((0, -1), (1, 0), (0, -1), (1, 0)), root, Fraction(1, 10**9)) for root in roots
    ]
    assert root.inverted
    assert abs(1 / float(root.lower) - 3**0.5) < 1e-8


@pytest.mark.parametrize("bits", [1, 7, 300, 2000])
def test_a_root_to_many_bits(bits: int) -> None:
    # (u² − 2) (u² − √3 u + 5)
    form = Ring(3).product(rational([-2, 0, 1]), ((5, 0), (0, -1), (1, 0)))
    width = Fraction(1, 1 << bits)
    roots = [refined(Ring(3), form, root, width) for root in real_roots(Ring(3), form)]
    assert len(roots) == 2
    for root in roots:
        low, high = sorted((root.lower**2, root.upper**2))
        assert root.inverted
        assert root.width <= width
        assert low <= Fraction(1, 2) <= high


def test_a_root_beside_the_end_of_its_interval() -> None:
    # 0 is a root and the end of the interval of −1/8
    form = rational([0, 1, 8])
    [root] = [r for r in real_roots(Ring(1), form) if r.lower < 0]
    assert abs(float(refined(Ring(1), form, root, Fraction(1, 1 << 40)).lower) + 0.125) < 1e-9


def test_a_shift() -> None:
    assert shifted([(1, 0), (0, 1), (2, 0)]) == [(3, 1), (4, 1), (2, 0)]


def test_simple_roots_and_shared_ones() -> None:
    ring = Ring(7)
    simple, other = ((1, 1), (2, 0), (0, 3)), rational([5, 1])
    assert simple_and_apart(ring, simple, other)
    assert not simple_and_apart(ring, ring.product(simple, simple), other)
    assert not simple_and_apart(ring, ring.product(simple, other), other)
    assert simple_and_apart(Ring(1), rational([-2, 0, 1]), other)
