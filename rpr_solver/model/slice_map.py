"""A manipulator seen from one fixed leg: the map (α, θ) → (f, g) and its curves J = 0, E = 0.

With leg i fixed at length L and its direction e(θ), the pose is X = L e(θ), platform angle α
(the direction of B1B2), and each other leg has the squared length

    f = |X + R(α) m − a|²,     m = its platform point, a = its base point, both seen from leg i.

A pose is singular where J = f_α g_θ − f_θ g_α vanishes (the article's eq. 6), and three poses
coalesce where E = v·∇J vanishes too, with v = (−f_θ, f_α) tangent to f = const (on J = 0 equivalent to the
article's eq. 10; mathematics.md#poses-that-coalesce).

Base and platform are in one plane over a quadratic field (triangles/frames.py): everything is scaled to
integers, lengths being multiplied by ``scale``, and y is measured in √ρ, so that all coordinates and
coefficients lie in ℤ[ω], ω = √``radicand``. Six rational numbers have ρ = 1, and a rational multiple of ω is
the height of the platform. The squared length of (x, y) is x² + ρ y²; turns are (c, s) with c² + ρ s² = 1
and half tangents 1 − ρt² : 2t : 1 + ρt² (mathematics.md#the-norm-form). Slopes, J and E are taken without
their factors √ρ and ρ.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from math import gcd, isfinite, lcm, sqrt
from typing import Any, TypeAlias

from flint import acb, arb, ctx, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver.contract import check_leg, check_type
from rpr_solver.exact.biform import OMEGA, RING, BiForm, L, T, Table, U
from rpr_solver.exact.numerals import double
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.quadratic import QuadraticNumber, QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Waves
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.packed import PackedForm, PackedSlice, packed_forms
from rpr_solver.triangles import Corner

TRIG = fmpz_mpoly_ctx.get(("cos_alpha", "sin_alpha", "cos_theta", "sin_theta", "L", "omega"), "lex")
_COS_A, _SIN_A, _COS_T, _SIN_T, _L, _ = range(6)
_DOUBLE_BITS = 192
"""Working precision for doubles: coordinates lose few of these bits."""
_HOMOGENEOUS = fmpz_mpoly_ctx.get(("C", "S", "N", "c", "s", "n", "L", "omega"), "lex")

Point: TypeAlias = tuple[QuadraticNumber[int], QuadraticNumber[int]]
"""x and y of a point, y in √ρ."""
Axis: TypeAlias = Point
"""A direction, as a point without common factors."""
ALONG: Axis = QuadraticNumber(1, 0, 1), QuadraticNumber(0, 0, 1)
"""That of the x-axis."""


@dataclass(frozen=True)
class Leg:
    """A free leg seen from the fixed one.

    Attributes:
        platform, base: m and a, the platform point and the base point.
        rho, radicand: ρ and ω².
        axes: the directions of B1B2 and of A1A2, which the article has on the x-axis.
    """

    platform: Point
    base: Point
    rho: int
    radicand: int
    axes: tuple[Axis, Axis] = (ALONG, ALONG)

    @cached_property
    def platform2(self) -> int:
        """|m|²: the squared side of the platform between this leg and the fixed one."""
        return dot(self.platform, self.platform, self.rho).a

    @cached_property
    def base2(self) -> int:
        """|a|²: the squared side of the base."""
        return dot(self.base, self.base, self.rho).a

    @property
    def m(self) -> int:
        """The x coordinate of the platform point, if this is an integer."""
        return self.platform[0].a

    @property
    def n(self) -> int:
        """The y coordinate of the platform point over ω, if this is an integer."""
        y = self.platform[1]
        return y.a if self.radicand == 1 else y.b

    @property
    def ax(self) -> int:
        """The x coordinate of the base point, if this is an integer."""
        return self.base[0].a

    @property
    def ay(self) -> int:
        """The y coordinate of the base point, if this is an integer."""
        return self.base[1].a

    @property
    def size(self) -> int:
        """A length like those of its points: the sum of three coordinates, those of the base point first."""
        return sum(_whole(z) for z in (*self.base, self.platform[0]))

    def points(self, omega: Any) -> tuple[Any, Any]:
        """m and a in the arithmetic of ω: in the article's frame by balls, else as in forms."""
        if isinstance(omega, arb):
            m, a = self.own_points(omega)
            platform, base = self.axes
            return self._from_axis(m, platform, omega), self._from_axis(a, base, omega)
        one = omega * 0 + 1
        first, second = (
            PlaneNumber(x.times(one, omega), y.times(one, omega), self.rho)
            for x, y in (self.platform, self.base)
        )
        return first, second

    def own_points(self, omega: arb) -> tuple[acb, acb]:
        """m and a by balls, in the directions of the forms."""
        return complex_ball(self.platform, self.rho, omega), complex_ball(self.base, self.rho, omega)

    def _from_axis(self, z: acb, axis: Axis, omega: arb) -> acb:
        if axis == ALONG:
            return z
        turn = complex_ball(axis, self.rho, omega)
        return z * turn.conjugate() / abs(turn)

    def doubles(self, unit: Fraction) -> tuple[complex, complex]:
        """m and a in the article's frame over a length, right to two units of the last place.

        Raises:
            OverflowError: a coordinate is beyond the range of doubles.
        """
        if self.rho == 1 and self.axes == (ALONG, ALONG):
            # three rational coordinates, and the square of the fourth
            height = sqrt(Fraction(self.n**2 * self.radicand) / unit**2)
            platform = complex(double(self.m / unit), height if self.n >= 0 else -height)
            return platform, complex(double(self.ax / unit), double(self.ay / unit))
        with ctx.workprec(_DOUBLE_BITS):
            over = ball_of(unit)
            points = [z / over for z in self.points(omega_ball(self.radicand, _DOUBLE_BITS))]
            numbers = [complex(float(z.real), float(z.imag)) for z in points]
        if not all(isfinite(z.real) and isfinite(z.imag) for z in numbers):
            raise OverflowError("a coordinate is beyond the range of doubles")
        platform, base = numbers
        return platform, base

    def waves(self, omega: Any) -> Waves:
        """The waves at α = θ = 0 in the arithmetic of ω."""
        return Waves.of(*self.points(omega))

    def rotated(self, cos: Any, sin: Any, omega: Any) -> tuple[Any, Any]:
        """R(α) m, the platform point turned by α, in any ring."""
        m, n = self.platform
        drop = n.times(sin, omega)
        x = m.times(cos, omega) - (drop if self.rho == 1 else drop * self.rho)
        return x, m.times(sin, omega) + n.times(cos, omega)

    def base_times(self, one: Any, omega: Any) -> tuple[Any, Any]:
        """The coordinates of the base point times an element of any ring."""
        return self.base[0].times(one, omega), self.base[1].times(one, omega)

    @cached_property
    def collinear(self) -> QuadraticPoly:
        """The quadratic in u of the poses with the fixed leg along the base line to this leg."""
        x, y = self.base
        return polynomial([y, x * -2, y * -self.rho])

    def closed(self, length: Fraction) -> QuadraticPoly:
        """The quadratic in u of the poses with this leg of length 0, times the squared denominator of L."""
        n, d = length.numerator, length.denominator
        x, y = (z * (2 * n * d) for z in self.base)
        even = QuadraticNumber(n * n + d * d * (self.base2 - self.platform2), 0, self.radicand)
        return polynomial([even - x, y * (-2 * self.rho), (even + x) * self.rho])


def _whole(z: QuadraticNumber[int]) -> int:
    """|z|, upwards to an integer."""
    if not z.b:
        return abs(z.a)
    with ctx.workprec(_DOUBLE_BITS):
        size = abs(z.times(arb(1), omega_ball(z.radicand, _DOUBLE_BITS)))
        return int(size.abs_upper().ceil().unique_fmpz() or 1)


def complex_ball(point: Point, rho: int, omega: arb) -> acb:
    """A point as a complex number at the working precision."""
    x, y = (z.times(arb(1), omega) for z in point)
    return acb(x, y if rho == 1 else y * arb(rho).sqrt())


def dot(p: Point, q: Point, rho: int) -> QuadraticNumber[int]:
    """The scalar product of two vectors."""
    return p[0] * q[0] + p[1] * q[1] * rho


def cross(p: Point, q: Point) -> QuadraticNumber[int]:
    """The cross product of two vectors, in √ρ."""
    return p[0] * q[1] - p[1] * q[0]


def polynomial(coefficients: list[QuadraticNumber[int]]) -> QuadraticPoly:
    """The polynomial with these coefficients, those of low powers first."""
    a, b = (fmpz_poly([z.a for z in coefficients]), fmpz_poly([z.b for z in coefficients]))
    return QuadraticPoly(a, b, coefficients[0].radicand)


@dataclass(frozen=True)
class SliceMap:
    """The integer model of a manipulator with one leg fixed.

    ``scale`` times a length in the user's unit is the *scaled* length used here. ``rho`` and ``radicand`` are
    ρ and ω²; both are 1 if the six lengths and the height of the platform are rational. ``axes`` are the
    turns of the platform and of the fixed leg at which the article's α and θ are 0 (bridge.py).
    """

    fixed_leg: int
    scale: Fraction
    rho: int
    radicand: int
    f: Leg
    g: Leg
    axes: tuple[Axis, Axis] = (ALONG, ALONG)

    @classmethod
    def of(cls, manipulator: Manipulator, fixed_leg: int = 1, *, with_shared: bool = False) -> SliceMap:
        """Builds the model.

        Args:
            manipulator: the geometry.
            fixed_leg: the leg whose length is fixed.
            with_shared: whether legs may share joints, so that a, m or a − b or m − n of both free legs may
                be 0.

        Raises:
            InputError: ``manipulator`` is not a manipulator, or has no coordinates over one quadratic field,
                or its legs share joints; ``fixed_leg`` is not 1, 2 or 3.
        """
        check_type(manipulator, Manipulator, "manipulator")
        if not with_shared:
            manipulator.geometry.apart_from_shared()
        return cls._of(manipulator, check_leg(fixed_leg))

    @classmethod
    @lru_cache(maxsize=64)
    def _of(cls, manipulator: Manipulator, fixed_leg: int) -> SliceMap:
        frame = manipulator.frame
        rational = [_rational_parts(corner) for corner in (*frame.base, *frame.platform)]
        unit = lcm(*(x.denominator for parts in rational for x in parts))
        parts = [[x.numerator * (unit // x.denominator) for x in parts] for parts in rational]
        common = gcd(*(x for row in parts for x in row))
        radicand, rho = frame.radicand, frame.rho
        corners = [
            (
                QuadraticNumber(a // common, b // common, radicand),
                QuadraticNumber(c // common, d // common, radicand),
            )
            for a, b, c, d in parts
        ]
        (ox, oy), (om, on) = corners[fixed_leg - 1], corners[fixed_leg + 2]
        own, other = frame.axes
        axes = _axis(other), _axis(own)
        f, g = (
            Leg(
                (corners[k + 2][0] - om, corners[k + 2][1] - on),
                (corners[k - 1][0] - ox, corners[k - 1][1] - oy),
                rho,
                radicand,
                axes,
            )
            for k in (1, 2, 3)
            if k != fixed_leg
        )
        alpha = axes[1] if axes[0] == ALONG else _axis(own * other.conjugate)
        return cls(fixed_leg, Fraction(unit, common), rho, radicand, f, g, (alpha, axes[1]))

    @cached_property
    def unit(self) -> int:
        """A length in terms of which the base is integral, and so are the squared sides of the platform,
        twice their products and four times its area (mathematics.md#the-content-of-the-eliminant)."""
        f, g = self.f, self.g
        products = dot(f.platform, g.platform, self.rho) * 2, cross(f.platform, g.platform) * 2
        squares = gcd(f.platform2, g.platform2, *(x for z in products for x in (z.a, z.b)))
        unit = gcd(*(x for z in (*f.base, *g.base) for x in (z.a, z.b)))
        while squares % unit**2:
            unit = gcd(unit, squares // gcd(squares, unit))
        return unit

    @cached_property
    def side2(self) -> int:
        """|a − b|²: the squared side of the base between the free legs."""
        (x, y), (u, v) = self.f.base, self.g.base
        side = x - u, y - v
        return dot(side, side, self.rho).a

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
        first, second = self._packed
        return first.table(4), second.table(6)

    def sliced(self, length: Fraction) -> tuple[PackedSlice, PackedSlice]:
        """J and E at one L, primitive."""
        first, second = self._packed
        return first.sliced(length, 4), second.sliced(length, 6)

    @cached_property
    def _packed(self) -> tuple[PackedForm, PackedForm]:
        f, g = ((leg.platform, leg.base) for leg in (self.f, self.g))
        return packed_forms(f, g, self.rho)

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
        return j, f_alpha * d_theta(j, self.rho) - length * f_theta * d_alpha(j, self.rho)


def _axis(direction: Corner) -> Axis:
    """A direction without common factors."""
    x, y = direction.x, direction.y
    if not (y.a or y.b or x.b) and x.a > 0:
        return ALONG
    parts = _rational_parts(direction)
    unit = lcm(*(part.denominator for part in parts))
    whole = [int(part * unit) for part in parts]
    common = gcd(*whole)
    a, b, c, d = (part // common for part in whole)
    return QuadraticNumber(a, b, x.radicand), QuadraticNumber(c, d, x.radicand)


def _rational_parts(corner: Corner) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    return corner.x.a, corner.x.b, corner.y.a, corner.y.b


def slopes(leg: Leg) -> tuple[fmpz_mpoly, fmpz_mpoly]:
    """f_α / 2 and f_θ / (2 L) of one leg, over √ρ."""
    cos_a, sin_a, cos_t, sin_t, length, omega = TRIG.gens()
    x, y = leg.rotated(cos_a, sin_a, omega)
    ax, ay = leg.base_times(TRIG.constant(1), omega)
    along = (length * sin_t - ay) * x - (length * cos_t - ax) * y
    across = cos_t * (y - ay) - sin_t * (x - ax)
    return along, across


def excess(leg: Leg, square: Fraction) -> tuple[fmpz_mpoly, fmpz_mpoly, fmpz_mpoly]:
    """The coefficients of L⁰, L¹ and L² of f − ``square``, times its denominator."""
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    x, y = leg.rotated(cos_a, sin_a, omega)
    ax, ay = leg.base_times(TRIG.constant(1), omega)
    n, d = square.numerator, square.denominator
    both = cos_t * (x - ax) + leg.rho * sin_t * (y - ay)
    constant = d * (leg.platform2 + leg.base2) - n - 2 * d * (ax * x + leg.rho * ay * y)
    return constant, 2 * d * both, TRIG.constant(d)


def d_alpha(p: fmpz_mpoly, rho: int) -> fmpz_mpoly:
    """√ρ ∂/∂α of a polynomial in turns."""
    return TRIG.gen(_COS_A) * p.derivative(_SIN_A) - rho * TRIG.gen(_SIN_A) * p.derivative(_COS_A)


def d_theta(p: fmpz_mpoly, rho: int) -> fmpz_mpoly:
    """√ρ ∂/∂θ of a polynomial in turns."""
    return TRIG.gen(_COS_T) * p.derivative(_SIN_T) - rho * TRIG.gen(_SIN_T) * p.derivative(_COS_T)


def reduced(p: fmpz_mpoly, rho: int, radicand: int) -> fmpz_mpoly:
    """The normal form modulo c² + ρ s² = 1 and ω² = radicand, whose degree is the true one."""
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    turns = (cos**2 + rho * sin**2 - 1 for cos, sin in ((cos_a, sin_a), (cos_t, sin_t)))
    for turn in turns:
        p %= turn
    return p % (omega**2 - radicand)


def half_angles(p: fmpz_mpoly, orders: tuple[int, int], rho: int, radicand: int) -> BiForm:
    """The numerator of a polynomial in turns, of the given degrees in α and in θ.

    It is made homogeneous, since c : s : 1 = 1 − ρt² : 2t : 1 + ρt². Derivatives must be taken before, of c
    and s: those by α and by t differ by the factor dt/dα.
    """
    a, b = orders
    terms = {(i, j, a - i - j, k, m, b - k - m, *rest): c for (i, j, k, m, *rest), c in p.to_dict().items()}
    half = (*_half_turn(T, rho), *_half_turn(U, rho), L, OMEGA)
    numerator = _HOMOGENEOUS.from_dict(terms).compose(*half, ctx=RING)
    return BiForm.of(numerator, radicand, 2 * a, 2 * b)


def _half_turn(x: fmpz_mpoly, rho: int) -> tuple[fmpz_mpoly, fmpz_mpoly, fmpz_mpoly]:
    return 1 - rho * x**2, 2 * x, 1 + rho * x**2


def in_tangents(p: fmpz_mpoly, orders: tuple[int, int], rho: int, radicand: int) -> BiForm:
    """The numerator in t and v = tan θ/√ρ, which takes the place of u, of a reduced polynomial in turns.

    With the degree b in θ it must change by the factor (−1)ᵇ under θ ↦ θ + π. It is divided by cosᵇ θ.
    """
    a, b = orders
    terms = {}
    for (i, j, k, m, *rest), c in p.to_dict().items():
        half, odd = divmod(b - k - m, 2)
        if odd:
            raise ValueError("half a turn does more than change the sign")
        terms[i, j, a - i - j, k, m, half, *rest] = c
    tangents = (*_half_turn(T, rho), T**0, U, 1 + rho * U**2, L, OMEGA)
    return BiForm.of(_HOMOGENEOUS.from_dict(terms).compose(*tangents, ctx=RING), radicand, 2 * a, b)
