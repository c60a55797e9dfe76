"""Numbers a + b κ with a, b in ℤ[ω], κ being a square root, and polynomials of them in one variable."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import ZERO, Ring, Surd, negative, plus

Number = tuple[Surd, Surd]
"""a + b κ."""


@dataclass(frozen=True)
class Field:
    """ℤ[ω, κ] with κ = √square ≥ 0."""

    ring: Ring
    square: Surd

    def times(self, x: Number, y: Number) -> Number:
        """The product of two numbers."""
        (a, b), (c, d), times = x, y, self.ring.times
        if b == d == ZERO:
            return times(a, c), ZERO
        return plus(times(a, c), times(self.square, times(b, d))), plus(times(a, d), times(b, c))

    def sign(self, x: Number) -> int:
        """−1, 0 or 1."""
        a, b = x
        first, second = self.ring.sign(a), self.ring.sign(b) * self.ring.sign(self.square)
        if first * second >= 0:
            return first or second
        own, other = self.ring.times(a, a), self.ring.times(self.square, self.ring.times(b, b))
        return first * self.ring.sign((own[0] - other[0], own[1] - other[1]))

    def interval(self, x: Number, bits: int) -> Interval:
        """The number, in a small interval."""
        omega = Interval.of(self.ring.radicand, bits).root()
        a, b, k = (Interval.of(p, bits) + omega.scaled(q) for p, q in (*x, self.square))
        return a + b * k.root() if x[1] != ZERO else a

    def quotient(self, x: Number, y: Number) -> tuple[object, ...]:
        """A name of x / y that is the same for equal numbers over ℚ(ω), or with the same κ."""
        (c, d), square = y, self.square
        above = self.times(x, (c, (-d[0], -d[1])))
        below, _ = self.times(y, (c, (-d[0], -d[1])))
        p, q = below
        norm = p * p - self.ring.radicand * q * q
        parts = [self.ring.times(part, (p, -q)) for part in above]
        values = [Fraction(n, norm) for part in parts for n in part]
        return (*values[:2],) if not any(values[2:]) else (*values, square)


def difference(x: Number, y: Number) -> Number:
    """x − y."""
    return plus(x[0], negative(y[0])), plus(x[1], negative(y[1]))


def trimmed(field: Field, p: list[Number]) -> list[Number]:
    """Without leading zeros, and without an integer divisor."""
    while p and not field.sign(p[-1]):
        p = p[:-1]
    divisor = gcd(*(part for x in p for surd in x for part in surd)) or 1
    return [((a // divisor, b // divisor), (c // divisor, d // divisor)) for (a, b), (c, d) in p]


def gcd_of(field: Field, p: list[Number], q: list[Number]) -> list[Number]:
    """A greatest common divisor; one that is empty stands for 0."""
    p, q = sorted((p, q), key=len, reverse=True)
    while q:
        rest = p
        while len(rest) >= len(q):
            shift = len(rest) - len(q)
            spend(16 * len(rest), max(part.bit_length() for surd in (*rest[-1], *q[-1]) for part in surd))
            shifted = [(ZERO, ZERO)] * shift + [field.times(rest[-1], x) for x in q]
            rest = [difference(field.times(q[-1], x), y) for x, y in zip(rest, shifted, strict=True)]
            rest = trimmed(field, rest[:-1])
        p, q = q, rest
    return p
