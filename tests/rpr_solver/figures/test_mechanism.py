"""Base and platform in floats, at any size.

The mechanism: joints where the pose has them, its lengths, the other poses behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import dist
from random import Random

import pytest

from rpr_solver import EXAMPLES, Figure, InputError, Manipulator, PoseTable, cusp_table, poses
from rpr_solver.figures.mechanism import Triangles, geometry_figure, point_figure, poses_figure
from rpr_solver.figures.sheet import box_of
from rpr_solver.notebook.scene import Disc, Group, Path, Point, Text, area
from rpr_solver.notebook.tables import SCREEN, Style
from tests.support.pictures import GEOMETRY, check, every, random_robot, words
from tests.support.sampling import sample, seeds


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


INNOCENTI = EXAMPLES["innocenti"]


@cache
def the_six() -> PoseTable:
    return poses(INNOCENTI, "14.98", 16, 20, digits=15)


def test_a_pose_with_the_others_behind_it() -> None:
    figure = the_six().figure(3)
    check(figure)
    assert {"A1", "A2", "A3", "B1", "B2", "B3", "L1 = 14.98", "L2 = 16", "L3 = 20"} <= set(words(figure))
    groups = [shape.name for shape in figure.scene.shapes if isinstance(shape, Group)]
    assert [f"pose {k}" for k in (1, 2, 4, 5, 6)] == [name for name in groups if name.startswith("pose")]
    assert {str(k) for k in range(1, 7)} <= set(words(figure))
    assert figure.scene.title == "Pose 3 of 6 with these legs"
    assert f"α = {float(the_six().poses[2].alpha_deg):.3f}°" in figure.scene.description


def test_joints_are_as_far_apart_as_the_legs_are_long() -> None:
    discs = [shape.centre for shape in every(the_six().figure(1).scene.shapes) if isinstance(shape, Disc)]
    a, b = discs[:3], discs[3:]
    lengths = [((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2) ** 0.5 for p, q in zip(a, b, strict=True)]
    assert [x / lengths[0] for x in lengths] == pytest.approx([1, 16 / 14.98, 20 / 14.98])


STYLES = [SCREEN, *(Style(width, is_print=True, has_symbols=True) for width in (320, 344, 720))]


def rings(figure: Figure) -> dict[str, Sequence[Point]]:
    """The platforms in a picture, by the numbers of their poses."""
    groups = [shape for shape in figure.scene.shapes if isinstance(shape, Group)]
    chosen = figure.scene.title.split()[1]
    named = [(group.name.replace("platform", f"pose {chosen}"), group.shapes[-1]) for group in groups]
    paths = [(name, shape) for name, shape in named if isinstance(shape, Path)]
    return {name.split()[1]: path.lines[0] for name, path in paths if name.startswith("pose")}


def assert_numbered(figure: Figure) -> None:
    """Each number lies in the platform of its pose, or a line leads from there to it."""
    check(figure)
    assert_named(figure)
    texts = {
        text.words: text for text in figure.scene.shapes if isinstance(text, Text) and text.words.isdigit()
    }
    dots = [shape.centre for shape in figure.scene.shapes if isinstance(shape, Disc) and shape.radius == 2]
    platforms = rings(figure)
    assert texts.keys() == platforms.keys()
    for number, ring in platforms.items():
        at = texts[number].at
        assert holds(ring, at) or any(holds(ring, dot) and dist(dot, at) < 80 for dot in dots)


def assert_named(figure: Figure) -> None:
    """Each name of a joint stands beside it, or a line leads from the one to the other."""
    shapes = figure.scene.shapes
    joints = [shape.centre for shape in shapes if isinstance(shape, Disc) and shape.radius > 2]
    texts = {shape.words: box_of(shape) for shape in shapes if isinstance(shape, Text)}
    leaders = {shape.lines[0][0] for shape in shapes if isinstance(shape, Path) and len(shape.lines[0]) == 2}
    for name, at in zip(("A1", "A2", "A3", "B1", "B2", "B3"), joints, strict=True):
        box = texts[name]
        beside = min(max(at[0], box.x0), box.x1), min(max(at[1], box.y0), box.y1)
        assert dist(at, beside) < 50, name
        assert dist(at, beside) < 26 or at in leaders, name


def holds(ring: Sequence[Point], point: Point) -> bool:
    parts = [area([ring[k - 1], ring[k], point]) for k in range(3)]
    return abs(sum(map(abs, parts)) - abs(area(ring))) < 1e-6 * abs(area(ring)) + 1e-9


@pytest.mark.parametrize("style", STYLES, ids=["screen", "80mm", "86mm", "180mm"])
@pytest.mark.parametrize("pose", sample(range(1, 7), 1, 4))
def test_poses_have_the_numbers_of_the_table(pose: int, style: Style) -> None:
    assert_numbered(the_six().figure(pose).styled(style))


@pytest.mark.parametrize("some", seeds(1))
def test_random_poses_at_every_width(some: range) -> None:
    for rng in map(Random, some):
        draw_poses(rng)


def draw_poses(rng: Random) -> None:
    """All poses of the legs of a random pose, one of them in full."""
    robot = random_robot(rng)
    alpha, x, y = rng.uniform(-180, 180), rng.uniform(-20, 20), rng.uniform(-20, 20)
    shape = Triangles.of(robot.to_json())
    at = shape.placed(alpha, (float(x) / float(shape.unit), float(y) / float(shape.unit)))
    lengths = [f"{dist(p, q) * float(shape.unit):.3f}" for p, q in zip(shape.base, at, strict=True)]
    table = poses(robot, *lengths, digits=15)
    for style in STYLES:
        if len(table.poses) > 1:
            assert_numbered(table.figure(rng.randint(1, len(table.poses))).styled(style))


@pytest.mark.parametrize("style", [STYLES[0], STYLES[-1]], ids=["screen", "180mm"])
@pytest.mark.parametrize("pose", sample(range(1, 7), 1, 4))
def test_lengths_of_legs_lie_beside_the_platforms_of_other_poses(pose: int, style: Style) -> None:
    figure = the_six().figure(pose).styled(style)
    texts = [shape for shape in figure.scene.shapes if isinstance(shape, Text) and shape.words[0] == "L"]
    assert len(texts) == 3
    others = [ring for number, ring in rings(figure).items() if number != str(pose)]
    for text in texts:
        assert not any(holds(ring, text.at) for ring in others), text.words


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
