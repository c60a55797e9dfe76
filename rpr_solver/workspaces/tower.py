"""Real numbers made of the cosine and sine of a rational angle in degrees, and of square roots: exact.

A number is Σ pₘ(c) ∏ g over sets m of generators g, each the square root of a positive number with earlier
generators; one of them is the sine s = ±√(1 − c²). The polynomials p have rational coefficients. Whether a
number a + b g is 0 follows from its norm a² − b² g², which has one generator less: if that is 0, then so are
both a and b, or one of a ± b g, and the signs of a and b, which are not 0, say which of these. At the bottom,
p(c) is 0 exactly if the minimal polynomial Ψ of c = cos(2π k/n), of degree φ(n)/2, divides p.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import TypeAlias

from flint import arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

from rpr_solver.errors import ControlFlow, Unproved
from rpr_solver.exact.precision import precisions
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.triangles.surds import Surd

_FIRST_BITS = 128
_EXACT_BITS = 512
"""A number whose sign balls of this precision leave open is most likely 0, which is tried exactly."""
_GREATEST_BITS = 1 << 16
"""A number that is not 0 and still open here would be smaller than 10 to the power of −19,000."""

_Terms: TypeAlias = dict[int, fmpq_poly]
_Rational: TypeAlias = int | Fraction


class Open(ControlFlow):
    """Balls of the present precision do not decide a question."""


@dataclass(frozen=True, eq=False)
class Tower:
    """The field of c and of generators.

    Attributes:
        turn: the angle as a part of a full turn, 0 ≤ ``turn`` < 1.
        squares: the squares of the generators, each in terms of the earlier ones.
        signs: the signs of the generators.
    """

    turn: Fraction
    squares: tuple[Mapping[int, fmpq_poly], ...] = ()
    signs: tuple[int, ...] = ()
    _balls: dict[int, tuple[arb, ...]] = field(default_factory=dict, repr=False)

    def number(self, x: _Rational) -> Number:
        """A rational number."""
        return Number(self, {0: fmpq_poly([_fmpq(x)])} if x else {})

    @cached_property
    def cosine(self) -> Number:
        """c."""
        return Number(self, _reduced(self, {0: fmpq_poly([0, 1])}))

    def with_root(self, square: Number, sign: int = 1) -> tuple[Tower, Number]:
        """The tower with one more generator, the root of a number that is not 0, and this root.

        A root that is rational needs no generator.
        """
        if (known := square.rational) is not None and (root := rational_sqrt(known)) is not None:
            return self, self.number(sign * root)
        wider = Tower(self.turn, (*self.squares, square.terms), (*self.signs, sign))
        return wider, Number(wider, {1 << len(self.squares): fmpq_poly([1])})

    def with_surd(self, surd: Surd) -> Tower:
        """The tower with a generator for the root of a surd, if none of its own has it."""
        return self if self._surd(surd) else self.with_root(self.number(surd.square))[0]

    def surd(self, surd: Surd) -> Number:
        """A surd of which the tower has the root."""
        found = self._surd(surd)
        assert found is not None
        return found

    def _surd(self, surd: Surd) -> Number | None:
        if (value := surd.rational) is not None:
            return self.number(value)
        for k, terms in enumerate(self.squares):
            square = Number(self, terms).rational
            if square and (times := rational_sqrt(surd.square / square)) is not None:
                return Number(self, {1 << k: fmpq_poly([_fmpq(surd.sign * times)])})
        return None

    @cached_property
    def degree(self) -> int:
        """That of Ψ, φ(n)/2; where n is very large at least its bound √(n/2)/2."""
        n = self.turn.denominator
        return _phi(n) // 2 if n < _FACTORED else isqrt(n // 8)

    @cached_property
    def minimal(self) -> fmpq_poly:
        """Ψ."""
        return fmpq_poly(fmpz_poly.cos_minpoly(self.turn.denominator))(fmpq_poly([0, 2]))

    def balls(self, bits: int) -> tuple[arb, ...]:
        """c and the generators, at a precision."""
        if bits not in self._balls:
            with ctx.workprec(bits + 32):
                found = [arb.cos_pi_fmpq(_fmpq(2 * self.turn))]
                for terms, sign in zip(self.squares, self.signs, strict=True):
                    found.append(_ball(terms, found).sqrt() * sign)
            self._balls[bits] = tuple(found)
        return self._balls[bits]


_FACTORED = 10**12
"""Larger n are not factored: no polynomial of a number has as many coefficients as the degree of their Ψ."""
_SHORT = 96
"""Polynomials are reduced by a Ψ of at most this degree, which keeps them short."""


@dataclass(frozen=True, eq=False)
class Number:
    """A number of a tower; sums and products with numbers of the same or of an extended tower are exact."""

    tower: Tower
    terms: Mapping[int, fmpq_poly]

    def ball(self, bits: int) -> arb:
        """A ball round the number; not finite where a root is not yet known to be real."""
        balls = self.tower.balls(bits)
        with ctx.workprec(bits + 32):
            return _ball(self.terms, balls)

    @property
    def rational(self) -> Fraction | None:
        """The number, if it has no c and no generator."""
        if not self.terms:
            return Fraction(0)
        if set(self.terms) != {0} or self.terms[0].degree() > 0:
            return None
        x = self.terms[0][0]
        return Fraction(int(x.p), int(x.q))

    def __add__(self, other: Number | _Rational) -> Number:
        own = self._of(other)
        terms = dict(self.terms)
        for mask, p in own.terms.items():
            terms[mask] = terms[mask] + p if mask in terms else p
        return Number(_wider(self, own), _nonzero(terms))

    __radd__ = __add__

    def __neg__(self) -> Number:
        return Number(self.tower, {mask: -p for mask, p in self.terms.items()})

    def __sub__(self, other: Number | _Rational) -> Number:
        return self + (-other)

    def __rsub__(self, other: _Rational) -> Number:
        return -self + other

    def __mul__(self, other: Number | _Rational) -> Number:
        own = self._of(other)
        tower = _wider(self, own)
        return Number(tower, _reduced(tower, _product(tower, self.terms, own.terms)))

    __rmul__ = __mul__

    def _of(self, other: Number | _Rational) -> Number:
        return other if isinstance(other, Number) else self.tower.number(other)

    @property
    def sign(self) -> int:
        """Its sign, exact."""
        for bits in precisions(_FIRST_BITS, _GREATEST_BITS):
            ball = self.ball(bits)
            if ball > 0 or ball < 0:
                return 1 if ball > 0 else -1
            if bits == _EXACT_BITS and self.is_zero:
                return 0
        raise Unproved("the sign of a number at an orientation could not be decided")

    @property
    def is_zero(self) -> bool:
        """Whether it is 0, exact."""
        if not self.terms:
            return True
        top = max(self.terms).bit_length() - 1
        if top < 0:
            p = self.terms[0]
            return p.degree() >= self.tower.degree and not p % self.tower.minimal
        a, b = self._split(top)
        square = Number(self.tower, self.tower.squares[top])
        if not (a * a - b * b * square).is_zero:
            return False
        if a.is_zero or b.is_zero:
            return True
        # a² = b² g² ≠ 0
        return a.sign != b.sign * self.tower.signs[top]

    def _split(self, top: int) -> tuple[Number, Number]:
        """a and b of a + b g."""
        bit = 1 << top
        without = {mask: p for mask, p in self.terms.items() if not mask & bit}
        times = {mask ^ bit: p for mask, p in self.terms.items() if mask & bit}
        return Number(self.tower, without), Number(self.tower, times)


def _wider(x: Number, y: Number) -> Tower:
    return x.tower if len(x.tower.squares) >= len(y.tower.squares) else y.tower


def _product(tower: Tower, first: Mapping[int, fmpq_poly], second: Mapping[int, fmpq_poly]) -> _Terms:
    terms: _Terms = {}
    for m, p in first.items():
        for n, q in second.items():
            part: Mapping[int, fmpq_poly] = {m ^ n: p * q}
            for k in range((m & n).bit_length()):
                if m & n & (1 << k):
                    part = _product(tower, part, tower.squares[k])
            for mask, r in part.items():
                terms[mask] = terms[mask] + r if mask in terms else r
    return _nonzero(terms)


def _nonzero(terms: _Terms) -> _Terms:
    return {mask: p for mask, p in terms.items() if p}


def _reduced(tower: Tower, terms: _Terms) -> _Terms:
    """The terms, their polynomials reduced where Ψ is of a degree that saves work."""
    degree = tower.degree
    if degree > _SHORT:
        return terms
    return _nonzero({mask: p % tower.minimal if p.degree() >= degree else p for mask, p in terms.items()})


def _ball(terms: Mapping[int, fmpq_poly], balls: Sequence[arb]) -> arb:
    c, *generators = balls
    total = arb(0)
    for mask, p in terms.items():
        value = arb_poly(p)(c) if p.degree() > 0 else arb(p[0])
        for k, g in enumerate(generators):
            if mask & (1 << k):
                value *= g
        total += value
    return total


def _fmpq(x: _Rational) -> fmpq:
    return fmpq(x.numerator, x.denominator)


def _phi(n: int) -> int:
    value = n
    for prime, _ in fmpz(n).factor():
        value -= value // int(prime)
    return max(value, 2)
