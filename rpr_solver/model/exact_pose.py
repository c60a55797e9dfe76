"""Poses in real number fields: the common zeros of two forms, classified, and their coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.factors import ExactRoot, same_number
from rpr_solver.exact.number_field import Algebraic, common_roots, exact_omega
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.model.classify import PoseKind, classify, cos_sin, tan_half
from rpr_solver.model.half_tangent import direction
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap


@dataclass(frozen=True)
class ExactPose:
    """A classified pose with L > 0, all of it in one real number field (scaled units)."""

    kind: PoseKind
    local: LocalMap[Algebraic]

    @classmethod
    def of(cls, slice_map: SliceMap, pose: Pose[Algebraic]) -> ExactPose:
        """The pose with its kind."""
        local = LocalMap.at(slice_map, pose, 4)
        return cls(classify(local), local)

    @property
    def length(self) -> Algebraic:
        """L (scaled)."""
        return self.local.pose.length

    def coordinates(self, bits: int) -> tuple[arb, arb, arb | Fraction, arb | Fraction]:
        """α and θ in degrees, and the free legs in the user's unit; rational lengths are exact."""
        p = self.local.pose
        alpha, theta = (
            exact_direction(p.cos_alpha, p.sin_alpha, bits),
            exact_direction(p.cos_theta, p.sin_theta, bits),
        )
        first, second = (self._length(square, bits) for square in self.local.squared_lengths())
        return alpha, theta, first, second

    def _length(self, square: Algebraic, bits: int) -> arb | Fraction:
        root = None if square.rational is None else rational_sqrt(square.rational)
        if root is not None:
            return root / self.local.slice_map.scale
        ball = square.ball(bits)
        with ctx.workprec(bits):
            return ball.sqrt() / self.local.slice_map.scale_ball()

    def is_at(self, other: ExactPose) -> bool:
        """Whether both poses have the same α and θ, also if their number fields differ."""
        first, second = self.local.pose, other.local.pose
        return _same_angle((first.cos_alpha, first.sin_alpha), (second.cos_alpha, second.sin_alpha)) and (
            _same_angle((first.cos_theta, first.sin_theta), (second.cos_theta, second.sin_theta))
        )


def _same_angle(first: tuple[Algebraic, Algebraic], second: tuple[Algebraic, Algebraic]) -> bool:
    x, y = tan_half(*first), tan_half(*second)
    return x is None and y is None if x is None or y is None else same_number(x, y)


def place(root: ExactRoot | None, radicand: int) -> tuple[Algebraic | None, Algebraic]:
    """u, None at ∞, and ω in one field."""
    return (None, exact_omega(radicand)) if root is None else root.in_field()


def common_poses(
    first: BiForm, second: BiForm, root: ExactRoot | None, length: Fraction | int
) -> list[Pose[Algebraic]] | None:
    """The real common zeros of two forms above one root u, as poses of the slice of this length.

    ``root`` is None for u = ∞. Returns None if every t is a common zero.
    """
    u, omega = place(root, first.radicand)
    at_u = first.above(u, omega), second.above(u, omega)
    roots = common_roots(*at_u, *cos_sin(u, omega.field), omega)
    if roots is None:
        return None
    return [
        Pose(*cos_sin(t, at_omega.field), cos, sin, at_omega.field(length), at_omega)
        for t, (cos, sin, at_omega) in roots
    ]


def exact_direction(x: Algebraic, y: Algebraic, bits: int) -> arb:
    """The angle of (x, y) in degrees, in (−180, 180], exact at multiples of 90."""
    if y.is_zero:
        return arb(0 if x.sign > 0 else 180)
    if x.is_zero:
        return arb(90 * y.sign)
    balls = x.ball(bits), y.ball(bits)
    with ctx.workprec(bits):
        return direction(*balls)
