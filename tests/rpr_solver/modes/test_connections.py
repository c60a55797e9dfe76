"""Pose connections against the paths of each pair, and what a table of connections must be."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import combinations, product
from random import Random
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Obstacle,
    PoseConnections,
    SolverError,
    pose_connections,
    pose_path,
)
from tests.support.families import FAMILIES, family
from tests.support.motions import Mover
from tests.support.sampling import long

FIRST = EXAMPLES["innocenti"]
UNDECIDED = Obstacle.UNDECIDED


def sound(found: PoseConnections) -> None:
    """The matrix is symmetric, being joined is transitive, and groups are its classes."""
    matrix, places = found.matrix, range(len(found.poses))
    assert [len(row) for row in matrix] == [len(found.poses)] * len(found.poses)
    joined = {(i, k) for i, k in product(places, places) if matrix[i][k] is None}
    for i, k in product(places, places):
        assert matrix[i][k] is matrix[k][i]
        for m in places:
            # those that are joined are joined with the same, and apart from the same for the same reason
            assert (i, k) not in joined or matrix[i][m] is matrix[k][m]
    assert {(i - 1, k - 1) for group in found.groups for i, k in product(group, group)} == joined


def compared(found: PoseConnections, **options: Any) -> Counter[str]:
    """Each pair of regular poses with the answer about its path; what was found."""
    sound(found)
    words: Counter[str] = Counter()
    table = [{f"l{leg}": x for leg, x in enumerate(lengths, 1)} for lengths in found.lengths]
    seconds = [pose.lengths is not None and pose.lengths == found.poses[-1].lengths for pose in found.poses]
    ends = [
        {**table[int(second)], "pose": pose.number} for second, pose in zip(seconds, found.poses, strict=True)
    ]
    for i, k in combinations(range(len(ends)), 2):
        own = found.matrix[i][k]
        words[own or "joined"] += 1
        if own is Obstacle.SINGULAR_POSE:
            with pytest.raises(InputError, match="a singular pose"):
                pose_path(found.manipulator, ends[i], ends[k], samples=2, **options)
            continue
        try:
            path = pose_path(found.manipulator, ends[i], ends[k], samples=2, **options)
        except SolverError:
            words["unproved"] += 1
            continue
        expected = None if path else path.obstacle
        # a pair may be decided by others, and never less than alone
        assert own is expected or expected is UNDECIDED, (i, k)
    return words


def test_limits_separate_poses_of_one_aspect() -> None:
    assert pose_connections(FIRST, 27, 20, 20).groups == ((1, 2), (3, 4))
    found = pose_connections(FIRST, 27, 20, 20, limits={"l2": (5, 21)})
    assert found.matrix[0] == (None, "separated-by-limits", "opposite-signs", "opposite-signs")
    assert (found.groups, found.signs) == (((1,), (2,), (3, 4)), (-1, -1, 1, 1))
    assert found.resolution is not None
    assert found.resolution.angle_deg <= Fraction(45, 16)


@pytest.mark.parametrize(
    ("lengths", "options", "words"),
    [
        ((27, "25.7", "9.2"), {}, {"joined", "opposite-signs", "other-aspect"}),
        ((27, "25.7", "9.2"), {"between": (27, 30)}, {"joined", "opposite-signs"}),
        ((27, 20, 20), {"limits": {"l2": (5, 21)}}, {"joined", "opposite-signs", "separated-by-limits"}),
        long((27, 20, 20), {"limits": {"l3": (20, "20.5")}}, {"opposite-signs", "separated-by-limits"}),
        ((27, 20, 20), {"limits": {"l1": (28, 30)}, "between": (26, 30)}, {"outside-limits"}),
        ((20, 27, 20), {"fixed_leg": 2, "limits": {1: (5, 25)}}, {"opposite-signs"}),
    ],
)
def test_each_pair_is_answered_as_its_path(
    lengths: tuple[Any, Any, Any], options: dict[str, Any], words: set[str]
) -> None:
    found = compared(pose_connections(FIRST, *lengths, **options), **options)
    assert set(found) == words


def test_two_joint_vectors_of_a_range() -> None:
    found = pose_connections(FIRST, 27, 20, 20, to=(30, 21, 19), limits={"l2": (5, 22)})
    assert found.groups == ((1, 5), (2,), (3, 4, 6))
    assert [pose.lengths for pose in found.poses[3:5]] == [("27", "20", "20"), ("30", "21", "19")]
    assert found.between == (27, 30)
    document = found.to_json()
    assert "l1" not in document
    assert document["poses"][4]["l1"] == "30"
    sound(found)


@pytest.mark.long
def test_each_pair_of_two_joint_vectors_is_answered_as_its_path() -> None:
    compared(pose_connections(FIRST, 27, 20, 20, to=(30, 21, 19)))


def test_a_singular_pose_is_joined_with_none() -> None:
    m = Manipulator(8, 0, 6, 4, 3, 5)
    found = pose_connections(m, 4, 8, 3)
    assert found.signs.count(0) == 1
    place = found.signs.index(0)
    assert set(found.matrix[place]) == {"singular-pose"}
    assert all(place + 1 not in group for group in found.groups)
    compared(found)


def test_no_poses_make_an_empty_table() -> None:
    found = pose_connections(FIRST, 27, 200, 2)
    assert (found.matrix, found.groups, found.to_json()["matrix"]) == ((), (), [])


@pytest.mark.parametrize(
    ("options", "fields"),
    [
        ({"to": (27, 20, 20)}, ["to"]),
        ({"to": (27, 20)}, ["to"]),
        ({"to": "27"}, ["to"]),
        ({"to": (27, 0, "x")}, ["to.l2", "to.l3"]),
        ({"between": (28, 30)}, ["between"]),
        ({"limits": {"l2": (5, 4)}}, ["limits.l2.max"]),
        ({"fixed_leg": 4}, ["fixed_leg"]),
    ],
)
def test_bad_input(options: dict[str, Any], fields: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        pose_connections(FIRST, 27, 20, 20, **options)
    assert [problem.field for problem in caught.value.problems] == fields


def random_tables(count: int, seed: int) -> Counter[str]:
    """What became of the pairs of poses of so many random joint vectors."""
    random, found = Random(seed), Counter[str]()
    manipulators = (*EXAMPLES.values(), *(family(name) for name in FAMILIES if "flat" not in name))
    for _ in range(count):
        m, leg = random.choice(manipulators), random.choice([1, 2, 3])
        length = random.uniform(0.1, 1.5) * (float(m.d1) + float(m.d2))
        lengths = [
            f"{x:.3f}" for x in Mover.of(m, leg).legs(random.uniform(0, 6), random.uniform(0, 6), length)
        ]
        options: dict[str, Any] = {"fixed_leg": leg}
        if random.random() < 0.5:
            own = lengths[leg % 3]
            room = random.choice([0.02, 0.1, 0.5]) * float(own)
            options["limits"] = {leg % 3 + 1: (f"{float(own) - room:.3f}", f"{float(own) + room:.3f}")}
        if random.random() < 0.3:
            options["between"] = (lengths[leg - 1], f"{1.2 * float(lengths[leg - 1]):.3f}")
        try:
            table = pose_connections(m, *lengths, **options)
        except (InputError, SolverError) as error:
            found[type(error).__name__] += 1
            continue
        found += compared(table, **options)
    return found


def test_few_random_tables_agree_with_paths() -> None:
    found = random_tables(4, 35)
    assert {"joined", "opposite-signs", "other-aspect", "separated-by-limits"} <= {*found}


@pytest.mark.long
def test_100_random_tables_agree_with_paths() -> None:
    found = random_tables(100, 1)
    assert found["undecided"] <= 0.05 * found.total(), found


@pytest.mark.parametrize("option", ["samples", "motion"])
def test_options_of_one_path_are_refused(option: str) -> None:
    with pytest.raises(InputError, match=f"{option}: is an option of one path; leave it out"):
        pose_connections(FIRST, 27, 20, 20, **{option: 2})  # type: ignore[arg-type]
