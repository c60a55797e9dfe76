"""Paths between any two poses: of two joint vectors, or given by their angles."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import degrees
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, InputError, NoPath, Obstacle, Path, joint_path, pose_path
from tests.support.motions import Mover, angles_of, apart, legs_of
from tests.support.strategies import examples

FIRST = EXAMPLES["innocenti"]
MOVER = Mover.of(FIRST)


def joint(l1: object, l2: object, l3: object, pose: int) -> dict[str, Any]:
    return {"l1": l1, "l2": l2, "l3": l3, "pose": pose}


def given_pose(alpha: object, theta: object, l1: object) -> dict[str, Any]:
    return {"alpha_deg": alpha, "theta1_deg": theta, "l1": l1}


HERE = joint(27, 20, 20, 1)
ISLAND = joint(27, "25.7", "9.2", 2)


def follows(path: Path) -> bool:
    """Whether the samples of a path are poses of their legs, near one another, with one sign of J."""
    many = path.resampled(301).samples
    for sample in many:
        alpha, theta = angles_of(sample)
        legs = legs_of(sample)
        assert MOVER.legs(alpha, theta, legs[0]) == pytest.approx(legs, rel=1e-9)
        assert MOVER.determinant(alpha, theta, legs[0]) * path.sign > 0
    return all(apart(angles_of(x), angles_of(y)) < 0.2 for x, y in pairwise(many))


@pytest.mark.parametrize(
    ("start", "stop", "options"),
    [
        (HERE, joint(27, 21, 19, 2), {}),
        (HERE, joint(30, 21, 19, 1), {}),
        (HERE, given_pose(-40, 140, 27), {}),
        (given_pose(-40, 140, 27), given_pose("-50.5", 100, 30), {"between": (20, 40)}),
        (given_pose(-40, 140, 27), given_pose("-50.5", 100, 27), {"limits": {"l2": (1, 60)}}),
        (given_pose(320, 500, 27), joint(24, 20, 20, 1), {}),
    ],
)
def test_two_poses_are_joined(start: dict[str, Any], stop: dict[str, Any], options: dict[str, Any]) -> None:
    path = pose_path(FIRST, start, stop, samples=3, **options)
    assert isinstance(path, Path)
    assert follows(path)
    document = path.to_json()
    assert (document["closed"], path.lengths, "l1" in document) == (False, None, False)
    for end, asked, sample in (("from", start, path.samples[0]), ("to", stop, path.samples[-1])):
        assert document[end]["pose"] == asked.get("pose")
        assert Fraction(document[end]["l1"]) == Fraction(asked["l1"])
        assert apart(angles_of(sample), angles_of(path.start if end == "from" else path.stop)) < 1e-12
        if "alpha_deg" in asked:
            turns = (degrees(angles_of(sample)[0]) - float(asked["alpha_deg"])) / 360
            assert turns == pytest.approx(round(turns), abs=1e-9)
    assert path.reversed().start == path.stop


def test_two_poses_of_one_joint_vector_are_the_usual_question() -> None:
    path = pose_path(FIRST, HERE, joint(27, "20.0", 20, 2), samples=5)
    assert path.to_json() == joint_path(FIRST, 27, 20, 20, 1, 2, samples=5).to_json()


@pytest.mark.parametrize(
    ("start", "stop", "options", "obstacle"),
    [
        (HERE, joint(30, 21, 19, 2), {}, Obstacle.OPPOSITE_SIGNS),
        (ISLAND, joint(27, 20, 20, 4), {}, Obstacle.OTHER_ASPECT),
        (HERE, given_pose("-50.5", 100, 27), {"limits": {"l2": (20, 35)}}, Obstacle.OUTSIDE_LIMITS),
        (HERE, given_pose(-40, 140, 27), {"limits": {"l1": (28, 35)}}, Obstacle.OUTSIDE_LIMITS),
        (HERE, joint(27, 21, 19, 2), {"limits": {"l2": (20, 26)}}, Obstacle.SEPARATED_BY_LIMITS),
    ],
)
def test_the_reason_is_proved_where_they_are_not(
    start: dict[str, Any], stop: dict[str, Any], options: dict[str, Any], obstacle: Obstacle
) -> None:
    none = pose_path(FIRST, start, stop, **options)
    assert isinstance(none, NoPath)
    assert (none.obstacle, none.to_json()["connected"]) == (obstacle, False)


def test_another_aspect_of_two_slices_comes_with_a_range_that_joins() -> None:
    none = pose_path(FIRST, ISLAND, joint(28, 20, 20, 4))
    assert isinstance(none, NoPath)
    assert (none.obstacle, none.between) == (Obstacle.OTHER_ASPECT, (27, 28))
    assert none.connecting is not None
    assert none.connecting[0] == 27 < 28 < none.connecting[1]
    joined = pose_path(FIRST, ISLAND, joint(28, 20, 20, 4), between=none.connecting, samples=2)
    assert isinstance(joined, Path)


def test_the_other_poses_are_followed_on_closed_paths_only() -> None:
    path = pose_path(FIRST, HERE, joint(27, 21, 19, 2), samples=2)
    assert isinstance(path, Path)
    with pytest.raises(InputError, match="others: are followed on paths that come back"):
        path.with_others()


@pytest.mark.parametrize(
    ("start", "stop", "options", "message"),
    [
        (HERE, HERE, {}, "stop: is pose 1"),
        (given_pose(10, 20, 27), given_pose(370, 20, 27), {}, "stop: is a given pose"),
        (joint(27, 20, 20, 5), HERE, {}, "start.pose: is 5; give the number of a pose, 1 to 4"),
        (HERE, joint(27, 200, 20, 1), {}, "stop.pose: is a pose of a joint vector that has none"),
        (HERE, joint(27, 0, 20, 1), {}, "stop.l2"),
        (HERE, given_pose("x", 20, 27), {}, "stop.alpha_deg"),
        (HERE, {"pose": 1}, {}, "stop: is .*give l1, l2, l3 and pose, or alpha_deg, theta1_deg, l1"),
        (
            HERE,
            joint(30, 20, 20, 1),
            {"between": (27, 29)},
            "between: is 27 to 29; it must hold l1 = 27 and 30",
        ),
        (HERE, given_pose(0, 0, 27), {"fixed_leg": 2}, "stop: .*give .* alpha_deg, theta2_deg, l2"),
    ],
)
def test_each_part_at_fault_is_named(
    start: dict[str, Any], stop: dict[str, Any], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        pose_path(FIRST, start, stop, **options)


def test_a_singular_pose_is_refused() -> None:
    flat = EXAMPLES["zein-flat"]
    with pytest.raises(InputError, match="stop: is a singular pose"):
        pose_path(flat, given_pose(40, 140, 20), given_pose(0, 0, 20))


@settings(examples(24), deadline=None)
@given(
    st.tuples(*[st.integers(-1800, 1800)] * 4),
    st.sampled_from([(27, 27), (24, 31)]),
)
def test_a_path_or_another_sign_is_found_for_any_poses(angles: tuple[int, ...], l1: tuple[int, int]) -> None:
    ends = [
        given_pose(Fraction(a, 10), Fraction(t, 10), x)
        for a, t, x in ((angles[0], angles[1], l1[0]), (angles[2], angles[3], l1[1]))
    ]
    if ends[0] == ends[1]:
        return
    signs = [
        MOVER.determinant(*(float(e[k]) * 0.017453292519943295 for k in ("alpha_deg", "theta1_deg")), e["l1"])
        for e in ends
    ]
    if min(map(abs, signs)) < 0.5:
        return
    answer = pose_path(FIRST, *ends, samples=2)
    if signs[0] * signs[1] < 0:
        assert isinstance(answer, NoPath)
        assert answer.obstacle is Obstacle.OPPOSITE_SIGNS
    elif isinstance(answer, Path):
        assert follows(answer)
    else:
        assert answer.obstacle is Obstacle.OTHER_ASPECT
