"""Random pairs of poses, in slices and ranges, with limits and without: paths against a grid of poses.

A path must keep the sign of J and the limits at many places. Two poses that the grid joins may not be called
apart.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from math import radians
from random import Random
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
    pose_path,
    poses,
)
from tests.support.families import FAMILIES, family
from tests.support.motions import Mover, angles_of, legs_of
from tests.support.pair_grid import PairGrid, Place

Asked = dict[str, Any]
Limits = dict[int, tuple[Fraction, Fraction]]
_MANIPULATORS = (*EXAMPLES.values(), *(family(name) for name in FAMILIES if "flat" not in name))


def a_manipulator(random: Random) -> Manipulator:
    """One of the examples and of the families, or a generic one."""
    if random.random() < 0.5:
        return random.choice(_MANIPULATORS)
    while True:
        sizes = [f"{random.uniform(2, 20):.1f}" for _ in range(6)]
        try:
            return Manipulator(*sizes, random.choice(["ccw", "cw"]))
        except InputError:
            continue


def an_end(random: Random, m: Manipulator, leg: int, length: Fraction) -> tuple[Asked, Place]:
    """A random pose: by its angles, or by its number among those of its joint vector."""
    alpha, theta = (Fraction(random.randint(-1799, 1800), 10) for _ in range(2))
    place = radians(alpha), radians(theta), float(length)
    if random.random() < 0.5:
        return {"alpha_deg": alpha, f"theta{leg}_deg": theta, f"l{leg}": length}, place
    legs = [f"{x:.3f}" for x in Mover.of(m, leg).legs(*place)]
    legs[leg - 1] = str(length)
    table = poses(m, *legs, digits=15)
    if not table.count:
        return an_end(random, m, leg, length)
    number = random.randint(1, table.count)
    pose = table.poses[number - 1].to_json()
    angles = radians(float(pose["alpha_deg"])), radians(float(pose[f"theta{leg}_deg"]))
    return {"l1": legs[0], "l2": legs[1], "l3": legs[2], "pose": number}, (*angles, float(length))


def some_limits(random: Random, m: Manipulator, leg: int, places: tuple[Place, Place]) -> Limits:
    """Limits of the free legs that both poses keep, often narrowly."""
    limits = {}
    for k in {1, 2, 3} - {leg}:
        own = [Mover.of(m, leg).legs(*place)[k - 1] for place in places]
        room = random.choice([0.01, 0.1, 0.5, 2.0]) * max(own)
        low = max(min(own) - room, min(own) / 2)
        limits[k] = Fraction(f"{low:.4f}"), Fraction(f"{max(own) + room:.4f}")
    return limits


def is_kept(path: Path, leg: int, limits: Limits, span: tuple[float, float]) -> bool:
    """Whether samples of a path are regular poses of one sign within the limits and the range."""
    mover = Mover.of(path.manipulator, leg)
    for sample in path.resampled(301).samples:
        legs = legs_of(sample)
        assert mover.legs(*angles_of(sample), legs[leg - 1]) == pytest.approx(legs, rel=1e-8)
        assert span[0] - 1e-9 <= legs[leg - 1] <= span[1] + 1e-9
        assert float(sample.determinant) * path.sign > 0
        assert all(
            float(low) - 1e-9 <= legs[k - 1] <= float(high) + 1e-9 for k, (low, high) in limits.items()
        )
    return True


def compared(count: int, seed: int) -> Counter[str]:
    """What became of so many pairs, each compared with the grid."""
    random = Random(seed)
    found: Counter[str] = Counter()
    while found.total() < count:
        m, leg = a_manipulator(random), random.choice([1, 2, 3])
        size = float(m.d1) + float(m.d2)
        low = Fraction(f"{random.uniform(0.1, 1.5) * size:.2f}")
        high = low * random.choice([1, 1, Fraction(11, 10), Fraction(3, 2)])
        lengths = [low, high] if random.random() < 0.5 else [low, low]
        ends = [an_end(random, m, leg, length) for length in lengths]
        places = ends[0][1], ends[1][1]
        limits = some_limits(random, m, leg, places) if random.random() < 0.4 else {}
        between = None if low == high else (low, high)
        try:
            answer = pose_path(
                m, ends[0][0], ends[1][0], between=between, limits=limits, fixed_leg=leg, samples=2
            )
        except InputError:
            found["refused"] += 1
            continue
        except SolverError as error:
            found[f"unproved: {error}"] += 1
            continue
        span = float(low), float(high)
        if isinstance(answer, Path):
            assert is_kept(answer, leg, limits, span)
            found["path"] += 1
            continue
        assert isinstance(answer, NoPath)
        bounds = {k: (float(x), float(y)) for k, (x, y) in limits.items()}
        sizes = {"size": 90, "lengths": 16} if between else {"size": 360}
        is_joined = PairGrid(m, leg, span, bounds, **sizes).joins(*places)
        if answer.obstacle is Obstacle.UNDECIDED:
            found["undecided, but the grid joins" if is_joined else "undecided"] += 1
        else:
            assert not is_joined, (m, leg, ends, between, limits, answer.obstacle)
            found[answer.obstacle.value] += 1
    return found


def test_few_pairs_agree_with_the_grid() -> None:
    found = compared(8, 3)
    assert found["path"]
    assert found["opposite-signs"]


@pytest.mark.long
def test_500_pairs_agree_with_the_grid() -> None:
    found = compared(500, 1)
    undecided = sum(n for name, n in found.items() if name.startswith(("undecided", "unproved")))
    assert (undecided <= 15, found["path"] > 100) == (True, True), found
