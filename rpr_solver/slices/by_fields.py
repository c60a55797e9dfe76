"""Poses of a slice over real number fields: for multiple roots, spurious factors and shared curves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.errors import SolverError
from rpr_solver.exact.factors import ExactRoot
from rpr_solver.exact.number_field import Algebraic, common_roots
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.model.classify import PoseKind, classify, cos_sin
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.shared_curves import SliceForms


@dataclass(frozen=True)
class ExactPose:
    """A classified pose, exact: tan(α/2), or None at α = 180°, tan(θ/2), and f, g in one field.

    With ``theta_offset`` 180 the fixed leg is reversed (L negative), so that u = 0 is θ = 180°.
    """

    kind: PoseKind
    t: Algebraic | None
    u: Algebraic
    theta_offset: int
    f: Algebraic
    g: Algebraic
    slice_map: SliceMap

    @classmethod
    def of(cls, kind: PoseKind, t: Algebraic | None, u: Algebraic, local: LocalMap[Algebraic]) -> ExactPose:
        """From the jets at the pose."""
        offset = 0 if local.pose.length.sign > 0 else 180
        return cls(kind, t, u, offset, *local.squared_lengths(), local.slice_map)

    def coordinates(self, bits: int) -> tuple[arb, arb, arb, arb]:
        """α and θ in degrees and the two free lengths in the user's unit, as balls."""
        u, f, g = (x.ball(bits) for x in (self.u, self.f, self.g))
        with ctx.workprec(bits):
            alpha = arb(180) if self.t is None else HalfTangent(self.t.ball(bits), arb(1)).degrees()
            theta = HalfTangent(u, arb(1)).degrees(self.theta_offset)
            scale = self.slice_map.scale_ball()
            lengths = [arb(0) if x.is_zero else b.sqrt() / scale for x, b in ((self.f, f), (self.g, g))]
            return alpha, theta, lengths[0], lengths[1]

    def exact_lengths(self) -> tuple[Fraction | None, Fraction | None]:
        """The two free lengths in the user's unit; None for an irrational one."""
        first, second = (x.rational and rational_sqrt(x.rational) for x in (self.f, self.g))
        scale = self.slice_map.scale
        return first and first / scale, second and second / scale


def poses_above(forms: SliceForms, root: ExactRoot) -> Iterator[ExactPose]:
    """All real poses with J = E = 0 at one root u, classified; ordinary singular poses are left out.

    Raises:
        SolverError: J and E vanish on the whole line θ = const.
    """
    u, omega = root.in_field()
    j, e = ([row(u, omega) for row in form] for form in (forms.singular, forms.coalescence))
    roots = common_roots(j, e, u, omega)
    if roots is None:
        raise SolverError("the singular curve holds a whole line theta = const")
    for t, (at_u, at_omega) in roots:
        if not any(curve.holds(t, at_u) for curve in forms.shared):
            local = local_map(forms.slice_map, forms.length, t, at_u, at_omega)
            kind = classify(local)
            if kind is not PoseKind.ORDINARY:
                yield ExactPose.of(kind, t, at_u, local)


def poses_at_half_turn(turned: SliceForms) -> Iterator[ExactPose]:
    """The poses with J = E = 0 at θ = 180° exactly, where u is infinite; ``turned`` is the slice of −L."""
    return poses_above(turned, ExactRoot.origin(turned.slice_map.radicand))


def local_map(
    slice_map: SliceMap, length: Fraction, t: Algebraic | None, u: Algebraic, omega: Algebraic
) -> LocalMap[Algebraic]:
    """The jets that determine a pose's kind; t is None at α = 180°."""
    field = u.field
    return LocalMap.at(slice_map, Pose(*cos_sin(t, field), *cos_sin(u, field), field(length), omega), 4)
