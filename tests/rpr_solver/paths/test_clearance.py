"""The clearance of paths: against a grid of poses, poses beside the path, and other leg lengths."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from functools import cache
from math import cos, pi, radians, sin
from random import Random
from statistics import median
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    SolverError,
    Unproved,
    cusp_loop,
    joint_path,
    pose_path,
)
from rpr_solver.paths.corridors import Corridors
from rpr_solver.paths.loops import loop_in_slice, slice_for_loops
from rpr_solver.paths.proofs import Clearance
from rpr_solver.paths.question import PathTerms
from tests.rpr_solver.paths.test_random_pairs import a_manipulator
from tests.support.motions import Mover, angles_of, arrives
from tests.support.shared import eliminant_of
from tests.support.width_grid import Spot, WidthGrid, bottleneck_of_range

FIRST = EXAMPLES["innocenti"]
NARROW = (27, "25.7", "9.2", 1, 3)
"""Two poses far from all singular ones, with a narrow way between them."""


@cache
def narrow() -> tuple[Path, Clearance]:
    return widest(*NARROW)


def widest(*asked: Any, **options: Any) -> tuple[Path, Clearance]:
    path = joint_path(FIRST, *asked, **{"clearance": "best", "samples": 2} | options)
    assert isinstance(path, Path)
    assert path.clearance is not None
    return path, path.clearance


def is_clear(path: Path, proved: Fraction, count: int = 60) -> bool:
    """Whether J has the sign of the path at poses within the clearance from its samples."""
    mover = Mover.of(path.manipulator, path.fixed_leg)
    for sample in path.resampled(count).samples:
        alpha, theta = angles_of(sample)
        length = float(sample.lengths[path.fixed_leg - 1])
        for k in range(24):
            reach = radians(float(proved)) * 0.9999
            at = alpha + reach * cos(2 * pi * k / 24), theta + reach * sin(2 * pi * k / 24)
            if mover.determinant(*at, length) * path.sign <= 0:
                return False
    return True


def test_the_widest_path_is_as_wide_as_a_grid_finds() -> None:
    path, clearance = narrow()
    assert is_clear(path, clearance.proved)
    assert arrives(path, 400) < 1e-6
    first, last = ((float(end.alpha_deg), float(end.theta_deg)) for end in (path.start, path.stop))
    bottleneck = WidthGrid(FIRST, 1, 27, 180).bottleneck(first, last)
    assert bottleneck is not None
    assert clearance.bound is not None
    assert 0.9 * bottleneck <= float(clearance.proved) <= 1.1 * bottleneck
    distances = [WidthGrid(FIRST, 1, 27, 180).distance(spot) for spot in (first, last)]
    assert float(clearance.bound) == pytest.approx(min(distances), rel=0.01)
    plain = joint_path(FIRST, *NARROW, samples=2)
    assert not is_clear(plain, clearance.proved)  # type: ignore[arg-type]


def test_a_way_between_arcs_that_nearly_meet_is_not_taken_for_narrow() -> None:
    """J is nearly 0 on a ridge between two arcs 13° apart, where steps towards them do not arrive."""
    m = Manipulator("4.9", "14.1", "0.001", "17.5", "5.6", "12.7", "cw")
    path = joint_path(m, "29.38", "49.308", "52.528", 4, 3, clearance="best", samples=2)
    assert isinstance(path, Path)
    assert path.clearance is not None
    first, last = ((float(end.alpha_deg), float(end.theta_deg)) for end in (path.start, path.stop))
    bottleneck = WidthGrid(m, 1, 29.38, 180).bottleneck(first, last)
    assert bottleneck is not None
    assert float(path.clearance.proved) >= 0.8 * bottleneck


def test_a_clearance_is_required() -> None:
    _, clearance = widest(*NARROW, clearance="8")
    assert clearance.asked == "8"
    assert clearance.proved >= 8
    none = joint_path(FIRST, *NARROW, clearance=20)
    assert isinstance(none, NoPath)
    assert none.obstacle is Obstacle.TOO_NARROW
    assert none.clearance is not None
    assert none.clearance.bound is not None
    assert none.clearance.proved < none.clearance.bound < 20
    document = none.to_json()
    assert document["clearance"] == none.clearance.to_json()
    assert document["connected"] is False


def test_what_lies_between_both_bounds_is_undecided() -> None:
    _, clearance = narrow()
    asked = clearance.proved + Fraction(1, 10**5)
    none = joint_path(FIRST, *NARROW, clearance=asked)
    assert isinstance(none, NoPath)
    assert none.obstacle is Obstacle.UNDECIDED


def test_a_small_change_of_legs_meets_no_fold() -> None:
    """Legs that change by less than the bound carry the pose without a change of the sign of J."""
    path, clearance = widest(27, 20, 20, 1, 2)
    mover = Mover.of(FIRST)
    random = Random(1)
    for sample in path.resampled(12).samples:
        legs = [float(x) for x in sample.lengths]
        angle, size = random.uniform(0, 2 * pi), 0.999 * float(clearance.legs)
        goal = [legs[0], legs[1] + size * cos(angle), legs[2] + size * sin(angle)]
        steps = [[x + (y - x) * k / 20 for x, y in zip(legs, goal, strict=True)] for k in range(21)]
        start = angles_of(sample)
        for k in range(1, 21):
            place = mover.followed(start, steps[: k + 1])
            assert mover.determinant(*place, legs[0]) * path.sign > 0


def test_the_path_turns_no_sharper_than_it_says() -> None:
    path, clearance = narrow()
    assert clearance.radius is not None
    arcs = path.route.at(64)
    for arc in arcs:
        x, y = ([float(c) for c in p] for p in (arc.alpha, arc.theta))
        for k in range(101):
            slope = [c[1] + 2 * c[2] * k / 100 for c in (x, y)]
            cross = abs(slope[0] * 2 * y[2] - slope[1] * 2 * x[2])
            radius = (slope[0] ** 2 + slope[1] ** 2) ** 1.5 / cross
            assert radius * 180 / pi >= float(clearance.radius) * (1 - 1e-9)


def test_the_widest_path_keeps_limits() -> None:
    limits = {"l2": (5, 22)}
    path, clearance = widest(27, 20, 20, 3, 4, limits=limits)
    assert is_clear(path, clearance.proved, 20)
    assert all(5 <= float(sample.lengths[1]) <= 22 for sample in path.resampled(200).samples)


@pytest.mark.parametrize("clearance", ["0", "-1", "widest", 0])
def test_a_clearance_is_a_positive_number(clearance: Any) -> None:
    with pytest.raises(InputError, match="clearance"):
        joint_path(FIRST, 27, 20, 20, 1, 2, clearance=clearance)


def test_a_free_leg_makes_the_way_wider() -> None:
    path, clearance = widest(*NARROW, between=(27, 30))
    assert path.between == (27, 30)
    assert path.to_json()["clearance"] == clearance.to_json()
    _, held = narrow()
    assert held.proved * 2 < clearance.proved
    assert {float(sample.lengths[0]) > 27 for sample in path.resampled(9).samples} == {True, False}
    assert is_clear(path, clearance.proved)
    assert arrives(path, 400) < 1e-6
    assert clearance.bound is not None
    assert clearance.proved <= clearance.bound


@pytest.mark.long
def test_a_wide_path_in_a_range_keeps_limits_of_all_legs() -> None:
    limits = {"l1": (26, 29), "l2": (5, 22)}
    path, clearance = widest(27, 20, 20, 3, 4, between=(20, 40), limits=limits)
    assert is_clear(path, clearance.proved, 20)
    for sample in path.resampled(100).samples:
        lengths = [float(x) for x in sample.lengths]
        assert 26 <= lengths[0] <= 29
        assert 5 <= lengths[1] <= 22


def test_a_loop_is_made_wide() -> None:
    old = cusp_loop(FIRST, 27, "B", samples=2)
    loop = cusp_loop(FIRST, 27, "B", samples=2, clearance="best")
    assert loop.clearance is not None
    assert (loop.winding, loop.sign, loop.clearance.bound) == (1, old.sign, None)
    assert is_clear(loop, loop.clearance.proved)
    assert not is_clear(old, loop.clearance.proved)
    assert arrives(loop, 400) < 1e-6
    with pytest.raises(Unproved, match="the greatest that was proved"):
        cusp_loop(FIRST, 27, "B", clearance=40)


def compared(count: int, seed: int, size: int = 360) -> tuple[Counter[str], list[float]]:
    """Widest paths of random pairs of poses, and their clearances over the bottlenecks of the grid."""
    random = Random(seed)
    found: Counter[str] = Counter()
    shares = []
    while found["path"] < count:
        m, leg = a_manipulator(random), random.choice([1, 2, 3])
        length = Fraction(f"{random.uniform(0.1, 1.5) * (float(m.d1) + float(m.d2)):.2f}")
        spots = [(random.randint(-1799, 1800) / 10, random.randint(-1799, 1800) / 10) for _ in range(2)]
        share = _share(m, leg, length, (spots[0], spots[1]), found, size)
        if share is not None:
            shares.append(share)
    return found, shares


def _share(
    m: Manipulator, leg: int, length: Fraction, spots: tuple[Spot, Spot], found: Counter[str], size: int
) -> float | None:
    names = "alpha_deg", f"theta{leg}_deg", f"l{leg}"
    ends = [dict(zip(names, (str(a), str(t), length), strict=True)) for a, t in spots]
    try:
        path = pose_path(m, *ends, fixed_leg=leg, samples=2, clearance="best")
    except (InputError, SolverError) as error:
        found[f"{type(error).__name__}: {error}"] += 1
        return None
    if isinstance(path, NoPath):
        return None
    found["path"] += 1
    assert path.clearance is not None
    proved, bound = path.clearance.proved, path.clearance.bound
    assert is_clear(path, proved, 20)
    bottleneck = WidthGrid(m, leg, float(length), size).bottleneck(*spots)
    if bottleneck is None:
        found["not joined on the grid"] += 1
        return None
    # the grid sees the curve as points, and so a little farther
    assert bound is None or proved <= bound
    assert bound is None or float(bound) >= bottleneck * 0.99 - 0.01
    return float(proved) / bottleneck


def test_a_pair_is_as_wide_as_the_grid_says() -> None:
    found, shares = compared(1, 5, 120)
    assert found["path"] == 1
    assert min(shares) >= 0.9


@pytest.mark.long
def test_100_pairs_are_as_wide_as_the_grid_says() -> None:
    found, shares = compared(100, 1)
    assert min(shares) >= 0.9, (found, sorted(shares)[:10])


def share_in_range(random: Random, slices: int, size: int) -> tuple[float, Fraction | None, float]:
    """The clearance of the widest path between random poses in a random range, its upper bound, and the
    bottleneck of a grid of all three coordinates."""
    while True:
        m, leg = a_manipulator(random), random.choice([1, 2, 3])
        low = Fraction(f"{random.uniform(0.1, 1.3) * (float(m.d1) + float(m.d2)):.2f}")
        high = Fraction(f"{float(low) * random.uniform(1.05, 1.8):.2f}")
        names = "alpha_deg", f"theta{leg}_deg", f"l{leg}"
        lengths = [low + (high - low) * Fraction(k, slices - 1) for k in range(slices)]
        own = [
            (random.randint(-1799, 1800) / 10, random.randint(-1799, 1800) / 10, random.choice(lengths))
            for _ in range(2)
        ]
        ends = [dict(zip(names, (str(a), str(t), length), strict=True)) for a, t, length in own]
        try:
            path = pose_path(m, *ends, fixed_leg=leg, between=(low, high), samples=2, clearance="best")
        except (InputError, SolverError):
            continue
        if isinstance(path, NoPath) or path.clearance is None:
            continue
        places = [(a, t, float(x)) for a, t, x in own]
        bottleneck = bottleneck_of_range(m, leg, [float(x) for x in lengths], (places[0], places[1]), size)
        if bottleneck is not None:
            assert is_clear(path, path.clearance.proved, 20)
            return float(path.clearance.proved), path.clearance.bound, bottleneck


@pytest.mark.long
@pytest.mark.timeout(0)
def test_paths_in_ranges_are_as_wide_as_a_grid_of_three_coordinates_says() -> None:
    random = Random(3)
    found = [share_in_range(random, 17, 120) for _ in range(12)]
    assert min(proved / bottleneck for proved, _, bottleneck in found) >= 0.9, found
    # the grid sees the singular curve as points, and so a little farther
    assert all(bound is None or float(bound) >= 0.99 * bottleneck - 0.01 for _, bound, bottleneck in found)


@pytest.mark.long
@pytest.mark.parametrize("length", ["27", "28.1"])
def test_loops_are_twice_as_clear(length: str) -> None:
    eliminant = eliminant_of(FIRST)
    table = slice_for_loops(eliminant, length)
    before, after = [], []
    for cusp in range(1, table.count + 1):
        old, new = (
            loop_in_slice(eliminant, table, cusp, PathTerms.of(samples=2, clearance=clearance))
            for clearance in (None, "best")
        )
        ends = old.route.start, old.route.stop
        span = (old.route.start.legs[0],) * 2
        was = Corridors.of(ends, span, old.sign).clearance(old.route, bounded=False)
        assert was is not None
        assert new.clearance is not None
        before.append(was.proved)
        after.append(new.clearance.proved)
    assert all(x >= y * Fraction(99, 100) for x, y in zip(after, before, strict=True))
    assert median(after) >= 2 * median(before)
