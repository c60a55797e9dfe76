"""Proofs modulo a prime: a polynomial over ℤ[ω] has no multiple root, or shares none with another.

ω ↦ a square root of the radicand modulo p maps ℤ[ω] to the field of p elements. If the image keeps its
degree and is prime to its derivative, the discriminant is not 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from random import Random

from rpr_solver.verify.core.surds import Poly, Ring

_TRIES = 4


def simple_and_apart(ring: Ring, p: Poly, other: Poly) -> bool:
    """Whether some prime proves that ``p`` has only simple roots, and none in common with ``other``."""
    for prime, omega in _places(ring.radicand):
        image, beside = ([(a + b * omega) % prime for a, b in form] for form in (p, other))
        if _simple(image, prime) and _coprime(image, beside, prime):
            return True
    return False


def proves_simple(ring: Ring, p: Poly, prime: int, omega: int) -> bool:
    """Whether a prime, with a square root of the radicand modulo it, proves that ``p`` has only simple roots.

    The prime must be below 2^64, where SymPy's test of primes is a proof.
    """
    from sympy.ntheory import isprime

    if not 2 < prime < 1 << 64 or not isprime(prime) or (omega * omega - ring.radicand) % prime:
        return False
    return _simple([(a + b * omega) % prime for a, b in p], prime)


def _simple(image: Sequence[int], prime: int) -> bool:
    """Whether the image keeps the degree and is prime to its derivative."""
    return bool(image[-1]) and _coprime(image, [k * x % prime for k, x in enumerate(image)][1:], prime)


def _places(radicand: int) -> Iterator[tuple[int, int]]:
    """Primes below 2^61, each with a square root of the radicand."""
    from sympy.ntheory import prevprime, sqrt_mod

    prime, found = 1 << 61, 0
    while found < _TRIES:
        prime = int(prevprime(prime))
        root = sqrt_mod(radicand % prime, prime)
        if root is not None:
            found += 1
            yield prime, int(root)


def random_places(radicand: int, draw: Random, count: int) -> Iterator[tuple[int, int]]:
    """Random primes from 2^60 to 2^61, each with a square root of the radicand."""
    from sympy.ntheory import nextprime, sqrt_mod

    found = 0
    while found < count:
        prime = int(nextprime(draw.randrange(1 << 60, (1 << 61) - (1 << 16))))
        root = sqrt_mod(radicand % prime, prime)
        if root is not None:
            found += 1
            yield prime, int(root)


def _coprime(p: Sequence[int], q: Sequence[int], prime: int) -> bool:
    """Whether two polynomials modulo a prime share no root in any extension."""
    p, q = _trimmed(p), _trimmed(q)
    while q:
        inverse = pow(q[-1], -1, prime)
        rest = list(p)
        for k in reversed(range(len(rest) - len(q) + 1)):
            factor = rest[k + len(q) - 1] * inverse % prime
            for i, x in enumerate(q, k):
                rest[i] = (rest[i] - factor * x) % prime
        p, q = q, _trimmed(rest)
    return len(p) == 1


def _trimmed(p: Sequence[int]) -> list[int]:
    size = len(p)
    while size and not p[size - 1]:
        size -= 1
    return list(p[:size])
