"""Equality of algebraic numbers of different fields."""

from fractions import Fraction
from random import Random

import pytest
import sympy as sp
from flint import fmpq, fmpq_poly

from rpr_solver.exact.equal_numbers import minimal_polynomial, same_number
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots

RATIONALS = Field.rationals()


def field_of(*coefficients: int) -> Field:
    """ℚ of the greatest real root."""
    return Field(real_roots(QuadraticPoly.rational(list(coefficients)))[-1])


ROOT_TWO = field_of(-2, 0, 1)
BOTH = field_of(1, 0, -10, 0, 1)
"""ℚ(√2 + √3)."""


def in_both(text: str) -> Algebraic:
    """√2 or √3 by the generator g: √2 = (g³ − 9 g) / 2, √3 = (11 g − g³) / 2."""
    coefficients = {"√2": [0, fmpq(-9, 2), 0, fmpq(1, 2)], "√3": [0, fmpq(11, 2), 0, fmpq(-1, 2)]}[text]
    return BOTH(fmpq_poly(coefficients))


def test_conjugates_are_not_thesame_number() -> None:
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
