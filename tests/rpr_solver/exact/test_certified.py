"""Forms with what proves their real roots."""

from __future__ import annotations

from flint import fmpz_poly

from rpr_solver.exact.certified import Certified
from rpr_solver.exact.quadratic import Form, QuadraticPoly


def of(coefficients: list[int], degree: int) -> Certified:
    return Certified.of(Form(QuadraticPoly.rational(fmpz_poly(coefficients)), degree))


def test_simple_roots_have_a_prime() -> None:
    found = of([-2, 0, 1], 2)  # u² − 2
    assert found.place is not None
    prime = int((found.squarefree_json() or {})["prime"])
    assert (prime > 2, [multiplicity for _, multiplicity in found.roots]) == (True, [1, 1])
    assert found.polynomial_json("u") == {"variable": "u", "degree": 2, "coefficients": ["-2", "0", "1"]}


def test_multiple_and_infinite_roots_have_none() -> None:
    double, infinite = of([0, 0, -1, 1], 3), of([-2, 0, 1], 3)  # u³ − u²
    assert sorted(multiplicity for _, multiplicity in double.roots) == [1, 2]
    assert [double.squarefree_json(), infinite.squarefree_json()] == [None, None]
    assert len(infinite.roots) == 2
    assert of([0], 1).roots == ()


def test_an_irrational_coefficient() -> None:
    found = Certified.of(Form(QuadraticPoly(fmpz_poly([0, 1]), fmpz_poly([1]), 3), 1))  # u + √3
    assert found.polynomial_json("u")["omega"] == "sqrt(3)"
    [(root, multiplicity)] = found.roots
    assert multiplicity == 1
    assert abs(float(root.refined(60)) + 3**0.5) < 1e-15
