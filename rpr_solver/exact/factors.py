"""The irreducible factors over ℚ(ω) of a polynomial A + ω B, and its real roots in number fields.

They serve where balls cannot decide, as at multiple roots: above an exact root, equality with zero is decided
exactly. The factors are derived from those of the norm, which FLINT factors over ℚ
(mathematics.md#factors-over-a-quadratic-field).

Whether two numbers, perhaps of different fields, are equal is shown by their minimal polynomials, as no
precision does (mathematics.md#equal-lengths): both are roots of one, and lie in the isolating interval
of the same root.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypedDict

from flint import ctx, fmpq_mat, fmpq_poly, fmpz_poly

from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import Algebraic, Field, adjoin_real_roots, inverse_modulo
from rpr_solver.exact.precision import GREATEST_BITS, LENGTH_BITS, decided, decided_or_none
from rpr_solver.exact.quadratic import Form, QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, real_roots

_FIRST_BITS, _APART_BITS = 256, 1 << 12
_MOST_WORK = 5_000_000
"""The cubed degree of the field of a root, times its bits; a pose in it takes several seconds."""


class FactorShape(TypedDict):
    """The degree of a factor, and its multiplicity."""

    degree: int
    multiplicity: int


def shapes_json(shapes: Iterable[tuple[int, int]]) -> list[FactorShape]:
    """The contract's objects of factors, given by (degree, multiplicity)."""
    return [{"degree": degree, "multiplicity": multiplicity} for degree, multiplicity in shapes]


@dataclass(frozen=True)
class NormFactor:
    """An irreducible factor M over ℚ of the norm of A + ω B, and how it divides A + ω B.

    M divides both parts ``common`` times, and ``rest`` is the quotient. Where ``extra`` > 0, M = P P̄ splits
    over ℚ(ω), and P divides ``extra`` times more.
    """

    polynomial: fmpz_poly
    common: int
    extra: int
    rest: QuadraticPoly

    @property
    def shape(self) -> list[tuple[int, int]]:
        """(degree, multiplicity) of the factors of A + ω B that divide M."""
        degree = int(self.polynomial.degree())
        if not self.extra:
            return [(degree, self.common)]
        parts = [(degree // 2, self.common + self.extra), (degree // 2, self.common)]
        return [part for part in parts if part[1]]

    @cached_property
    def omega(self) -> fmpq_poly:
        """ω as a polynomial in a root of P; its coefficients are as long as a resultant."""
        modulus = fmpq_poly(self.polynomial)
        inverse = inverse_modulo(fmpq_poly(self.rest.b) % modulus, modulus)
        return -(fmpq_poly(self.rest.a) * inverse) % modulus


@dataclass(frozen=True)
class ExactRoot:
    """A real root u of a polynomial over ℤ[ω], as a root of an irreducible rational polynomial.

    ``determines`` is the factor by which u determines ω, else None.
    """

    root: RealRoot
    radicand: int
    multiplicity: int
    determines: NormFactor | None

    def in_field(self) -> tuple[Algebraic, Algebraic]:
        """The root and ω as elements of one real field."""
        field = Field(self.root)
        if self.determines is not None:
            return field.generator, field(self.determines.omega)
        if self.radicand == 1:
            return field.generator, field(1)
        square = [field(-self.radicand), field(0), field(1)]
        [extension] = (x for x in adjoin_real_roots(field, square) if x.root.sign > 0)
        return extension.generator, extension.root


def norm_factors(polynomial: QuadraticPoly) -> list[NormFactor]:
    """The factors of A + ω B, by factoring A² − ω² B² over ℚ."""
    return [_norm_factor(polynomial, *factor) for factor in polynomial.norm.factor()[1]]


def simple_and_other_roots(polynomial: QuadraticPoly) -> tuple[list[RealRoot], list[ExactRoot]]:
    """The real roots of A + ω B that are simple roots of the norm too, and the others.

    Only the others need the irreducible factors, which are expensive for a norm of high degree.
    """
    simple: list[RealRoot] = []
    factors = []
    for power, exponent in polynomial.norm.factor_squarefree()[1]:
        if exponent == 1:
            roots = real_roots(QuadraticPoly.rational(power))
            simple += (root for root in roots if _is_root(polynomial, root))
        else:
            factors += [_norm_factor(polynomial, factor, exponent) for factor, _ in power.factor()[1]]
    return simple, list(exact_roots(factors))


def factor_at(root: RealRoot, factors: Sequence[NormFactor]) -> NormFactor | None:
    """The factor of the norm of which a root of A + ω B is one; None if balls do not tell it from others."""
    v = root.refined(_APART_BITS)
    with ctx.workprec(_APART_BITS):
        near = [
            factor
            for factor in factors
            if QuadraticPoly.rational(factor.polynomial).ball(_APART_BITS)(v).contains(0)
        ]
    return near[0] if len(near) == 1 else None


def exact_counterparts(roots: Sequence[RealRoot], factors: Sequence[NormFactor]) -> list[ExactRoot]:
    """The exact roots of A + ω B, given by its factors, equal to some of its real roots.

    Raises:
        Unproved: their number field is too large.
    """
    balls = [root.refined(_APART_BITS) for root in roots]

    def matches(root: RealRoot) -> bool:
        own = root.refined(_APART_BITS)
        return any(own.overlaps(ball) for ball in balls)

    used = [
        factor
        for factor in factors
        if any(map(matches, real_roots(QuadraticPoly.rational(factor.polynomial))))
    ]
    for factor in used:
        _check_size(factor.polynomial)
    counterparts = [root for root in exact_roots(used) if matches(root.root)]
    if len(counterparts) != len(roots):
        raise Unproved("a root was lost between balls and exact arithmetic")
    return counterparts


def _check_size(polynomial: fmpz_poly) -> None:
    degree, bits = int(polynomial.degree()), int(polynomial.height_bits())
    if degree**3 * bits > _MOST_WORK:
        raise Unproved(f"a pose needs a number field of degree {degree} with {bits} bits, which is too large")


def _is_root(polynomial: QuadraticPoly, root: RealRoot) -> bool:
    """Whether a root of the norm at which not both parts vanish is one of A + ω B rather than of A − ω B."""
    if not polynomial.b:
        return True
    conjugate = polynomial.conjugate

    def vanishes(bits: int) -> bool | None:
        u = root.refined(bits)
        with ctx.workprec(bits):
            own, other = polynomial.ball(bits)(u), conjugate.ball(bits)(u)
            return bool(own.contains(0)) if own.contains(0) != other.contains(0) else None

    return decided(vanishes, _FIRST_BITS, GREATEST_BITS, "a root could not be told from its conjugate")


def _norm_factor(polynomial: QuadraticPoly, factor: fmpz_poly, exponent: int) -> NormFactor:
    a, b = polynomial.a, polynomial.b
    if not b:
        return NormFactor(factor, exponent, 0, polynomial)
    common = 0
    while not a % factor and not b % factor:
        a, b, common = a / factor, b / factor, common + 1
    return NormFactor(factor, common, exponent - 2 * common, QuadraticPoly(a, b, polynomial.radicand))


def exact_roots(factors: list[NormFactor]) -> Iterator[ExactRoot]:
    """The real roots u ≠ ∞ of A + ω B with their multiplicities."""
    for factor in factors:
        for root in real_roots(QuadraticPoly.rational(factor.polynomial)):
            determines = factor if factor.extra and _is_root(factor.rest, root) else None
            if multiplicity := factor.common + (factor.extra if determines else 0):
                yield ExactRoot(root, factor.rest.radicand, multiplicity, determines)


def roots_of(form: Form) -> list[ExactRoot | None]:
    """The real roots of a form, each once; None is u = ∞."""
    roots = exact_roots(norm_factors(form.polynomial))
    return [*roots, None] if form.zeros_at_infinity else list(roots)


_EQUAL_BITS = 256


def same_number(x: Algebraic, y: Algebraic) -> bool:
    """Whether two real algebraic numbers are equal: one minimal polynomial, and the same root of it."""
    if not x.ball(_EQUAL_BITS).overlaps(y.ball(_EQUAL_BITS)):
        return False
    minimal = minimal_polynomial(x)
    if minimal_polynomial(y) != minimal:
        return False
    roots = real_roots(QuadraticPoly.rational(minimal.numer()))

    def same(bits: int) -> bool | None:
        first, second = (
            [i for i, root in enumerate(roots) if root.refined(bits).overlaps(z.ball(bits))] for z in (x, y)
        )
        return first == second if len(first) == len(second) == 1 else None

    return bool(decided_or_none(same, _EQUAL_BITS, LENGTH_BITS))


def minimal_polynomial(x: Algebraic) -> fmpq_poly:
    """The monic minimal polynomial over ℚ."""
    n = x.field.degree
    power, columns = x.field(1), []
    for _ in range(n):
        columns.append([(x * power).poly[i] for i in range(n)])
        power = power * x.field.generator
    characteristic = fmpq_poly(fmpq_mat(columns).charpoly())
    common = characteristic.gcd(characteristic.derivative())
    return characteristic / common
