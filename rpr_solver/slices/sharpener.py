"""From balls that hold one cusp each to printed digits: interval Newton steps on u, then on t.

u is sharpened as a root of Q, then t as the root of J above it (mathematics.md#real-roots). Each step about
doubles the bits of the last.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, arb_poly, ctx

from rpr_solver.exact.decimals import digit_bits
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.joint_points import ClassifiedPoint, JointPoint
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.decimals import HalfAngle, PointDecimals

_BEYOND = 26
"""Bits of a half tangent beyond those of the digits: enough for nearly all decimals."""
_LEAST_TARGET = 32
"""The fewest bits that a step is to find."""
_GAIN = 1.5
"""How many times the bits of a ball those are that a step finds in all but few cases."""
_ABOVE_TARGET = 64
"""Precision of a Newton step beyond the bits that it is to find."""
_ABOVE_DIGITS = 64
_MOST_BITS = 1 << 18
"""Those of an exact number, which is sharpened once."""
_NEAR = 8
"""Half tangents beyond are found as their inverse."""
_DEGREE_OF_J = 4


class PoseSharpener:
    """From balls of poses to printed cusps: for all slices of one leg, and one number of digits.

    Half tangents have the unit 1 here, in place of 1/√ρ.

    Attributes:
        bits: the precision of the polynomials that are sharpened with.
    """

    def __init__(self, slice_map: SliceMap, digits: int) -> None:
        targets = [digit_bits(digits) + _BEYOND]
        while targets[-1] > _LEAST_TARGET:
            targets.append(targets[-1] // 2 + 3)
        self._targets = targets[::-1]
        self.bits, self._bits_of_decimals = targets[0] + _ABOVE_TARGET, digit_bits(digits) + _ABOVE_DIGITS
        self._decimals = PointDecimals(slice_map, digits, self._bits_of_decimals)
        with ctx.workprec(self.bits):
            self._goal = arb(2) ** -targets[0]
        self._bridge = Bridge.of(slice_map)

    def thetas(self, q: Sequence[arb], starts: Sequence[HalfAngle]) -> list[HalfAngle] | None:
        """The roots of Q in some balls, by its coefficients of u⁰, u¹, …; None if that fails."""
        straight = _with_slope(q)
        reverse = _with_slope(q[::-1]) if any(x.inverse for x in starts) else straight
        return self._sharpened(starts, [reverse if x.inverse else straight for x in starts])

    def alphas(
        self, j: Sequence[arb_poly], thetas: Sequence[HalfAngle], starts: Sequence[HalfAngle]
    ) -> list[HalfAngle] | None:
        """The roots of J in some balls above those of Q, by its coefficients of t⁰, t¹, …"""
        reverse = [_reversed(row) for row in j] if any(x.inverse for x in thetas) else j
        above = []
        for theta, start in zip(thetas, starts, strict=True):
            # FLINT's values of polynomials are tighter than sums of powers
            row = [part(theta.x) for part in (reverse if theta.inverse else j)]
            above.append(_with_slope(row[::-1] if start.inverse else row))
        return self._sharpened(starts, above)

    def points(
        self, length: arb, alphas: Sequence[HalfAngle], thetas: Sequence[HalfAngle]
    ) -> list[JointPoint] | None:
        """The cusps at these angles, ascending by θ, in decimals; None if one is not decided."""
        cusps = []
        with ctx.workprec(self._bits_of_decimals):
            for alpha, theta in zip(alphas, thetas, strict=True):
                cusp = self._cusp(length, alpha, theta)
                if cusp is None:
                    return None
                cusps.append(cusp)
        if not self._bridge.is_along:
            cusps.sort(key=lambda cusp: cusp.theta.mid())
        return [cusp.point for cusp in cusps]

    def _cusp(self, length: arb, alpha: HalfAngle, theta: HalfAngle) -> ClassifiedPoint | None:
        """The cusp at these angles of the forms."""
        if self._bridge.is_along:
            return self._decimals.cusp(length, alpha, theta)
        angles = self._bridge.angles_of(alpha.tangent, theta.tangent)
        first, second = (HalfAngle.of(x, self._bits_of_decimals - _ABOVE_DIGITS) for x in angles)
        return first and second and self._decimals.cusp(length, first, second)

    def _sharpened(
        self, starts: Sequence[HalfAngle], polynomials: Sequence[tuple[arb_poly, arb_poly]]
    ) -> list[HalfAngle] | None:
        """Small balls of the roots in some balls, of polynomials with their slopes; None if that fails."""
        roots = [start.x for start in starts]
        have = _GAIN * min(map(_bits, roots))
        last = self._targets[-1]
        with ctx.workprec(self.bits):
            for target in (*(x for x in self._targets if x > have), last):
                if target == last and all(x.rad() < self._goal for x in roots):
                    break
                ctx.prec = (target + _ABOVE_TARGET) // 2 + _ABOVE_TARGET
                slopes = [slope(x) for x, (_, slope) in zip(roots, polynomials, strict=True)]
                ctx.prec = target + _ABOVE_TARGET
                middles = [x.mid() for x in roots]
                roots = [
                    middle - polynomial(middle) / slope
                    for middle, slope, (polynomial, _) in zip(middles, slopes, polynomials, strict=True)
                ]
            ctx.prec = self.bits
            if not all(x.rad() < self._goal for x in roots):
                return None
        return [HalfAngle(x, start.inverse) for x, start in zip(roots, starts, strict=True)]


def _bits(x: arb) -> int:
    """Those of a ball around a number of usual size."""
    mantissa, exponent = x.rad().man_exp()
    return -int(exponent) - mantissa.bit_length() if mantissa else _MOST_BITS


def near_start(x: arb, *, inverse: bool = False) -> HalfAngle:
    """The half angle of tan(θ/2), or of its inverse, from which a root is sharpened."""
    if inverse:
        return HalfAngle(x, inverse=True) if _NEAR * abs(x) < 1 else HalfAngle(1 / x)
    return HalfAngle(1 / x, inverse=True) if abs(x) > _NEAR else HalfAngle(x)


def _with_slope(coefficients: Sequence[arb]) -> tuple[arb_poly, arb_poly]:
    polynomial = arb_poly(list(coefficients))
    return polynomial, polynomial.derivative()


def _reversed(polynomial: arb_poly) -> arb_poly:
    """A coefficient of J in 1/u."""
    return arb_poly([polynomial[_DEGREE_OF_J - k] for k in range(_DEGREE_OF_J + 1)])
