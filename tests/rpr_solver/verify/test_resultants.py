"""Resultants by Sylvester's determinant, against SymPy."""

import pytest
import sympy as sp

from rpr_solver.verify.core.resultants import interpolated, interpolated_resultant, resultant
from rpr_solver.verify.core.surds import Ring

T, U = sp.symbols("t u")


def test_a_resultant_with_an_irrational_coefficient() -> None:
    p, q = T**2 + sp.sqrt(5) * T - 3, 2 * T**3 - T + sp.sqrt(5)
    a, b = resultant(Ring(5), [(-3, 0), (0, 1), (1, 0)], [(0, 1), (-1, 0), (0, 0), (2, 0)])
    assert sp.expand(sp.resultant(p, q, T) - a - b * sp.sqrt(5)) == 0


def test_formal_degrees_and_zero_pivots() -> None:
    assert resultant(Ring(1), [(1, 0), (2, 0), (0, 0)], [(3, 0), (1, 0), (0, 0)]) == (0, 0)
    assert resultant(Ring(1), [(0, 0), (1, 0)], [(5, 0), (0, 0), (1, 0)]) == (5, 0)


def test_interpolation_in_the_other_variable() -> None:
    p, q = T**2 + U * T - U**2 + 1, U * T**2 + 3
    found = interpolated_resultant(
        Ring(1), lambda u: [(1 - u * u, 0), (u, 0), (1, 0)], lambda u: [(3, 0), (0, 0), (u, 0)], 8
    )
    expected = sp.Poly(sp.resultant(p, q, T), U)
    assert [a for a, _ in found] == [int(c) for c in reversed(expected.all_coeffs())]
    with pytest.raises(ArithmeticError):
        interpolated([0, 1, 2], [0, 0, 1])
