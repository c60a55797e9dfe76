"""Condition numbers against numpy's singular values, of poses and along paths; and what a path must keep."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from random import Random

import numpy as np
import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    Unproved,
    cusp_loop,
    joint_path,
    path_csv,
    pose_path,
    poses,
    poses_of_squares,
    with_condition,
)
from rpr_solver.model.conditioning import scale_of
from tests.rpr_solver.long_run import manipulator

INNOCENTI = EXAMPLES["innocenti"]


def corners(m: Manipulator) -> tuple[np.ndarray, np.ndarray]:
    """Base and platform in doubles, from the six numbers and the law of cosines."""
    a2x, a3x, a3y, d1, d2, d3 = m.doubles()
    x = (d1**2 + d3**2 - d2**2) / (2 * d1)
    y = max(d3**2 - x**2, 0) ** 0.5 * (1 if m.orientation == "ccw" else -1)
    return np.array([0, a2x, a3x + 1j * a3y]), np.array([0, d1, x + 1j * y])


def by_singular_values(m: Manipulator, alpha: float, tip: complex, scale: float) -> float:
    """The condition number of the legs' rates at a pose, B1 being at ``tip``."""
    base, platform = corners(m)
    turned = platform * np.exp(1j * alpha)
    legs = turned + tip - base
    u, arms = legs / abs(legs), turned - turned.mean()
    matrix = np.stack([u.real, u.imag, (arms.conj() * u).imag / scale], -1)
    first, _, last = np.linalg.svd(matrix, compute_uv=False)
    return float(first / last)


def random_machines(count: int) -> Iterator[tuple[Random, Manipulator]]:
    random, found = Random(50), 0
    while found < count:
        m = manipulator(random)
        if m.d1:
            found += 1
            yield random, m


@pytest.mark.parametrize("digits", [15, 40])
def test_poses_have_theirs(digits: int) -> None:
    seen = 0
    for random, m in random_machines(40):
        lengths = [Fraction(random.randint(10, 400), 10) for _ in range(3)]
        table = with_condition(poses(m, *lengths, digits=digits), "2.5" if random.random() < 0.5 else None)
        scale = float(scale_of(m, "2.5" if table.length_scale == "2.5" else None).ball())
        for pose in table.poses:
            seen += 1
            tip = complex(float(pose.b1_x), float(pose.b1_y))
            expected = by_singular_values(m, np.deg2rad(float(pose.alpha_deg)), tip, scale)
            assert pose.condition is not None
            assert len(pose.condition.replace(".", "").lstrip("0")) == digits
            assert float(pose.condition) == pytest.approx(expected, rel=1e-12 * max(10, expected))
    assert seen > 10


def test_a_machine_of_another_size_has_the_same_numbers() -> None:
    twice = Manipulator("31.82", 0, 20, "34.08", "33.08", "41.68")
    one, other = (
        with_condition(poses(m, *lengths, digits=20))
        for m, lengths in ((INNOCENTI, (27, 20, 20)), (twice, (54, 40, 40)))
    )
    assert [pose.condition for pose in one.poses] == [pose.condition for pose in other.poses]
    assert (one.length_scale, other.length_scale) == ("sqrt(2495597/22500)", "sqrt(2495597/5625)")


def test_an_isotropic_pose_has_1() -> None:
    """Legs of length 1 at right angles to the arms of an equilateral platform: one singular value, thrice."""
    m = Manipulator(base={"circumradius": "sqrt(1.5)"}, platform={"circumradius": "sqrt(0.5)"})
    table = with_condition(poses(m, 1, 1, 1, digits=30), 1)
    assert "1.00000000000000000000000000000" in [pose.condition for pose in table.poses]


def test_at_a_singular_pose_it_is_infinite() -> None:
    """Where similar triangles are parallel, the legs meet in one point: here with B1 = (1, 1)."""
    table = with_condition(poses_of_squares(Manipulator(4, 0, 3, 2, "2.5", "1.5"), 2, 2, "1.25", digits=15))
    document = table.to_json()
    seen = [(pose["condition"] is None, pose["clearance_deg"] == "0") for pose in document["poses"]]
    assert seen == [(pose["multiplicity"] > 1,) * 2 for pose in document["poses"]]
    assert (True, True) in seen
    assert document["condition"]["length_scale"] == "sqrt(25/18)"


def signs(m: Manipulator, length: float, alpha: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The signs of the determinants of the legs' rates at poses."""
    base, platform = corners(m)
    arms = np.exp(1j * alpha) * platform[:, None]
    legs = length * np.exp(1j * theta) + arms - base[:, None]
    rows = np.stack([legs.real, legs.imag, (arms.conj() * legs).imag], -1)
    return np.sign(np.linalg.det(rows.transpose(1, 0, 2)))


def test_no_singular_pose_is_within_the_clearance_and_one_is_not_far_beyond() -> None:
    angles = np.linspace(-np.pi, np.pi, 721)
    for random, m in random_machines(12):
        lengths = [Fraction(random.randint(50, 300), 10) for _ in range(3)]
        for pose in with_condition(poses(m, *lengths, digits=15)).poses:
            assert pose.clearance_deg is not None
            alpha, theta, radius = (
                np.deg2rad(float(x)) for x in (pose.alpha_deg, pose.theta1_deg, pose.clearance_deg)
            )
            found = [
                signs(m, float(lengths[0]), alpha + r * np.cos(angles), theta + r * np.sin(angles))
                for r in radius * np.array([*np.linspace(0, 0.999, 40), 1.03])
            ]
            inside = np.concatenate(found[:-1])
            assert abs(inside.sum()) == len(inside)
            assert inside[0] in found[-1] * -1


def fine(path: Path) -> list[float]:
    return [float(sample.condition or 0) for sample in path.resampled(301).samples]


@pytest.mark.parametrize("which", ["loop", "slice", "range", "other lengths"])
def test_along_a_path_all_are_between_the_bounds_which_are_close(which: str) -> None:
    start, stop = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}, {"l1": 30, "l2": 21, "l3": 19, "pose": 1}
    options = {"condition": True, "samples": 2}
    found = {
        "loop": lambda: cusp_loop(INNOCENTI, 27, "B", **options),
        "slice": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, **options),
        "range": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, 30), **options),
        "other lengths": lambda: pose_path(INNOCENTI, start, stop, length_scale=3, samples=2),
    }[which]()
    assert isinstance(found, Path)
    assert found.condition is not None
    numbers, least, greatest = fine(found), float(found.condition.least), float(found.condition.greatest)
    assert least <= min(numbers) <= least * 1.01
    assert max(numbers) <= greatest <= max(numbers) * 1.01
    assert fine(found.reversed())[:5] == pytest.approx(numbers[:-6:-1], rel=1e-6)


def test_samples_have_theirs_and_csv_has_a_column() -> None:
    loop = cusp_loop(INNOCENTI, 27, "B", condition=True, samples=5)
    scale = float(scale_of(INNOCENTI).ball())
    for sample in loop.samples:
        theta = np.deg2rad(float(sample.theta_deg))
        expected = by_singular_values(
            INNOCENTI, np.deg2rad(float(sample.alpha_deg)), 27 * np.exp(1j * theta), scale
        )
        assert float(sample.condition or 0) == pytest.approx(expected, rel=1e-12)
    [head, *rows] = path_csv(loop.to_json()).split()
    assert head.endswith(",clearance_deg,condition")
    assert [row.rpartition(",")[2] for row in rows] == [sample.condition for sample in loop.samples]
    plain = cusp_loop(INNOCENTI, 27, "B", samples=5).to_json()
    asked = loop.to_json()
    del asked["condition"]
    for sample in asked["samples"]:
        del sample["condition"]
    assert asked == plain


def test_a_requirement_is_kept_or_the_reason_is_told() -> None:
    ends = INNOCENTI, 27, 20, 20, 1, 2
    free = joint_path(*ends, condition=True)
    assert free
    assert free.condition is not None
    assert free.condition.greatest > 30
    kept = joint_path(*ends, max_condition=12)
    assert isinstance(kept, Path)
    assert kept.condition is not None
    assert kept.condition.greatest <= 12
    assert max(fine(kept)) <= 12
    none = joint_path(*ends, max_condition="9.5")
    assert isinstance(none, NoPath)
    assert none.condition is not None
    assert (none.obstacle, none.condition.asked) == (Obstacle.UNDECIDED, Fraction("9.5"))
    assert none.condition.greatest > Fraction("9.5")
    # that of pose 2 is 7.069…
    refused = joint_path(*ends, max_condition=7)
    assert isinstance(refused, NoPath)
    assert (refused.obstacle, refused.to_json()["connected"]) == (Obstacle.ILL_CONDITIONED, False)
    with pytest.raises(Unproved):
        cusp_loop(INNOCENTI, 27, "B", max_condition=3)


@pytest.mark.parametrize(
    ("options", "field"),
    [({"length_scale": 0}, "length_scale"), ({"max_condition": "0.99"}, "max_condition")],
    ids=str,
)
def test_what_is_no_requirement_is_named(options: dict[str, object], field: str) -> None:
    with pytest.raises(InputError) as caught:
        cusp_loop(INNOCENTI, 27, "B", **options)  # type: ignore[arg-type]
    assert [p.field for p in caught.value.problems] == [field]
