"""The legs: f and g, their slopes, J and E, in any arithmetic, from the closure of the legs alone.

One leg is fixed at the length L and the angle θ, and the platform is turned by α. Vectors of the plane
are complex numbers, e = exp(iθ) and z = exp(iα). A free leg, seen from the fixed one, has a platform
point m and a base point a: it is the vector V = L e + m z − a. Half its squared length is

    f = (L² + |m|² + |a|²) / 2 + L (p − b) − r,

    p + i q = m z ē,        b + i d = ā e,        r + i w = m ā z.

The first of these *waves* turns with α − θ, the second with θ and the third with α. The derivative of a
wave by its angle is i times the wave, so that all derivatives of f are made of these six sinusoids:

    f_α = w − L q,        f_θ = L φ,    φ = q + d,        f_αα = r − L p,    φ_α = p,    φ_θ = b − p,

and so on. With g of the other free leg, J = f_α g_θ − f_θ g_α is the product ∇f × ∇g; and E = v·∇J,
v = (−f_θ, f_α), is ∇f × ∇J.

The arithmetic is that of the numbers which are put in (exact/plane.py): doubles, arrays of them, balls,
elements of a number field, polynomials, power series, or functions with bounds of their errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rpr_solver.exact.plane import PlaneNumber

Point = tuple[Any, Any]
"""The coordinates of a vector."""


def free_points(
    base: Sequence[Any], platform: Sequence[Any], fixed_leg: int, zero: Any = None
) -> tuple[tuple[PlaneNumber[Any], PlaneNumber[Any]], ...]:
    """m and a of both free legs, from six numbers of any ring in the frame of the article.

    A₁ is its origin, and at α = 0 so is B₁; A₂ and B₂ are on the axis of x.

    Args:
        base: a2x, a3x and a3y.
        platform: b2x, b3x and b3y, at α = 0.
        fixed_leg: 1, 2 or 3.
        zero: that of the ring, if its elements have no products with integers.
    """

    def seen(x2: Any, x3: Any, y3: Any) -> list[PlaneNumber[Any]]:
        """The corners of the free legs, less that of the fixed one."""
        nought = x2 * 0 if zero is None else zero
        corners = [(nought, nought), (x2, nought), (x3, y3)]
        u, v = corners.pop(fixed_leg - 1)
        return [PlaneNumber(x - u, y - v) for x, y in corners]

    return tuple(zip(seen(*platform), seen(*base), strict=True))


class Waves(NamedTuple):
    """The waves of a leg, in any arithmetic.

    Attributes:
        both: that of m, which turns with α − θ.
        base: that of ā, which turns with θ.
        platform: that of m ā, which turns with α.
    """

    both: Any
    base: Any
    platform: Any

    @classmethod
    def of(cls, m: Any, a: Any) -> Waves:
        """Those at α = θ = 0, from the platform and the base point."""
        back = a.conjugate()
        return cls(m, back, m * back)

    def turned(self, between: Any, theta: Any, alpha: Any) -> Sinusoids:
        """The sinusoids at a pose, from the waves at α = θ = 0 and :func:`turns`."""
        both, base, platform = self
        return Sinusoids.of(both * between, base * theta, platform * alpha)


def turns(alpha: Any, theta: Any) -> tuple[Any, Any, Any]:
    """z ē, e and z, by which the waves of all legs turn, from z and e; from z and L e, those with L."""
    return alpha * theta.conjugate(), theta, alpha


class Sinusoids(NamedTuple):
    """p, q, b, d, r and w of a leg at a pose.

    Their methods take L, or None if p, q, b and d have L as a factor already. Then φ is f_θ.
    """

    p: Any
    q: Any
    b: Any
    d: Any
    r: Any
    w: Any

    @classmethod
    def of(cls, both: Any, base: Any, platform: Any) -> Sinusoids:
        """The real and imaginary parts of the waves."""
        return cls(both.real, both.imag, base.real, base.imag, platform.real, platform.imag)

    def shrunk(self, inverse: Any) -> Sinusoids:
        """p, q, b, d, r / L and w / L: those of f / L, with a factor 1 in place of L."""
        return Sinusoids(self.p, self.q, self.b, self.d, self.r * inverse, self.w * inverse)

    def value(self, length: Any = None) -> Any:
        """f, less its constant (L² + |m|² + |a|²) / 2."""
        long = self.by_length
        return (long if length is None else long * length) - self.r

    def gradient(self, length: Any = None) -> Gradient:
        """f_α and φ."""
        return self.w - (self.q if length is None else self.q * length), self.q + self.d

    def slopes(self, length: Any = None) -> LegSlopes:
        """f_α and φ, and the derivatives of both."""
        p, q, b, d, r, w = self
        long_p, long_q = (p, q) if length is None else (p * length, q * length)
        return (w - long_q, q + d), (r - long_p, p), (long_p, b - p)

    @property
    def by_length(self) -> Any:
        """f_L − L."""
        return self.p - self.b

    @property
    def slopes_by_length(self) -> Gradient:
        """Those of which the cross product is the derivative of J / L by L: f_αL, and φ itself."""
        return -self.q, self.q + self.d

    def derivatives(self) -> Derivatives:
        """∂α^i ∂θ^j of f.

        It is the real part of iⁱ⁻ʲ times the first wave, for i = 0 less iʲ times the second one, and for
        j = 0 less iⁱ times the third one.
        """
        p, q, b, d, r, w = self

        def derivative(i: int, j: int) -> Any:
            parts = [_part(p, q, i - j)]
            if i == 0:
                parts.append(_part(b, d, j))
            if j == 0:
                parts.append(_part(r, w, i))
            return _difference(*parts)

        return derivative

    def slope_derivatives(self, length: Any) -> tuple[Derivatives, Derivatives]:
        """∂α^i ∂θ^j of f_α and of φ, in the same way."""
        p, q, b, d, r, w = self
        long_p, long_q = p * length, q * length

        def alpha(i: int, j: int) -> Any:
            own = _part(long_p, long_q, i + 1 - j)
            return _difference(own, _part(r, w, i + 1)) if j == 0 else _difference(own)

        def phi(i: int, j: int) -> Any:
            own = _part(p, q, i - j - 1)
            return _difference(own, _part(b, d, j + 1)) if i == 0 else _difference(own)

        return alpha, phi


_Signed = tuple[Any, bool]
"""An element and whether it is to be negated."""


def _part(x: Any, y: Any, power: int) -> _Signed:
    """The real part of x + i y times a power of i."""
    return (y if power % 2 else x), power % 4 in (1, 2)


def _difference(first: _Signed, *others: _Signed) -> Any:
    """The first one less the others."""
    value, negative = first
    for other, less in others:
        if negative == less:
            value, negative = (other - value if negative else value - other), False
        else:
            value = value + other
    return -value if negative else value


Derivatives = Callable[[int, int], Any]
"""The derivatives of a function, of order i by α and j by θ."""
Gradient = tuple[Any, Any]
"""The derivatives of a function by α and θ."""


def cross(f: Gradient, g: Gradient) -> Any:
    """∇f × ∇g: J, if these are of the free legs; E, if they are of a leg and of J."""
    a, b = f
    c, d = g
    return a * d - b * c


def cross_slope(f: Gradient, f_slope: Gradient, g: Gradient, g_slope: Gradient) -> Any:
    """The derivative of :func:`cross`, from the derivatives of both gradients."""
    a, b = f
    a_slope, b_slope = f_slope
    c, d = g
    c_slope, d_slope = g_slope
    return a_slope * d + a * d_slope - b_slope * c - b * c_slope


LegSlopes = tuple[Gradient, Gradient, Gradient]
"""f_α and φ, or f_θ in its place, and the derivatives of both by α and by θ."""


def gradient_by_vector(vector: Point, turned: Point, tip: Point) -> Gradient:
    """f_α and f_θ, or φ, by the coordinates of V, of m z, and of L e, or e: V·(i m z) and V·(i L e).

    They are the same as by waves, but for their roundings, and on intervals their bounds.
    """
    (x, y), (u, v), (s, t) = vector, turned, tip
    return y * u - x * v, y * s - x * t


def slopes_by_vector(vector: Point, turned: Point, tip: Point, square: Any) -> LegSlopes:
    """As :func:`gradient_by_vector`, with the derivatives of both; ``square`` is L²."""
    (x, y), (u, v), (s, t) = vector, turned, tip
    mixed = u * s + v * t
    gradient = gradient_by_vector(vector, turned, tip)
    return gradient, (u * u + v * v - x * u - y * v, mixed), (mixed, square - x * s - y * t)


def gradient_in_doubles(vector: Any, turned: Any, tip: Any) -> Gradient:
    """As :func:`gradient_by_vector`, for arrays of complex doubles."""
    alpha, theta = ((vector.conjugate() * 1j * part).real for part in (turned, tip))
    return alpha, theta


def singularity(f: LegSlopes, g: LegSlopes) -> tuple[Any, Any, Any]:
    """J, or J / L, and its derivatives by α and θ."""
    f_slopes, f_alpha, f_theta = f
    g_slopes, g_alpha, g_theta = g
    return (
        cross(f_slopes, g_slopes),
        cross_slope(f_slopes, f_alpha, g_slopes, g_alpha),
        cross_slope(f_slopes, f_theta, g_slopes, g_theta),
    )


def singularity_and_coalescence(first: Sinusoids, second: Sinusoids) -> tuple[Any, Any]:
    """J and E, from the sinusoids of both legs with L."""
    f, g = first.slopes(), second.slopes()
    j, j_alpha, j_theta = singularity(f, g)
    return j, cross(f[0], (j_alpha, j_theta))


class PoseDerivatives(NamedTuple):
    """J and E with their gradients, at a pose."""

    j: Any
    j_alpha: Any
    j_theta: Any
    e: Any
    e_alpha: Any
    e_theta: Any

    @classmethod
    def of(cls, first: Sinusoids, second: Sinusoids) -> PoseDerivatives:
        """From the sinusoids of both legs with L, by the product rule.

        f_ααα = −f_α, f_αθθ = −f_ααθ and f_θθθ = −f_θ, as f is a sum of three sinusoids.
        """
        f, g = first.slopes(), second.slopes()
        f_slopes, f_by_alpha, f_by_theta = f
        _, g_by_alpha, g_by_theta = g
        (fa, ft), (faa, _), (_, ftt) = f
        (ga, gt), (gaa, _), (_, gtt) = g
        faat, gaat = -first.q, -second.q
        j, ja, jt = singularity(f, g)
        slopes, twice, both = (ja, jt), cross(f_by_alpha, g_by_alpha), cross(f_by_theta, g_by_theta)
        jaa = twice + twice + fa * gaat - faat * ga - j
        jat = faat * gt + faa * gtt - fa * gaat + faat * ga - ftt * gaa - ft * gaat
        jtt = both + both - faat * gt + ft * gaat - j
        ea = cross_slope(f_slopes, f_by_alpha, slopes, (jaa, jat))
        et = cross_slope(f_slopes, f_by_theta, slopes, (jat, jtt))
        return cls(j, ja, jt, cross(f_slopes, slopes), ea, et)


def slopes_on_line(m: Point, a: Point, direction: Point, length: float) -> tuple[float, ...]:
    """f_α and φ on a line θ = const: x₁ cos α + x₂ sin α and d + y₁ cos α + y₂ sin α.

    f_α = Im(z m (ā − L ē)), φ = Im(z m ē) + Im(ā e).

    Args:
        m: the platform point.
        a: the base point.
        direction: cosine and sine of θ.
        length: L.

    Returns:
        x₁, x₂, d, y₁ and y₂.
    """
    (mx, my), (ax, ay), (c, s) = m, a, direction
    p, q = ax - length * c, length * s - ay
    return my * p + mx * q, mx * p - my * q, s * ax - c * ay, c * my - s * mx, c * mx + s * my


SINGULAR_WAVES = ((0, 1), (2, -1), (1, -1), (1, 1), (1, -2), (1, 0))
"""By how much α and θ turn each of the six waves of J / L; the last two have the factor L."""


def singular_waves(first: Waves, second: Waves, length: Any) -> list[Any]:
    """The waves of J / L at α = θ = 0, from those of both legs there; J / L is half the sum of real parts.

    A product of sinusoids is Im x Im y = Re(x ȳ − x y) / 2; those of two that turn with α − θ cancel.
    """
    (m, a, u), (n, b, v) = first, second
    m_back, a_back, n_back, b_back = (x.conjugate() for x in (m, a, n, b))
    return [
        u * n_back - m_back * v,
        m * v - u * n,
        u * b_back - a_back * v,
        a * v - u * b,
        (a_back * n - m * b_back) * length,
        (m * b - a * n) * length,
    ]
