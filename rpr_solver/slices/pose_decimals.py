"""From a pose in balls to decimals: its angles in degrees, and the lengths of the free legs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from flint import acb, arb, ctx

from rpr_solver.exact.decimals import round_all
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.cusp_proof import At, LegPoints

_ONE = arb(1)


class HalfAngle(NamedTuple):
    """tan(angle/2), or its inverse: whichever is small."""

    x: arb
    inverse: bool = False

    def cos_sin(self) -> tuple[arb, arb]:
        """Cosine and sine of the angle."""
        x = self.x
        part = _ONE / (x * x + 1)
        cos = part + part - 1
        return -cos if self.inverse else cos, (x + x) * part

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
        f, g: the moving legs, scaled.
        points: the platform point and the base point of each, in the user's unit, as complex numbers.
        scale: of the lengths.
        half_turns: 360/π.
    """

    f: LegPoints[arb]
    g: LegPoints[arb]
    points: tuple[tuple[acb, acb], ...]
    scale: arb
    half_turns: arb

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, slice_map: SliceMap, bits: int) -> MapBalls:
        """At one working precision."""
        with ctx.workprec(bits):
            omega, scale = omega_ball(slice_map.radicand, bits), slice_map.scale_ball()
            f, g = (LegPoints.of(leg, lambda a, b: omega * b + a) for leg in (slice_map.f, slice_map.g))
            points = tuple((acb(leg.m, leg.n) / scale, acb(leg.ax, leg.ay) / scale) for leg in (f, g))
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

    def pose(self, alpha: HalfAngle, theta: HalfAngle) -> At[arb]:
        """The scaled L, and the cosines and sines of both angles."""
        return (self.length, *alpha.cos_sin(), *theta.cos_sin())

    def texts(self, degrees: tuple[arb, arb], at: At[arb]) -> list[str] | None:
        """α and θ in degrees and both lengths at a pose; None if the balls do not decide them."""
        _, ca, sa, ct, st = at
        end, turned = acb(self._own * ct, self._own * st), acb(ca, sa)
        lengths = [abs(end + turned * platform - base) for platform, base in self.maps.points]
        return round_all((*degrees, *lengths), self.digits)
