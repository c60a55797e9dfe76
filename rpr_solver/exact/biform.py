"""Forms over ℤ[ω] in two half tangents: A + ω B with A and B in ℤ[t, u, L], as quadratic.py in one variable.

The degrees in t = tan(α/2) and u = tan(θ/2) are formal: those of a homogeneous form in the sine and cosine
of the half angle. If the actual degree is smaller, the difference is the number of zeros at α = 180° or θ =
180°. Formal degrees are additive in products, and independent of coefficients that happen to vanish.

A form of degrees (m, n) in t and u, where tan(α/2) = √ρ t and tan(θ/2) = √ρ u, stands for the function
form / (1+ρt²)^(m/2) / (1+ρu²)^(n/2), up to a sign if a degree is odd. The line α = 180° is a factor too: the
form 1 of degree 1 in t.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

from flint import fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver.exact.number_field import Algebraic, evaluate
from rpr_solver.exact.quadratic import Quadratic, QuadraticPoly, univariate

RING = fmpz_mpoly_ctx.get(("t", "u", "L", "omega"), "lex")
"""ℤ[t, u, L][ω], the ring of all forms."""
T, U, L, OMEGA = RING.gens()

R = TypeVar("R")
Rows = tuple[QuadraticPoly, ...]
"""A form without L: the coefficients of t⁰, t¹, … up to the formal degree, polynomials in u."""
Table = tuple[Rows, ...]
"""Row i holds the coefficients of tⁱ L⁰, tⁱ L¹, …, polynomials in u."""


def omega_parts(p: fmpz_mpoly, radicand: int) -> tuple[fmpz_mpoly, fmpz_mpoly]:
    """A and B with A + ω B = p, where ω, the last variable of the ring, has the square ``radicand``.

    For radicand 1, ω is 1 and B is 0.
    """
    omega = p.context().gens()[-1]
    if radicand == 1:
        return p % (omega - 1), p * 0
    p = p % (omega**2 - radicand)
    b = p.derivative(p.context().nvars() - 1)
    return p - omega * b, b


def leading_coefficient(p: fmpz_mpoly, variable: int) -> fmpz_mpoly:
    """The coefficient of the highest power of a variable, given by its number."""
    top = p.degrees()[variable]
    terms = {powers: c for powers, c in p.to_dict().items() if powers[variable] == top}
    ring = p.context()
    return ring.from_dict(terms) / ring.gen(variable) ** top


@dataclass(frozen=True)
class BiForm(Quadratic[fmpz_mpoly]):
    """A + ω B, a form in t and u of formal degrees ``degree_t`` and ``degree_u``, polynomial in L."""

    degree_t: int
    degree_u: int

    @classmethod
    def of(cls, p: fmpz_mpoly, radicand: int, degree_t: int, degree_u: int) -> BiForm:
        """From a polynomial in t, u, L and ω, with ω² put in."""
        return cls(*omega_parts(p, radicand), radicand, degree_t, degree_u)

    @classmethod
    def of_table(cls, table: Table, radicand: int) -> BiForm:
        """From its coefficients, with the same degree in t and in u."""
        degree = len(table) - 1
        a, b = (
            RING.from_dict(
                {
                    (i, k, power, 0): c
                    for i, row in enumerate(table)
                    for power, p in enumerate(row)
                    for k, c in enumerate((p.a, p.b)[part].coeffs())
                    if c
                }
            )
            for part in (0, 1)
        )
        form = cls(a, b, radicand, degree, degree)
        # the cached property, which would be read from the terms
        form.__dict__["coefficients"] = table
        return form

    @classmethod
    def of_rows(cls, rows: Rows, degree_u: int) -> BiForm:
        """A form without L, from its coefficients of t⁰, t¹, …"""
        a, b = (
            RING.from_dict({(i, k, 0, 0): p[k] for i, p in enumerate(part) for k in range(len(p)) if p[k]})
            for part in zip(*((row.a, row.b) for row in rows), strict=True)
        )
        return cls(a, b, rows[0].radicand, len(rows) - 1, degree_u)

    @property
    def joined(self) -> fmpz_mpoly:
        """A + ω B with ω as a variable."""
        return self.a + OMEGA * self.b

    @property
    def transposed(self) -> BiForm:
        """The form with t and u exchanged."""
        a, b = (
            RING.from_dict({(k, i, *rest): c for (i, k, *rest), c in part.to_dict().items()})
            for part in (self.a, self.b)
        )
        return BiForm(a, b, self.radicand, self.degree_u, self.degree_t)

    @property
    def zeros_at_infinity(self) -> int:
        """The multiplicity of t = ∞."""
        return self.degree_t - int(self.joined.degrees()[0])

    @cached_property
    def coefficients(self) -> Table:
        """The table of the form."""
        size = max(0, *(part.degrees()[2] for part in (self.a, self.b))) + 1
        table: list[list[tuple[dict[int, fmpz], dict[int, fmpz]]]]
        table = [[({}, {}) for _ in range(size)] for _ in range(self.degree_t + 1)]
        for which, part in enumerate((self.a, self.b)):
            for (i, k, power, _), c in part.to_dict().items():
                table[i][power][which][k] = c
        return tuple(
            tuple(QuadraticPoly(univariate(a), univariate(b), self.radicand) for a, b in row) for row in table
        )

    @property
    def rows(self) -> Rows:
        """The coefficients of tⁱ of a form without L."""
        return tuple(row[0] for row in self.coefficients)

    def at(self, length: Fraction | None) -> Rows:
        """The coefficients of tⁱ at one L, made integral by the power of its denominator; None is L = ∞."""
        return rows_at(self.coefficients, length)

    def sliced(self, length: Fraction | None) -> BiForm:
        """The form at one L, without L and integral; None is L = ∞."""
        return BiForm.of_rows(self.at(length), self.degree_u)

    def above(self, u: R | None, omega: R) -> list[R]:
        """The coefficients of tⁱ of a form without L at one u, in any ring; None is u = ∞."""
        if u is None:
            return [row.coefficient(self.degree_u, omega) for row in self.rows]
        return [row(u, omega) for row in self.rows]

    def norm1(self) -> int:
        """A bound on the sum of the absolute values of all coefficients."""
        return sum(c.norm1() for row in self.coefficients for c in row)

    def __mul__(self, other: BiForm) -> BiForm:
        degrees = self.degree_t + other.degree_t, self.degree_u + other.degree_u
        return BiForm(*self._product(other), self.radicand, *degrees)

    def __truediv__(self, divisor: fmpz_mpoly) -> BiForm:
        """The exact quotient by a rational polynomial; the formal degrees fall by its actual ones."""
        t, u, *_ = divisor.degrees()
        return BiForm(self.a / divisor, self.b / divisor, self.radicand, self.degree_t - t, self.degree_u - u)

    def quotient(self, divisor: BiForm) -> BiForm:
        """The exact quotient over ℚ(ω), up to a rational factor: primitive.

        Raises:
            DivisionError: there is a remainder.
        """
        degrees = self.degree_t - divisor.degree_t, self.degree_u - divisor.degree_u
        return BiForm(*self._quotient(divisor), self.radicand, *degrees)


def scale(whole: BiForm, *factors: BiForm) -> Fraction:
    """The rational number that is left of a form, not 0, when it is divided by all its factors."""
    product = QuadraticPoly.rational([1], whole.radicand)
    for form in factors:
        product = product * _leading(form)
    leading = _leading(whole)
    above, below = (leading.a, product.a) if product.a else (leading.b, product.b)
    return Fraction(int(above[0]), int(below[0]))


def _leading(form: BiForm) -> QuadraticPoly:
    """The coefficient of the leading monomial, which is multiplicative."""
    parts = [part for part in (form.a, form.b) if part]
    top = max(part.monomial(0) for part in parts)
    a, b = (fmpz_poly([part[top]]) for part in (form.a, form.b))
    return QuadraticPoly(a, b, form.radicand)


def rows_at(table: Table, length: Fraction | None) -> Rows:
    """:meth:`BiForm.at` of the form with these coefficients."""
    top, radicand = len(table[0]) - 1, table[0][0].radicand
    n, d = (fmpz(1), fmpz(0)) if length is None else map(fmpz, length.as_integer_ratio())
    weights = [n**k * d ** (top - k) for k in range(top + 1)]

    def combined(parts: list[fmpz_poly]) -> fmpz_poly:
        return sum((part * w for part, w in zip(parts, weights, strict=True)), fmpz_poly([0]))

    return tuple(
        QuadraticPoly(combined([c.a for c in row]), combined([c.b for c in row]), radicand) for row in table
    )


def without_common_factors(j: BiForm, e: BiForm) -> tuple[BiForm, BiForm, list[fmpz_mpoly]]:
    """Divides two forms by the rational factors that they share; also these factors.

    j is divided by every power of such a factor, lest a power beyond those of e reappear as isolated zeros.
    """
    common = []
    while (factor := _common(j.a, j.b, e.a, e.b)) is not None:
        common.append(factor)
        j, e = j / factor, e / factor
        while (again := _common(j.a, j.b, factor)) is not None:
            j = j / again
    return j, e, common


def _common(*polynomials: fmpz_mpoly) -> fmpz_mpoly | None:
    common = T * 0
    for p in polynomials:
        common = common.gcd(p)
    return None if common.is_constant() else common


_T, _U, _L = range(3)


def rational_form(p: fmpz_mpoly, degree_t: int, degree_u: int) -> BiForm:
    """A form with rational coefficients."""
    return BiForm.of(p, 1, degree_t, degree_u)


def by_length(form: BiForm) -> tuple[BiForm, BiForm]:
    """The coefficients of L⁰ and L¹ of a rational form linear in L."""
    zeroth = form.a.subs({"L": 0})
    return replace(form, a=zeroth), replace(form, a=(form.a - zeroth).derivative(_L))


def along_alpha(form: BiForm, rho: int) -> BiForm:
    """2 √ρ ∂/∂α of a rational form, of the same degrees."""
    return replace(form, a=(1 + rho * T**2) * form.a.derivative(_T) - form.degree_t * rho * T * form.a)


def along_theta(form: BiForm, rho: int) -> BiForm:
    """2 √ρ ∂/∂θ of a rational form, of the same degrees."""
    return replace(form, a=(1 + rho * U**2) * form.a.derivative(_U) - form.degree_u * rho * U * form.a)


def imaginary(factor: fmpz_mpoly, rho: int) -> bool:
    """Whether an irreducible polynomial is 1 + ρt² or 1 + ρu², which have no real points."""
    return factor in (rho * T**2 + 1, rho * U**2 + 1)


def curves(form: BiForm, rho: int) -> Iterator[tuple[BiForm, int]]:
    """The factors irreducible over ℚ with their multiplicities, without 1 + ρt² and 1 + ρu².

    A factor that is L alone is left out as well.
    """
    for factor, multiplicity in form.a.factor()[1]:
        t, u, *_ = factor.degrees()
        if (t or u) and not imaginary(factor, rho):
            yield rational_form(factor, t, u), multiplicity
    missing_t, missing_u = (
        degree - actual
        for degree, actual in zip((form.degree_t, form.degree_u), form.a.degrees(), strict=False)
    )
    if missing_t:
        yield rational_form(T**0, 1, 0), missing_t
    if missing_u:
        yield rational_form(T**0, 0, 1), missing_u


def divides(curve: BiForm, form: BiForm) -> bool:
    """Whether a factor as given by :func:`curves` divides a form; every one divides 0."""
    if form.is_zero:
        return True
    if curve.a.is_one():
        t, u, *_ = form.a.degrees()
        return bool(form.degree_t > t if curve.degree_t else form.degree_u > u)
    return not (form.a % curve.a or form.b % curve.a)


def value(form: BiForm, t: Algebraic | None, u: Algebraic | None, one: Algebraic) -> Algebraic:
    """The form's value at a point of the torus, None standing for ∞; in the field of ``one``."""
    rows = form.above(u, one)
    return rows[-1] if t is None else evaluate(rows, t)
