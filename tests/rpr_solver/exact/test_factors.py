"""Factors over ℚ(ω) from those of the norm, roots in number fields, and equality."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from random import Random

import pytest
import sympy as sp
from flint import fmpz_poly
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.exact.factors import (
    exact_counterparts,
    exact_roots,
    minimal_polynomial,
    norm_factors,
    same_number,
    simple_and_other_roots,
)
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from tests.support.number_fields import BOTH, RATIONALS, ROOT_TWO, in_both

ROOT2 = QuadraticPoly.omega(2)
X = QuadraticPoly.rational([0, 1], 2)


def constant(n: int) -> QuadraticPoly:
    return QuadraticPoly.rational([n], 2)


def shapes(p: QuadraticPoly) -> Counter[tuple[int, int]]:
    return Counter(shape for factor in norm_factors(p) for shape in factor.shape)


def test_a_factor_and_its_conjugate_are_told_apart() -> None:
    # (x − √2)³ (x + √2): the norm is (x² − 2)⁴, and x² − 2 divides once
    p = (X - ROOT2) * (X - ROOT2) * (X - ROOT2) * (X + ROOT2)
    assert shapes(p) == Counter({(1, 3): 1, (1, 1): 1})
    [triple] = (root for root in exact_roots(norm_factors(p)) if root.multiplicity == 3)
    u, omega = triple.in_field()
    assert (u - omega).is_zero
    assert u.sign == 1


@given(st.lists(st.tuples(st.integers(-5, 5), st.integers(-5, 5)), min_size=1, max_size=3, unique=True))
def test_every_root_is_a_zero_and_all_are_there(numbers: list[tuple[int, int]]) -> None:
    """The roots of a product of x − a − b √2, wherever their conjugates are."""
    p = constant(1)
    for a, b in numbers:
        p = p * (X - constant(a) - ROOT2 * b)
    roots = list(exact_roots(norm_factors(p)))
    assert sum(root.multiplicity for root in roots) == len(numbers)
    for root in roots:
        assert p(*root.in_field()).is_zero
    simple, others = simple_and_other_roots(p)
    assert len(simple) + len(others) == len(roots)
    balls = [r.refined(80) for r in simple] + [r.root.refined(80) for r in others]
    assert all(any(ball.overlaps(r.root.refined(80)) for ball in balls) for r in roots)


@given(st.lists(st.integers(-9, 9), min_size=2, max_size=5), st.lists(st.integers(-9, 9), max_size=5))
def test_real_roots_have_exact_counterparts(a: list[int], b: list[int]) -> None:
    p = QuadraticPoly(fmpz_poly(a), fmpz_poly(b), 2)
    norm = p.norm
    assume(p.degree > 0 and p.a.degree() != p.b.degree() and norm.gcd(norm.derivative()).degree() == 0)
    roots = real_roots(p)
    for root in roots[:2]:
        [exact] = exact_counterparts([root], norm_factors(p))
        assert exact.root.refined(100).overlaps(root.refined(100))
        assert p(*exact.in_field()).is_zero


def test_conjugates_are_not_the_same_number() -> None:
    two, other = ROOT_TWO.generator, in_both("√2")
    assert same_number(two, other)
    assert not same_number(two, -other)
    assert not same_number(two, in_both("√3"))
    assert same_number(other * other, RATIONALS(2))


@pytest.mark.parametrize("seed", range(6))
def test_minimal_polynomials(seed: int) -> None:
    """Against SymPy's; elements of subfields have one of lower degree."""
    random = Random(seed)
    a, b, c = (random.randint(-3, 3) * (k < 1 + seed % 3) for k in range(3))
    ours = minimal_polynomial(in_both("√2") * a + in_both("√3") * b + BOTH(c))
    x = sp.Symbol("x")
    theirs = sp.Poly(sp.minimal_polynomial(a * sp.sqrt(2) + b * sp.sqrt(3) + c, x), x)
    assert [Fraction(str(k)) for k in ours.coeffs()] == [
        Fraction(str(k)) for k in theirs.monic().all_coeffs()
    ][::-1]
