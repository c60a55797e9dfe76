"""Between the coordinates of the forms and the article's frame: the only place that knows both.

Forms, number fields and residues have the coordinates of a slice map: y in √ρ, and angles from axes of their
own. Whatever is printed, drawn or asked for has the article's: α is the argument of z m₀/a₀, and θ that of
e/a₀, where z and e are the turns of the platform and of the fixed leg, a₀ and m₀ the vectors 12 of base and
platform (mathematics.md#the-norm-form). Where these are positive, as for six rational numbers, only √ρ is
between a half tangent and the tangent of half the angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

from flint import acb, arb, ctx

from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.quadratic import QuadraticNumber, omega_ball
from rpr_solver.model.jets import HalfTangent, direction
from rpr_solver.model.slice_map import ALONG, Axis, SliceMap, complex_ball, dot

_Two: TypeAlias = tuple[arb, arb]


@dataclass(frozen=True)
class Bridge:
    """Between half tangents of one slice map and the article's angles, at the working precision.

    Attributes:
        rho, radicand: ρ and ω².
        axes: the turns of the platform and of the fixed leg that are α = 0 and θ = 0, up to their lengths.
    """

    rho: int
    radicand: int
    axes: tuple[Axis, Axis]

    @classmethod
    def of(cls, slice_map: SliceMap) -> Bridge:
        """That of a slice map."""
        return cls(slice_map.rho, slice_map.radicand, slice_map.axes)

    @property
    def is_along(self) -> bool:
        """Whether the article's axes are those of the forms."""
        return self.axes == (ALONG, ALONG)

    def alpha(self, t: HalfTangent) -> HalfTangent:
        """tan(α/2) from a half tangent of the platform's turn."""
        return self._turned(self._measured(t), self.axes[0])

    def theta(self, u: HalfTangent) -> HalfTangent:
        """tan(θ/2) from a half tangent of the fixed leg's turn."""
        return self._turned(self._measured(u), self.axes[1])

    def angles_of(self, alpha: HalfTangent, theta: HalfTangent) -> tuple[HalfTangent, HalfTangent]:
        """Both from tangents of half the turns' angles, which are half tangents times √ρ."""
        return self._turned(alpha, self.axes[0]), self._turned(theta, self.axes[1])

    def from_alpha(self, t: HalfTangent) -> HalfTangent:
        """The half tangent of the platform's turn from tan(α/2)."""
        return self._own(t, self.axes[0])

    def from_theta(self, u: HalfTangent) -> HalfTangent:
        """The half tangent of the fixed leg's turn from tan(θ/2)."""
        return self._own(u, self.axes[1])

    def turns_of(self, alpha: HalfTangent, theta: HalfTangent) -> tuple[HalfTangent, HalfTangent]:
        """The inverse of :meth:`angles_of`."""
        return self._along_axis(alpha, self.axes[0]), self._along_axis(theta, self.axes[1])

    def _measured(self, t: HalfTangent) -> HalfTangent:
        if self.rho == 1:
            return t
        return HalfTangent(t.numerator * _root(self.rho, ctx.prec), t.denominator)

    def _turned(self, t: HalfTangent, axis: Axis) -> HalfTangent:
        if axis == ALONG:
            return t
        # tan((φ − ψ)/2) = (tan(φ/2) − tan(ψ/2)) / (1 + tan(φ/2) tan(ψ/2)), ψ being that of the axis
        n, d = t.numerator, t.denominator
        s, c = self._half(axis)
        return HalfTangent(n * c - d * s, d * c + n * s)

    def _own(self, t: HalfTangent, axis: Axis) -> HalfTangent:
        t = self._along_axis(t, axis)
        return t if self.rho == 1 else HalfTangent(t.numerator, t.denominator * _root(self.rho, ctx.prec))

    def _along_axis(self, t: HalfTangent, axis: Axis) -> HalfTangent:
        if axis == ALONG:
            return t
        n, d = t.numerator, t.denominator
        s, c = self._half(axis)
        return HalfTangent(n * c + d * s, d * c - n * s)

    def turns(self, bits: int) -> tuple[acb, acb]:
        """The axes, of length 1: exp(iα) times the first and exp(iθ) times the second are the turns."""
        with ctx.workprec(bits):
            first, second = (
                acb(1) if axis == ALONG else acb(*HalfTangent(*self._half(axis)).cos_sin())
                for axis in self.axes
            )
            return first, second

    def whole_tangent(self, theta: acb) -> arb:
        """The tangent of the fixed leg's turn over √ρ from exp(iθ)."""
        own = theta if self.is_along else theta * self.turns(ctx.prec)[1]
        tangent = own.imag / own.real
        return tangent if self.rho == 1 else tangent / _root(self.rho, ctx.prec)

    @property
    def offsets(self) -> tuple[float, float]:
        """The arguments of the axes in radians, by which the article's angles are less."""
        if self.is_along:
            return 0.0, 0.0
        alpha, theta = (float(z.arg()) for z in self.turns(64))
        return alpha, theta

    def vector(self, x: arb, y: arb) -> tuple[arb, arb]:
        """The coordinates in the article's frame of a vector of the plane, y in √ρ."""
        if self.rho > 1:
            y = y * _root(self.rho, ctx.prec)
        if self.axes[1] == ALONG:
            return x, y
        turned = acb(x, y) * self.turns(ctx.prec)[1].conjugate()
        return turned.real, turned.imag

    def coordinates(
        self, x: Algebraic, y: Algebraic, omega: Algebraic
    ) -> tuple[tuple[Algebraic, Fraction], tuple[Algebraic, Fraction]]:
        """The same in a number field, each as a number and the rational square of a factor to it."""
        axis = self.axes[1]
        if axis == ALONG:
            return (x, Fraction(1)), (y, Fraction(self.rho))
        p, q = self._along(x, y, omega, axis)
        norm = dot(axis, axis, self.rho).a
        return (p, Fraction(1, norm)), (q, Fraction(self.rho, norm))

    def alpha_degrees(self, cos: Algebraic, sin: Algebraic, omega: Algebraic, bits: int) -> arb:
        """α in degrees, in (−180, 180], exact at multiples of 90, of a turn in a number field."""
        return self._degrees(cos, sin, omega, self.axes[0], bits)

    def theta_degrees(self, cos: Algebraic, sin: Algebraic, omega: Algebraic, bits: int) -> arb:
        """θ likewise, of a direction of the fixed leg up to its length."""
        return self._degrees(cos, sin, omega, self.axes[1], bits)

    def _degrees(self, cos: Algebraic, sin: Algebraic, omega: Algebraic, axis: Axis, bits: int) -> arb:
        if axis != ALONG:
            cos, sin = self._along(cos, sin, omega, axis)
        return exact_direction(cos, sin, self.rho, bits)

    def _along(self, x: Algebraic, y: Algebraic, omega: Algebraic, axis: Axis) -> tuple[Algebraic, Algebraic]:
        """x + y j times the conjugate of the axis."""
        u, v = (z.times(omega.field(1), omega) for z in axis)
        return x * u + y * v * self.rho, y * u - x * v

    def _half(self, axis: Axis) -> _Two:
        return _half_axis(axis, self.rho, self.radicand, ctx.prec)

    def angles(self, fixed_leg: int) -> tuple[str, str]:
        """How documents write the angles of half tangents: with the arguments of axes, if they have any."""
        names = "alpha", f"theta{fixed_leg}"
        first, second = (
            name if axis == ALONG else f"({name} + arg({self._text(axis)}))"
            for name, axis in zip(names, self.axes, strict=True)
        )
        return first, second

    def tangents(self, fixed_leg: int) -> str:
        """The definitions of t and u in documents.

        >>> from rpr_solver.model.manipulator import EXAMPLES
        >>> Bridge.of(SliceMap.of(EXAMPLES["innocenti"])).tangents(1)
        't = tan(alpha/2), u = tan(theta1/2)'
        """
        over = "" if self.rho == 1 else f"/sqrt({self.rho})"
        first, second = self.angles(fixed_leg)
        return f"t = tan({first}/2){over}, u = tan({second}/2){over}"

    def _text(self, axis: Axis) -> str:
        x, y = (_number_text(z) for z in axis)
        return f"{x} + {y}*sqrt({-self.rho})"


def _number_text(z: QuadraticNumber[int]) -> str:
    return str(z.a) if not z.b else f"({z.a} + {z.b}*sqrt({z.radicand}))"


def exact_direction(x: Algebraic, y: Algebraic, rho: int, bits: int) -> arb:
    """The angle of (x, y), y in √ρ, in degrees, in (−180, 180], exact at multiples of 90."""
    if y.is_zero:
        return arb(0 if x.sign > 0 else 180)
    if x.is_zero:
        return arb(90 * y.sign)
    balls = x.ball(bits), y.ball(bits)
    with ctx.workprec(bits):
        return direction(balls[0], balls[1] * _root(rho, bits) if rho > 1 else balls[1])


@lru_cache(maxsize=256)
def _root(rho: int, bits: int) -> arb:
    with ctx.workprec(bits):
        return arb(rho).sqrt()


@lru_cache(maxsize=256)
def _half_axis(axis: Axis, rho: int, radicand: int, bits: int) -> _Two:
    """Sine and cosine of half the argument of an axis, up to their length."""
    with ctx.workprec(bits):
        z = complex_ball(axis, rho, omega_ball(radicand, bits))
        x, y, size = z.real, z.imag, abs(z)
        # tan(ψ/2) = sin ψ/(1 + cos ψ) = (1 − cos ψ)/sin ψ, whichever holds no cancellation
        return (y, size + x) if x > 0 else (size - x, y)
