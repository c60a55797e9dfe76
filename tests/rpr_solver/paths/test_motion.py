"""Motions within limits of speed, acceleration and jerk: they are kept at many times, and used up."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import pairwise
from random import Random
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Path, SolverError, cusp_loop, joint_path
from rpr_solver.model.lengths import MotionLimits
from tests.rpr_solver.paths.test_joint_paths import a_pair

FIRST = EXAMPLES["innocenti"]


@cache
def the_loop() -> Path:
    return cusp_loop(FIRST, 27, "B", samples=2)


@cache
def joined() -> Path:
    """Two arcs, which meet smoothly."""
    found = joint_path(FIRST, 27, "25.7", "9.2", 2, 4, between=(27, 30), samples=2)
    assert isinstance(found, Path)
    return found


USUAL = {"speed": 10, "acceleration": 20}
KINDS = ("speed", "acceleration", "jerk")


def differences(path: Path, order: int, every: int) -> list[float]:
    """For each leg the greatest difference of its lengths of an order, by the step of time to this power."""
    rows = [[Fraction(x) for x in sample.lengths] for sample in path.samples[::every]]
    step = path.duration * every / (len(path.samples) - 1)
    for _ in range(order):
        rows = [[y - x for x, y in zip(*pair, strict=True)] for pair in pairwise(rows)]
    return [float(max(abs(row[k]) for row in rows) / step**order) for k in range(3)]


def used(path: Path, limits: MotionLimits) -> list[float]:
    """Which share of its limits of speed, acceleration and jerk a path uses, by its samples."""
    own = [limits.speed, limits.acceleration, *([limits.jerk] if limits.jerk else [])]
    # the mean value theorem: a difference is a derivative somewhere between; jerks of finer rows are noise
    return [
        max(x / float(limit[leg]) for leg, x in enumerate(differences(path, order, every), 1) if x > 1e-9)
        for order, (limit, every) in enumerate(zip(own, (1, 1, 5), strict=False), 1)
    ]


def random_path(random: Random) -> Path:
    """A path between random poses of one joint vector, in a slice or in a range."""
    while True:
        if (pair := a_pair(random)) is None:
            continue
        manipulator, lengths, leg, start, stop = pair
        length = lengths[leg - 1]
        between = random.choice([None, (length * Fraction(7, 10), length * Fraction(3, 2))])
        try:
            found = joint_path(manipulator, *lengths, start, stop, fixed_leg=leg, between=between, samples=2)
        except SolverError:
            continue
        if isinstance(found, Path):
            return found


def random_motion(random: Random) -> dict[str, Any]:
    limits: dict[str, Any] = {
        kind: {f"l{leg}": f"{10 ** random.uniform(-1, 2):.3g}" for leg in (1, 2, 3)} for kind in KINDS
    }
    if random.random() < 0.5:
        del limits["jerk"]
    return limits


def keeps(random: Random, count: int) -> list[float]:
    """The shares that a random path uses of random limits, at so many samples."""
    path, motion = random_path(random), random_motion(random)
    shares = used(path.resampled(count, motion=motion), MotionLimits.of(motion))
    assert max(shares) <= 1 + 1e-6, (path, motion, shares)
    return shares


def test_limits_are_kept_at_many_samples() -> None:
    random = Random(2)
    assert max(keeps(random, 401)) > 0.5


@pytest.mark.long
def test_limits_are_kept_at_10001_samples_of_100_paths() -> None:
    random = Random(1)
    shares = [max(keeps(random, 10_001)) for _ in range(100)]
    assert min(shares) > 0.2


@pytest.mark.parametrize("jerk", [{}, {"jerk": 200}])
def test_limits_are_used(jerk: dict[str, int]) -> None:
    motion = USUAL | jerk
    path = the_loop().resampled(501, motion=motion)
    shares = used(path, MotionLimits.of(motion))
    assert max(shares) <= 1 + 1e-6
    assert max(shares) > 0.8
    assert path.timing == "motion"


def test_with_limits_of_jerk_legs_rest_where_arcs_meet() -> None:
    path = joined().resampled(2, motion=USUAL | {"jerk": 200})
    [stop] = path.to_json()["motion"]["stops"]
    moved, near = path.motion, Fraction(stop) / 10**6
    assert moved is not None
    assert moved.place(Fraction(stop)) == (1, 0)
    for time in (Fraction(stop) - near, Fraction(stop) + near):
        arc, tau = moved.place(time)
        # a rest: the way grows with the square of the time
        assert min(tau, 1 - tau) < Fraction(1, 10**8), arc


def test_legs_pass_smooth_joints_of_arcs_without_a_rest() -> None:
    path = joined().resampled(401, motion=USUAL)
    assert path.to_json()["motion"]["stops"] == []
    assert max(used(path, MotionLimits.of(USUAL))) <= 1 + 1e-6
    [run] = path.to_json()["certificate"]["motion"]
    assert run["shares"] == ["0.5", "0.5"]


BAD: Sequence[tuple[Any, str]] = [
    ({"speed": 1}, "motion: "),
    (5, "motion: "),
    ({"speed": 1, "acceleration": 0}, "motion.acceleration: is 0; a limit must be > 0"),
    ({"speed": {}, "acceleration": 1}, "motion.speed: has no limits"),
    ({"speed": {"l4": 1}, "acceleration": 1}, "motion.speed: 'l4'"),
    ({"speed": {"l2": 1}, "acceleration": 1}, "motion.speed.l3: is missing; this leg moves, too"),
]


@pytest.mark.parametrize(("motion", "text"), BAD)
def test_limits_that_cannot_be_read_are_named(motion: Any, text: str) -> None:
    with pytest.raises(InputError) as caught:
        the_loop().resampled(motion=motion)
    assert text in str(caught.value)


@pytest.mark.parametrize("option", [{"timing": "constant"}, {"duration": 2}])
def test_times_follow_from_limits(option: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="follows from motion"):
        the_loop().resampled(motion=USUAL, **option)
