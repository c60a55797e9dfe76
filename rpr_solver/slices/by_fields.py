"""Poses of a slice over real number fields: for multiple roots, spurious factors and shared curves."""

from __future__ import annotations

from collections.abc import Iterator

from rpr_solver.errors import SolverError
from rpr_solver.exact.factors import ExactRoot
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.exact_pose import ExactPose, common_poses
from rpr_solver.slices.shared_curves import SliceForms


def poses_above(forms: SliceForms, root: ExactRoot | None) -> Iterator[ExactPose]:
    """All real poses with J = E = 0 at one root u, classified; ordinary singular poses are left out.

    ``root`` is None for u = ∞, where θ = 180°.

    Raises:
        SolverError: J and E vanish on the whole line θ = const.
    """
    poses = common_poses(forms.singular, forms.coalescence, root, forms.length)
    if poses is None:
        raise SolverError("the singular curve holds a whole line theta = const")
    for pose in poses:
        if not any(curve.holds(pose) for curve in forms.shared):
            exact = ExactPose.of(forms.slice_map, pose)
            if exact.kind is not PoseKind.ORDINARY:
                yield exact
