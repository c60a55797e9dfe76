"""Poses along a leg, against direct kinematics."""

from __future__ import annotations

from cmath import rect
from collections.abc import Mapping
from fractions import Fraction
from math import radians

import pytest

from rpr_solver import EXAMPLES, EndKind, InputError, Manipulator, leg_poses, poses
from tests.rpr_solver.along.long_run import failures, machine
from tests.support.sampling import sample

M = EXAMPLES["innocenti"]
EQUILATERAL = Manipulator(base={"equilateral": 10}, platform={"equilateral": 5})
CONGRUENT = Manipulator(base={"equilateral": 10}, platform={"equilateral": 10})


@pytest.mark.parametrize("number", sample(range(24), *range(10)))
def test_of_random_exact_and_degenerate_machines(number: int) -> None:
    _, manipulator, held = machine(number, 7)
    assert list(failures(leg_poses(manipulator, held, digits=90))) == []


def test_what_a_textbook_asks() -> None:
    """Question 7 of a project about the planar Stewart platform, whose six poses lie in a narrow interval."""
    textbook = Manipulator(
        base={"points": [[0, 0], [5, 0], [0, 6]]}, platform={"sides": [3, 3, "3*sqrt(2)"]}, orientation="cw"
    )
    found = leg_poses(textbook, {"l1": 5, "l3": 3}, 0, 12, digits=30)
    for interval in found.intervals:
        assert poses(textbook, 5, interval.at, 3, digits=15).count == interval.count
    assert found.intervals[0].start == "0"
    assert found.intervals[-1].stop == "12"


def test_signs_and_aspects_hold_between_ends() -> None:
    found = leg_poses(M, {"l1": 17, "l3": 15}, digits=20)
    assert [interval.count for interval in found.intervals] == [0, 2, 4, 6, 4, 2, 0]
    for interval in found.intervals:
        assert sum(sign or 0 for sign in interval.signs) == 0  # half of all poses have J > 0
        pairs = set(zip(interval.signs, interval.aspects, strict=True))
        assert len({aspect for _, aspect in pairs}) == len(pairs)  # an aspect has one sign


def test_the_range_cuts() -> None:
    whole = leg_poses(M, {"l1": 17, "l3": 15}, digits=30)
    part = leg_poses(M, {"l1": 17, "l3": 15}, 10, 20, digits=30)
    assert [end.length for end in part.ends] == [
        end.length for end in whole.ends if 10 < Fraction(end.length) < 20
    ]
    assert (part.intervals[0].start, part.intervals[0].stop) == ("10", part.ends[0].length)
    assert part.intervals[-1].stop == "20"


def test_an_end_of_the_range_at_a_fold() -> None:
    found = leg_poses(EQUILATERAL, {"l1": 5, "l3": "6.5"}, "1.5", "11.5", digits=30)
    assert [Fraction(end.length) for end in found.ends[::3]] == [Fraction(3, 2), Fraction(23, 2)]
    assert [interval.count for interval in found.intervals] == [4, 2, 4]


def test_exact_ends_of_special_machines() -> None:
    found = leg_poses(EQUILATERAL, {"l1": 5, "l3": 5}, digits=40)
    assert [(end.kind, end.length) for end in found.ends] == [
        (EndKind.CLOSED_LEG, "0"),
        (EndKind.DEGENERATE, "8.660254037844386467637231707529361834714"),
        (EndKind.DEGENERATE, "10" + "." + "0" * 38),
    ]
    assert [interval.count for interval in found.intervals] == [2, 4, 0]


def test_a_movable_machine_has_an_end_there() -> None:
    found = leg_poses(CONGRUENT, {"l1": 5, "l3": 5}, digits=20)
    assert [Fraction(end.length) for end in found.ends] == [0, 5, 10]
    assert [interval.count for interval in found.intervals] == [4, 4, 0]


def test_legs_that_cannot_close() -> None:
    found = leg_poses(M, {"l1": 1000, "l3": 1})
    assert found.ends == ()
    assert [(x.start, x.stop, x.count) for x in found.intervals] == [("0", None, 0)]


def test_what_is_no_question() -> None:
    for lengths in ({"l1": 5}, {"l1": 5, "l2": 4, "l3": 3}, {"l1": 5, "x": 3}):
        with pytest.raises(InputError, match="lengths"):
            leg_poses(M, lengths)
    with pytest.raises(InputError, match="l3"):
        leg_poses(M, {"l1": 5, "l3": -1})
    with pytest.raises(InputError, match="stop"):
        leg_poses(M, {"l1": 5, "l3": 1}, 3, 2)


@pytest.mark.parametrize("number", sample([*range(9), 19, 27], 0, 1, 2, 9, 10))
def test_singular_poses_have_the_lengths_of_their_ends(number: int) -> None:
    _, manipulator, held = machine(number, 7)
    found = leg_poses(manipulator, held, digits=30)
    for end in found.ends:
        assert end.kind is not EndKind.FOLD or len(end.poses) == 1
        for pose in end.poses:
            lengths = {name: float(x) for name, x in held.items()} | {
                f"l{found.moving_leg}": float(end.length)
            }
            for leg, vector in enumerate(vectors(manipulator, pose), 1):
                length = lengths[f"l{leg}"]
                assert abs(vector) == pytest.approx(length, rel=1e-9, abs=1e-9)
                if end.kind is not EndKind.CLOSED_LEG or leg != found.moving_leg:
                    angle = radians(float(pose[f"theta{leg}_deg"]))
                    assert abs(vector - rect(length, angle)) < 1e-9 * (1 + length)


def vectors(manipulator: Manipulator, pose: Mapping[str, str]) -> list[complex]:
    """Those of the legs at a pose, by floats."""
    a2x, a3x, a3y, d1, d2, d3 = manipulator.doubles()
    x = (d1**2 + d3**2 - d2**2) / (2 * d1)
    height = max(d3**2 - x**2, 0.0) ** 0.5 * (-1 if manipulator.orientation == "cw" else 1)
    platform, base = (0, d1, complex(x, height)), (0, a2x, complex(a3x, a3y))
    turn, b1 = rect(1, radians(float(pose["alpha_deg"]))), complex(float(pose["b1_x"]), float(pose["b1_y"]))
    return [b1 + turn * b - a for a, b in zip(base, platform, strict=True)]


def test_singular_poses_in_the_frame_of_the_points() -> None:
    corners = [[1, 2], [4, 6], [1, 10]]
    placed = Manipulator(base={"points": corners}, platform={"points": [[7, 1], [7, 4], [3, 4]]})
    found = leg_poses(placed, {"l1": 5, "l3": 4}, digits=15)
    assert found.ends
    assert all({"x", "y", "phi_deg"} <= pose.keys() for end in found.ends for pose in end.poses)


def test_angles_that_are_exactly_0_or_180() -> None:
    flat = Manipulator(base={"points": [[0, 0], [6, 0], [9, 0]]}, platform={"sides": [2, 1, 3]})
    first, last = leg_poses(flat, {"l1": 9, "l3": 6}, digits=15).ends
    assert [pose["alpha_deg"] for pose in first.poses] == ["180.000000000000"] * 2
    assert [pose["alpha_deg"] for pose in last.poses] == ["0"] * 2


@pytest.mark.parametrize(("digits", "text"), [(16, "10.00000000000000"), (17, "9.9999999999999995")])
def test_a_length_that_is_a_decimal_or_half_way_between_two_is_decided(digits: int, text: str) -> None:
    """All joints of this machine lie on a line at the fold, where L2 = 13 − L1."""
    lengths = {"l1": "3.0000000000000005", "l3": "13.0000000000000005"}
    table = leg_poses(Manipulator(20, 6, 0, 7, 9, 16), lengths, digits=digits)
    assert table.to_json()["intervals"][1]["from"] == text
