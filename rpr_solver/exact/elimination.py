"""Res_t of two forms in (t, u) over ℤ[ω], divided by known factors, from its values in balls.

All degrees are formal, so that zeros at t = ∞ and u = ∞ count. The quotient is evaluated on a circle
(:class:`Circle`). It has coefficients in ℤ[ω], so balls that hold one integer each determine it
(mathematics.md#integers-from-balls); if the known factors did not divide, some ball would hold none.

A form of degree D in (cos φ, sin φ) is a trigonometric polynomial with the exponents −D, 2 − D, …, D of
exp(iφ), so its values at D + 1 or more equidistant φ of a half circle give it without loss: no other points
are better conditioned. The angles are (1 + πk)/N. Their tangents over √ρ are transcendental (Lindemann), so
no form with algebraic coefficients vanishes at any of them, unless it is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import prod
from typing import TypeVar

from flint import acb, arb, arb_mat, arb_poly, ctx, fmpz, fmpz_mat, fmpz_poly

from rpr_solver.errors import ControlFlow, SolverError, Unproved
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.modular import sylvester
from rpr_solver.exact.precision import decided
from rpr_solver.exact.quadratic import Form, QuadraticPoly, omega_ball

T = TypeVar("T", arb, acb)


@dataclass(frozen=True)
class Circle:
    """The N points u = tan φ, at the precision ``bits``, which should be the working precision."""

    count: int
    bits: int

    def monomials(self, degree: int) -> arb_mat:
        """Row k has cosᴰ⁻ᵏ sinᵏ at every point, so that coefficients of uᵏ times this are values."""
        return _monomials(self, degree)

    def coefficients(self, values: Sequence[arb], degree: int) -> list[arb] | None:
        """The coefficients of u⁰ … uᴰ of the form of degree D < N with these values.

        None if they cannot be the values of such a form; for that, N must exceed D + 1.
        """
        before, after, turns = _transform(self, degree)
        exponents = acb.dft([x * y for x, y in zip(values, before, strict=True)])
        if not all(x.contains(0) for x in exponents[degree + 1 :]):
            return None
        used = [x * y for x, y in zip(exponents, after, strict=False)]
        # iᵏ times a sum over the exponents that is real for even k and imaginary for odd k
        parts = arb_mat([[x.real for x in used], [x.imag for x in used]]) * turns
        return [parts[k % 2, k] * (1, -1, -1, 1)[k % 4] for k in range(degree + 1)]


@lru_cache(maxsize=16)
def _points(circle: Circle) -> list[acb]:
    """exp(iφ)."""
    n = circle.count
    first, turn = ((acb(0, angle) / n).exp() for angle in (arb(1), arb.pi()))
    return [first * power for power in _powers(turn, n - 1)]


@lru_cache(maxsize=32)
def _monomials(circle: Circle, degree: int) -> arb_mat:
    columns = [(_powers(x.real, degree), _powers(x.imag, degree)) for x in _points(circle)]
    return arb_mat([[c[degree - k] * s[k] for c, s in columns] for k in range(degree + 1)])


@lru_cache(maxsize=16)
def _transform(circle: Circle, degree: int) -> tuple[list[acb], list[acb], arb_mat]:
    """Factors before and after a discrete Fourier transform, and from exponents to powers of u.

    The coefficient of exp(i(2m − D)φ) is the mean of the values times exp(−i(2m − D)φ).
    """
    n = circle.count
    turn, back = (acb(0, arb.pi() * degree) / n).exp(), (acb(0, -2) / n).exp()
    first = (acb(0, degree) / n).exp() / n
    after = [first * power for power in _powers(back, degree)]
    return _powers(turn, n - 1), after, arb_mat(_turns(degree))


def _powers(x: T, top: int) -> list[T]:
    """1, x, …; each from two of half its exponent, lest the radii grow with every step."""
    powers = [x**0, x]
    for k in range(2, top + 1):
        powers.append(powers[k // 2] * powers[(k + 1) // 2])
    return powers[: top + 1]


@lru_cache(maxsize=32)
def _turns(degree: int) -> fmpz_mat:
    """Row m has the coefficients of (1 + y)ᵐ (1 − y)ᴰ⁻ᵐ; with y = iu they are those of exp(i(2m − D)φ)."""
    plus, minus = ([fmpz_poly([1, sign]) ** k for k in range(degree + 1)] for sign in (1, -1))
    return fmpz_mat([(plus[m] * minus[degree - m]).coeffs() for m in range(degree + 1)])


_SPARE_BITS = 32
_WORTH_A_TRIAL, _TRIAL_BITS, _TRIED = 1024, 128, 5
_LIMB = 64
"""Working precisions are multiples of it, so that manipulators of like sides share what a circle keeps."""
_MOST_TIMES = 16
"""The most times the precision of the bound; more would be needed only at a pole of the quotient."""


class _NoQuotient(ControlFlow):
    """The values are not those of a polynomial over ℤ[ω]."""


def no_quotient() -> SolverError:
    """The error that a known factor does not divide."""
    return SolverError("an eliminant lacks its known factors; please report this geometry")


def resultant_bound(first: BiForm, second: BiForm) -> int:
    """A bound on the 1-norm of Res_t, which is at most ‖first‖ⁿ ‖second‖ᵐ for the degrees m and n in t.

    Every term of Sylvester's determinant holds n coefficients of the first form and m of the second, and
    1-norms are submultiplicative.
    """
    return int(first.norm1() ** second.degree_t * second.norm1() ** first.degree_t)


def resultant(
    first: BiForm, second: BiForm, known: Form | None = None, content: Fraction = Fraction(1)
) -> Form:
    """Res_t(first, second) / known, primitive; zero where it vanishes.

    The quotient is multiplied by the content of the norm of ``known``, so that its coefficients stay in ℤ[ω]:
    then it is Res_t times the conjugate of ``known``, divided by a primitive rational polynomial.

    Args:
        first, second: forms in t and u.
        known: a factor of the resultant.
        content: a number such that the quotient is its product with a form over ℤ[1/2, ω].

    Raises:
        SolverError: a known factor does not divide.
    """
    radicand = first.radicand
    divisor = known or Form(QuadraticPoly.rational([1], radicand), 0)
    degree = first.degree_t * second.degree_u + second.degree_t * first.degree_u - divisor.degree
    multiple = divisor.polynomial.norm.content()
    own = _odd_part((content * int(multiple)).numerator)

    def values(omega: arb, every: int = 1) -> list[arb]:
        circle = Circle(degree + 2, ctx.prec)
        tables = (_at_points(form.rows, form.degree_u, circle, omega) for form in (first, second))
        [divisors] = zip(*_at_points([divisor.polynomial], divisor.degree, circle, omega), strict=True)
        places = list(zip(*tables, divisors, strict=True))[::every]
        scale = arb(multiple) / own
        return [ball_resultant(j, e) * scale / k for j, e, k in places]

    def coefficients(omega: arb) -> list[arb] | None:
        return Circle(degree + 2, ctx.prec).coefficients(values(omega), degree)

    bits = (resultant_bound(first, second) // own).bit_length() + degree
    if bits > _WORTH_A_TRIAL:
        with ctx.workprec(_TRIAL_BITS):  # the bound is far from the size, which grows with the radii
            radii = [x.rad() for x in values(omega_ball(radicand, _TRIAL_BITS), _TRIED)]
        if all(radius.is_finite() for radius in radii):
            mantissa, exponent = max(radii).man_exp()
            bits = min(bits, _TRIAL_BITS + degree + int(exponent) + int(mantissa).bit_length())
    a, b = recovered(radicand, coefficients, bits)
    return Form(QuadraticPoly(fmpz_poly(a), fmpz_poly(b), radicand).primitive(), degree)


def _odd_part(number: int) -> int:
    return number // (number & -number)


def _at_points(rows: Sequence[QuadraticPoly], degree: int, circle: Circle, omega: arb) -> list[list[arb]]:
    """The values of forms of one degree in u, a row for each point of the circle."""
    matrix = _matrix([row.a for row in rows], degree)
    if any(row.b for row in rows):
        matrix += _matrix([row.b for row in rows], degree) * omega
    return (matrix * circle.monomials(degree)).transpose().tolist()


def _matrix(polynomials: Sequence[fmpz_poly], degree: int) -> arb_mat:
    return arb_mat(fmpz_mat([[p[k] for k in range(degree + 1)] for p in polynomials]))


def recovered(
    radicand: int, coefficients: Callable[[arb], list[arb] | None], bits: int
) -> tuple[list[fmpz], list[fmpz]]:
    """The numbers of A and B, where those of A + ω B are enclosed for either sign of ω.

    ``coefficients`` takes ω as a ball and computes at the working precision, which begins with ``bits``; it
    returns None where it sees that there are no such numbers.

    Raises:
        SolverError: they are not in ℤ[ω].
    """

    def attempt(work: int) -> tuple[list[fmpz], list[fmpz]] | None:
        with ctx.workprec(work):
            omega = omega_ball(radicand, work)
            plus = _enclosures(coefficients(omega))
            if radicand == 1:
                a = _integers(plus)
                return None if a is None else (a, [fmpz(0)] * len(a))
            minus = _enclosures(coefficients(-omega))
            pairs = list(zip(plus, minus, strict=True))
            a = _integers([(x + y) / 2 for x, y in pairs])
            b = None if a is None else _integers([(x - y) / (2 * omega) for x, y in pairs])
            return None if a is None or b is None else (a, b)

    start = -(-(bits + _SPARE_BITS) // _LIMB) * _LIMB
    try:
        return decided(attempt, start, _MOST_TIMES * start, "a resultant could not be evaluated")
    except (_NoQuotient, Unproved):
        raise no_quotient() from None


def _enclosures(coefficients: list[arb] | None) -> list[arb]:
    if coefficients is None:
        raise _NoQuotient
    return coefficients


def _integers(balls: Sequence[arb]) -> list[fmpz] | None:
    """The only integers in these balls; None if one of the balls holds several."""
    integers = []
    for ball in balls:
        integer = ball.unique_fmpz()
        if integer is None:
            if ball.is_finite() and not ball.contains_integer():
                raise _NoQuotient
            return None
        integers.append(integer)
    return integers


def ball_resultant(first: Sequence[arb], second: Sequence[arb]) -> arb:
    """Res of two forms by ascending coefficients; a common zero at infinity counts."""
    if len(first) < len(second):
        swapped = ball_resultant(second, first)
        return -swapped if (len(first) - 1) * (len(second) - 1) % 2 else swapped
    value = _by_remainders(first, second)
    if value is None:
        # in coordinates without special points all degrees fall by one
        value = _by_remainders(_turned(first), _turned(second))
    return arb_mat(sylvester(first, second, arb(0))).det() if value is None else value


def _by_remainders(first: Sequence[arb], second: Sequence[arb]) -> arb | None:
    """Euclid's algorithm; None if a leading coefficient may be 0 but the remainder is not."""
    f, g, m, n = arb_poly(list(first)), arb_poly(list(second)), len(first) - 1, len(second) - 1
    value = arb(1)
    while n > 0:
        lead = g[n]
        if lead.contains(0):
            size_g, size_f = (sum((abs(c) for c in p.coeffs()), arb(0)) for p in (g, f))
            tiny = value * _power(size_g, m) * _power(size_f, n)
            return arb(0, tiny.abs_upper()) if all(c.contains(0) for c in g.coeffs()) else None
        # Res(f, g) = (−1)^(mn) lc(g)^(m − n + 1) Res(g, rest), with the formal degree n − 1 of the rest
        value *= _power(lead, m - n + 1)
        if m * n % 2:
            value = -value
        f, g, m, n = g, f % g, n, n - 1
    return value * _power(g[0], m)


def _power(x: arb, exponent: int) -> arb:
    """FLINT's own power of a small ball round 0 may be NaN."""
    return prod([x] * exponent, start=arb(1))


def _turned(form: Sequence[arb]) -> list[arb]:
    """The form in turned coordinates, t = tan(x) for tan(x + 1); resultants do not change."""
    [turned] = (arb_mat([list(form)]) * _turn(len(form) - 1, ctx.prec)).tolist()
    return turned


@lru_cache(maxsize=16)
def _turn(degree: int, bits: int) -> arb_mat:
    """Row k has the coefficients of tᵏ in turned coordinates."""
    with ctx.workprec(bits):
        sin, cos = arb(1).sin(), arb(1).cos()
        up, down = arb_poly([sin, cos]), arb_poly([cos, -sin])
        rows = [up**k * down ** (degree - k) for k in range(degree + 1)]
        return arb_mat([[row[i] for i in range(degree + 1)] for row in rows])
