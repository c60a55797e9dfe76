"""Polynomials over ℤ[ω] modulo primes: values, interpolation, Chinese remainders.

What their images prove is in mathematics.md#images-modulo-primes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import count, islice
from typing import TypeVar

from flint import fmpz, fmpz_poly, nmod_mat, nmod_poly

from rpr_solver.exact.quadratic import QuadraticPoly

T = TypeVar("T")

Image = Callable[[int, int, bool], "list[int] | None"]
"""(p, ω mod p, first prime?) → the coefficients modulo p, or None where p is unsuitable."""

_CHECK_PRIMES = 4
_ONE = fmpz_poly([1])


def primes(radicand: int) -> Iterator[tuple[int, int]]:
    """Primes p below 2⁶² in which ω exists, each with one value of ω modulo p."""
    p = 2**62 + 3
    while True:
        p, omega = _next_prime(p, radicand)
        yield p, omega


@lru_cache(maxsize=1024)
def _next_prime(above: int, radicand: int) -> tuple[int, int]:
    root, candidates = fmpz(radicand), map(fmpz, count(above - 4, -4))  # p ≡ 3 (mod 4)
    p = next(p for p in candidates if p.is_prime() and root.jacobi(p) == 1)
    return int(p), 1 if radicand == 1 else int((root % p).sqrtmod(p))


def simple_and_finite(polynomial: QuadraticPoly, degree: int, *, apart_from: fmpz_poly = _ONE) -> bool:
    """Proves modulo a prime that a form of this formal degree has no multiple root and none at infinity.

    With ``apart_from`` also that it shares no root with that polynomial. False if none of a few primes gives
    a proof.
    """
    for p, omega in islice(primes(polynomial.radicand), _CHECK_PRIMES):
        image = polynomial.residue(p, omega)
        others = image.derivative(), nmod_poly(apart_from, p)
        if image.degree() == degree and all(image.gcd(other).degree() == 0 for other in others):
            return True
    return False


def reconstruct(radicand: int, image: Image, bound: int) -> tuple[list[fmpz], list[fmpz]]:
    """The coefficients of A and B, where A + ω B has the given images and ``bound`` bounds |A|, |B|.

    The result is primitive: without the common content of all coefficients.
    """
    images: list[tuple[int, list[int]]] = []
    modulus = 1
    for p, omega in primes(radicand):
        positive = image(p, omega, not images)
        if positive is None:
            continue
        if radicand == 1:
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
    values = _chinese_remainder(images, modulus)
    if content := fmpz_poly(values).content():
        values = [x // content for x in values]
    half_way = len(values) // 2
    return values[:half_way], values[half_way:]


def resultants(first: Sequence[nmod_poly], second: Sequence[nmod_poly], us: Sequence[int]) -> list[int]:
    """Res_t at each u of two forms modulo p, given by the coefficients of t⁰, t¹, …, polynomials in u.

    The degrees in t are formal, so that a common zero at t = ∞ counts.
    """
    p = first[0].modulus()
    return [formal_resultant([int(c(u)) for c in first], [int(c(u)) for c in second], p) for u in us]


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


def interpolated(
    values: Sequence[Sequence[int]], us: Sequence[int], ls: Sequence[int], p: int
) -> list[list[int]]:
    """The coefficients modulo p, rows by powers of L, of the polynomial in u and L with these values.

    Row i of the values belongs to the i-th L; there are as many points as coefficients.
    """
    flat = [x for row in values for x in row]
    in_u, in_l = (_inverse_vandermonde(tuple(points), p) for points in (us, ls))
    result = in_l * nmod_mat(len(ls), len(us), flat, p) * in_u.transpose()
    return [[int(x) for x in row] for row in result.tolist()]


@lru_cache(maxsize=4)
def _inverse_vandermonde(points: tuple[int, ...], p: int) -> nmod_mat:
    """The matrix from values to coefficients; cached, since one prime serves several values of ω."""
    n = len(points)
    return nmod_mat(n, n, [power for x in points for power in _powers(x, n, p)], p).inv()


def _powers(x: int, count: int, p: int) -> Iterator[int]:
    power = 1
    for _ in range(count):
        yield power
        power = power * x % p


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
