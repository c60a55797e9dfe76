"""Paths from pose to pose, and the reasons why there is none.

What the document of two poses without a path says.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NoReturn

import pytest

from rpr_solver import (
    EXAMPLES,
    Exact,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    SolverError,
    aspects,
    joint_path,
    pose_path,
)
from rpr_solver.model.lengths import ExactLimits
from rpr_solver.paths import between_poses
from tests.support.motions import Mover, angles_of, apart, arrives, legs_of
from tests.support.sampling import long

FIRST = EXAMPLES["innocenti"]
ISLAND = ("25.7", "9.2")
"""L2 and L3 of a joint vector at L1 = 27 with a pose in each aspect with J > 0."""


def test_two_poses_of_one_aspect_are_joined() -> None:
    path = joint_path(FIRST, 27, 20, 20, 1, 2, samples=5)
    assert isinstance(path, Path)
    assert (path.start.number, path.stop.number, path.cusp, path.winding) == (1, 2, None, None)
    assert {sample.lengths[0] for sample in path.samples} == {"27.0000000000000"}
    least = float(path.certificate["least_determinant"])
    assert all(float(s.determinant) * path.sign >= least > 0 for s in path.resampled(31).samples)
    assert max(arrives(path, samples) for samples in (200, 400)) < 1e-6
    assert path.to_json()["connected"] is True


def test_opposite_signs_are_never_joined() -> None:
    none = joint_path(FIRST, 27, 20, 20, 1, 3)
    assert isinstance(none, NoPath)
    assert none.obstacle is Obstacle.OPPOSITE_SIGNS
    document = none.to_json()
    assert (document["connected"], document["obstacle"]) == (False, "opposite-signs")
    assert document["samples"] == []


@pytest.mark.parametrize(
    ("sides", "lengths", "leg", "poses"),
    [
        (("7.8", "7.8", "10.4", "30.42", "40.56", "50.7"), ("50.15", "52.36", "22.28"), 1, (1, 3)),
        long(("7.8", "7.8", "10.4", "30.42", "40.56", "50.7"), ("50.15", "52.36", "22.28"), 2, (2, 4)),
        long(("7.8", "7.8", "10.4", "30.42", "40.56", "50.7"), ("50.15", "52.36", "22.28"), 3, (1, 3)),
        ((52, 52, "54.6", 52, "54.6", "75.4"), ("88.31", 41, "77.76"), 3, (3, 1)),
    ],
)
@pytest.mark.parametrize("limits", [{}, {"l1": (5, 100), "l2": (None, 60)}])
def test_similar_triangles_keep_their_aspects(
    sides: tuple[Exact, ...],
    lengths: tuple[Exact, Exact, Exact],
    leg: int,
    poses: tuple[int, int],
    limits: ExactLimits,
) -> None:
    """They have four at every length of the leg, so that no range of lengths joins two of them."""
    none = joint_path(Manipulator(*sides), *lengths, *poses, fixed_leg=leg, limits=limits)
    assert isinstance(none, NoPath)
    assert (none.obstacle, none.connecting) == (Obstacle.OTHER_ASPECT, None)
    assert len(aspects(none.manipulator, fixed_leg=leg)) == 4


@pytest.mark.long
def test_another_aspect_comes_with_a_range_that_connects_them() -> None:
    none = joint_path(FIRST, 27, *ISLAND, 2, 4)
    assert isinstance(none, NoPath)
    assert none.obstacle is Obstacle.OTHER_ASPECT
    assert none.connecting is not None
    assert (none.connecting[0], none.to_json()["connecting_range"]["from"]) == (27, "27")
    path = joint_path(FIRST, 27, *ISLAND, 2, 4, between=none.connecting, samples=2)
    assert isinstance(path, Path)


def test_an_island_is_left_through_another_slice() -> None:
    path = joint_path(FIRST, 27, *ISLAND, 2, 4, between=(27, 30), samples=41)
    assert isinstance(path, Path)
    lengths = [Fraction(sample.lengths[0]) for sample in path.samples]
    assert 27 <= min(lengths) < max(lengths) <= 30
    assert (lengths[0], lengths[-1]) == (27, 27)
    mover = Mover.of(FIRST)
    for sample in path.samples[::5]:
        legs, (alpha, theta) = legs_of(sample), angles_of(sample)
        assert mover.legs(alpha, theta, legs[0]) == pytest.approx(legs)
        assert mover.determinant(alpha, theta, legs[0]) * path.sign > 0
    assert arrives(path, 600) < 1e-6
    assert apart(angles_of(path.samples[-1]), angles_of(path.stop)) < 1e-12


def test_a_way_along_arcs_that_turn_quickly_is_proved() -> None:
    """Within a tenth of a radian of θ the gap moves by two radians of α, which probes in floats miss."""
    m, length = Manipulator("5.5", "19.7", "7.6", "16", "19.6", "6.2"), Fraction(2399, 50)
    start = {"l1": "44.222", "l2": "57.651", "l3": length, "pose": 1}
    stop = {"l1": "56.840", "l2": "37.637", "l3": length, "pose": 1}
    path = pose_path(m, start, stop, fixed_leg=3, samples=41)
    assert isinstance(path, Path)
    mover = Mover.of(m, 3)
    for sample in path.samples:
        assert mover.determinant(*angles_of(sample), float(length)) * path.sign > 0


def test_a_pose_close_to_an_arc_beside_a_critical_line_is_reached() -> None:
    """Floats have the pose beyond the arc, and so a full turn away at the other end of its gap."""
    length = Fraction("13.388939421")
    start, stop = (
        {"alpha_deg": alpha, "theta2_deg": theta, "l2": length}
        for alpha, theta in (("38.1461383", "1.6533502"), ("-164.4567182", "80.2329505"))
    )
    path = pose_path(Manipulator("4.7", "7.9", "3.9", 13, "8.5", "19.1"), start, stop, fixed_leg=2, samples=5)
    assert isinstance(path, Path)
    assert path.sign == -1


@pytest.mark.parametrize(
    ("sides", "leg", "length", "start", "stop"),
    [
        (
            (30, 0, 40, 30, 50, 40),
            3,
            "64.32",
            ("-24.5630329", "-91.0525034"),
            ("80.6818217", "-75.6541481"),
        ),
        (
            (10, "16.5", "12.5", "22.5", 38, "25.5"),
            2,
            "34.229187152",
            ("11.0018964", "14.0737177"),
            ("-110.6173529", "94.1677326"),
        ),
    ],
)
def test_a_way_round_the_tip_of_a_curve_keeps_off_it(
    sides: tuple[Exact, ...], leg: int, length: str, start: tuple[str, str], stop: tuple[str, str]
) -> None:
    """The way through cells turns back at the line through the tip, nearer to it than control points are."""
    m = Manipulator(*sides, orientation="cw")
    ends = [{"alpha_deg": a, f"theta{leg}_deg": t, f"l{leg}": length} for a, t in (start, stop)]
    path = pose_path(m, *ends, fixed_leg=leg, samples=41)
    assert isinstance(path, Path)
    mover = Mover.of(m, leg)
    for sample in path.samples:
        assert mover.determinant(*angles_of(sample), float(length)) * path.sign > 0


def test_a_range_that_does_not_join_is_a_proved_no(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(between_poses, "_connecting", lambda *_: None)
    narrow = joint_path(FIRST, 27, *ISLAND, 2, 4, between=(27, "27.01"))
    assert isinstance(narrow, NoPath)
    document = narrow.to_json()
    assert (narrow.obstacle, document["connected"]) == (Obstacle.OTHER_ASPECT, False)
    assert document["between"] == {"from": "27", "to": "27.01"}


def test_a_range_whose_ends_are_refused_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> NoReturn:
        raise SolverError("no chart")

    monkeypatch.setattr(between_poses.Range, "of", refused)
    none = joint_path(FIRST, 27, *ISLAND, 2, 4, between=(27, 30))
    assert isinstance(none, NoPath)
    assert (none.obstacle, none.to_json()["connected"]) == (Obstacle.UNDECIDED, None)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"start": 5}, "start"),
        ({"stop": 0}, "stop"),
        ({"stop": 1}, "stop"),
        ({"l2": 0}, "l2"),
        ({"between": (28, 30)}, "between"),
        ({"between": (0, 30)}, "between"),
        ({"samples": 1}, "samples"),
        ({"digits": 3}, "digits"),
    ],
)
def test_each_argument_at_fault_is_named(change: dict[str, object], field: str) -> None:
    asked: dict[str, object] = {"l1": 27, "l2": 20, "l3": 20, "start": 1, "stop": 2, **change}
    with pytest.raises(InputError) as caught:
        joint_path(FIRST, **asked)  # type: ignore[arg-type]
    assert [problem.field for problem in caught.value.problems] == [field]
