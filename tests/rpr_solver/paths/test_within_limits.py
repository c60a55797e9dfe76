"""Paths that keep joint limits, against a search on a grid and against their own samples.

The search among boxes: a way stays in allowed boxes, and its corners are near each other.
"""

from __future__ import annotations

from fractions import Fraction
from math import radians
from random import Random

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    cusp_loop,
    joint_path,
    pose_connections,
)
from rpr_solver.model.lengths import Bounds
from rpr_solver.paths import search
from service.schemas.motions import Path as PathDocument
from tests.rpr_solver.paths.test_joint_paths import a_pair, joined_on_a_grid
from tests.support.motions import Mover, arrives
from tests.support.sampling import long, sample

FIRST = EXAMPLES["innocenti"]
Limits = dict[int, Bounds]


def keeps(path: Path, limits: Limits, count: int = 100) -> bool:
    """Whether samples keep the limits."""
    return all(
        (low is None or low <= Fraction(sample.lengths[leg - 1]))
        and (high is None or Fraction(sample.lengths[leg - 1]) <= high)
        for leg, (low, high) in limits.items()
        for sample in path.resampled(count).samples
    )


@pytest.mark.parametrize(
    ("poses", "limits", "obstacle"),
    [
        ((1, 2), {2: (Fraction(5), Fraction(21))}, Obstacle.SEPARATED_BY_LIMITS),
        ((3, 4), {2: (Fraction(5), Fraction(21))}, None),
        ((1, 2), {2: (Fraction(21), None)}, Obstacle.OUTSIDE_LIMITS),
        ((1, 3), {2: (Fraction(5), Fraction(21))}, Obstacle.OPPOSITE_SIGNS),
        # the joint vector lies on a limit
        ((3, 4), {2: (None, Fraction(20))}, None),
        ((1, 2), {2: (None, Fraction(20))}, Obstacle.SEPARATED_BY_LIMITS),
    ],
)
def test_two_poses_within_limits(poses: tuple[int, int], limits: Limits, obstacle: Obstacle | None) -> None:
    found = joint_path(FIRST, 27, 20, 20, *poses, limits=limits, samples=2)
    if isinstance(found, Path):
        assert obstacle is None
        assert keeps(found, limits)
        assert found.to_json()["limits"] == found.reversed().to_json()["limits"] is not None
    else:
        assert found.obstacle is obstacle
        assert (found.resolution is not None) is (obstacle is Obstacle.SEPARATED_BY_LIMITS)


def detour(random: Random) -> tuple[Manipulator, tuple[Fraction, ...], int, int, int, Limits]:
    """A random pair of poses of one sign with random limits of the free legs."""
    while (pair := a_pair(random)) is None:
        pass
    manipulator, lengths, leg, start, stop = pair
    limits: Limits = {
        free: (
            round(length * Fraction(random.uniform(0.1, 0.95)), 2),
            round(length * Fraction(random.uniform(1.05, 2.5)), 2),
        )
        for free, length in enumerate(lengths, 1)
        if free != leg
    }
    return manipulator, lengths, leg, start, stop, limits


def agrees(random: Random) -> str:
    """What a random pair gives, having compared it with a grid."""
    manipulator, (l1, l2, l3), leg, start, stop, limits = detour(random)
    found = joint_path(manipulator, l1, l2, l3, start, stop, fixed_leg=leg, limits=limits, samples=2)
    length = float((l1, l2, l3)[leg - 1])
    if isinstance(found, Path):
        assert keeps(found, limits, 1000)
        # where a path comes near to J = 0, a pose is followed in floats by short steps alone
        assert min(arrives(found, count) for count in (600, 5000)) < 1e-6
        return "path"
    if found.obstacle is not Obstacle.UNDECIDED:
        assert not joined_on_a_grid(found, [length], limits)
    return str(found.obstacle)


def test_a_random_pair_agrees_with_a_grid() -> None:
    assert agrees(Random(4)) in ("path", "separated-by-limits")


@pytest.mark.long
def test_a_hundred_random_pairs_agree_with_a_grid() -> None:
    random = Random(8)
    outcomes = [agrees(random) for _ in range(100)]
    assert outcomes.count("path") > 20
    assert outcomes.count("separated-by-limits") > 20
    assert outcomes.count("undecided") < 5


def test_another_way_is_found_where_the_shortest_exceeds_the_limits() -> None:

    manipulator, (l1, l2, l3), leg, start, stop, limits = detour(Random(19))
    free = joint_path(manipulator, l1, l2, l3, start, stop, fixed_leg=leg, samples=2)
    within = joint_path(manipulator, l1, l2, l3, start, stop, fixed_leg=leg, limits=limits, samples=2)
    assert isinstance(free, Path)
    assert isinstance(within, Path)
    assert not keeps(free, limits)
    assert keeps(within, limits)


def test_the_fixed_leg_keeps_its_limits_too() -> None:
    island = (FIRST, 27, "25.7", "9.2", 2, 4)
    limits = {1: (Fraction(27), Fraction(30)), 2: (Fraction(1), Fraction(100))}
    free = joint_path(*island, between=(20, 30), samples=2, limits=limits)
    assert isinstance(free, Path)
    assert keeps(free, limits)
    held = joint_path(*island, between=(20, 30), limits={"l1": (27, 28)})
    assert isinstance(held, NoPath)
    assert held.obstacle is Obstacle.OTHER_ASPECT


@pytest.mark.parametrize("limits", [{2: (Fraction(8), Fraction(20))}, {2: (Fraction(12), Fraction(14))}])
def test_a_loop_keeps_the_limits(limits: Limits) -> None:
    loop = cusp_loop(FIRST, 27, "B", limits=limits, samples=2)
    assert not keeps(cusp_loop(FIRST, 27, "B", samples=2), limits)
    assert keeps(loop, limits)
    assert loop.winding == 1


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"l2": (13, 20)}, "limits.l2: exclude cusp 2"),
        ({"l1": (28, None)}, "limits.l1: exclude the slice L1 = 27"),
        ({"l2": (20, 8)}, "limits.l2.max: is 8"),
    ],
)
def test_limits_that_exclude_the_cusp_are_refused(limits: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        cusp_loop(FIRST, 27, "B", limits=limits)  # type: ignore[arg-type]


def test_an_answer_that_stays_undecided_says_near_which_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_LEVELS", {2: (6, 7)})
    found = joint_path(FIRST, 27, 20, 20, 1, 2, limits={"l2": (None, "26.3438")})
    assert isinstance(found, NoPath)
    assert found.obstacle is Obstacle.UNDECIDED
    document = found.to_json()
    assert PathDocument.model_validate(document).model_dump(exclude_unset=True, by_alias=True) == document
    near = {name: float(text) for name, text in document["near_pose"].items()}
    assert near["l1"] == 27
    lengths = Mover.of(FIRST).legs(radians(near["alpha_deg"]), radians(near["theta1_deg"]), near["l1"])
    assert lengths[1] == pytest.approx(26.3438, rel=0.1)
    table = pose_connections(FIRST, 27, 20, 20, limits={"l2": (None, "26.3438")}).to_json()
    assert table["undecided"] == [{"poses": [1, 2], "near": document["near_pose"]}]
    monkeypatch.undo()
    decided = joint_path(FIRST, 27, 20, 20, 1, 2, limits={"l2": (None, 21)}).to_json()
    assert (decided["obstacle"], "near_pose" in decided) == ("separated-by-limits", False)


HOME = Manipulator("16.1", "6.8", "12.5", "19.5", "15.1", "18.4", "cw"), ("22.2", "30.2", "24.88"), 3, 2


@pytest.mark.parametrize("room", sample([0, Fraction(1, 10**9), Fraction(1, 10**5), Fraction(1, 100)], 1))
def test_a_pose_just_inside_a_limit_keeps_the_path_that_the_limit_itself_has(room: Fraction) -> None:
    manipulator, lengths, start, stop = HOME
    limits: Limits = {2: (Fraction("30.2") - room, Fraction("43.9"))}
    found = joint_path(manipulator, *lengths, start, stop, fixed_leg=3, samples=2, limits=limits)
    assert isinstance(found, Path)
    assert keeps(found, limits)


def test_an_end_just_inside_a_limit_leaves_it_inwards() -> None:
    """What is not decided from the pose itself is decided from one farther inside."""
    manipulator = Manipulator("27.7", "22.9", "19.1", "14.8", "13.9", "8", "cw")
    for room in (Fraction(0), Fraction(1, 10**30)):
        limits: Limits = {2: (None, Fraction("35.87") + room), 3: (None, Fraction("33.19") + room)}
        found = joint_path(manipulator, "10.8", "35.87", "33.19", 3, 1, samples=2, limits=limits)
        assert isinstance(found, Path), room
        assert keeps(found, limits)


def loosened(random: Random) -> list[str]:
    """What a random question gives, its limits just at the ends at first, then wider step by step."""
    while (pair := a_pair(random)) is None:
        pass
    manipulator, lengths, leg, start, stop = pair
    wide = {k: Fraction(random.randint(110, 250), 100) for k in {1, 2, 3} - {leg}}
    is_minimum = random.random() < 0.5
    answers = []
    for room in (0, Fraction(1, 10**7), Fraction(1, 10**4), Fraction(1, 100), Fraction(1, 10)):
        limits: Limits = {}
        for k, most in wide.items():
            length, inner, outer = lengths[k - 1], 1 - room, most + room
            limits[k] = (length * inner, length * outer) if is_minimum else (None, length * (1 + room))
        found = joint_path(manipulator, *lengths, start, stop, fixed_leg=leg, limits=limits, samples=2)
        answers.append("path" if isinstance(found, Path) else str(found.obstacle))
    return answers


def never_loses(answers: list[str]) -> bool:
    """Whether every answer after a path is one."""
    return "path" not in answers or set(answers[answers.index("path") :]) == {"path"}


def test_looser_limits_keep_a_path() -> None:
    answers = loosened(Random(11))
    assert answers[0] == "path"
    assert never_loses(answers)


@pytest.mark.long
def test_looser_limits_keep_a_path_in_200_questions() -> None:
    random = Random(6)
    steps = [loosened(random) for _ in range(200)]
    assert [answers for answers in steps if not never_loses(answers)] == []
    assert sum("path" in answers for answers in steps) > 60


@pytest.mark.parametrize(
    ("between", "most"), [long(("1", "1000"), "20.00000001"), (("1e-200", "1e200"), "20." + "0" * 29 + "1")]
)
def test_a_wide_range_with_an_end_beside_a_limit_is_undecided(between: tuple[str, str], most: str) -> None:
    """Boxes of the range are wide, and cannot tell the pose from the limit."""
    path = joint_path(FIRST, 27, 20, 20, 1, 2, between=between, limits={"l2": (None, most)})
    assert isinstance(path, NoPath)
    assert path.obstacle is Obstacle.UNDECIDED


@pytest.mark.parametrize("between", [None, (20, 30)])
def test_limits_that_hold_the_fixed_leg(between: tuple[int, int] | None) -> None:
    held = joint_path(FIRST, 27, 20, 20, 3, 4, between=between, limits={1: (27, 27)}, samples=2)
    assert isinstance(held, Path)
    assert {sample.lengths[0] for sample in held.resampled(9).samples} == {"27.0000000000000"}
    apart = joint_path(FIRST, 27, "25.7", "9.2", 2, 4, between=(27, 30), limits={1: (27, 27)})
    assert isinstance(apart, NoPath)
    assert apart.obstacle is Obstacle.OTHER_ASPECT
    outside = joint_path(FIRST, 27, 20, 20, 3, 4, limits={1: (28, 28)})
    assert isinstance(outside, NoPath)
    assert outside.obstacle is Obstacle.OUTSIDE_LIMITS
