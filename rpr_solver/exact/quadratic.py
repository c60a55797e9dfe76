"""Polynomials over ℤ[ω], ω² a positive integer: A + ω B with A and B in ℤ[x], and the radicand ω².

The height of a platform is a rational multiple of ω = √radicand, so every coefficient of this solver lies in
ℤ[ω]. If the height is rational, the radicand and ω are 1 and B is 0: the field is ℚ.

Factoring and division are reduced to rational polynomials, for which FLINT has them, by the conjugate A − ω B
and the norm A² − ω² B² = (A + ω B)(A − ω B): a root of A + ω B is a root of the norm, and P/S is P S̄ over
the norm of S.

Of polynomials in balls, Sturm's sequence counts the real roots (mathematics.md#real-roots).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import isqrt
from typing import Any, Generic, Self, TypeAlias, TypeVar

from flint import arb, arb_poly, ctx, fmpz, fmpz_mpoly, fmpz_poly, nmod_poly
from flint.utils.flint_exceptions import DomainError

from rpr_solver.errors import SolverError


class DivisionError(SolverError):
    """A quotient that should be exact leaves a remainder."""


P = TypeVar("P", fmpz_poly, fmpz_mpoly)
Q = TypeVar("Q", int, Fraction)
R = TypeVar("R")


@dataclass(frozen=True)
class QuadraticNumber(Generic[Q]):
    """a + b ω with integers or rational numbers a and b, ω = √``radicand``; b is 0 if the radicand is 1."""

    a: Q
    b: Q
    radicand: int

    def __add__(self, other: QuadraticNumber[Q]) -> QuadraticNumber[Q]:
        return QuadraticNumber(self.a + other.a, self.b + other.b, self.radicand)

    def __sub__(self, other: QuadraticNumber[Q]) -> QuadraticNumber[Q]:
        return QuadraticNumber(self.a - other.a, self.b - other.b, self.radicand)

    def __neg__(self) -> QuadraticNumber[Q]:
        return QuadraticNumber(-self.a, -self.b, self.radicand)

    def __mul__(self, other: QuadraticNumber[Q] | Q | int) -> QuadraticNumber[Q]:
        if not isinstance(other, QuadraticNumber):
            return QuadraticNumber(self.a * other, self.b * other, self.radicand)
        a = self.a * other.a + self.radicand * self.b * other.b
        return QuadraticNumber(a, self.a * other.b + self.b * other.a, self.radicand)

    def times(self, x: R, omega: R) -> R:
        """The product with an element of a ring that holds ω."""
        whole: Any = x
        if not self.b:
            return whole * self.a  # type: ignore[no-any-return]
        part = whole * omega * self.b
        return whole * self.a + part if self.a else part  # type: ignore[no-any-return]


@lru_cache(maxsize=256)
def omega_ball(radicand: int, bits: int) -> arb:
    """√radicand as a ball."""
    with ctx.workprec(bits):
        return arb(radicand).sqrt()


def univariate(terms: Mapping[int, int | fmpz]) -> fmpz_poly:
    """The polynomial with these coefficients, by exponent."""
    return fmpz_poly([terms.get(k, 0) for k in range(max(terms, default=-1) + 1)])


@dataclass(frozen=True)
class Quadratic(Generic[P]):
    """A + ω B over a ring of polynomials with integer coefficients, in one or several variables."""

    a: P
    b: P
    radicand: int

    @property
    def is_zero(self) -> bool:
        """Whether this is the zero polynomial."""
        return not (self.a or self.b)

    @property
    def norm(self) -> P:
        """A² − ω² B², or A itself where B is 0."""
        return self.a * self.a - self.radicand * self.b * self.b if self.b else self.a

    @property
    def conjugate(self) -> Self:
        """A − ω B."""
        return replace(self, b=-self.b)

    @property
    def content(self) -> int:
        """The greatest common divisor of all coefficients of A and B."""
        return int(_content(self.a).gcd(_content(self.b)))

    def primitive(self) -> Self:
        """Without the common content of all coefficients."""
        a, b = _primitive_parts(self.a, self.b)
        return replace(self, a=a, b=b)

    def __neg__(self) -> Self:
        return replace(self, a=-self.a, b=-self.b)

    def __add__(self, other: Self) -> Self:
        """The sum; two forms must have equal degrees."""
        return replace(self, a=self.a + other.a, b=self.b + other.b)

    def __sub__(self, other: Self) -> Self:
        return self + -other

    def _product(self, other: Quadratic[P]) -> tuple[P, P]:
        a = self.a * other.a
        if self.b and other.b:
            a += self.radicand * (self.b * other.b)
        return a, self.a * other.b + self.b * other.a

    def _quotient(self, other: Quadratic[P]) -> tuple[P, P]:
        """The exact quotient over ℚ(ω), primitive.

        Raises:
            DivisionError: there is a remainder.
        """
        a, b, divisor = self.a, self.b, other.norm
        if other.b:
            a, b = a * other.a - self.radicand * (b * other.b), b * other.a - a * other.b
        try:
            divisor = divisor / _content(divisor)
            return _primitive_parts(a / divisor, b / divisor)
        except (DomainError, ZeroDivisionError):
            raise DivisionError(
                "a polynomial lacks a factor that it has for every geometry; please report this geometry"
            ) from None


def _primitive_parts(a: P, b: P) -> tuple[P, P]:
    """A and B without their common content."""
    content = _content(a).gcd(_content(b))
    return (a, b) if content in (0, 1) else (a / content, b / content)


def _content(p: fmpz_poly | fmpz_mpoly) -> fmpz:
    return p.content()  # type: ignore[union-attr]  # missing in the stubs of fmpz_mpoly


@dataclass(frozen=True)
class QuadraticPoly(Quadratic[fmpz_poly]):
    """A(x) + ω B(x)."""

    _balls: dict[int, arb_poly] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def rational(cls, a: fmpz_poly | Sequence[int | fmpz], radicand: int = 1) -> QuadraticPoly:
        """A alone."""
        return cls(fmpz_poly(a), fmpz_poly([]), radicand)

    @classmethod
    def omega(cls, radicand: int) -> QuadraticPoly:
        """ω, a constant."""
        return cls.rational([1]) if radicand == 1 else cls(fmpz_poly([]), fmpz_poly([1]), radicand)

    @property
    def degree(self) -> int:
        """The degree; −1 for the zero polynomial."""
        return max(self.a.degree(), self.b.degree())

    def __add__(self, other: QuadraticPoly) -> QuadraticPoly:
        return QuadraticPoly(self.a + other.a, self.b + other.b, self.radicand)

    def __sub__(self, other: QuadraticPoly) -> QuadraticPoly:
        return QuadraticPoly(self.a - other.a, self.b - other.b, self.radicand)

    def __mul__(self, other: QuadraticPoly | int) -> QuadraticPoly:
        parts = self._product(other) if isinstance(other, QuadraticPoly) else (self.a * other, self.b * other)
        return QuadraticPoly(*parts, self.radicand)

    def __truediv__(self, divisor: fmpz_poly) -> QuadraticPoly:
        """The exact quotient by a rational polynomial."""
        return QuadraticPoly(self.a / divisor, self.b / divisor, self.radicand)

    def quotient(self, divisor: QuadraticPoly) -> QuadraticPoly:
        """The exact quotient over ℚ(ω), up to a rational factor: primitive.

        Raises:
            DivisionError: there is a remainder.
        """
        return QuadraticPoly(*self._quotient(divisor), self.radicand)

    def common(self, other: QuadraticPoly) -> QuadraticPoly:
        """The greatest common divisor over ℚ(ω), primitive, of polynomials of which one is not 0.

        By Euclid's algorithm with remainders over ℤ[ω]; each has a smaller degree than the last.
        """
        if not (self.b or other.b):
            return QuadraticPoly.rational(self.a.gcd(other.a), self.radicand)
        first, second = (self, other) if self.degree >= other.degree else (other, self)
        while not second.is_zero:
            first, second = second, first._remainder(second).primitive()
        return first.primitive()

    def _remainder(self, divisor: QuadraticPoly) -> QuadraticPoly:
        """A multiple of the remainder by a number of ℤ[ω]."""
        rest, top, lead = self, divisor.degree, divisor._leading
        while rest.degree >= top:
            shift = fmpz_poly([0] * (rest.degree - top) + [1])
            rest = rest * lead - divisor * rest._leading * QuadraticPoly.rational(shift, self.radicand)
        return rest

    @property
    def _leading(self) -> QuadraticPoly:
        top = self.degree
        return QuadraticPoly(fmpz_poly([self.a[top]]), fmpz_poly([self.b[top]]), self.radicand)

    def __call__(self, x: R, omega: R) -> R:
        """The value in any ring that holds x and ω."""
        total, part = _horner(self.a, x), _horner(self.b, x)
        return total + part * omega if self.b else total  # type: ignore[no-any-return]

    def coefficient(self, k: int, omega: R) -> R:
        """The coefficient of xᵏ in any ring that holds ω."""
        value: Any = omega
        return value * self.b[k] + self.a[k]  # type: ignore[no-any-return]

    def residue(self, p: int, omega: int) -> nmod_poly:
        """The image modulo p, with a value chosen for ω."""
        a = nmod_poly(self.a, p)
        return a + nmod_poly(self.b, p) * omega if self.b else a

    def norm1(self) -> int:
        """A bound on the sum of the absolute values of all coefficients."""
        return sum(self.coefficient_norms())

    def coefficient_norms(self) -> list[int]:
        """Bounds on the absolute values of all coefficients."""
        root = isqrt(self.radicand) + 1
        if not self.b:
            return [abs(int(c)) for c in self.a.coeffs()]
        return [abs(int(self.a[k])) + abs(int(self.b[k])) * root for k in range(self.degree + 1)]

    def ball(self, bits: int) -> arb_poly:
        """The polynomial with coefficients as balls of ``bits`` bits, cached for all its roots."""
        if bits not in self._balls:
            with ctx.workprec(bits):
                whole = arb_poly(self.a)
                if self.b:
                    whole += omega_ball(self.radicand, bits) * arb_poly(self.b)
                self._balls[bits] = whole
        return self._balls[bits]


def _horner(polynomial: fmpz_poly, x: Any) -> Any:
    total = x * 0
    for c in reversed(polynomial.coeffs()):
        total = total * x + c
    return total


@dataclass(frozen=True)
class Form:
    """A polynomial in u with a formal degree; the excess over its actual degree counts zeros at u = ∞."""

    polynomial: QuadraticPoly
    degree: int

    @property
    def zeros_at_infinity(self) -> int:
        """The multiplicity of u = ∞."""
        return self.degree - self.polynomial.degree

    def __mul__(self, other: Form) -> Form:
        return Form(self.polynomial * other.polynomial, self.degree + other.degree)

    def quotient(self, divisor: Form) -> Form:
        """The exact quotient over ℚ(ω), primitive.

        Raises:
            DivisionError: there is a remainder.
        """
        return Form(self.polynomial.quotient(divisor.polynomial), self.degree - divisor.degree)


SturmChain: TypeAlias = tuple[list[arb_poly], list[arb_poly]]
"""Sturm's sequence, and the quotients of neighbours from the last but two up."""


def sturm_chain(first: arb_poly) -> SturmChain | None:
    """Sturm's sequence; None if a leading coefficient may be 0, or a degree falls by several."""
    chain, quotients, second = [first], [], first.derivative()
    for degree in range(first.degree() - 1, -1, -1):
        if second[degree].contains(0) or chain[-1][degree + 1].contains(0):
            return None
        chain.append(second)
        quotient, rest = divmod(first, second)
        quotients.append(quotient)
        first, second = second, -rest
    return chain, quotients[-2::-1]


def changes_at(chain: SturmChain, point: arb | None) -> int | None:
    """The sign changes of Sturm's sequence at a point, of which None is ∞; None if they stay open."""
    polynomials, quotients = chain
    if point is None:
        return changes_between([p[p.degree()] for p in polynomials])
    values = [polynomials[-1][0], polynomials[-2](point)]
    for quotient in quotients:  # from the last two up: faster, and nearly always as good as one by one
        values.append(quotient(point) * values[-1] - values[-2])
    changes = changes_between(values)
    return changes_between([p(point) for p in polynomials]) if changes is None else changes


def changes_between(values: Sequence[arb]) -> int | None:
    """Changes of sign between neighbours; None if a sign is not certain."""
    if any(value.contains(0) for value in values):
        return None
    signs = [bool(value > 0) for value in values]
    return sum(a != b for a, b in pairwise(signs))
