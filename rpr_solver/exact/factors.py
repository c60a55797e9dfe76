"""Poses that balls cannot decide, decided exactly: multiple roots, spurious coincidences, shared curves.

Every candidate becomes a pose over a real number field, where derivatives are zero or not by exact
arithmetic, and is told apart by the conditions of method.md section 2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flint import ctx, fmpq, fmpq_poly, fmpz_poly

from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import (
    Algebraic,
    Field,
    adjoin_real_roots,
    evaluate,
)
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.exact.quadratic import Pair
from rpr_solver.exact.real_roots import RealPolynomial, RealRoot, real_roots

_NOTHING = fmpz_poly([])
_FIRST_BITS, _APART_BITS = 256, 1 << 12


@dataclass(frozen=True)
class NormFactor:
    """An irreducible factor M over ℚ of the norm of A + ω B, and how it divides A + ω B.

    M divides both parts ``common`` times. Where ``extra`` > 0, M = P P̄ splits over ℚ(ω), P divides
    ``extra`` times more, and ω is a polynomial in a root of P, given as ``omega``.
    """

    polynomial: fmpz_poly
    common: int
    extra: int
    omega: fmpq_poly | None

    @property
    def shape(self) -> list[tuple[int, int]]:
        """(degree, multiplicity) of the factors of A + ω B that M stands for."""
        degree = int(self.polynomial.degree())
        if not self.extra:
            return [(degree, self.common)]
        parts = [(degree // 2, self.common + self.extra), (degree // 2, self.common)]
        return [part for part in parts if part[1]]


@dataclass(frozen=True)
class ExactRoot:
    """A real root u of the eliminant, as a root of an irreducible rational polynomial.

    ``omega`` is ω as a polynomial in u where u determines it, else None.
    """

    root: RealRoot
    multiplicity: int
    omega: fmpq_poly | None


def norm_factors(pair: Pair, radicand: int) -> list[NormFactor]:
    """The factors of A + ω B, found by factoring A² − ω² B² over ℚ."""
    return [_norm_factor(pair, *factor) for factor in _irreducible(_norm(pair, radicand))]


def simple_and_other_roots(pair: Pair, radicand: int) -> tuple[list[RealRoot], list[ExactRoot]]:
    """The real roots of A + ω B that are simple even in the norm, and the others.

    Only the others need irreducible factors, which for a norm of high degree take long.
    """
    simple: list[RealRoot] = []
    factors = []
    for power, exponent in _norm(pair, radicand).factor_squarefree()[1]:
        if exponent == 1:
            roots = real_roots(RealPolynomial(power, _NOTHING, 1))
            simple += (root for root in roots if _is_root(pair, radicand, root))
        else:
            factors += [_norm_factor(pair, factor, exponent) for factor, _ in power.factor()[1]]
    return simple, list(exact_roots(factors))


def exact_counterparts(roots: Sequence[RealRoot], pair: Pair, radicand: int) -> list[ExactRoot]:
    """Some of the real roots of A + ω B, exactly; no other factor of the norm is looked at."""
    balls = [root.refined(_APART_BITS) for root in roots]

    def wanted(root: RealRoot) -> bool:
        own = root.refined(_APART_BITS)
        return any(own.overlaps(ball) for ball in balls)

    factors = [
        _norm_factor(pair, factor, exponent)
        for factor, exponent in _irreducible(_norm(pair, radicand))
        if any(map(wanted, real_roots(RealPolynomial(factor, _NOTHING, 1))))
    ]
    found = [root for root in exact_roots(factors) if wanted(root.root)]
    if len(found) != len(roots):
        raise Unproved("a root was lost between balls and exact arithmetic")
    return found


def _norm(pair: Pair, radicand: int) -> fmpz_poly:
    a, b = pair
    return a * a - radicand * b * b if b else a


def _irreducible(norm: fmpz_poly) -> Iterator[tuple[fmpz_poly, int]]:
    """The irreducible factors with their exponents."""
    for power, exponent in norm.factor_squarefree()[1]:
        yield from ((factor, exponent) for factor, _ in power.factor()[1])


def _is_root(pair: Pair, radicand: int, root: RealRoot) -> bool:
    """Whether a simple root of the norm is one of A + ω B, and not of A − ω B."""
    a, b = pair
    if not b:
        return True

    def vanishes(bits: int) -> bool | None:
        u = root.refined(bits)
        with ctx.workprec(bits):
            own, other = (RealPolynomial(a, part, radicand).ball(bits)(u) for part in (b, -b))
            return bool(own.contains(0)) if own.contains(0) != other.contains(0) else None

    return decided(vanishes, _FIRST_BITS, GREATEST_BITS, "a root could not be told from its conjugate")


def _norm_factor(pair: Pair, factor: fmpz_poly, exponent: int) -> NormFactor:
    a, b = pair
    if not b:
        return NormFactor(factor, exponent, 0, None)
    common = 0
    while not a % factor and not b % factor:
        a, b, common = a / factor, b / factor, common + 1
    extra = exponent - 2 * common
    omega = None
    if extra:
        modulus = fmpq_poly(factor)
        _, inverse, _ = (fmpq_poly(b) % modulus).xgcd(modulus)
        omega = -(fmpq_poly(a) * inverse) % modulus
    return NormFactor(factor, common, extra, omega)


def exact_roots(factors: list[NormFactor]) -> Iterator[ExactRoot]:
    """The real roots u ≠ ∞ of A + ω B with their multiplicities."""
    for factor in factors:
        for root in real_roots(RealPolynomial(factor.polynomial, _NOTHING, 1)):
            omega = factor.omega
            if omega is not None and Algebraic(Field.of_root(root), omega).sign < 0:
                omega = None  # a root of the conjugate P̄
            if multiplicity := factor.common + (factor.extra if omega is not None else 0):
                yield ExactRoot(root, multiplicity, omega)


def root_and_omega(radicand: int, root: ExactRoot) -> Iterator[tuple[Algebraic, Algebraic]]:
    """The root and ω as elements of one real field (exactly one pair)."""
    field = Field.of_root(root.root)
    if root.omega is not None:
        yield field.generator, field(root.omega)
    elif radicand == 1:
        yield field.generator, field(1)
    else:
        square = [field(-radicand), field(0), field(1)]
        for extension in adjoin_real_roots(field, square):
            if extension.root.sign > 0:
                yield extension.generator, extension.root


def value_at(pair: Pair, u: Algebraic, omega: Algebraic) -> Algebraic:
    """A + ω B at u, exactly."""
    a, b = ([u.field(fmpq(c)) for c in part.coeffs()] for part in pair)
    total = evaluate(a, u)
    return total + evaluate(b, u) * omega if b else total
