"""Polynomials A + ω B with ω² rational."""

from __future__ import annotations

from collections.abc import Mapping

from flint import fmpz, fmpz_poly

Pair = tuple[fmpz_poly, fmpz_poly]
"""A + ω B, polynomials in u = tan(θ/2)."""


def univariate(terms: Mapping[int, int | fmpz]) -> fmpz_poly:
    """The polynomial with these coefficients, by exponent."""
    return fmpz_poly([terms.get(k, 0) for k in range(max(terms, default=-1) + 1)])


def primitive_pair(a: fmpz_poly, b: fmpz_poly) -> Pair:
    """A + ω B without its rational content."""
    content = a.content().gcd(b.content()) if a or b else fmpz(1)
    return a / content if content != 1 else a, b / content if content != 1 else b
