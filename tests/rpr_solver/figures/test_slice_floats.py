"""The slice in floats agrees with exact poses and exact cusps."""

import pytest

from rpr_solver import EXAMPLES, cusp_table, poses
from rpr_solver.figures.slice_floats import SliceFloats

INNOCENTI = EXAMPLES["innocenti"]


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_poses_have_their_legs(leg: int) -> None:
    table = poses(INNOCENTI, "14.98", 16, 20, digits=15)
    free = [float(length) for name, length in table.lengths.items() if name != f"l{leg}"]
    floats = SliceFloats.of(INNOCENTI.to_json(), leg, table.lengths[f"l{leg}"])
    for pose in (pose.to_json() for pose in table.poses):
        angles = float(pose["alpha_deg"]), float(pose[f"theta{leg}_deg"])
        assert floats.lengths(angles) == pytest.approx(free)


def test_j_is_zero_at_cusps_and_its_slopes_are_right() -> None:
    [table] = cusp_table(INNOCENTI, 27, digits=15)
    floats = SliceFloats.of(INNOCENTI.to_json(), 1, "27")
    radians = 0.017453292519943295
    for cusp in table.cusps:
        alpha, theta = float(cusp.alpha_deg), float(cusp.theta1_deg)
        value, a, t = floats.singular((alpha, theta))
        assert abs(value) < 1e-10
        step = 1e-4
        assert floats.singular((alpha + step, theta))[0] / (step * radians) == pytest.approx(a, abs=1e-4)
        assert floats.singular((alpha, theta + step))[0] / (step * radians) == pytest.approx(t, abs=1e-4)
        assert abs(floats.singular(floats.onto_curve((alpha + 0.3, theta - 0.2)))[0]) < 1e-6
