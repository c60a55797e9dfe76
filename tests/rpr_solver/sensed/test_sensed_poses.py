"""Poses from lengths and angles: random poses are given back, none is missed, special ones are named."""

from __future__ import annotations

from cmath import exp, phase
from fractions import Fraction
from itertools import combinations
from math import degrees, radians
from random import Random
from typing import Any

import numpy as np
import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    SensedPose,
    Unproved,
    poses,
    poses_csv,
    sensed_poses,
    verify_document,
    workspace,
)
from rpr_solver.triangles import UserFrame
from tests.support.sampling import sample
from tests.support.workspace_places import exact, plain, symmetric

M = EXAMPLES["innocenti"]
CONGRUENT = Manipulator(base={"equilateral": 10}, platform={"equilateral": 10})
EQUILATERAL = Manipulator(base={"equilateral": 10}, platform={"equilateral": 4})
Data = dict[str, Fraction]


class Drawn:
    """A machine at a random pose, in floats: its joints, and the lengths and angles of its legs, exact."""

    def __init__(self, number: int, seed: int) -> None:
        rng = Random(f"{seed} {number}")
        self.machine = (plain, exact, symmetric)[number % 3](rng)
        a2x, a3x, a3y, d1, d2, d3 = self.machine.doubles()
        self.size = max(map(abs, (a2x, a3x, a3y, d1, d2, d3)))
        x = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1)
        y = max(d3 * d3 - x * x, 0.0) ** 0.5 * (-1 if self.machine.geometry.platform.sense == "cw" else 1)
        self.base, self.platform = (0j, complex(a2x), complex(a3x, a3y)), (0j, complex(d1), complex(x, y))
        self.b1 = complex(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5)) * self.size
        turn = exp(1j * radians(rng.uniform(-180, 180)))
        frame = UserFrame.of(self.machine.geometry)
        self.axis = 1 + 0j
        if frame is not None:
            self.axis = complex(
                *(float(u.decimal(17)) + float(v.decimal(17)) for u, v in frame.base.direction)
            )
        legs = [self.b1 + turn * b - a for a, b in zip(self.base, self.platform, strict=True)]
        self.lengths: Data = {f"l{k}": Fraction(abs(v)) for k, v in enumerate(legs, 1)}
        self.angles: Data = {
            f"angle{k}": Fraction(degrees(phase(v * self.axis))) for k, v in enumerate(legs, 1)
        }

    @property
    def has_one_field(self) -> bool:
        """Whether the machine has coordinates over one quadratic field."""
        try:
            return bool(self.machine.frame)
        except InputError:
            return False

    def far(self, pose: SensedPose) -> float:
        """How far B1 of a pose is from that of this one, by the size of the machine."""
        return abs(complex(float(pose.texts["b1_x"]), float(pose.texts["b1_y"])) - self.b1) / self.size


def given_back(number: int, seed: int) -> None:
    """Any three data of a pose, and more, have this pose among their poses."""
    drawn = Drawn(number, seed)
    rng = Random(number)
    for count in range(4):
        lengths = {name: drawn.lengths[name] for name in rng.sample(sorted(drawn.lengths), count)}
        angles = {name: drawn.angles[name] for name in rng.sample(sorted(drawn.angles), 3 - count)}
        if count == 3 and not drawn.has_one_field:
            continue  # direct kinematics needs it
        found = sensed_poses(drawn.machine, lengths, angles, digits=15)
        more = sensed_poses(drawn.machine, lengths, drawn.angles, angle_tolerance_deg="1e-6", digits=15)
        assert min(map(drawn.far, found.poses)) < 1e-6
        assert any(drawn.far(pose) < 1e-6 for pose in more.poses)
        assert len(more.poses) <= len(found.poses) + len(found.others)


@pytest.mark.parametrize("number", sample(range(45), *range(15)))
def test_angles_of_random_poses_give_them_back(number: int) -> None:
    given_back(number, 1)


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("part", range(10))
def test_angles_of_500_random_poses_give_them_back(part: int) -> None:
    for number in range(50 * part, 50 * part + 50):
        given_back(number, 2)


def counted_by_signs(drawn: Drawn, lengths: Data, angles: Data) -> int:
    """The number of poses, by changes of sign over a grid of α: B1 by two data, the third one compared."""
    alpha = np.radians(np.linspace(-180, 180, 40_001) + 1e-3)
    w = [np.exp(1j * alpha) * b - a for a, b in zip(drawn.base, drawn.platform, strict=True)]
    unit = {int(k[-1]) - 1: exp(1j * radians(x)) / drawn.axis for k, x in angles.items()}
    size = {int(k[-1]) - 1: float(x) for k, x in lengths.items()}
    first = min(unit)
    u = unit[first]
    kept: Any = True
    if first in size:
        branches: list[Any] = [size[first] * u - w[first]]
        del size[first]
    elif len(unit) > 1:
        second = max(unit)
        v = unit.pop(second)
        apart = w[first] - w[second]
        # V_second = λ u − apart is along v
        branches = [-w[first] + (np.conj(v) * apart).imag / (np.conj(v) * u).imag * u]
        kept = (np.conj(v) * (branches[0] + w[second])).real > 0
    else:
        second = min(size)
        x = np.conj(u) * (w[second] - w[first])
        with np.errstate(invalid="ignore"):
            half = np.sqrt(size.pop(second) ** 2 - x.imag**2)
        branches = [-w[first] + (side * half - x.real) * u for side in (1, -1)]
    total = 0
    for p in branches:
        [(third, is_length)] = [(k, True) for k in size] + [(k, False) for k in unit if k != first]
        vector = p + w[third]
        residual = np.abs(vector) - size[third] if is_length else (np.conj(unit[third]) * vector).imag
        good = (np.conj(u) * (p + w[first])).real > 0
        if not is_length:
            good &= (np.conj(unit[third]) * vector).real > 0
        good &= kept
        changes = np.sign(residual[:-1]) * np.sign(residual[1:]) < 0
        total += int((changes & good[:-1] & good[1:]).sum())
    return total


@pytest.mark.parametrize("number", sample(range(24), *range(9)))
def test_no_pose_is_missed(number: int) -> None:
    """Poses nearer than the grid come in pairs, or a branch ends between: then the solver has two more."""
    drawn = Drawn(number, 3)
    for count in range(3):
        for lengths in combinations(drawn.lengths, count):
            for angles in combinations(drawn.angles, 3 - count):
                own = {name: drawn.lengths[name] for name in lengths}
                turns = {name: drawn.angles[name] for name in angles}
                found = sensed_poses(drawn.machine, own, turns, digits=15)
                assert 0 <= len(found.poses) - counted_by_signs(drawn, own, turns) <= 1


def test_three_lengths_are_as_in_the_table_of_poses() -> None:
    table = poses(M, "14.98", 15, 30, digits=30)
    found = sensed_poses(M, {"l1": "14.98", "l2": 15, "l3": 30}, {}, digits=30)
    assert [pose.texts["theta2_deg"] for pose in found.poses] == [pose.theta2_deg for pose in table.poses]


def test_a_measured_angle_chooses_among_poses_or_contradicts_all() -> None:
    lengths = {"l1": "14.98", "l2": 15, "l3": 30}
    chosen = sensed_poses(M, lengths, {"angle1": "23.61"}, angle_tolerance_deg="0.01", digits=15)
    assert [pose.off_deg["angle1"] for pose in chosen.poses] == ["0.00289997"]
    assert len(chosen.others) == 1
    none = sensed_poses(M, lengths, {"angle1": "23.61", "angle2": 50}, angle_tolerance_deg="0.01", digits=15)
    assert (none.poses, none.disagree) == ((), ("angle2",))


@pytest.mark.parametrize(
    ("machine", "lengths", "angles", "alphas"),
    [
        (EQUILATERAL, {}, {"angle1": 30, "angle2": 150, "angle3": 270}, ["0", "180.000000000000"]),
        (Manipulator(6, 0, 8, 3, 5, 4), {"l1": 3, "l2": 6}, {"angle1": 0}, ["180.000000000000"]),
        (EQUILATERAL, {"l1": 3, "l3": 3}, {"angle1": 90}, None),
        (EQUILATERAL, {"l1": 6}, {"angle2": 90, "angle3": 270}, None),
        (EQUILATERAL, {"l1": 6}, {"angle2": "12.3456", "angle3": "12.3456"}, None),
    ],
)
def test_exact_machines(
    machine: Manipulator, lengths: dict[str, int], angles: dict[str, Any], alphas: list[str] | None
) -> None:
    found = sensed_poses(machine, lengths, angles, digits=15)
    if alphas is not None:
        assert [pose.texts["alpha_deg"] for pose in found.poses] == alphas
    for pose in found.poses:
        for name, value in lengths.items():
            assert float(pose.texts[name]) == pytest.approx(value, abs=1e-12)
        for name, value in angles.items():
            assert float(pose.texts[f"theta{name[-1]}_deg"]) % 360 == pytest.approx(float(value) % 360)


def test_a_curve_of_poses_is_named() -> None:
    for lengths, angles in (
        ({}, {"angle1": 90, "angle2": 90, "angle3": 90}),
        ({"l1": 5, "l2": 5, "l3": 5}, {}),
    ):
        found = sensed_poses(CONGRUENT, lengths, angles, digits=15)
        assert found.is_curve
        assert found.poses == ()


def test_what_stays_open_is_said() -> None:
    """A leg of length 0 has no angle."""
    with pytest.raises(Unproved, match="leg 2"):
        sensed_poses(Manipulator(6, 0, 8, 3, 5, 4), {"l1": 3}, {"angle1": 0, "angle2": 90}, digits=15)


def test_angles_are_in_the_frame_of_the_points() -> None:
    base = [["0", "0"], ["3", "4"], ["-4", "5"]]
    placed = Manipulator(base={"points": base}, platform={"sides": [2, 3, 3]})
    bare = Manipulator.from_json(placed.to_json())
    found = sensed_poses(placed, {"l1": 4, "l2": 5}, {"angle1": 100}, digits=20)
    turned = Fraction(100) - Fraction(degrees(phase(3 + 4j)))
    other = sensed_poses(bare, {"l1": 4, "l2": 5}, {"angle1": turned}, digits=20)
    assert [float(x.texts["b1_x"]) for x in found.poses] == pytest.approx(
        [float(x.texts["b1_x"]) for x in other.poses]
    )
    for pose in found.poses:
        place = complex(float(pose.texts["x"]), float(pose.texts["y"]))
        assert degrees(phase(place)) == pytest.approx(100)  # B1 is the platform's origin, A1 that of the base
    lines = poses_csv(found.to_json()).splitlines()
    assert len(lines) == 1 + len(found.poses)
    assert lines[0].endswith("l1,l2,l3,x,y,phi_deg")
    found.figure()


@pytest.mark.parametrize(
    ("lengths", "angles", "tolerance", "field"),
    [
        ({"l1": 5}, {"angle1": 3}, None, "angles"),
        ({"l4": 5}, {"angle1": 3}, None, "lengths"),
        ({}, {"theta1": 3}, None, "angles"),
        ({"l1": 0}, {"angle1": 3, "angle2": 5}, None, "l1"),
        ({"l1": 5, "l2": 5, "l3": 5}, {"angle1": 3}, None, "angle_tolerance_deg"),
        ({"l1": 5, "l2": 5, "l3": 5}, {"angle1": 3}, 0, "angle_tolerance_deg"),
        ({"l1": 5, "l2": 5}, {"angle1": 1000}, None, "angle1"),
    ],
)
def test_what_is_wrong_is_named(
    lengths: dict[str, int], angles: dict[str, int], tolerance: int | None, field: str
) -> None:
    with pytest.raises(InputError) as caught:
        sensed_poses(M, lengths, angles, angle_tolerance_deg=tolerance)
    assert caught.value.problems[0].field == field


def test_no_document_is_taken_for_one_that_is_verified() -> None:
    found = sensed_poses(M, {"l1": 15, "l2": 10}, {"angle3": 45}, digits=15)
    with pytest.raises(InputError, match="angles of legs"):
        verify_document(found.to_json())
    with pytest.raises(InputError, match="a workspace"):
        verify_document(workspace(M, 30, {"l1": (5, 30)}).to_json())
