"""From a pose in balls to a printed cusp, whose document depends on the pose alone, not on the way to it.

A pose can be found in several ways, whose balls differ. So before anything is printed, both half tangents are
put on a grid: each becomes the nearest multiple of a power of 2, with half a step as the radius. What a
document says of a cusp is what this box decides: decimals, precision and proof. What proves a cusp are closed
formulas in any ring: balls, or arrays of floats with bounds of errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from flint import acb, arb, ctx

from rpr_solver.exact.decimals import digit_bits, round_all
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import PoseDerivatives, Waves, turns
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.joint_points import ClassifiedPoint, PoseKind, joint_point
from rpr_solver.model.slice_map import SliceMap

Pose = tuple[acb, acb]
"""exp(iα) and exp(iθ)."""

_ONE = arb(1)


class HalfAngle(NamedTuple):
    """tan(angle/2), or its inverse: whichever is small."""

    x: arb
    inverse: bool = False

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


@dataclass(frozen=True)
class MapBalls:
    """A manipulator with one leg fixed, as balls of one precision.

    Attributes:
        f, g: the waves of the free legs, scaled.
        points: the platform point and the base point of each, in the user's unit, as complex numbers.
        scale: of the lengths.
        half_turns: 360/π.
    """

    f: Waves
    g: Waves
    points: tuple[tuple[acb, acb], ...]
    scale: arb
    half_turns: arb

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, slice_map: SliceMap, bits: int) -> MapBalls:
        """At one working precision."""
        with ctx.workprec(bits):
            omega, scale = omega_ball(slice_map.radicand, bits), slice_map.scale_ball()
            legs = [leg.points(omega) for leg in (slice_map.f, slice_map.g)]
            f, g = (Waves.of(m, a) for m, a in legs)
            points = tuple((m / scale, a / scale) for m, a in legs)
            return cls(f, g, points, scale, 360 / arb.pi())


class SliceDecimals:
    """The slice of one *scaled* L, as a ball; the precision of the maps must be that of the caller."""

    def __init__(self, maps: MapBalls, length: arb, digits: int) -> None:
        self.maps, self.length, self.digits = maps, length, digits
        self._own = length / maps.scale

    def degrees(self, alpha: HalfAngle, theta: HalfAngle) -> tuple[arb, arb] | None:
        """Both angles; None if one may be 180 and −180."""
        turns = self.maps.half_turns
        first, second = alpha.degrees(turns), theta.degrees(turns)
        return None if first is None or second is None else (first, second)

    def texts(self, degrees: tuple[arb, arb], pose: Pose) -> list[str] | None:
        """α and θ in degrees and both lengths at a pose; None if the balls do not decide them."""
        turn, tip = pose[0], pose[1] * self._own
        lengths = [abs(tip + turn * platform - base) for platform, base in self.maps.points]
        return round_all((*degrees, *lengths), self.digits)


GRID_GUARD = 128
"""The working precision less the bits of the grid."""
_PROOF_BITS = 128
_PROOF_ACCURACY = 40
"""A proof with fewer correct bits is computed again at the working precision; five digits need 17."""

_HALF, _MIDDLE = arb(0.5), arb(1.5)


def first_bits(digits: int) -> int:
    """The working precision that is tried first."""
    return digit_bits(digits) + 192


def on_grid(x: HalfTangent, bits: int) -> HalfAngle | None:
    """The box of a half tangent on the grid of working precision ``bits``; None if the ball is too wide.

    It is tan or 1/tan, whichever is at most 1 on the grid. An exact 0 stays exact.
    """
    steps = bits - GRID_GUARD
    n, d = x.numerator, x.denominator
    t = n / d
    if abs(t) < _MIDDLE:
        box = _rounded(t, steps)
        if box is None or abs(box.mid()) <= 1:
            return None if box is None else HalfAngle(box)
    box = _rounded(d / n, steps)
    return None if box is None else HalfAngle(box, inverse=True)


def _rounded(x: arb, steps: int) -> arb | None:
    if x.is_zero():
        return x
    scale, step, half = _powers(steps)
    nearest = (x * scale + _HALF).floor().unique_fmpz()
    return None if nearest is None else arb(nearest * step, half)


@lru_cache(maxsize=64)
def _powers(steps: int) -> tuple[arb, arb, arb]:
    """2^steps, and 2^−steps and its half."""
    return arb(2) ** steps, arb(2) ** -steps, arb(2) ** (-steps - 1)


class GridSlice:
    """The slice of one *scaled* L at one working precision: from poses on the grid to cusps in decimals."""

    def __init__(self, slice_map: SliceMap, length: Fraction, digits: int, bits: int) -> None:
        self.bits, self._leg = bits, slice_map.fixed_leg
        maps, self._low = (MapBalls.of(slice_map, x) for x in (bits, _PROOF_BITS))
        with ctx.workprec(bits):
            self._decimals = SliceDecimals(maps, ball_of(length), digits)

    def point(self, alpha: HalfAngle, theta: HalfAngle) -> ClassifiedPoint | None:
        """The proved cusp in a box of :func:`on_grid`, or None if the box decides too little.

        The precision must be the working precision.
        """
        decimals = self._decimals
        pose, degrees = (alpha.turn, theta.turn), decimals.degrees(alpha, theta)
        texts = degrees and decimals.texts(degrees, pose)
        proof = texts and self._proof(pose)
        if not (degrees and texts and proof):
            return None
        strings = {name: x.str(5) for name, x in proof.items()}
        point = joint_point(texts, self._leg)
        return ClassifiedPoint(PoseKind.CUSP, degrees[1], degrees[0], point, strings, self.bits)

    def _proof(self, pose: Pose) -> dict[str, arb] | None:
        """What excludes 0 at a cusp (:class:`~rpr_solver.PoseKind`), by its names in the certificate."""
        length = self._decimals.length
        try:
            ctx.prec = _PROOF_BITS
            proof = cusp_proof(self._low, length, pose)
        finally:
            ctx.prec = self.bits
        if any(x.rel_accuracy_bits() < _PROOF_ACCURACY for x in proof.values()):
            proof = cusp_proof(self._decimals.maps, length, pose)
        return None if any(x.contains(0) for x in proof.values()) else proof


def cusp_proof(maps: MapBalls, length: arb, pose: Pose) -> dict[str, arb]:
    """∇f, ∇J and v·∇E (the larger component of each gradient) at a pose.

    Lengths are scaled, and f and g halves of the squares.
    """
    at = turns(pose[0], pose[1] * length)
    d = PoseDerivatives.of(maps.f.turned(*at), maps.g.turned(*at))
    return {
        "rank_1": larger(d.f_alpha, d.f_theta),
        "grad_J": larger(d.j_alpha, d.j_theta),
        "v_grad_E": d.v_grad_e,
    }


def larger(x: arb, y: arb) -> arb:
    """The one that is farther from 0 by proof; the first if neither is."""
    return x if x.abs_lower() >= y.abs_lower() else y
