"""Small number fields, in which several tests compute."""

from flint import fmpq, fmpq_poly

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
