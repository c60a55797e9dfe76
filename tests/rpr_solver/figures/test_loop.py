"""A loop round a cusp: joint space, the torus, the mechanism; the same times in all three."""

from functools import cache

import numpy as np
import pytest

from rpr_solver import EXAMPLES, SingularCurves, cusp_loop, pose_path, singular_curves
from rpr_solver import Path as PosePath
from rpr_solver.figures.loop import _Course, loop_figure
from rpr_solver.figures.strands import SliceCurves
from tests.support.pictures import STYLES, check, sheet_of, words
from tests.support.sampling import sample

INNOCENTI = EXAMPLES["innocenti"]


@cache
def the_loop() -> PosePath:
    return cusp_loop(INNOCENTI, 27, "B")


@cache
def the_curves() -> SingularCurves:
    return singular_curves(INNOCENTI, 27)


@pytest.mark.parametrize("style", sample(STYLES, 1))
def test_a_loop_with_the_curves_round_it(style: object) -> None:
    figure = loop_figure(the_loop().to_json(), the_curves().to_json())
    check(figure.styled(style))  # type: ignore[arg-type]
    start, stop = the_loop().start.number, the_loop().stop.number
    assert {"B", "A1", "A2", "A3", f"1: pose {start}", f"5: pose {stop}", "L2", "L3"} <= set(words(figure))
    assert {"θ1 [°]", "α [°]", "1, 5"} <= set(words(figure))


def test_the_path_crosses_no_curve_on_the_torus() -> None:
    curves, course = SliceCurves.of(the_curves().to_json()), _Course.of(the_loop().to_json())
    value, _, _ = curves.floats.singular(course.angles[:, ::-1])
    assert len(set(np.sign(value))) == 1


def test_the_platform_at_equal_times_with_the_same_numbers_everywhere() -> None:
    figure = the_loop().figure(the_curves())
    shown = words(figure)
    assert {"1", "2", "3", "4", "5"} <= set(shown)
    assert [shown.count(k) for k in "234"] == [3, 3, 3]
    [ax] = sheet_of(figure).axes
    rings = [patch.get_xy() for patch in ax.child_axes[2].patches]
    sides = [np.sort(np.hypot(*np.diff(ring, axis=0).T)) for ring in rings if len(ring) == 4]
    assert sum(own == pytest.approx(sides[0]) for own in sides) == 5
    assert "1 to 5: equal times" in words(the_loop().figure())
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


def test_a_path_with_times_of_its_own_is_drawn_at_equal_ones() -> None:
    """Between the samples of the picture as much time passes as the legs need."""
    motion = {"speed": 10, "acceleration": {"l2": 1, "l3": 20}}
    slow = the_loop().resampled(motion=motion, sampling={"chord": "0.1"})
    check(loop_figure(slow.to_json()))
    drawn = _Course.of(slow.to_json()).joints[:, 0]
    plan = [float(sample.lengths[1]) for sample in slow.resampled(37, motion=motion).samples]
    assert drawn == pytest.approx(plan, abs=0.02 * (max(plan) - min(plan)))
