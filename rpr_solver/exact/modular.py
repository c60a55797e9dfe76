"""Images of polynomials over ℤ[ω] modulo primes, and Sylvester's matrix.

What the images prove is in mathematics.md#images-modulo-primes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import count, islice
from typing import TypeVar

from flint import fmpz

from rpr_solver.exact.quadratic import QuadraticPoly

T = TypeVar("T")

_CHECK_PRIMES = 4


def primes(radicand: int, rho: int = 1) -> Iterator[tuple[int, int]]:
    """Primes p below 2⁶² in which ω exists and √−ρ does not, each with one value of ω modulo p."""
    p = 2**62 + 3
    while True:
        p, omega = _next_prime(p, radicand, rho)
        yield p, omega


@lru_cache(maxsize=1024)
def _next_prime(above: int, radicand: int, rho: int) -> tuple[int, int]:
    # −1 is no square modulo p ≡ 3 (mod 4), and ρ is one
    root, square, candidates = fmpz(radicand), fmpz(rho), map(fmpz, count(above - 4, -4))
    p = next(p for p in candidates if p.is_prime() and root.jacobi(p) == 1 and square.jacobi(p) == 1)
    return int(p), 1 if radicand == 1 else int((root % p).sqrtmod(p))


def simple_and_finite(
    polynomial: QuadraticPoly, degree: int, *, apart_from: Sequence[QuadraticPoly] = ()
) -> bool:
    """Whether one of a few primes proves that a form of this formal degree has only simple and finite roots.

    With ``apart_from`` also none that it shares with one of those polynomials.
    """
    for p, omega in islice(primes(polynomial.radicand), _CHECK_PRIMES):
        image = polynomial.residue(p, omega)
        others = image.derivative(), *(other.residue(p, omega) for other in apart_from)
        if image.degree() == degree and all(image.gcd(other).degree() == 0 for other in others):
            return True
    return False


def sylvester(j: Sequence[T], e: Sequence[T], zero: T) -> list[list[T]]:
    """Rows of the Sylvester matrix of two forms given by ascending coefficients."""
    m, n = len(j) - 1, len(e) - 1
    rows = [[zero] * i + [*reversed(j)] + [zero] * (n - 1 - i) for i in range(n)]
    return rows + [[zero] * i + [*reversed(e)] + [zero] * (m - 1 - i) for i in range(m)]
