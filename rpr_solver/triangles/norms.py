"""Numbers of the form x² + ρ y²: the norm equation over ℚ, and over a real quadratic field ℚ(ω).

x² + ρ y² = k has a rational solution if and only if Hilbert's symbol (−ρ, k) is 1 at every prime (Legendre,
Hasse); the finitely many primes where it is −1 are *ramified*. A solution is checked by putting it in, so
that nothing rests on the way in which it was found (mathematics.md#norm-equations).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import islice, product
from math import gcd, isqrt, prod
from typing import TypeAlias

from flint import fmpz, fmpz_mat

from rpr_solver.errors import ControlFlow

Two: TypeAlias = tuple[Fraction, Fraction]

FACTORED_BITS = 128
"""The most bits of a number to factor, less its primes below 1000: FLINT takes a twentieth of a second."""
_PRIMES = tuple(p for p in range(2, 1000) if all(p % q for q in range(2, isqrt(p) + 1)))
_SPLIT_PRIMES = tuple(p for p in _PRIMES if p < 200)
_CHOICES = 64
"""How many choices of square roots modulo primes are tried; each gives a lattice."""
_COMBINED = (0, 1, -1, 2, -2)
"""Coefficients of the vectors of a reduced basis: a short solution has small ones."""
_WEIGHT_BITS = 24
"""Bits of a root of a weight by which a column of a lattice is scaled."""
_LARGEST = 24
"""The greatest numbers that are tried for a point over a quadratic field."""


class TooLargeToFactor(ControlFlow):
    """A number that has more than :data:`FACTORED_BITS` bits and no known factors."""


def split_square(n: int) -> tuple[int, int]:
    """(s, r) with n = s² r, r free of squares of primes below 200; (√n, 1) for a square, (0, 1) for 0.

    >>> split_square(75), split_square(10**40)
    ((5, 3), (100000000000000000000, 1))
    """
    root = isqrt(n)
    if root * root == n:
        return root, 1
    square = 1
    for p in _SPLIT_PRIMES:
        while n % (p * p) == 0:
            n //= p * p
            square *= p
    return square, n


def without_squares(n: int) -> int:
    """n > 0 divided by a square: square-free if n is factored or a square times a small number.

    Otherwise it is r of :func:`split_square`.

    >>> without_squares(3 * 10**400), without_squares(2 * 853**4)
    (3, 2)
    """
    if isqrt(n) ** 2 == n:
        return 1
    try:
        return SquareClass.of(n).free
    except TooLargeToFactor:
        small = (r for r in range(2, _PRIMES[-1]) if isqrt(n * r) ** 2 == n * r)
        return next(small, split_square(n)[1])


@dataclass(frozen=True)
class SquareClass:
    """A positive rational number as ``root``² times the product of different ``primes``."""

    root: Fraction
    primes: frozenset[int]

    @classmethod
    def of(cls, x: Fraction | int) -> SquareClass:
        """Factors a number.

        Raises:
            TooLargeToFactor: a part of it is not factored.
        """
        x = Fraction(x)
        factors = [*_factors(x.numerator), *_factors(x.denominator)]
        root = Fraction(prod(p ** (exponent // 2) for p, exponent in factors), x.denominator)
        return cls(root, frozenset(p for p, exponent in factors if exponent % 2))

    @cached_property
    def free(self) -> int:
        """The square-free integer of the class."""
        return prod(self.primes)


def _factors(n: int) -> Iterator[tuple[int, int]]:
    """Factors of n > 0 with their exponents; those with odd exponents are different primes."""
    for p in _PRIMES:
        exponent = 0
        while n % p == 0:
            n, exponent = n // p, exponent + 1
        if exponent:
            yield p, exponent
    if n.bit_length() > FACTORED_BITS and not fmpz(n).is_prime():
        root = isqrt(n)
        if root * root != n:
            raise TooLargeToFactor
        yield root, 2
    elif n > 1:
        yield from ((int(p), int(exponent)) for p, exponent in fmpz(n).factor())


def ramified(rho: SquareClass, k: SquareClass) -> frozenset[int]:
    """The primes at which x² + ρ y² = k z² has no solution but 0.

    The symbol of 2 is the product of all others; that of the real numbers is 1.
    """
    odd = {p for p in rho.primes | k.primes if p > 2 and _symbol(-rho.free, k.free, p) == -1}
    return frozenset(odd | {2} if len(odd) % 2 else odd)


def _symbol(a: int, b: int, p: int) -> int:
    """Hilbert's symbol (a, b) of square-free integers at an odd prime."""
    if a % p:
        return 1 if b % p else _legendre(a, p)
    return _legendre(b, p) if b % p else _legendre(-(a // p) * (b // p), p)


def _legendre(a: int, p: int) -> int:
    return int(fmpz(a % p).jacobi(p))


def splits(primes: Iterable[int], radicand: int) -> bool:
    """Whether over ℚ(√radicand) no prime is ramified that is over ℚ: the radicand is a square at none of
    them."""
    free = SquareClass.of(radicand)
    return not any(_is_square_at(p, free) for p in primes)


def _is_square_at(p: int, number: SquareClass) -> bool:
    if p in number.primes:
        return False
    return number.free % 8 == 1 if p == 2 else _legendre(number.free, p) == 1


def norm_equation(rho: int, k: Fraction) -> Two | None:
    """A solution of x² + ρ y² = k, with small numerators and denominators; None if there is none.

    Args:
        rho: ρ > 0.
        k: k > 0.

    Raises:
        TooLargeToFactor: ρ or k is not factored.

    >>> norm_equation(1, Fraction(13, 4)), norm_equation(3, Fraction(2))
    ((Fraction(1, 1), Fraction(3, 2)), None)
    """
    own, other = SquareClass.of(rho), SquareClass.of(k)
    if ramified(own, other):
        return None
    # g X² + (ρ/g) Y² = (k/g) Z² for x = g X, g being common to both: coprime and square-free coefficients
    common = own.primes & other.primes
    g = prod(common)
    found = _smallest(
        g,
        own.free // g,
        other.free // g,
        [sorted(part) for part in (common, own.primes - common, other.primes - common)],
    )
    if found is None:
        return None
    x, y, z = found
    scale = other.root / z
    solution = g * x * scale, y * scale / own.root
    assert solution[0] ** 2 + rho * solution[1] ** 2 == k
    return solution


def _smallest(a: int, b: int, d: int, primes: Sequence[Sequence[int]]) -> tuple[int, int, int] | None:
    """A short solution of a X² + b Y² = d Z².

    Modulo primes of d, b and a it says X = r Y, X = r Z and Y = r Z for square roots r. The triples for which
    this holds are a lattice, in which the form is a multiple of a b d; so its shortest vectors are, most
    often, solutions.
    """
    of_a, of_b, of_d = primes
    quotients = [(d, b, p) for p in of_a] + [(d, a, p) for p in of_b] + [(-b, a, p) for p in of_d]
    roots = [_root(n * pow(m, -1, p), p) for n, m, p in quotients]
    for choice in islice(
        product(*(sorted({r, -r % p}) for r, (_, _, p) in zip(roots, quotients, strict=True))), _CHOICES
    ):
        moduli = [p for _, _, p in quotients]
        r_a, r_b, r_d = (
            _crt(list(zip(choice, moduli, strict=True))[start : start + size])
            for start, size in ((0, len(of_a)), (len(of_a), len(of_b)), (len(of_a) + len(of_b), len(of_d)))
        )
        one_d = b * pow(b, -1, d) if d > 1 else 0
        one_b = d * pow(d, -1, b) if b > 1 else 0
        basis = [[b * d, 0, 0], [one_d * r_d * a, a, 0], [one_d * r_d * r_a + one_b * r_b, r_a, 1]]
        if solutions := [
            v for v in _short(basis, (a, b, d)) if a * v[0] ** 2 + b * v[1] ** 2 == d * v[2] ** 2
        ]:
            return min(solutions, key=lambda v: (v[2], v[0]))
    return None


def _root(n: int, p: int) -> int:
    return n % p if p == 2 or n % p == 0 else int(fmpz(n % p).sqrtmod(p))


def _crt(residues: Sequence[tuple[int, int]]) -> int:
    """The number modulo the product of primes with these residues."""
    modulus = prod(p for _, p in residues)
    return (
        sum(r * (modulus // p) * pow(modulus // p, -1, p) for r, p in residues) % modulus if residues else 0
    )


def _short(basis: list[list[int]], weights: tuple[int, int, int]) -> Iterator[tuple[int, int, int]]:
    """Short vectors of a lattice, other than 0, for the form Σ weight x², without signs."""
    scales = [isqrt(w << 2 * _WEIGHT_BITS) for w in weights]
    scaled = fmpz_mat([[x * s for x, s in zip(row, scales, strict=True)] for row in basis]).lll()
    reduced = [[int(x) // s for x, s in zip(row, scales, strict=True)] for row in scaled.tolist()]
    for factors in product(_COMBINED, repeat=3):
        x, y, z = (abs(sum(f * row[i] for f, row in zip(factors, reduced, strict=True))) for i in range(3))
        if x or y or z:
            yield x, y, z


def point_over(rho: int, radicand: int, k: Fraction) -> tuple[Two, Two] | None:
    """((x, x′), (y, y′)) with (x + x′ω)² + ρ (y + y′ω)² = k, ω² = ``radicand``; None if no small one is
    found.

    With rational W, X, Y, Z and j² = −ρ, Y² + ρ Z² = k (radicand W² + ρ X²) makes (Y + Z j) / (W ω + X j) of
    norm k; each point has this form, up to a turn.

    Raises:
        TooLargeToFactor: a number is not factored.

    >>> [[str(part) for part in parts] for parts in point_over(1, 3, Fraction(6)) or ()]
    [['0', '1'], ['0', '1']]
    """
    if solution := norm_equation(rho, k):
        return (solution[0], Fraction(0)), (solution[1], Fraction(0))
    if radicand == 1:
        return None
    for size in range(1, _LARGEST):
        for w, x in [(size, x) for x in range(size + 1)] + [(w, size) for w in range(1, size)]:
            if gcd(w, x) == 1 and (found := norm_equation(rho, k * (radicand * w * w + rho * x * x))):
                y, z = found
                norm = Fraction(radicand * w * w + rho * x * x)
                # (Y + Z j) (W ω − X j) / norm
                return (rho * z * x / norm, y * w / norm), (-y * x / norm, z * w / norm)
    return None
