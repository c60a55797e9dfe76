"""A manipulator seen from one fixed leg: the map (α, θ) → (f, g) and its curves J = 0, E = 0.

With leg i fixed at length L and its direction e(θ), the pose is X = L e(θ), platform angle α
(the direction of B1B2), and each other leg has the squared length

    f = |X + R(α) m − a|²,     m = its platform point, a = its base point, both seen from leg i.

A pose is singular where J = f_α g_θ − f_θ g_α vanishes (the article's eq. 6), and three poses
coalesce where E = v·∇J vanishes too, with v = (−f_θ, f_α) tangent to f = const (on J = 0 equivalent to the
article's eq. 10; mathematics.md#poses-that-coalesce).

Everything is scaled to integers: lengths are multiplied by ``scale``, and the height of the
platform is a rational multiple of ω = √``radicand``, so all coefficients lie in ℤ[ω].
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, isqrt, lcm, sqrt
from typing import Any

from flint import acb, arb, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver.contract import LENGTHS, check_leg, check_type
from rpr_solver.exact.biform import OMEGA, RING, BiForm, L, T, Table, U
from rpr_solver.exact.numerals import double
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Waves
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.triangles import CW

TRIG = fmpz_mpoly_ctx.get(("cos_alpha", "sin_alpha", "cos_theta", "sin_theta", "L", "omega"), "lex")
_COS_A, _SIN_A, _COS_T, _SIN_T, _L, _ = range(6)
_HOMOGENEOUS = fmpz_mpoly_ctx.get(("C", "S", "N", "c", "s", "n", "L", "omega"), "lex")
_SMALL_PRIMES = tuple(p for p in range(2, 200) if all(p % q for q in range(2, isqrt(p) + 1)))


@dataclass(frozen=True)
class Leg:
    """A free leg seen from the fixed one: platform point (m, n ω), base point (ax, ay), and ω²."""

    m: int
    n: int
    ax: int
    ay: int
    radicand: int

    @property
    def platform2(self) -> int:
        """|m|²: the squared side of the platform between this leg and the fixed one."""
        return self.m**2 + self.n**2 * self.radicand

    @property
    def base2(self) -> int:
        """|a|²: the squared side of the base."""
        return self.ax**2 + self.ay**2

    def points(self, omega: Any) -> tuple[Any, Any]:
        """m and a in the arithmetic of ω."""
        if isinstance(omega, arb):
            return acb(self.m, omega * self.n), acb(self.ax, self.ay)
        zero = omega * 0
        return PlaneNumber(zero + self.m, omega * self.n), PlaneNumber(zero + self.ax, zero + self.ay)

    def doubles(self, unit: Fraction) -> tuple[complex, complex]:
        """m and a over a length, right to two units of the last place.

        Raises:
            OverflowError: the height of m is beyond the range of doubles; a greater coordinate is infinite.
        """
        height = sqrt(Fraction(self.n**2 * self.radicand) / unit**2)
        platform = complex(double(self.m / unit), height if self.n >= 0 else -height)
        return platform, complex(double(self.ax / unit), double(self.ay / unit))

    def waves(self, omega: Any) -> Waves:
        """The waves at α = θ = 0 in the arithmetic of ω."""
        return Waves.of(*self.points(omega))

    def rotated(self, cos: Any, sin: Any, omega: Any) -> tuple[Any, Any]:
        """R(α) m, the platform point turned by α, in any ring."""
        n = omega * self.n
        return cos * self.m - sin * n, sin * self.m + cos * n

    def collinear(self) -> fmpz_poly:
        """The quadratic in u of the poses with the fixed leg along the base line to this leg."""
        return fmpz_poly([self.ay, -2 * self.ax, -self.ay])

    def closed(self, length: Fraction) -> fmpz_poly:
        """The quadratic in u of the poses with this leg of length 0, times the squared denominator of L."""
        n, d = length.numerator, length.denominator
        even = n * n + d * d * (self.base2 - self.platform2)
        return fmpz_poly([even - 2 * n * d * self.ax, -4 * n * d * self.ay, even + 2 * n * d * self.ax])


@dataclass(frozen=True)
class SliceMap:
    """The integer model of a manipulator with one leg fixed.

    ``scale`` times a length in the user's unit is the *scaled* length used here. ``radicand`` is ω²; it is 1
    if the height of the platform is rational.
    """

    fixed_leg: int
    scale: Fraction
    radicand: int
    f: Leg
    g: Leg

    @classmethod
    def of(cls, manipulator: Manipulator, fixed_leg: int = 1) -> SliceMap:
        """Builds the model.

        Raises:
            InputError: ``manipulator`` is not a manipulator, or ``fixed_leg`` is not 1, 2 or 3.
        """
        check_type(manipulator, Manipulator, "manipulator")
        fixed_leg = check_leg(fixed_leg)
        lengths = [getattr(manipulator, name) for name in LENGTHS]
        unit = lcm(*(x.denominator for x in lengths))
        a2x, a3x, a3y, d1, d2, d3 = (int(x * unit) for x in lengths)
        # times 2 d1 the platform is integral: B2 = (2 d1², 0), B3 = (d1² + d3² − d2², ω)
        double = 2 * d1
        square, radicand = _split_square(int(manipulator.area16 * unit**4))
        height = -square if manipulator.orientation == CW else square
        base = [(0, 0), (double * a2x, 0), (double * a3x, double * a3y)]
        platform = [(0, 0), (double * d1, 0), (d1 * d1 + d3 * d3 - d2 * d2, height)]
        common = gcd(*itertools.chain(*base, *platform))
        base = [(x // common, y // common) for x, y in base]
        platform = [(x // common, y // common) for x, y in platform]
        (ox, oy), (om, on) = base.pop(fixed_leg - 1), platform.pop(fixed_leg - 1)
        points = zip(platform, base, strict=True)
        f, g = (Leg(m - om, n - on, x - ox, y - oy, radicand) for (m, n), (x, y) in points)
        return cls(fixed_leg, Fraction(unit * double, common), radicand, f, g)

    @property
    def similar(self) -> bool:
        """Whether base and platform are similar triangles of one sense: m : a is one complex number."""
        f, g = self.f, self.g
        # the height of a platform that is similar to a rational base is rational
        return self.radicand == 1 and (
            f.m * g.ax - f.n * g.ay == g.m * f.ax - g.n * f.ay
            and f.m * g.ay + f.n * g.ax == g.m * f.ay + g.n * f.ax
        )

    @cached_property
    def unit(self) -> int:
        """A length in terms of which the base is integral, and so are the squared sides of the platform,
        twice their products and four times its area (mathematics.md#the-content-of-the-eliminant)."""
        f, g = self.f, self.g
        products = 2 * (f.m * g.m + f.n * g.n * f.radicand), 2 * (f.m * g.n - f.n * g.m)
        squares = gcd(f.platform2, g.platform2, *products)
        unit = gcd(f.ax, f.ay, g.ax, g.ay)
        while squares % unit**2:
            unit = gcd(unit, squares // gcd(squares, unit))
        return unit

    @property
    def side2(self) -> int:
        """|a − b|²: the squared side of the base between the free legs."""
        return (self.f.ax - self.g.ax) ** 2 + (self.f.ay - self.g.ay) ** 2

    @cached_property
    def singular(self) -> BiForm:
        """J / (4 L): degrees 4 in t and u, 1 in L."""
        return BiForm.of_table(self.tables[0], self.radicand)

    @cached_property
    def coalescence(self) -> BiForm:
        """E, up to a constant factor: degrees 6 in t and u, 2 in L."""
        return BiForm.of_table(self.tables[1], self.radicand)

    @cached_property
    def tables(self) -> tuple[Table, Table]:
        """The coefficients of both, without the polynomials in several variables."""
        (f_alpha, f_theta), (g_alpha, g_theta) = (_packed_slopes(leg) for leg in (self.f, self.g))
        j = f_alpha * g_theta - f_theta * g_alpha
        along_alpha, along_theta = _packed_derivatives(j)
        length = QuadraticPoly.rational(_PACKED_L)
        twice = f_alpha * along_theta - f_theta * length * along_alpha
        return _unpacked(j, 4), _unpacked(twice / fmpz_poly([2]), 6)

    def scale_ball(self) -> arb:
        """``scale`` as a ball at the working precision."""
        return ball_of(self.scale)

    @cached_property
    def trigonometric(self) -> tuple[fmpz_mpoly, fmpz_mpoly]:
        """J / (4 L) and E in cosines and sines of α and θ, L and ω (ring :data:`TRIG`)."""
        length = TRIG.gen(_L)
        f_alpha, f_theta = slopes(self.f)
        g_alpha, g_theta = slopes(self.g)
        j = f_alpha * g_theta - f_theta * g_alpha
        return j, f_alpha * d_theta(j) - length * f_theta * d_alpha(j)


_PLACE_U, _PLACE_L = 7, 49
"""The powers of x that stand for u and L, as x does for t, in *packed* forms of degrees up to 6."""
_X = fmpz_poly([0, 1])
_PACKED_L = _X**_PLACE_L
_PACKED_ALPHA = _COS_ALPHA, _SIN_ALPHA, _ONE_ALPHA = (
    fmpz_poly([1, 0, -1]),
    fmpz_poly([0, 2]),
    fmpz_poly([1, 0, 1]),
)
_COS_THETA, _SIN_THETA, _ONE_THETA = (p(_X**_PLACE_U) for p in _PACKED_ALPHA)


def _packed_slopes(leg: Leg) -> tuple[QuadraticPoly, QuadraticPoly]:
    """:func:`slopes` times (1 + t²)(1 + u²)."""
    x = _COS_ALPHA * leg.m, -_SIN_ALPHA * leg.n
    y = _SIN_ALPHA * leg.m, _COS_ALPHA * leg.n
    in_x = _SIN_THETA * _PACKED_L - _ONE_THETA * leg.ay
    in_y = _ONE_THETA * leg.ax - _COS_THETA * _PACKED_L
    across = _ONE_ALPHA * (_SIN_THETA * leg.ax - _COS_THETA * leg.ay), fmpz_poly([])
    alpha = (in_x * p + in_y * q for p, q in zip(x, y, strict=True))
    theta = (_COS_THETA * q - _SIN_THETA * p + c for p, q, c in zip(x, y, across, strict=True))

    def joined(a: fmpz_poly, b: fmpz_poly) -> QuadraticPoly:
        return QuadraticPoly.rational(a + b) if leg.radicand == 1 else QuadraticPoly(a, b, leg.radicand)

    return joined(*alpha), joined(*theta)


def _packed_derivatives(j: QuadraticPoly) -> tuple[QuadraticPoly, QuadraticPoly]:
    """2 ∂/∂α and 2 ∂/∂θ of a packed form of degrees 4."""
    results = []
    for place, size, one in ((1, _PLACE_U, _ONE_ALPHA), (_PLACE_U, _PLACE_L, _ONE_THETA)):
        x = _X**place
        parts = []
        for p in (j.a, j.b):
            # coefficients times their exponents: x times the derivative
            slope = fmpz_poly([c * (n % size // place) for n, c in enumerate(p.coeffs())])
            parts.append(one * slope / x - 4 * x * p)
        results.append(QuadraticPoly(parts[0], parts[1], j.radicand))
    return results[0], results[1]


def _unpacked(p: QuadraticPoly, degree: int) -> Table:
    """The coefficients of a packed form of one degree in t and u."""
    size = max(p.degree // _PLACE_L, 0) + 1
    a, b = (part.coeffs() for part in (p.a, p.b))
    starts = [[power * _PLACE_L + i for power in range(size)] for i in range(degree + 1)]
    return tuple(
        tuple(
            QuadraticPoly(
                fmpz_poly(a[n : n + _PLACE_L : _PLACE_U]),
                fmpz_poly(b[n : n + _PLACE_L : _PLACE_U]),
                p.radicand,
            )
            for n in row
        )
        for row in starts
    )


def _split_square(n: int) -> tuple[int, int]:
    """(s, r) with n = s² r, r free of small squares; (√n, 1) for a square, (0, 1) for 0."""
    root = isqrt(n)
    if root * root == n:
        return root, 1
    square = 1
    for p in _SMALL_PRIMES:
        while n % (p * p) == 0:
            n //= p * p
            square *= p
    return square, n


def slopes(leg: Leg) -> tuple[fmpz_mpoly, fmpz_mpoly]:
    """f_α / 2 and f_θ / (2 L) of one leg."""
    cos_a, sin_a, cos_t, sin_t, length, omega = TRIG.gens()
    x, y = leg.rotated(cos_a, sin_a, omega)
    x_alpha, y_alpha = -y, x
    along = length * (cos_t * x_alpha + sin_t * y_alpha) - (leg.ax * x_alpha + leg.ay * y_alpha)
    across = cos_t * (y - leg.ay) - sin_t * (x - leg.ax)
    return along, across


def excess(leg: Leg, square: Fraction) -> tuple[fmpz_mpoly, fmpz_mpoly, fmpz_mpoly]:
    """The coefficients of L⁰, L¹ and L² of f − ``square``, times its denominator."""
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    x, y = leg.rotated(cos_a, sin_a, omega)
    n, d = square.numerator, square.denominator
    both = cos_t * x + sin_t * y - leg.ax * cos_t - leg.ay * sin_t
    constant = d * (leg.platform2 + leg.base2) - n - 2 * d * (leg.ax * x + leg.ay * y)
    return constant, 2 * d * both, TRIG.constant(d)


def d_alpha(p: fmpz_mpoly) -> fmpz_mpoly:
    """∂/∂α of a polynomial in cosines and sines."""
    return TRIG.gen(_COS_A) * p.derivative(_SIN_A) - TRIG.gen(_SIN_A) * p.derivative(_COS_A)


def d_theta(p: fmpz_mpoly) -> fmpz_mpoly:
    """∂/∂θ of a polynomial in cosines and sines."""
    return TRIG.gen(_COS_T) * p.derivative(_SIN_T) - TRIG.gen(_SIN_T) * p.derivative(_COS_T)


def reduced(p: fmpz_mpoly, radicand: int) -> fmpz_mpoly:
    """The normal form modulo cos² + sin² = 1 and ω² = radicand, whose degree is the true one."""
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    return p % (cos_a**2 + sin_a**2 - 1) % (cos_t**2 + sin_t**2 - 1) % (omega**2 - radicand)


def half_angles(p: fmpz_mpoly, orders: tuple[int, int], radicand: int) -> BiForm:
    """The numerator of a trigonometric polynomial of the given degrees in α and in θ.

    It is made homogeneous, since cos : sin : 1 = 1 − t² : 2 t : 1 + t². Derivatives must be taken before, of
    cosines and sines: d/dα and d/dt differ by the factor dt/dα.
    """
    a, b = orders
    terms = {(i, j, a - i - j, k, m, b - k - m, *rest): c for (i, j, k, m, *rest), c in p.to_dict().items()}
    half = (1 - T**2, 2 * T, 1 + T**2, 1 - U**2, 2 * U, 1 + U**2, L, OMEGA)
    numerator = _HOMOGENEOUS.from_dict(terms).compose(*half, ctx=RING)
    return BiForm.of(numerator, radicand, 2 * a, 2 * b)


def in_tangents(p: fmpz_mpoly, orders: tuple[int, int], radicand: int) -> BiForm:
    """The numerator in t = tan(α/2) and v = tan θ, which takes the place of u, of a reduced polynomial.

    With the degree b in θ it must change by the factor (−1)ᵇ under θ ↦ θ + π. It is divided by cosᵇ θ.
    """
    a, b = orders
    terms = {}
    for (i, j, k, m, *rest), c in p.to_dict().items():
        half, odd = divmod(b - k - m, 2)
        if odd:
            raise ValueError("half a turn does more than change the sign")
        terms[i, j, a - i - j, k, m, half, *rest] = c
    tangents = (1 - T**2, 2 * T, 1 + T**2, T**0, U, 1 + U**2, L, OMEGA)
    return BiForm.of(_HOMOGENEOUS.from_dict(terms).compose(*tangents, ctx=RING), radicand, 2 * a, b)
