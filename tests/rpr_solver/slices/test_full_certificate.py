"""Full certificates, checked by SymPy and plain integers."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy as sp

from rpr_solver import EXAMPLES, InputError, eliminate, solve_slice, table_document
from rpr_solver.slices.full_certificate import full_certificate
from tests.support.families import family

U = sp.Symbol("u")


def test_a_slice_over_the_integers() -> None:
    document = table_document(EXAMPLES["zein-flat"], 10, digits=15, certificate="full")
    [part] = document["slices"]
    full = part["certificate"]["full"]
    coefficients = [int(c) for c in full["polynomial"]["coefficients"]]
    q = sp.Poly(list(reversed(coefficients)), U)
    assert (q.degree(), "omega" in full["polynomial"]) == (24, False)
    prime = int(full["squarefree"]["prime"])
    assert sp.isprime(prime)
    modulo = sp.Poly(q, U, modulus=prime)
    assert sp.gcd(modulo, modulo.diff()).degree() == 0
    assert q.count_roots() == len(full["real_roots"]) == part["count"]
    for root in full["real_roots"]:
        low, high = (sp.Rational(root[end]) for end in ("lower", "upper"))
        assert q.eval(low) * q.eval(high) < 0
    assert full["boxes"][0]["l2"] == {"centre": part["cusps"][0]["l2"], "radius": "5e-14"}


def test_the_rest_of_the_document_is_as_usual() -> None:
    short, full = (
        table_document(EXAMPLES["innocenti"], ["14.98", 0], digits=15, certificate=name)
        for name in ("short", "full")
    )
    assert full["slices"][0]["certificate"].pop("full")["polynomial"]["omega"].startswith("sqrt(")
    assert full == short
    with pytest.raises(InputError, match="certificate"):
        table_document(EXAMPLES["innocenti"], "14.98", certificate="long")


@pytest.mark.parametrize("name", ["both flat", "congruent"])
def test_slices_with_multiple_roots_have_no_prime(name: str) -> None:
    eliminant = eliminate(family(name))
    table = solve_slice(eliminant, 3, 15)
    full = full_certificate(eliminant, Fraction(3), [cusp.to_json() for cusp in table.cusps])
    assert full["squarefree"] is None
    assert [root["multiplicity"] > 1 for root in full["real_roots"]] == [True] * len(full["real_roots"])
