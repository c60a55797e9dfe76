"""The special poses on curves of degenerate poses.

All poses of such a curve are degenerate, and most of them are alike (mathematics.md#shared-curves). Named
beside the curve are those where other parts of the singular curve cross it, or both legs are stationary.
"""

from __future__ import annotations

from collections.abc import Iterator

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.torus_forms import divides
from rpr_solver.model.exact_pose import ExactPose, common_poses
from rpr_solver.model.slice_map import half_angles, slopes
from rpr_solver.slices.shared_curves import Curve, SliceForms


def special_poses(forms: SliceForms) -> list[ExactPose]:
    """The poses with ∇J = 0 on simple curves that were divided out of a slice, and those with ∇f = ∇g = 0."""
    found: list[ExactPose] = []
    for curve in forms.shared:
        own, rest = curve.form, forms.slice_map.singular.sliced(forms.length)
        simple = not divides(own * own, rest) if not own.a.is_one() else rest.zeros_at_infinity == 1
        for other in _others(forms, curve):
            for pose in () if divides(own, other) else _common(own, other, forms):
                if _stands_out(pose, simple) and not any(pose.is_at(x) for x in found):
                    found.append(pose)
    return found


def _stands_out(pose: ExactPose, simple: bool) -> bool:
    local = pose.local
    j = local.singularity()
    legs = (leg for moving in (local.f, local.g) for leg in (moving.alpha, moving.theta))
    slopes = (j.alpha, j.theta) if simple else legs
    return all(slope.value.is_zero for slope in slopes)


def _others(forms: SliceForms, curve: Curve) -> Iterator[BiForm]:
    """Forms of which one vanishes where ∇J = 0 on the curve: other factors of J, gradients of the legs."""
    yield forms.singular
    yield from (other.form for other in forms.shared if other is not curve)
    for leg in (forms.slice_map.f, forms.slice_map.g):
        for slope in slopes(leg):
            yield half_angles(slope, (1, 1), leg.radicand).sliced(forms.length)


def _common(first: BiForm, second: BiForm, forms: SliceForms) -> Iterator[ExactPose]:
    eliminant = resultant(first, second)
    roots: list[ExactRoot | None] = list(exact_roots(norm_factors(eliminant.polynomial)))
    if eliminant.zeros_at_infinity:
        roots.append(None)
    for root in roots:
        for pose in common_poses(first, second, root, forms.length) or ():
            yield ExactPose.of(forms.slice_map, pose)
