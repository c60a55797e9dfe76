"""Poses of a slice over real number fields: multiple roots, spurious coincidences, shared curves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx, fmpz

from rpr_solver.errors import SolverError
from rpr_solver.exact.factors import ExactRoot
from rpr_solver.exact.number_field import (
    Algebraic,
    adjoin_real_roots,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.model.classify import classify, cos_sin
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.shared_curves import SliceForms


@dataclass(frozen=True)
class ExactPose:
    """A classified pose, exact: tan(α/2), or None at α = 180°, tan(θ/2), and f, g in one field."""

    kind: str
    t: Algebraic | None
    u: Algebraic
    theta_offset: int
    f: Algebraic
    g: Algebraic
    slice_map: SliceMap

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
        """The two free lengths in the user's unit where they are rational, else None."""
        first, second = (_rational_sqrt(x.rational) for x in (self.f, self.g))
        scale = self.slice_map.scale
        return first and first / scale, second and second / scale


def poses_above(
    slice_map: SliceMap, length: Fraction, plane: SliceForms, root: ExactRoot, *, theta_offset: int = 0
) -> Iterator[ExactPose]:
    """All real poses with J = E = 0 at one root u, classified; ordinary singular poses are left out.

    With ``theta_offset`` 180 the slice map is turned by half a turn, so that u = 0 is θ = 180°;
    ``length`` is then −L.
    """
    yield from _poses(slice_map, length, plane, *root.in_field(), theta_offset)


def poses_at_half_turn(slice_map: SliceMap, length: Fraction, turned: SliceForms) -> Iterator[ExactPose]:
    """The poses with J = E = 0 at θ = 180° exactly, where u is infinite; ``turned`` belongs to −L."""
    return poses_above(slice_map, -length, turned, ExactRoot.origin(slice_map.radicand), theta_offset=180)


def _poses(
    slice_map: SliceMap,
    length: Fraction,
    plane: SliceForms,
    u: Algebraic,
    omega: Algebraic,
    theta_offset: int,
) -> Iterator[ExactPose]:
    j, e = ([row(u, omega) for row in form] for form in (plane.singular, plane.coalescence))
    if j[-1].is_zero and e[-1].is_zero:
        yield from _classified(slice_map, length, plane, None, u, omega, theta_offset)
    common = poly_gcd(trimmed(j), trimmed(e))
    if not common:
        raise SolverError("the singular curve holds a whole line theta = const")
    if len(common) == 1:
        return
    for extension in adjoin_real_roots(u.field, squarefree_part(common)):
        yield from _classified(
            slice_map, length, plane, extension.root, extension.lift(u), extension.lift(omega), theta_offset
        )


def _classified(
    slice_map: SliceMap,
    length: Fraction,
    plane: SliceForms,
    t: Algebraic | None,
    u: Algebraic,
    omega: Algebraic,
    theta_offset: int,
) -> Iterator[ExactPose]:
    if any(curve.holds(t, u) for curve in plane.shared):
        return
    field = u.field
    cos_a, sin_a = (field(-1), field(0)) if t is None else cos_sin(t)
    cos_t, sin_t = cos_sin(u)
    pose = Pose(cos_a, sin_a, cos_t, sin_t, field(length), omega)
    local = LocalMap.at(slice_map, pose, 4)
    kind = classify(slice_map, pose, local)
    if kind is not None:
        f, g = local.squared_lengths(slice_map, pose)
        yield ExactPose(kind, t, u, theta_offset, f, g, slice_map)


def _rational_sqrt(x: Fraction | None) -> Fraction | None:
    if x is None or x < 0:
        return None
    n, d = fmpz(x.numerator), fmpz(x.denominator)
    if not (n.is_square() and d.is_square()):
        return None
    return Fraction(int(n.isqrt()), int(d.isqrt()))
