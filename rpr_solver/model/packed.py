"""J and E *packed*: forms in t, u and L as polynomials in one variable x, for the products of FLINT.

x stands for t, x⁷ for u and x⁴⁹ for L. All degrees in t and u are up to 6, those of products too.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import TypeAlias

from flint import arb, arb_mat, fmpz, fmpz_mat, fmpz_poly

from rpr_solver.exact.biform import Rows, Table
from rpr_solver.exact.quadratic import QuadraticNumber, QuadraticPoly
from rpr_solver.exact.two_values import Size

_U, _L = 7, 49
"""The powers of x that stand for u and L."""
_EXPONENTS_OF_T, _EXPONENTS_OF_U = (
    [fmpz(n % _U) for n in range(3 * _L)],
    [fmpz(n % _L // _U) for n in range(3 * _L)],
)
"""Those of t and u in each power of x."""
_X = fmpz_poly([0, 1])
_LENGTH = _X**_L

Coordinates: TypeAlias = tuple[QuadraticNumber[int], QuadraticNumber[int]]
"""x and y of a point, y in √ρ."""


@dataclass(frozen=True)
class PackedSlice:
    """A form of one slice.

    Attributes:
        polynomial: primitive.
        degree: the degree in t and in u.
        content: what it was divided by.
        powers: those of the denominator of L with which it was multiplied before.
    """

    polynomial: QuadraticPoly
    degree: int
    content: int
    powers: int

    @cached_property
    def rows(self) -> Rows:
        """The coefficients of t⁰, t¹, …"""
        return _rows(self.polynomial, self.degree)

    def matrix(self, omega: arb) -> arb_mat:
        """A row of coefficients of t⁰, t¹, … for each of u⁰, u¹, …"""
        matrix = self._matrix(self.polynomial.a)
        return matrix + self._matrix(self.polynomial.b) * omega if self.polynomial.b else matrix

    def _matrix(self, part: fmpz_poly) -> arb_mat:
        size, numbers = self.degree + 1, part.coeffs() + [fmpz(0)] * _L
        return arb_mat(fmpz_mat([numbers[_U * k : _U * k + size] for k in range(size)]))

    def size(self, rho: int) -> Size:
        """That of the form in √ρ t and √ρ u."""
        a, b = (_squares(part, rho) for part in (self.polynomial.a, self.polynomial.b))
        # (x + y)² ≤ 2 x² + 2 y²
        return Size(self.degree, 2 * (a + self.polynomial.radicand * b) if b else a)


def _squares(p: fmpz_poly, rho: int) -> fmpz:
    """The sum of the squared coefficients of √ρ t and √ρ u, upwards."""
    numbers = p.coeffs()
    if not numbers:
        return fmpz(0)
    size, weights = len(numbers), _weights(rho)
    others = numbers if rho == 1 else [c * weight for c, weight in zip(numbers, weights, strict=False)]
    total = (fmpz_mat(1, size, numbers) * fmpz_mat(size, 1, others))[0, 0]
    return -(-total // weights[0])


@lru_cache(maxsize=16)
def _weights(rho: int) -> list[fmpz]:
    """ρ¹² over the squared units of tⁱ uᵏ in terms of √ρ t and √ρ u."""
    return [fmpz(rho) ** (2 * (_U - 1) - n % _U - n // _U) for n in range(_L)]


@dataclass(frozen=True)
class PackedForm:
    """A form by powers of L.

    Attributes:
        powers: the coefficients of L⁰, L¹, …
    """

    powers: tuple[QuadraticPoly, ...]

    @classmethod
    def of(cls, form: QuadraticPoly) -> PackedForm:
        """From the polynomial in x."""
        a, b = form.a.coeffs(), form.b.coeffs()
        starts = range(0, max(form.degree, 0) + 1, _L)
        parts = ((fmpz_poly(a[n : n + _L]), fmpz_poly(b[n : n + _L])) for n in starts)
        return cls(tuple(QuadraticPoly(*part, form.radicand) for part in parts))

    def table(self, degree: int) -> Table:
        """The coefficients of tⁱ Lᵏ, polynomials in u; of this degree in t and u."""
        return tuple(zip(*(_rows(power, degree) for power in self.powers), strict=True))

    def sliced(self, length: Fraction, degree: int) -> PackedSlice:
        """At one L."""
        n, d, top = fmpz(length.numerator), fmpz(length.denominator), len(self.powers) - 1
        a, b = fmpz_poly([]), fmpz_poly([])
        for k, power in enumerate(self.powers):
            weight = n**k * d ** (top - k)
            a, b = a + power.a * weight, b + power.b * weight
        content = a.content().gcd(b.content()) or fmpz(1)
        polynomial = QuadraticPoly(a / content, b / content, self.powers[0].radicand)
        return PackedSlice(polynomial, degree, int(content), top)


def _rows(p: QuadraticPoly, degree: int) -> Rows:
    a, b = p.a.coeffs(), p.b.coeffs()
    return tuple(
        QuadraticPoly(fmpz_poly(a[n::_U]), fmpz_poly(b[n::_U]), p.radicand) for n in range(degree + 1)
    )


def packed_forms(
    f: tuple[Coordinates, Coordinates], g: tuple[Coordinates, Coordinates], rho: int
) -> tuple[PackedForm, PackedForm]:
    """J / (4 L), of degree 4 in t and u, and E, of degree 6.

    Args:
        f, g: the platform point m and the base point a of each free leg.
        rho: ρ.
    """
    (f_alpha, f_theta), (g_alpha, g_theta) = (_slopes(*leg, rho) for leg in (f, g))
    j = f_alpha * g_theta - f_theta * g_alpha
    along_alpha, along_theta = _derivatives(j, rho)
    length = QuadraticPoly.rational(_LENGTH, j.radicand)
    twice = f_alpha * along_theta - f_theta * length * along_alpha
    return PackedForm.of(j), PackedForm.of(twice / fmpz_poly([2]))


def _slopes(platform: Coordinates, base: Coordinates, rho: int) -> tuple[QuadraticPoly, QuadraticPoly]:
    """f_α / 2 and f_θ / (2 L) of one leg, over √ρ, times (1 + ρt²)(1 + ρu²)."""
    (m, n), (ax, ay) = platform, base
    # the parts without and with ω
    first = _factors(m.a, n.a, ax.a, ay.a, rho, 1)
    second = _factors(m.b, n.b, ax.b, ay.b, rho, 0)
    x, y, across, along, left, right = map(QuadraticPoly, first, second, [m.radicand] * len(first))
    cos, sin = (QuadraticPoly.rational(part, m.radicand) for part in _turn(rho)[:2])
    return across * x + along * y, cos * left - sin * right


def _factors(m: int, n: int, ax: int, ay: int, rho: int, one: int) -> list[fmpz_poly]:
    """x, y, L sin θ − a_y, a_x − L cos θ, y − a_y and x − a_x; the platform point turned by α is (x, y).

    f_α/2 = (L sin θ − a_y) x + (a_x − L cos θ) y, and f_θ/(2 L) = cos θ (y − a_y) − sin θ (x − a_x).
    """
    u, uu = [0] * (_U - 1), [0] * (2 * _U - 1)
    across = [-ay, *uu, -rho * ay]
    along = [ax, *uu, rho * ax]
    if one:
        zeros = [0] * (_L - 2 * _U - 1)
        across += [*zeros, 0, *u, 2]
        along += [*zeros, -1, *uu, rho]
    factors = (
        [m, -2 * rho * n, -rho * m],
        [n, 2 * m, -rho * n],
        across,
        along,
        [n - ay, 2 * m, -rho * (n + ay)],
        [m - ax, -2 * rho * n, -rho * (m + ax)],
    )
    return [fmpz_poly(factor) for factor in factors]


@lru_cache(maxsize=256)
def _turn(rho: int) -> tuple[fmpz_poly, fmpz_poly, fmpz_poly]:
    """1 − ρu², 2u and 1 + ρu²."""
    u = _X**_U
    return 1 - rho * u * u, 2 * u, 1 + rho * u * u


def _derivatives(j: QuadraticPoly, rho: int) -> tuple[QuadraticPoly, QuadraticPoly]:
    """2 √ρ ∂/∂α and 2 √ρ ∂/∂θ of a form of degrees 4."""
    results = []
    for x, exponents, one in (
        (_X, _EXPONENTS_OF_T, 1 + rho * _X * _X),
        (_X**_U, _EXPONENTS_OF_U, _turn(rho)[2]),
    ):
        parts = []
        for p in (j.a, j.b):
            # coefficients times their exponents: x times the derivative
            slope = fmpz_poly([c * n for c, n in zip(p.coeffs(), exponents, strict=False)])
            parts.append(one * (slope / x) - 4 * rho * x * p if p else p)
        results.append(QuadraticPoly(parts[0], parts[1], j.radicand))
    return results[0], results[1]
