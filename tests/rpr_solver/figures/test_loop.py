"""A loop in motion: it runs there and back, from pose to pose, and rests where motion is not wanted."""

from itertools import pairwise

import pytest

from rpr_solver import EXAMPLES, Path, cusp_loop, pose_path, singular_curves
from rpr_solver.figures.loop import loop_figure
from rpr_solver.notebook.scene import Group
from tests.support.pictures import check, every, words

INNOCENTI = EXAMPLES["innocenti"]
LOOP = cusp_loop(INNOCENTI, 27, "B")
CURVES = singular_curves(INNOCENTI, 27)


def test_a_loop_with_the_curves_round_it() -> None:
    figure = loop_figure(LOOP.to_json(), CURVES.to_json())
    check(figure)
    start, stop = LOOP.start.number, LOOP.stop.number
    assert {"B", "A1", "A2", "A3", f"pose {start}", f"pose {stop}", "L2", "L3"} <= set(words(figure))
    assert "prefers-reduced-motion" in figure.svg()


def test_everything_moves_in_step_and_comes_back() -> None:
    groups = [shape for shape in every(loop_figure(LOOP.to_json()).scene.shapes) if isinstance(shape, Group)]
    motions = [group.motion for group in groups if group.motion is not None]
    assert len(motions) == 9
    assert len({(len(motion.places), motion.seconds) for motion in motions}) == 1
    for motion in motions:
        assert motion.places[0] == motion.places[-1]
        turns = [place[2] for place in motion.places]
        assert max(abs(a - b) for a, b in pairwise(turns)) < 90


@pytest.mark.long
@pytest.mark.parametrize("leg", [2, 3])
def test_loops_of_other_legs(leg: int) -> None:
    loop = cusp_loop(INNOCENTI, 16, 1, fixed_leg=leg, samples=21)
    check(loop_figure(loop.to_json(), singular_curves(INNOCENTI, 16, fixed_leg=leg).to_json()))


def test_a_path_between_poses_of_other_legs_and_of_given_angles() -> None:
    start = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
    path = pose_path(INNOCENTI, start, {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}, samples=21)
    assert isinstance(path, Path)
    figure = loop_figure(path.to_json())
    check(figure)
    assert {"pose 1", "the end", "L2", "L3"} <= set(words(figure))
    assert repr(figure) == "<Figure 'Path at L1 = 27 to 28: from pose 1 to the end'>"


def test_the_motion_has_the_times_of_a_motion_within_limits() -> None:
    """Between the frames of the picture as much time passes as the legs need."""
    motion = {"speed": 10, "acceleration": {"l2": 1, "l3": 20}}
    slow = LOOP.resampled(motion=motion, sampling={"chord": "0.1"})
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
