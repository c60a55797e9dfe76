"""Aspects by cells, against the solver's, which follow from the singular curve."""

from __future__ import annotations

import random
from collections import Counter
from fractions import Fraction
from itertools import combinations

import pytest
from flint import ctx

from rpr_solver import EXAMPLES, Manipulator, joint_path, pose_connections, singular_curves
from rpr_solver.verify_by_boxes.aspects import are_joined, number_of_aspects
from rpr_solver.verify_by_boxes.claims import OpenError
from rpr_solver.verify_by_boxes.equations import Mechanism, Slice
from rpr_solver.verify_by_boxes.finding import poses_of
from rpr_solver.verify_by_boxes.geometry import Geometry
from rpr_solver.verify_by_boxes.path_ends import in_order
from rpr_solver.verify_by_boxes.work import Work
from tests.rpr_solver.long_run import manipulator
from tests.support.families import family

INNOCENTI = EXAMPLES["innocenti"]


def slice_of(manipulator: Manipulator, length: Fraction | int | str, fixed: int = 1) -> Slice:
    geometry = Geometry.read(manipulator.to_json(), "")
    return Slice(Mechanism(geometry, fixed), Fraction(length))


@pytest.mark.parametrize("length", ["9", "26.7863", "26.7864", "27", "28.0948", "28.1"])
def test_they_are_as_many_as_the_solver_finds_on_both_sides_of_transitions(length: str) -> None:
    found = Counter(aspect.sign for aspect in singular_curves(INNOCENTI, length).aspects)
    assert number_of_aspects([slice_of(INNOCENTI, length)], Work(0)) == found


def test_they_are_as_many_in_random_slices() -> None:
    draw = random.Random(3)
    for _ in range(8):
        m, leg, length = manipulator(draw), draw.choice([1, 2, 3]), Fraction(draw.randint(10, 300), 10)
        found = Counter(aspect.sign for aspect in singular_curves(m, length, fixed_leg=leg).aspects)
        assert number_of_aspects([slice_of(m, length, leg)], Work(0)) == found


def test_at_nodes_they_stay_open() -> None:
    with pytest.raises(OpenError):
        number_of_aspects([slice_of(family("similar"), 10)], Work(0))


def test_work_is_bounded() -> None:
    work = Work(0)
    work.spend(work.left)
    with pytest.raises(OpenError):
        number_of_aspects([slice_of(INNOCENTI, 27)], work)


@pytest.mark.parametrize("between", [(27,), (27, 29), (27, 30)])
def test_poses_share_one_if_the_solver_joins_them(between: tuple[int, ...]) -> None:
    legs, slices = (27, "25.7", "9.2"), [slice_of(INNOCENTI, length) for length in between]
    squares = [Fraction(x) ** 2 for x in legs[1:]]
    with ctx.workprec(96):
        zeros = in_order(poses_of(slices[0].mechanism, Fraction(27), squares, Work(0)).zeros, 0)
        poses = [zero.within(60) for zero in zeros]
        signs = [1 if slices[0].on(pose, 0).singular.value > 0 else -1 for pose in poses]
    span = between if len(between) > 1 else None
    joined = pose_connections(INNOCENTI, *legs, between=span).groups
    for i, k in combinations(range(4), 2):
        if signs[i] == signs[k]:
            together = any({i + 1, k + 1} <= set(group) for group in joined)
            assert are_joined(slices, signs[i], (0, poses[i]), (0, poses[k]), Work(0)) is together


def test_a_path_that_the_solver_finds_is_in_one_aspect() -> None:
    path = joint_path(INNOCENTI, 27, 20, 20, 1, 2, samples=2)
    with ctx.workprec(96):
        zeros = in_order(
            poses_of(slice_of(INNOCENTI, 27).mechanism, Fraction(27), [Fraction(400)] * 2, Work(0)).zeros, 0
        )
        nodes = [(0, zero.within(60)) for zero in zeros[:2]]
        assert are_joined([slice_of(INNOCENTI, 27)], path.sign, *nodes, Work(0))  # type: ignore[union-attr]
