"""One definition of a printed cusp: its document depends on the pose alone, not on the way to it.

A pose can be found in several ways, whose balls differ. So before anything is printed, both half tangents are
put on a grid: each becomes the nearest multiple of a power of 2, with half a step as the radius. All that a
document says of a cusp is computed from this box, by one way: decimals, precision and proof.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import arb, ctx

from rpr_solver.exact.decimals import digit_bits, round_all
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.slices.joint_points import ClassifiedPoint, joint_point

GRID_GUARD = 128
"""The working precision less the bits of the grid."""
_PROOF_BITS = 128
_PROOF_ACCURACY = 40
"""A proof with fewer correct bits is computed again at the working precision; five digits need 17."""


_HALF, _ONE, _MIDDLE = arb(0.5), arb(1), arb(1.5)


def first_bits(digits: int) -> int:
    """The working precision that is tried first."""
    return digit_bits(digits) + 192


def on_grid(x: HalfTangent, bits: int) -> HalfTangent | None:
    """The box of a half tangent on the grid of working precision ``bits``; None if the ball is too wide.

    It is tan or 1/tan, whichever is at most 1 on the grid. An exact 0 stays exact.
    """
    steps = bits - GRID_GUARD
    n, d = x.numerator, x.denominator
    t = n / d
    if abs(t) < _MIDDLE:
        box = _rounded(t, steps)
        if box is None or abs(box.mid()) <= 1:
            return HalfTangent(box, _ONE) if box is not None else None
    box = _rounded(d / n, steps)
    return HalfTangent(_ONE, box) if box is not None else None


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


@dataclass(frozen=True)
class _LegBalls:
    """A moving leg seen from the fixed one (:class:`~rpr_solver.model.slice_map.Leg`), ω put in."""

    m: arb
    n: arb
    ax: arb
    ay: arb
    squares: arb

    @classmethod
    def of(cls, leg: Leg, omega: arb) -> _LegBalls:
        return cls(arb(leg.m), omega * leg.n, arb(leg.ax), arb(leg.ay), arb(leg.platform2 + leg.base2))

    def rotated(self, cos: arb, sin: arb) -> tuple[arb, arb]:
        return cos * self.m - sin * self.n, sin * self.m + cos * self.n

    def squared_length(self, length: arb, ca: arb, sa: arb, ct: arb, st: arb) -> arb:
        """f at a pose."""
        x, y = self.rotated(ca, sa)
        inner = length * (ct * (x - self.ax) + st * (y - self.ay)) - (x * self.ax + y * self.ay)
        return length * length + self.squares + inner + inner

    def slopes(self, length: arb, ca: arb, sa: arb, ct: arb, st: arb) -> tuple[arb, arb, arb, arb, arb, arb]:
        """The derivatives f_α, f_θ, f_αα, f_αθ, f_θθ and f_ααθ of f/2; the others of order 3 follow.

        f_αθθ = −f_ααθ, f_ααα = −f_α and f_θθθ = −f_θ, as f is a sum of three sinusoids (jets.py).
        """
        x, y = self.rotated(ca, sa)
        value, slope = length * (ct * x + st * y), length * (st * x - ct * y)
        alpha = slope - x * self.ay + y * self.ax
        theta = length * (st * self.ax - ct * self.ay) - slope
        aa = x * self.ax + y * self.ay - value
        tt = length * (ct * self.ax + st * self.ay) - value
        return alpha, theta, aa, value, tt, slope


@dataclass(frozen=True)
class MapBalls:
    """A manipulator with one leg fixed, as balls of one precision."""

    f: _LegBalls
    g: _LegBalls
    scale: arb

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, slice_map: SliceMap, bits: int) -> MapBalls:
        """At one working precision."""
        with ctx.workprec(bits):
            omega = omega_ball(slice_map.radicand, bits)
            f, g = (_LegBalls.of(leg, omega) for leg in (slice_map.f, slice_map.g))
            return cls(f, g, slice_map.scale_ball())


class GridSlice:
    """The slice of one *scaled* L at one working precision: from poses on the grid to cusps in decimals."""

    def __init__(self, slice_map: SliceMap, length: Fraction, digits: int, bits: int) -> None:
        self.digits, self.bits, self._leg = digits, bits, slice_map.fixed_leg
        self._maps, self._low = (MapBalls.of(slice_map, x) for x in (bits, _PROOF_BITS))
        with ctx.workprec(bits):
            self._length = ball_of(length)

    def points(self, poses: Iterable[tuple[HalfTangent, HalfTangent]]) -> list[ClassifiedPoint] | None:
        """The proved cusps at some poses (α, θ); None if the balls of one decide too little."""
        cusps = []
        with ctx.workprec(self.bits):
            for alpha, theta in poses:
                boxes = on_grid(alpha, self.bits), on_grid(theta, self.bits)
                cusp = self.point(boxes[0], boxes[1]) if boxes[0] and boxes[1] else None
                if cusp is None:
                    return None
                cusps.append(cusp)
        return cusps

    def point(self, alpha: HalfTangent, theta: HalfTangent) -> ClassifiedPoint | None:
        """The proved cusp in a box of :func:`on_grid`, or None if the box decides too little.

        The precision must be the working precision.
        """
        if alpha.denominator.contains(0) or theta.denominator.contains(0):
            return None  # a ball cannot decide between 180° and −180°
        at, maps = (self._length, *alpha.cos_sin(), *theta.cos_sin()), self._maps
        first, second = maps.f.squared_length(*at), maps.g.squared_length(*at)
        if not (first > 0 and second > 0):
            return None
        degrees = alpha.degrees(), theta.degrees()
        texts = round_all((*degrees, first.sqrt() / maps.scale, second.sqrt() / maps.scale), self.digits)
        proof = texts and self._proof(at)
        if not (texts and proof):
            return None
        strings = {name: x.str(5) for name, x in proof.items()}
        return ClassifiedPoint(
            PoseKind.CUSP, degrees[1], degrees[0], joint_point(texts, self._leg), strings, self.bits
        )

    def _proof(self, at: tuple[arb, arb, arb, arb, arb]) -> dict[str, arb] | None:
        """What excludes 0 at a cusp (:class:`~rpr_solver.PoseKind`), by its names in the certificate."""
        try:
            ctx.prec = _PROOF_BITS
            proof = cusp_proof(self._low, at)
        finally:
            ctx.prec = self.bits
        if any(x.rel_accuracy_bits() < _PROOF_ACCURACY for x in proof.values()):
            proof = cusp_proof(self._maps, at)
        return None if any(x.contains(0) for x in proof.values()) else proof


def cusp_proof(maps: MapBalls, at: tuple[arb, arb, arb, arb, arb]) -> dict[str, arb]:
    """∇f, ∇J and v·∇E (the larger component of each gradient) at a pose, by the product rule.

    Lengths are scaled, and f and g halves of the squares. ``at`` is L and the cosines and sines of α and θ.
    """
    fa, ft, faa, fat, ftt, faat = maps.f.slopes(*at)
    ga, gt, gaa, gat, gtt, gaat = maps.g.slopes(*at)
    j = fa * gt - ft * ga
    ja = faa * gt + fa * gat - fat * ga - ft * gaa
    jt = fat * gt + fa * gtt - ftt * ga - ft * gat
    jaa = 2 * (faa * gat - fat * gaa) + fa * gaat - faat * ga - j
    jat = faat * gt + faa * gtt - fa * gaat + faat * ga - ftt * gaa - ft * gaat
    jtt = 2 * (fat * gtt - ftt * gat) - faat * gt + ft * gaat - j
    ea = faa * jt + fa * jat - fat * ja - ft * jaa
    et = fat * jt + fa * jtt - ftt * ja - ft * jat
    return {"rank_1": larger(fa, ft), "grad_J": larger(ja, jt), "v_grad_E": fa * et - ft * ea}


def larger(x: arb, y: arb) -> arb:
    """The one that is farther from 0 by proof; the first if neither is."""
    return x if x.abs_lower() >= y.abs_lower() else y
