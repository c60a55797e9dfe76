"""Special poses on curves of degenerate poses."""

from fractions import Fraction

import pytest

from rpr_solver import solve_slice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.shared_curves import SliceForms, without_shared_curves
from rpr_solver.slices.special_points import special_poses
from tests.support.families import CONGRUENT_FLAT, family
from tests.support.shared import eliminant_of


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize("length", [Fraction(5), Fraction(213, 10)])
def test_both_legs_are_stationary_at_two_poses_of_a_flat_curve(fixed_leg: int, length: Fraction) -> None:
    """All legs along the base, and of one length: translations along the base change nothing."""
    table = solve_slice(eliminant_of(CONGRUENT_FLAT, fixed_leg), length, 15)
    angle = f"theta{fixed_leg}_deg"
    on_curve = {
        point[angle]: point["kind"]
        for point in table.degenerate_points
        if point.get("alpha_deg") == "180.000000000000"
    }
    assert on_curve == {"0": "higher", "180.000000000000": "higher"}
    assert table.degenerate_points[0]["equation"] == "alpha = 180 deg"


def test_a_curve_without_special_poses() -> None:
    slice_map = SliceMap.of(family("congruent"))
    whole = SliceForms.of(slice_map, Fraction(5))
    assert special_poses(whole) == []
    forms, _ = without_shared_curves(whole)
    assert forms.shared
    assert special_poses(forms) == []
