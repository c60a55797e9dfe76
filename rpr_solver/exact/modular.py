"""Polynomials over ℤ[ω] from values modulo primes: interpolation, Chinese remainders, a proved bound."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from flint import fmpz, fmpz_poly, nmod_mat, nmod_poly

from rpr_solver.errors import SolverError

T = TypeVar("T")

Image = Callable[[int, int, bool], "list[int] | None"]
"""(p, ω mod p, first prime?) → the coefficients modulo p, or None where p is unsuitable."""


def reconstruct(
    primes: Iterator[tuple[int, int]], image: Image, bound: int, *, rational: bool
) -> tuple[list[fmpz], list[fmpz]]:
    """The coefficients of A and B, where A + ω B has the given images and ``bound`` bounds |A|, |B|.

    The common content of all coefficients is removed.

    Raises:
        SolverError: the primes run out before their product exceeds twice the bound.
    """
    images: list[tuple[int, list[int]]] = []
    modulus = 1
    for p, omega in primes:
        positive = image(p, omega, not images)
        if positive is None:
            continue
        if rational:
            residues = positive + [0] * len(positive)
        else:
            negative = image(p, -omega % p, False)
            if negative is None:
                continue
            half, slope = pow(2, -1, p), pow(2 * omega, -1, p)
            residues = [(x + y) * half % p for x, y in zip(positive, negative, strict=True)]
            residues += [(x - y) * slope % p for x, y in zip(positive, negative, strict=True)]
        images.append((p, residues))
        modulus *= p
        if modulus > 2 * bound:
            break
    else:
        raise SolverError("the coefficients of an eliminant are too large for this version")
    values = _chinese_remainder(images, modulus)
    content = fmpz(0)
    for x in values:
        content = content.gcd(x)
    if content:
        values = [x // content for x in values]
    half_way = len(values) // 2
    return values[:half_way], values[half_way:]


def residue(polynomial: fmpz_poly, p: int) -> nmod_poly:
    """A polynomial modulo p."""
    return nmod_poly([int(c) % p for c in polynomial.coeffs()], p)


def pair_residue(a: fmpz_poly, b: fmpz_poly, p: int, omega: int) -> nmod_poly:
    """A + ω B modulo p, with a value chosen for ω."""
    return residue(a, p) + residue(b, p) * omega


def formal_resultant(j: Sequence[int], e: Sequence[int], p: int) -> int:
    """Res of two forms modulo p by ascending coefficients; a common zero at infinity counts."""
    if j[-1] and e[-1]:
        return int(nmod_poly(list(j), p).resultant(nmod_poly(list(e), p)))
    return int(nmod_mat(sylvester(j, e, 0), p).det())


def sylvester(j: Sequence[T], e: Sequence[T], zero: T) -> list[list[T]]:
    """Rows of the Sylvester matrix of two forms given by ascending coefficients."""
    m, n = len(j) - 1, len(e) - 1
    rows = [[zero] * i + [*reversed(j)] + [zero] * (n - 1 - i) for i in range(n)]
    return rows + [[zero] * i + [*reversed(e)] + [zero] * (m - 1 - i) for i in range(m)]


def vandermonde(points: Sequence[int], p: int) -> nmod_mat:
    """The matrix that evaluates polynomials of degree < len(points) at the points."""
    n = len(points)
    return nmod_mat(n, n, [pow(x, k, p) for x in points for k in range(n)], p)


def _chinese_remainder(images: list[tuple[int, list[int]]], modulus: int) -> list[fmpz]:
    weights = []
    for p, _ in images:
        rest = modulus // p
        weights.append(rest * pow(rest, -1, p))
    values = []
    for residues in zip(*(image for _, image in images), strict=True):
        x = sum(w * r for w, r in zip(weights, residues, strict=True)) % modulus
        values.append(fmpz(x - modulus if 2 * x > modulus else x))
    return values
