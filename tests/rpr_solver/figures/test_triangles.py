"""Base and platform in floats, at any size."""

from math import dist

import pytest

from rpr_solver import EXAMPLES, Manipulator, poses
from rpr_solver.figures.triangles import Triangles


@pytest.mark.parametrize("name", EXAMPLES)
def test_sides(name: str) -> None:
    geometry = EXAMPLES[name].to_json()
    shape = Triangles.of(geometry)
    b1, b2, b3 = shape.placed(33, (4, 5))
    sides = [shape.length(geometry[side]) for side in ("d1", "d2", "d3")]
    assert [dist(b1, b2), dist(b2, b3), dist(b3, b1)] == pytest.approx(sides)
    turn = (b2[0] - b1[0]) * (b3[1] - b1[1]) - (b2[1] - b1[1]) * (b3[0] - b1[0])
    assert (turn < 0) == (geometry["orientation"] == "cw")


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_pose_is_the_same_from_each_leg(leg: int) -> None:
    m = EXAMPLES["innocenti"]
    shape, table = Triangles.of(m.to_json()), poses(m, "14.98", 15, 30, digits=15)
    pose = table.poses[0].to_json()
    length = shape.length(table.lengths[f"l{leg}"])
    x, y = shape.held(leg, length, float(pose["alpha_deg"]), float(pose[f"theta{leg}_deg"]))
    assert (x, y) == pytest.approx((shape.length(pose["b1_x"]), shape.length(pose["b1_y"])))


def test_enormous_and_tiny_manipulators_have_the_same_triangles() -> None:
    usual = Triangles.of(Manipulator(30, 11, 27, 13, 9, 4).to_json())
    for power in (350, -350):
        scaled = Manipulator(*(f"{x}e{power}" for x in (30, 11, 27, 13, 9, 4))).to_json()
        assert Triangles.of(scaled).base == usual.base
