"""A manipulator seen from one fixed leg: the map (α, θ) → (f, g) and its curves J = 0, E = 0.

With leg i fixed at length L and its direction e(θ), the pose is X = L e(θ), platform angle α
(the direction of B1B2), and each other leg has the squared length

    f = |X + R(α) m − a|²,     m = its platform point, a = its base point, both seen from leg i.

A pose is singular where J = f_α g_θ − f_θ g_α vanishes (the article's eq. 6), and three poses
coalesce where also E = v·∇J does, v = (−f_θ, f_α) being tangent to f = const (eq. 10 on J = 0;
method.md section 2).

Everything is scaled to integers: lengths are multiplied by ``scale``, and the height of the
platform is a rational multiple of ω = √``radicand``, so all coefficients lie in ℤ[ω].
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, isqrt, lcm

from flint import arb, fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver.errors import InputError
from rpr_solver.exact.quadratic import Pair
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.manipulator import CW, Manipulator

TRIG = fmpz_mpoly_ctx.get(("cos_alpha", "sin_alpha", "cos_theta", "sin_theta", "L", "omega"), "lex")
_COS_A, _SIN_A, _COS_T, _SIN_T, _L, _OMEGA = range(6)
_SMALL_PRIMES = tuple(p for p in range(2, 200) if all(p % q for q in range(2, isqrt(p) + 1)))


@dataclass(frozen=True)
class Leg:
    """A moving leg seen from the fixed one: platform point (m, n ω), base point (ax, ay)."""

    m: int
    n: int
    ax: int
    ay: int


@dataclass(frozen=True)
class BiForm:
    """A form in t = tan(α/2) and u = tan(θ/2): ``coefficients[i][k]`` belongs to tⁱ Lᵏ.

    ``degree_t`` and ``degree_u`` are formal: a lower actual degree is a zero at infinity.
    """

    degree_t: int
    degree_u: int
    coefficients: tuple[tuple[Pair, ...], ...]

    def at(self, length: Fraction) -> tuple[Pair, ...]:
        """The coefficients of tⁱ at one L, made integral by the power of its denominator."""
        top = len(self.coefficients[0]) - 1
        n, d = fmpz(length.numerator), fmpz(length.denominator)
        weights = [n**k * d ** (top - k) for k in range(top + 1)]

        def combine(row: tuple[Pair, ...], part: int) -> fmpz_poly:
            return sum((pair[part] * w for pair, w in zip(row, weights, strict=True)), fmpz_poly([0]))

        return tuple((combine(row, 0), combine(row, 1)) for row in self.coefficients)

    def norm1(self, omega_bound: int) -> int:
        """A bound on the sum of the absolute values of all coefficients in t, u and L."""
        return sum(
            abs(int(c)) * weight
            for row in self.coefficients
            for pair in row
            for part, weight in zip(pair, (1, omega_bound), strict=True)
            for c in part.coeffs()
        )


@dataclass(frozen=True)
class SliceMap:
    """The integer model of a manipulator with one leg fixed.

    ``scale`` × a length in the user's unit is the length used here; ``radicand`` is ω²,
    and 1 when the height of the platform is rational.
    """

    fixed_leg: int
    scale: Fraction
    radicand: int
    f: Leg
    g: Leg

    @classmethod
    def of(cls, manipulator: Manipulator, fixed_leg: int = 1) -> SliceMap:
        """Build the model.

        Raises:
            InputError: ``fixed_leg`` is not 1, 2 or 3.
        """
        if fixed_leg not in (1, 2, 3):
            raise InputError.of("fixed_leg", f"{fixed_leg!r} is not a leg; give 1, 2 or 3")
        lengths = [getattr(manipulator, name) for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")]
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
        f, g = (Leg(m - om, n - on, x - ox, y - oy) for (m, n), (x, y) in zip(platform, base, strict=True))
        return cls(fixed_leg, Fraction(unit * double, common), radicand, f, g)

    @property
    def rational(self) -> bool:
        """Whether ω is rational, and ℚ itself is the field of coefficients."""
        return self.radicand == 1

    @cached_property
    def singular(self) -> BiForm:
        """J / (4 L): degrees 4 in t and u, 1 in L (method.md section 3)."""
        return half_angles(self.trigonometric[0], (2, 2), self.radicand)

    @cached_property
    def coalescence(self) -> BiForm:
        """E, up to a factor: degrees 6 in t and u, 2 in L (method.md section 3)."""
        return half_angles(self.trigonometric[1], (3, 3), self.radicand)

    def scale_ball(self) -> arb:
        """``scale`` as a ball at the working precision."""
        return ball_of(self.scale)

    def collinear(self) -> fmpz_poly:
        """The quadratic whose roots u put leg i along the base line to leg f, where ∇f may vanish."""
        return fmpz_poly([self.f.ay, -2 * self.f.ax, -self.f.ay])

    def closed_leg(self, length: Fraction) -> fmpz_poly:
        """The quadratic in u of the poses in which leg f has length 0 (times the denominator²)."""
        n, d = length.numerator, length.denominator
        leg = self.f
        m2 = leg.m**2 + leg.n**2 * self.radicand
        even = n * n + d * d * (leg.ax**2 + leg.ay**2 - m2)
        return fmpz_poly([even - 2 * n * d * leg.ax, -4 * n * d * leg.ay, even + 2 * n * d * leg.ax])

    def primes(self) -> Iterator[tuple[int, int]]:
        """Primes p below 2⁶² in which ω exists, each with one value of ω modulo p."""
        for p in range(2**62 - 1, 2**61, -4):  # p ≡ 3 (mod 4)
            prime, radicand = fmpz(p), fmpz(self.radicand)
            if prime.is_prime() and radicand.jacobi(prime) == 1:
                yield p, 1 if self.rational else int((radicand % prime).sqrtmod(prime))

    @cached_property
    def trigonometric(self) -> tuple[fmpz_mpoly, fmpz_mpoly]:
        """J / (4 L) and E in cosines and sines of α and θ, L and ω (ring :data:`TRIG`)."""
        length = TRIG.gen(_L)
        f_alpha, f_theta = slopes(self.f)
        g_alpha, g_theta = slopes(self.g)
        j = f_alpha * g_theta - f_theta * g_alpha
        return j, f_alpha * d_theta(j) - length * f_theta * d_alpha(j)


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
    m, n = leg.m, leg.n * omega
    x, y = m * cos_a - n * sin_a, m * sin_a + n * cos_a
    x_alpha, y_alpha = -y, x
    along = length * (cos_t * x_alpha + sin_t * y_alpha) - (leg.ax * x_alpha + leg.ay * y_alpha)
    across = cos_t * (y - leg.ay) - sin_t * (x - leg.ax)
    return along, across


def d_alpha(p: fmpz_mpoly) -> fmpz_mpoly:
    """∂/∂α of a polynomial in cosines and sines."""
    return TRIG.gen(_COS_A) * p.derivative(_SIN_A) - TRIG.gen(_SIN_A) * p.derivative(_COS_A)


def d_theta(p: fmpz_mpoly) -> fmpz_mpoly:
    """∂/∂θ of a polynomial in cosines and sines."""
    return TRIG.gen(_COS_T) * p.derivative(_SIN_T) - TRIG.gen(_SIN_T) * p.derivative(_COS_T)


def half_angles(p: fmpz_mpoly, orders: tuple[int, int], radicand: int) -> BiForm:
    """The numerator of a trigonometric polynomial of the given degrees in α and in θ.

    Derivatives were taken before, on cosines and sines, so no term of the chain rule is lost
    (method.md section 7).
    """
    in_alpha, in_theta = (_half_angle_monomials(order) for order in orders)
    degree_l = p.degrees()[_L]
    table = [
        [[fmpz_poly([0]), fmpz_poly([0])] for _ in range(degree_l + 1)] for _ in range(2 * orders[0] + 1)
    ]
    for (i, j, k, m, power, omega), c in p.to_dict().items():
        in_u = in_theta[k, m] * (c * fmpz(radicand) ** (omega // 2))
        part = 0 if radicand == 1 else omega % 2
        for degree, weight in enumerate(in_alpha[i, j].coeffs()):
            if weight:
                table[degree][power][part] += in_u * weight
    rows = tuple(tuple((pair[0], pair[1]) for pair in row) for row in table)
    return BiForm(2 * orders[0], 2 * orders[1], rows)


def _half_angle_monomials(order: int) -> dict[tuple[int, int], fmpz_poly]:
    """The numerators of cosⁱ sinʲ over (1+x²)^order, x the tangent of half the angle."""
    cos, sin, one = fmpz_poly([1, 0, -1]), fmpz_poly([0, 2]), fmpz_poly([1, 0, 1])
    return {
        (i, j): cos**i * sin**j * one ** (order - i - j)
        for i in range(order + 1)
        for j in range(order + 1 - i)
    }
