"""A loop in motion: it runs there and back, from pose to pose, and rests where motion is not wanted."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import pytest

from rpr_solver import EXAMPLES, SingularCurves, cusp_loop, pose_path, singular_curves
from rpr_solver import Path as PosePath
from rpr_solver.figures.loop import loop_figure
from rpr_solver.notebook.scene import Group, Path, Point, distance
from rpr_solver.notebook.tables import SCREEN, Style
from tests.support.pictures import check, every, words

INNOCENTI = EXAMPLES["innocenti"]


@cache
def the_loop() -> PosePath:
    return cusp_loop(INNOCENTI, 27, "B")


@cache
def the_curves() -> SingularCurves:
    return singular_curves(INNOCENTI, 27)


STYLES = [SCREEN, *(Style(width, is_print=True, has_symbols=True, unit="mm") for width in (320, 344, 720))]


def test_a_loop_with_the_curves_round_it() -> None:
    figure = loop_figure(the_loop().to_json(), the_curves().to_json())
    check(figure)
    start, stop = the_loop().start.number, the_loop().stop.number
    assert {"B", "A1", "A2", "A3", f"1: pose {start}", f"5: pose {stop}", "L2", "L3"} <= set(words(figure))
    assert {"θ1 [°]", "α [°]", "1, 5"} <= set(words(figure))
    assert "prefers-reduced-motion" in figure.svg()


def test_everything_moves_in_step_and_comes_back() -> None:
    groups = [
        shape for shape in every(loop_figure(the_loop().to_json()).scene.shapes) if isinstance(shape, Group)
    ]
    motions = [group.motion for group in groups if group.motion is not None]
    assert len(motions) == 10
    assert len({(len(motion.places), motion.seconds) for motion in motions}) == 1
    for motion in motions:
        assert motion.places[0] == motion.places[-1]
        turns = [place[2] for place in motion.places]
        assert max(abs(a - b) for a, b in pairwise(turns)) < 90


def lines(group: Group) -> list[Sequence[Point]]:
    return [line for shape in group.shapes if isinstance(shape, Path) for line in shape.lines]


@pytest.mark.parametrize("style", STYLES, ids=["screen", "80mm", "86mm", "180mm"])
def test_the_path_crosses_curves_in_joint_space_and_none_on_the_torus(style: Style) -> None:
    figure = the_loop().figure(the_curves()).styled(style)
    check(figure)
    groups = [shape for shape in figure.scene.shapes if isinstance(shape, Group)]
    curves = [lines(group) for group in groups if group.name == "singular curves"]
    paths = [lines(group)[0] for group in groups if group.name.startswith("path")]
    assert [crossings(path, known) for path, known in zip(paths, curves, strict=True)] == [2, 0]
    [aspects] = [group for group in groups if group.name == "aspects"]
    around = [holding(aspects, point) for point in paths[1]]
    assert set(around) == {"plus1"}, "one aspect holds all of it"


def crossings(path: Sequence[Point], curves: Sequence[Sequence[Point]]) -> int:
    """How often a path meets curves."""

    def side(a: Point, b: Point, p: Point) -> float:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    pieces = [pair for line in curves for pair in pairwise(line)]
    return sum(
        side(a, b, p) * side(a, b, q) < 0 and side(p, q, a) * side(p, q, b) < 0
        for a, b in pairwise(path)
        for p, q in pieces
    )


def holding(aspects: Group, point: Point) -> str:
    """The colour of the aspect round a point."""
    x, y = point
    for shape in aspects.shapes:
        assert isinstance(shape, Path)
        for ring in shape.lines:
            above = [
                (ax, ay, bx, by)
                for (ax, ay), (bx, by) in pairwise([*ring, ring[0]])
                if (ay > y) != (by > y) and ax + (y - ay) / (by - ay) * (bx - ax) > x
            ]
            if len(above) % 2:
                return shape.paint.fill
    return ""


def test_the_platform_at_equal_times_with_the_same_numbers_everywhere() -> None:
    figure = the_loop().figure(the_curves())
    shown = words(figure)
    assert {"1", "2", "3", "4", "5"} <= set(shown)
    assert [shown.count(k) for k in "234"] == [3, 3, 3]
    groups = [shape for shape in figure.scene.shapes if isinstance(shape, Group)]
    names = [group.name for group in groups if group.name.startswith("time")]
    assert names == ["time 2", "time 3", "time 4"]
    rings = [lines(group)[0] for group in groups if group.name in ("time 2", "platform")]
    sides = [[distance(a, b) for a, b in pairwise([*ring, ring[0]])] for ring in rings]
    assert sides[0] == pytest.approx(sides[1])
    bare = words(the_loop().figure())
    assert "1 to 5: equal times" in bare
    assert "1 to 5: equal times; circles: cusps" in shown


@pytest.mark.long
@pytest.mark.parametrize("leg", [2, 3])
def test_loops_of_other_legs(leg: int) -> None:
    loop = cusp_loop(INNOCENTI, 16, 1, fixed_leg=leg, samples=21)
    check(loop_figure(loop.to_json(), singular_curves(INNOCENTI, 16, fixed_leg=leg).to_json()))


def test_a_path_between_poses_of_other_legs_and_of_given_angles() -> None:
    start = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
    path = pose_path(INNOCENTI, start, {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}, samples=21)
    assert isinstance(path, PosePath)
    figure = loop_figure(path.to_json())
    check(figure)
    assert {"1: pose 1", "5: the end", "L2", "L3"} <= set(words(figure))
    assert repr(figure) == "<Figure 'Path at L1 = 27 to 28: from pose 1 to the end'>"


def test_the_motion_has_the_times_of_a_motion_within_limits() -> None:
    """Between the frames of the picture as much time passes as the legs need."""
    motion = {"speed": 10, "acceleration": {"l2": 1, "l3": 20}}
    slow = the_loop().resampled(motion=motion, sampling={"chord": "0.1"})
    figure = loop_figure(slow.to_json())
    check(figure)
    groups = [shape for shape in every(figure.scene.shapes) if isinstance(shape, Group)]
    [point] = [group.motion for group in groups if group.name == "leg lengths"]
    assert point is not None
    assert len(point.places) == 2 * (37 + 6)
    plan = slow.resampled(37, motion=motion)
    ways = [abs(float(b.lengths[1]) - float(a.lengths[1])) for a, b in pairwise(plan.samples)]
    drawn = [abs(b[0] - a[0]) for a, b in pairwise(point.places[:37])]
    scale = sum(drawn) / sum(ways)
    assert drawn == pytest.approx([scale * way for way in ways], abs=0.05 * max(drawn))
