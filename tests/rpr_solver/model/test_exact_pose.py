"""Exact poses: common zeros of forms that are known, and the coordinates of constructed poses."""

from collections.abc import Callable
from fractions import Fraction

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_mpoly

from rpr_solver import PoseKind
from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model import jets
from rpr_solver.model.joint_points import ExactPose, common_poses
from rpr_solver.model.slice_map import SliceMap
from tests.support import constructed
from tests.support.constructed import TRIANGLE, WEST, Constructed, Pose, direction

BITS = 128
SHARED = (T - 1) * (T**2 - 2)


def root_at(u: int, radicand: int = 1) -> ExactRoot:
    [root] = exact_roots(norm_factors(QuadraticPoly.rational([-u, 1], radicand)))
    return root


def form(p: fmpz_mpoly, degree_t: int, degree_u: int, radicand: int = 1) -> BiForm:
    return BiForm.of(p, radicand, degree_t, degree_u)


def half_tangents(poses: list[jets.Pose]) -> list[float | None]:  # type: ignore[type-arg]
    """tan(α/2) of each, None at 180°."""
    values = [(float(p.cos_alpha.ball(BITS).mid()), float(p.sin_alpha.ball(BITS).mid())) for p in poses]
    return [None if c == -1 else s / (1 + c) for c, s in values]


def exactly(at: Constructed) -> ExactPose:
    slice_map, field = SliceMap.of(at.manipulator), Field.rationals()
    numbers = map(field, (*at.pose.alpha, *at.pose.theta, at.pose.l1 * slice_map.scale, 1))
    return ExactPose.of(slice_map, jets.Pose(*numbers))


def float_of(x: arb | Fraction) -> float:
    return float(x.mid()) if isinstance(x, arb) else float(x)


@pytest.mark.parametrize("u", [5, 0, None])
def test_real_common_zeros_are_found_and_no_others(u: int | None) -> None:
    """One form has ±i besides, the other u."""
    first, second = form(SHARED * (T**2 + 1), 5, 0), form(SHARED * (T - U), 4, 1)
    poses = common_poses(first, second, None if u is None else root_at(u), 7, 1)
    assert poses is not None
    assert half_tangents(poses) == pytest.approx([-(2**0.5), 1, 2**0.5])
    for pose in poses:
        cos, sin = (-1, 0) if u is None else (Fraction(1 - u * u, 1 + u * u), Fraction(2 * u, 1 + u * u))
        assert [x.rational for x in (pose.cos_theta, pose.sin_theta, pose.length)] == [cos, sin, 7]
        assert (pose.cos_alpha * pose.cos_alpha + pose.sin_alpha * pose.sin_alpha - 1).is_zero


def test_a_degree_that_is_lower_in_both_is_a_zero_at_180_degrees() -> None:
    low, full = form(SHARED, 4, 0), form(SHARED * (T - 9), 4, 0)
    for other, at_infinity in ((low, [None]), (full, [])):
        poses = common_poses(low, other, root_at(1), 1, 1)
        assert poses is not None
        assert [x for x in half_tangents(poses) if x is None] == at_infinity


@pytest.mark.parametrize(
    ("construct", "kind"),
    [
        (constructed.cusp, PoseKind.CUSP),
        (constructed.fold, PoseKind.ORDINARY),
        (constructed.leg_3_closed, PoseKind.ORDINARY),
        (lambda: constructed.cusp(Pose(TRIANGLE, Fraction(10), direction(1, 3), WEST), Fraction(25)), "cusp"),
        (lambda: constructed.cusp(Pose(TRIANGLE, Fraction(10), WEST, direction(1, 3)), Fraction(25)), "cusp"),
    ],
)
def test_a_pose_has_its_kind_its_angles_and_its_legs(construct: Callable[[], Constructed], kind: str) -> None:
    at = construct()
    exact = exactly(at)
    assert exact.kind == kind
    expected = [mp.degrees(mp.atan2(float(y), float(x))) for x, y in (at.pose.alpha, at.pose.theta)]
    expected += [mp.hypot(*map(float, leg)) for leg in constructed.legs_of(at).vectors[1:]]
    with ctx.workprec(BITS):
        assert [float_of(x) for x in exact.coordinates(BITS)] == pytest.approx([float(x) for x in expected])
    scale = exact.local.slice_map.scale
    assert exact.length.rational == at.pose.l1 * scale
