"""The eliminants of the transitions, compared with resultants at random values modulo primes.

On J = 0 the length is L = −J0/J1. With it E = φ C / J1² and v·∇E = J0 φ² W / J1³, and ∇J is a multiple of
(M1, M2), the Wronskians of J0 and J1. In t = tan(α/2) and v = tan θ, with formal degrees,

    Res_t(C, W)   = (v²+1)⁸ · Y⁴ · P,    Z = Res_t(J0, J1) / (v²+1),
    Res_t(M1, M2) = (v²+1)⁵ · Z · P,     Y = Z (v²+1) / Res_t(φ, γ)

(mathematics.md#the-eliminants-of-the-census). At a value of v modulo a prime both sides are numbers; a wrong
P of degree n agrees at a random value with a probability of some n / 2^60.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from random import Random

from rpr_solver.verify.core.modular import random_places
from rpr_solver.verify.core.surds import Surd
from rpr_solver.verify.core.system import Trig, derivative, in_half_tangent
from rpr_solver.verify.core.work import spend
from rpr_solver.verify.surface import Surface

Poly = list[int]
"""Coefficients in t modulo the prime, of formal degree."""


@dataclass(frozen=True)
class Place:
    """A prime, a square root of the radicand, and a value of v = tan θ modulo it."""

    surface: Surface
    prime: int
    omega: int
    v: int

    def form(self, p: Trig, alpha: int, theta: int) -> Poly:
        """A polynomial of these degrees in α and θ, which has one parity in θ, as one in t."""
        square = 1 + self.v * self.v
        spend(5 * len(p))

        def weight(cos: int, sin: int) -> int:
            rest, odd = divmod(theta - cos - sin, 2)
            if odd or rest < 0:
                raise ArithmeticError("a form in the direction of the leg is not homogeneous")
            return pow(square, rest, self.prime) * pow(self.v, sin, self.prime) % self.prime

        return [(a + b * self.omega) % self.prime for a, b in in_half_tangent(p, alpha, weight)]

    def at(self, p: Sequence[Surd]) -> int:
        """A polynomial in v at this value."""
        total = 0
        for a, b in reversed(p):
            total = (total * self.v + a + b * self.omega) % self.prime
        return total

    def circular(self, exponent: int) -> int:
        """(v² + 1)^exponent."""
        return pow(1 + self.v * self.v, exponent, self.prime)

    @cached_property
    def _singular(self) -> tuple[Poly, Poly]:
        j0, j1 = self.surface.singular
        return self.form(j0, 2, 1), self.form(j1, 1, 2)

    @cached_property
    def _slopes(self) -> tuple[Poly, Poly]:
        """φ and γ."""
        f, g = (self.form(leg.theta[1], 1, 1) for leg in self.surface.legs)
        return f, g

    @cached_property
    def permanent(self) -> int:
        """Z."""
        return resultant(*self._singular, self.prime) * pow(self.circular(1), -1, self.prime) % self.prime

    @cached_property
    def parallel(self) -> int:
        """Res_t(φ, γ) / (v² + 1)."""
        return resultant(*self._slopes, self.prime) * pow(self.circular(1), -1, self.prime) % self.prime

    def critical(self) -> tuple[int, int]:
        """Res_t(M1, M2), and its factor beside P."""
        j0, j1 = self._singular
        pairs = []
        for theta in (False, True):
            d0, d1 = (derivative(p, theta=theta) for p in self.surface.singular)
            slopes = self.form(d0, 2, 1), self.form(d1, 1, 2)
            pairs.append(self._difference(self._times(j0, slopes[1]), self._times(j1, slopes[0])))
        return resultant(pairs[0], pairs[1], self.prime), self.circular(5) * self.permanent % self.prime

    def swallowtails(self) -> tuple[int, int]:
        """Res_t(C, W), and its factor beside P."""
        leg, (phi, _) = self.surface.legs[0], self._slopes
        degrees = [(4, 1), (3, 2), (2, 3)], [(6, 1), (5, 2), (4, 3), (3, 4)]
        c, w = (self._on_surface(p, d) for p, d in zip((leg.kernel, leg.kernel2), degrees, strict=True))
        c = self._quotient(c, phi)
        # the terms of v·∇E are of degree 9 in α, their sum of degree 8
        for divisor in ([1, 0, 1], phi, phi, self._singular[0]):
            w = self._quotient(w, divisor)
        known = pow(self.permanent * pow(self.parallel, -1, self.prime), 4, self.prime)
        return resultant(c, w, self.prime), self.circular(8) * known % self.prime

    def _on_surface(self, graded: Sequence[Trig], degrees: Sequence[tuple[int, int]]) -> Poly:
        """Σ pₖ (−J0)ᵏ J1ⁿ⁻ᵏ."""
        (j0, j1), total = self._singular, [0]
        minus = [-x % self.prime for x in j0]
        for k, degree in enumerate(degrees):
            term = self.form(graded[k] if k < len(graded) else {}, *degree)
            for factor in [minus] * k + [j1] * (len(degrees) - 1 - k):
                term = self._times(term, factor)
            total = self._difference(term, [-x for x in total])
        return total

    def _times(self, p: Poly, q: Poly) -> Poly:
        result = [0] * (len(p) + len(q) - 1)
        for i, x in enumerate(p):
            for k, y in enumerate(q, i):
                result[k] += x * y
        return [x % self.prime for x in result]

    def _difference(self, p: Poly, q: Poly) -> Poly:
        q = q + [0] * (len(p) - len(q))
        return [(x - y) % self.prime for x, y in zip(p, q, strict=True)]

    def _quotient(self, p: Poly, q: Poly) -> Poly:
        """The exact quotient, of the formal degree that is the difference of both.

        Raises:
            ZeroDivisionError: the divisor vanishes at this place.
            ArithmeticError: there is a remainder.
        """
        size, top = len(p) - len(q) + 1, max((k for k, x in enumerate(q) if x), default=-1)
        if top < 0:
            raise ZeroDivisionError("a divisor vanishes modulo the prime")
        inverse, rest, result = pow(q[top], -1, self.prime), list(p), [0] * size
        for k in reversed(range(size)):
            factor = result[k] = rest[k + top] * inverse % self.prime
            for i, x in enumerate(q[: top + 1], k):
                rest[i] = (rest[i] - factor * x) % self.prime
        if any(rest):
            raise ArithmeticError("a division of the surface of singular poses leaves a remainder")
        return result


def resultant(p: Poly, q: Poly, prime: int) -> int:
    """Sylvester's determinant modulo a prime, for the formal degrees."""
    m, n = len(p) - 1, len(q) - 1
    rows = [[0] * k + p[::-1] + [0] * (n - 1 - k) for k in range(n)]
    rows += [[0] * k + q[::-1] + [0] * (m - 1 - k) for k in range(m)]
    result, size = 1, m + n
    spend(size**3 // 3)
    for k in range(size):
        pivot = next((i for i in range(k, size) if rows[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            rows[k], rows[pivot], result = rows[pivot], rows[k], -result
        head = rows[k]
        result = result * head[k] % prime
        inverse = pow(head[k], -1, prime)
        for row in rows[k + 1 :]:
            if row[k]:
                factor = row[k] * inverse % prime
                row[k:] = [(x - factor * y) % prime for x, y in zip(row[k:], head[k:], strict=True)]
    return result


Identity = Callable[[Place], tuple[int, int]]
"""The resultant at a place, and its known factors there."""


def agree(
    surface: Surface, form: Sequence[Surd], identity: Identity, draw: Random, count: int
) -> bool | None:
    """Whether a form is the rest of a resultant, by ``count`` random primes; None if that is always 0.

    The quotient of both sides does not depend on v, so two values of v are compared for each prime.
    """
    vanishing = 0
    for prime, omega in random_places(surface.ring.radicand, draw, count):
        sides = []
        for _ in range(2):
            place = Place(surface, prime, omega, draw.randrange(prime))
            whole, known = identity(place)
            sides.append((whole, known * place.at(form) % prime))
        (left, right), (other_left, other_right) = sides
        if not left and not other_left:
            vanishing += 1
        elif not right or (left * other_right - other_left * right) % prime:
            return False
    return None if vanishing == count else not vanishing
