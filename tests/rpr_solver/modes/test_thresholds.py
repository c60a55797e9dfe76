"""Changes of assembly mode, and connections, that keep a clearance and hold within a tolerance."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from random import Random
from typing import Any

import numpy as np
import pytest

from rpr_solver import (
    EXAMPLES,
    Change,
    InputError,
    Manipulator,
    Requirement,
    assembly_modes,
    check,
    exact_str,
    pose_connections,
    verify_document,
)
from rpr_solver.contract import LENGTHS
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.tolerant import Neighbours
from rpr_solver.modes.wide_pairs import wide_pairs
from rpr_solver.paths.clearances import clearance_in_balls
from tests.support.motions import Mover, angles_of, apart
from tests.support.oracle import free_legs_of, singularity
from tests.support.sampling import long
from tests.support.width_grid import WidthGrid

FIRST = EXAMPLES["innocenti"]
ROUNDED = Manipulator(a2x=500, a3x=250, a3y="433.0127019", d1=200, d2=200, d3=200)


@cache
def asked(length: Any, **thresholds: Any) -> Any:
    return assembly_modes(FIRST, length, with_regions=False, **thresholds)


@pytest.mark.long
def test_every_witness_has_its_clearance() -> None:
    witness = asked(27).witness
    grid = WidthGrid(FIRST, 1, 27.0, 120)
    places = [np.degrees(angles_of(sample)) for sample in witness.samples[::10]]
    seen = min(grid.distance((alpha, theta)) for alpha, theta in places)
    assert 13 < witness.clearance.proved < seen + 0.5
    assert clearance_in_balls(witness.route) <= witness.clearance.proved
    assert asked(27).to_json()["witness"]["path"]["clearance"]["asked"] == "0"


@pytest.mark.long
def test_the_path_of_a_witness_is_not_refused() -> None:
    assert verify_document(asked(27).to_json()["witness"]["path"]).verdict != "refused"


@pytest.mark.long
def test_a_machine_that_was_rounded_changes_its_mode_by_a_hair() -> None:
    span, limits = (150, 450), {"l2": (150, 450), "l3": (150, 450)}
    answer = assembly_modes(ROUNDED, between=span, limits=limits, with_regions=False)
    assert answer.change is Change.POSSIBLE
    assert answer.witness is not None
    assert answer.witness.clearance is not None
    assert 0 < answer.witness.clearance.proved < Fraction(1, 10**8)
    wide = assembly_modes(ROUNDED, between=span, limits=limits, clearance="0.5", with_regions=False)
    assert wide.change is Change.UNDECIDED
    assert wide.best is not None
    assert answer.witness.clearance.proved <= wide.best < Fraction(1, 2)
    assert "degrees" in str(wide.reason)


@pytest.mark.parametrize(
    ("length", "clearance", "change"),
    [
        (27, 43, "possible"),
        long(27, 60, "impossible"),
        long(27, 1, "possible"),
        long(27, 47, "impossible"),
        long("0.2", 3, "impossible"),
    ],
)
def test_a_clearance_is_kept_or_excluded(length: Any, clearance: int, change: str) -> None:
    answer = asked(length, clearance=clearance)
    assert answer.change == change
    document = answer.to_json()
    assert document["asked"]["clearance"] == str(clearance)
    if change == "possible":
        assert answer.witness.clearance.proved >= clearance
    else:
        assert document["certificate"]["method"] == "regions"


def test_the_impossible_stays_so_with_a_clearance_and_near_by() -> None:
    assert asked("0.1").change is Change.IMPOSSIBLE
    assert asked("0.1", clearance=1).change is Change.IMPOSSIBLE
    assert asked("0.1", tolerance="0.001").change is Change.IMPOSSIBLE
    assert asked("0.1", tolerance="0.001", clearance=1).to_json()["certificate"]["method"] == "folds"


def test_neighbours_follow_the_witness_to_another_pose_of_their_own() -> None:
    answer = asked(27, clearance="0.5", tolerance="0.05")
    assert answer.change is Change.POSSIBLE
    path, rng = answer.witness, Random(3)
    places = [angles_of(sample) for sample in path.resampled(301).samples]
    for _ in range(5):
        own = dict(zip(LENGTHS, FIRST.lengths, strict=True))
        other = Manipulator(**{g: x + Fraction(rng.choice((-1, 1)), 20) for g, x in own.items()})
        legs = free_legs_of(other, 1)
        assert all(singularity(legs, 27.0, *place) * path.sign > 0 for place in places)
        mover = Mover.of(other, 1)
        goal = mover.legs(*places[0], 27.0)
        # Newton's method from the end of the path
        alpha, theta = places[-1]
        for _step in range(20):
            alpha, theta = stepped(mover, (alpha, theta), goal)
        found = mover.legs(alpha, theta, 27.0)
        assert max(abs(x - y) for x, y in zip(found, goal, strict=True)) < 1e-8
        assert singularity(legs, 27.0, alpha, theta) * path.sign > 0
        assert apart((alpha, theta), places[0]) > 0.01
        assert apart((alpha, theta), places[-1]) < 0.2


def stepped(mover: Mover, place: tuple[float, float], goal: Any) -> tuple[float, float]:
    step, (alpha, theta) = 1e-7, place
    here = mover.legs(alpha, theta, 27.0)[1:]
    columns = [mover.legs(alpha + step, theta, 27.0)[1:], mover.legs(alpha, theta + step, 27.0)[1:]]
    (a, b), (c, d) = ([(y - x) / step for x, y in zip(here, column, strict=True)] for column in columns)
    u, v = (x - y for x, y in zip(goal[1:], here, strict=True))
    det = a * d - b * c
    return alpha + (u * d - v * c) / det, theta + (a * v - b * u) / det


def test_a_tolerance_that_is_too_wide_is_named() -> None:
    answer = asked(27, tolerance=20)
    assert answer.change is Change.UNDECIDED
    assert "flat" in answer.reason
    assert Neighbours.of(FIRST, SliceMap.of(FIRST, 1), (Fraction(20),) * 6, Fraction(27)) is None


@pytest.mark.long
def test_a_looser_threshold_never_loses_a_yes() -> None:
    clearances, tolerances = (None, 2, 43, 90), (None, "0.02")
    found = [[asked(27, clearance=c, tolerance=t).change for c in clearances] for t in tolerances]
    for rows in (found, list(zip(*found, strict=True))):
        for row in rows:
            possible = [change is Change.POSSIBLE for change in row]
            assert possible == sorted(possible, reverse=True)
    for row in found:
        excluded = [change is Change.IMPOSSIBLE for change in row]
        assert excluded == sorted(excluded)


def test_pairs_that_a_grid_suggests_are_poses_of_one_joint_vector() -> None:
    slice_map = SliceMap.of(FIRST, 1)
    mover = Mover.of(FIRST, 1)
    for bounds, count in (({}, 2), ({2: (None, Fraction(20))}, 1)):
        pairs = list(wide_pairs(slice_map, 27 * Fraction(slice_map.scale), bounds))
        assert len(pairs) >= count
        for joint, spots in pairs:
            assert joint[0] < bounds.get(2, (None, 99))[1]
            places = [tuple(np.radians(spot)) for spot in spots]
            for place in places:
                found = mover.legs(*place, 27.0)[1:]
                assert max(abs(x - float(y)) for x, y in zip(found, joint, strict=True)) < 1e-6
            assert apart(*places) > 0.1


def test_a_wide_change_is_found_where_the_grid_has_neighbours_with_like_legs() -> None:
    machine = Manipulator(a2x="7.4", a3x=10, a3y="3.5", d1=8, d2=40, d3="38.24")
    answer = assembly_modes(machine, "3.7", clearance=35, with_regions=False)
    assert answer.change is Change.POSSIBLE


@pytest.mark.long
def test_a_clearance_that_none_keeps_is_told_where_it_is_open() -> None:
    answer = asked(27, clearance=46)
    assert answer.change is Change.UNDECIDED
    assert answer.best < 46 < answer.bound
    assert asked(27, clearance=answer.bound).change is Change.IMPOSSIBLE
    assert answer.to_json()["clearance_bound"] == exact_str(answer.bound)


@pytest.mark.parametrize(
    ("thresholds", "groups"),
    [
        long({"clearance": 1}, ((1, 3), (2,), (4,))),
        ({"clearance": 25}, ((1,), (2,), (3,), (4,))),
        ({"clearance": 1, "tolerance": "0.001"}, ((1, 3), (2,), (4,))),
        ({"tolerance": 1}, ((1,), (2,), (3,), (4,))),
    ],
)
def test_connections_keep_thresholds(thresholds: dict[str, Any], groups: Any) -> None:
    found = pose_connections(FIRST, 27, "25.7", "9.2", **thresholds)
    assert found.groups == groups
    document = found.to_json()
    [path] = document["paths"]
    assert path["poses"] == [1, 3]
    assert 8 < Fraction(path["clearance"]) < 9
    is_loose = thresholds.get("tolerance") == 1
    assert found.matrix[0][1] == ("undecided" if is_loose else "opposite-signs")
    word = found.matrix[0][2]
    assert word is None or word == ("too-narrow" if "tolerance" not in thresholds else "undecided")


def test_a_check_asks_for_a_change_with_thresholds() -> None:
    wish = {"start": 20, "stop": 30}
    required = Requirement(**wish, mode_change="required", clearance="0.5")  # type: ignore[arg-type]
    report = check(FIRST, required, digits=15, tolerance="0.05")
    assert report
    assert report.to_json()["requirement"]["clearance"] == "0.5"
    assert Requirement.from_json(required.to_json()) == required


@pytest.mark.parametrize(
    ("mode_change", "clearance", "passed"),
    [("excluded", 1, False), long("required", 60, False), long("excluded", 60, True)],
)
def test_a_range_keeps_a_clearance_or_excludes_it(mode_change: Any, clearance: int, passed: bool) -> None:
    wish = Requirement(start=20, stop=21, mode_change=mode_change, clearance=clearance)
    assert check(FIRST, wish, digits=15).passed is passed


@pytest.mark.parametrize("limits", [long(None), {"l2": (14, 16), "l3": (22, 24)}])
def test_what_no_path_keeps_stays_so_for_neighbours(limits: Any) -> None:
    tolerance = "0.01"
    answer = assembly_modes(FIRST, 27, limits=limits, clearance=60, tolerance=tolerance, with_regions=False)
    assert answer.change is Change.IMPOSSIBLE


@pytest.mark.long
def test_a_range_within_limits_has_no_change_for_neighbours() -> None:
    limits = {"l2": (14, 16), "l3": (22, 24)}
    answer = assembly_modes(FIRST, between=(26, 28), limits=limits, tolerance="0.01", with_regions=False)
    assert answer.to_json()["certificate"]["method"] == "folds"


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: asked(27, clearance=0), "clearance"),
        (lambda: asked(27, tolerance=-1), "tolerance"),
        (lambda: assembly_modes(FIRST, 27, tolerance={"x": 1}), "tolerance.x"),
        (lambda: pose_connections(FIRST, 27, 20, 20, clearance=-1), "clearance"),
        (lambda: Requirement(start=1, max_cusps=3, clearance=1), "requirement.clearance"),
        (lambda: check(FIRST, Requirement(start=1, stop=2, max_cusps=3), tolerance=1), "tolerance"),
    ],
)
def test_what_is_wrong_is_named(call: Any, field: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert [problem.field for problem in caught.value.problems] == [field]
