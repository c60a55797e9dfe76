"""Points of a slice in decimals, from the tangents of half their angles in balls."""

from __future__ import annotations

from typing import NamedTuple

from flint import acb, arb, ctx

from rpr_solver.exact.decimals import round_all
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.joint_points import ClassifiedPoint, PoseKind, joint_point
from rpr_solver.model.slice_map import SliceMap

_ONE, _MIDDLE = arb(1), arb(1.5)


class HalfAngle(NamedTuple):
    """tan(angle/2), or its inverse: whichever is small."""

    x: arb
    inverse: bool = False

    @classmethod
    def of(cls, t: HalfTangent, bits: int) -> HalfAngle | None:
        """From tan(angle/2); None if its radius is not below 2^−bits."""
        straight = t.numerator / t.denominator
        is_small = abs(straight) < _MIDDLE
        x = straight if is_small else t.denominator / t.numerator
        return cls(x, not is_small) if x.rad() < arb(2) ** -bits else None

    @property
    def tangent(self) -> HalfTangent:
        """tan(angle/2)."""
        return HalfTangent(_ONE, self.x) if self.inverse else HalfTangent(self.x, _ONE)

    @property
    def turn(self) -> acb:
        """exp(i angle)."""
        x = self.x
        part = _ONE / (x * x + 1)
        cos = part + part - 1
        return acb(-cos if self.inverse else cos, (x + x) * part)

    def degrees(self, half_turns: arb) -> arb | None:
        """The angle in degrees, given 360/π; None if it may be 180 and −180."""
        angle = self.x.atan() * half_turns
        if not self.inverse:
            return angle
        if angle > 0:
            return 180 - angle
        return -180 - angle if angle < 0 else None


class PointDecimals:
    """From half angles to points of slices in decimals.

    Args:
        slice_map: of the manipulator and its fixed leg.
        digits: significant digits of every number.
        bits: the working precision, which must be that of the calls, too.
    """

    def __init__(self, slice_map: SliceMap, digits: int, bits: int) -> None:
        self._leg, self._digits = slice_map.fixed_leg, digits
        with ctx.workprec(bits):
            omega, self._half_turns = omega_ball(slice_map.radicand, bits), 360 / arb.pi()
            self._unit = 1 / slice_map.scale_ball()
            self._legs = [leg.points(omega) for leg in (slice_map.f, slice_map.g)]

    def cusp(self, length: arb, alpha: HalfAngle, theta: HalfAngle) -> ClassifiedPoint | None:
        """The cusp at a *scaled* L and these angles; None if the balls do not decide its decimals."""
        alpha_deg, theta_deg = alpha.degrees(self._half_turns), theta.degrees(self._half_turns)
        if alpha_deg is None or theta_deg is None:
            return None
        turn, tip = alpha.turn, theta.turn * length
        lengths = [abs(tip + turn * platform - base) * self._unit for platform, base in self._legs]
        texts = round_all((alpha_deg, theta_deg, *lengths), self._digits)
        if texts is None:
            return None
        return ClassifiedPoint(PoseKind.CUSP, theta_deg, alpha_deg, joint_point(texts, self._leg))
