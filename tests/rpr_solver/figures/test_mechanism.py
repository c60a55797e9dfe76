"""Base and platform in floats, at any size.

The mechanism: joints where the pose has them, its lengths, the other poses behind.
"""

from __future__ import annotations

from functools import cache
from random import Random

import numpy as np
import pytest
from matplotlib.text import Annotation

from rpr_solver import EXAMPLES, Figure, InputError, Manipulator, PoseTable, cusp_table, poses
from rpr_solver.figures.mechanism import Triangles, geometry_figure, point_figure, poses_figure
from rpr_solver.notebook.style import Style
from tests.support.pictures import GEOMETRY, STYLES, check, random_robot, sheet_of, words
from tests.support.sampling import sample, seeds


@pytest.mark.parametrize("name", EXAMPLES)
def test_sides(name: str) -> None:
    geometry = EXAMPLES[name].to_json()
    shape = Triangles.of(geometry)
    b1, b2, b3 = shape.placed(33, 4 + 5j)
    sides = [shape.length(geometry[side]) for side in ("d1", "d2", "d3")]
    assert [abs(b1 - b2), abs(b2 - b3), abs(b3 - b1)] == pytest.approx(sides)
    assert (((b2 - b1).conjugate() * (b3 - b1)).imag < 0) == (geometry["orientation"] == "cw")


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_pose_is_the_same_from_each_leg(leg: int) -> None:
    m = EXAMPLES["innocenti"]
    shape, table = Triangles.of(m.to_json()), poses(m, "14.98", 15, 30, digits=15)
    pose = table.poses[0].to_json()
    length = shape.length(table.lengths[f"l{leg}"])
    b1 = shape.held(leg, length, float(pose["alpha_deg"]), float(pose[f"theta{leg}_deg"]))
    assert b1 == pytest.approx(complex(shape.length(pose["b1_x"]), shape.length(pose["b1_y"])))


def test_enormous_and_tiny_manipulators_have_the_same_triangles() -> None:
    usual = Triangles.of(Manipulator(30, 11, 27, 13, 9, 4).to_json())
    for power in (350, -350):
        scaled = Manipulator(*(f"{x}e{power}" for x in (30, 11, 27, 13, 9, 4))).to_json()
        assert Triangles.of(scaled).base == usual.base


INNOCENTI = EXAMPLES["innocenti"]


@cache
def the_six() -> PoseTable:
    return poses(INNOCENTI, "14.98", 16, 20, digits=15)


def test_a_pose_with_the_others_behind_it() -> None:
    figure = the_six().figure(3)
    check(figure)
    assert {"A1", "A2", "A3", "B1", "B2", "B3", "L1 = 14.98", "L2 = 16", "L3 = 20"} <= set(words(figure))
    assert {str(k) for k in range(1, 7)} <= set(words(figure))
    assert figure.title == "Pose 3 of 6 with these legs"
    assert f"α = {float(the_six().poses[2].alpha_deg):.3f}°" in figure.description


def test_joints_are_as_far_apart_as_the_legs_are_long() -> None:
    [ax] = sheet_of(the_six().figure(1)).axes
    [joints] = [line for line in ax.lines if line.get_marker() == "o"]
    at = ax.transData.transform(joints.get_xydata())
    lengths = np.hypot(*(at[:3] - at[3:]).T)
    assert lengths / lengths[0] == pytest.approx([1, 16 / 14.98, 20 / 14.98])


def assert_numbered(figure: Figure) -> None:
    """Each number lies in the platform of its pose, or a line leads from there to it."""
    check(figure)
    [ax] = sheet_of(figure).axes
    notes = [text for text in ax.texts if isinstance(text, Annotation)]
    numbers = {text.get_text(): text for text in notes if text.get_text().isdigit()}
    platforms = [patch for patch in ax.patches if len(patch.get_path().vertices) == 4][0:]
    assert len(numbers) == len(platforms) - 1  # one is the base
    for number, text in numbers.items():
        assert any(ring.get_path().contains_point(text.xy) for ring in platforms), number


@pytest.mark.parametrize("style", sample(STYLES, 1))
@pytest.mark.parametrize("pose", sample(range(1, 7), 1))
def test_poses_have_the_numbers_of_the_table(pose: int, style: Style) -> None:
    assert_numbered(the_six().figure(pose).styled(style))


@pytest.mark.parametrize("some", seeds(0))
def test_random_poses_at_every_width(some: range) -> None:
    for rng in map(Random, some):
        draw_poses(rng)


def draw_poses(rng: Random) -> None:
    """All poses of the legs of a random pose, one of them in full."""
    robot = random_robot(rng)
    alpha, b1 = rng.uniform(-180, 180), complex(rng.uniform(-20, 20), rng.uniform(-20, 20))
    shape = Triangles.of(robot.to_json())
    at = shape.placed(alpha, b1 / float(shape.unit))
    lengths = [f"{abs(p - q) * float(shape.unit):.3f}" for p, q in zip(shape.base, at, strict=True)]
    table = poses(robot, *lengths, digits=15)
    for style in STYLES:
        if len(table.poses) > 1:
            assert_numbered(table.figure(rng.randint(1, len(table.poses))).styled(style))


@pytest.mark.parametrize("pose", [0, 7, -1])
def test_a_pose_that_there_is_not(pose: int) -> None:
    with pytest.raises(InputError, match=r"^pose: is -?\d; give 1 to 6$"):
        the_six().figure(pose)


def test_legs_without_a_pose() -> None:
    with pytest.raises(InputError, match="these legs have no pose"):
        poses(INNOCENTI, 1, 1, 1, digits=15).figure()


@pytest.mark.parametrize("leg", [1, 2])
def test_a_cusp_of_any_leg(leg: int) -> None:
    [table] = cusp_table(INNOCENTI, 15, fixed_leg=leg, digits=15)
    cusp = table.cusps[0].to_json()
    figure = point_figure(GEOMETRY, leg, "15", cusp, "Cusp A")
    check(figure)
    assert f"L{leg} = 15" in words(figure)


@pytest.mark.parametrize("name", EXAMPLES)
def test_manipulators(name: str) -> None:
    check(EXAMPLES[name].figure())


def test_flat_triangles_are_drawn() -> None:
    check(geometry_figure(Manipulator(20, 6, 0, 7, 9, 16).to_json()))
    check(poses_figure(poses(Manipulator(20, 6, 0, 7, 9, 16), 20, 18, 16, digits=15).to_json()))
