"""Routes in a slice and in a range against a search on a dense grid.

Short smooth routes from polylines.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import pi
from random import Random

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Path,
    SolverError,
    joint_path,
    poses,
)
from rpr_solver.model.lengths import Bounds
from tests.support.motions import Mover, angles_of, apart, legs_of

GRID = 400


def joined_on_a_grid(
    ends: Path | NoPath,
    lengths: Sequence[float],
    limits: Mapping[int, Bounds] | None = None,
) -> bool:
    """Whether a flood on a grid, within the limits, leads from one pose to the other, where J has its sign in
    one of the slices; the first is that of the poses."""
    mover = Mover.of(ends.manipulator, ends.fixed_leg)
    fixed = ends.fixed_leg - 1
    turns = [cmath.rect(1, (k + 0.5) * 2 * pi / GRID - pi) for k in range(GRID)]
    legs = [(mover.platform[i] - mover.platform[fixed], mover.base[i] - mover.base[fixed]) for i in range(3)]
    (first, second) = (leg for i, leg in enumerate(legs) if i != fixed)

    walls = [
        (low or 0, float("inf") if high is None else high)
        for low, high in ((limits or {}).get(leg, (None, None)) for leg in (1, 2, 3) if leg != fixed + 1)
    ]

    def has_sign(i: int, k: int, length: float) -> bool:
        slopes = []
        for (platform, base), (low, high) in zip((first, second), walls, strict=True):
            arm, tip = turns[i] * platform, length * turns[k]
            vector = (tip + arm - base).conjugate()
            if not low <= abs(vector) <= high:
                return False
            slopes.append(((vector * 1j * arm).real, (vector * 1j * tip).real))
        (fa, ft), (ga, gt) = slopes
        return (fa * gt - ft * ga > 0) == sign

    start, stop = (
        tuple(int(((x + pi) % (2 * pi)) / (2 * pi) * GRID) % GRID for x in angles_of(end))
        for end in (ends.start, ends.stop)
    )
    sign = mover.determinant(*angles_of(ends.start), lengths[0]) > 0
    seen, queue = {start}, [start]
    while queue and stop not in seen:
        x, y = queue.pop()
        for other in (((x + 1) % GRID, y), ((x - 1) % GRID, y), (x, (y + 1) % GRID), (x, (y - 1) % GRID)):
            if other not in seen:
                seen.add(other)
                if other == stop or any(has_sign(*other, length) for length in lengths):
                    queue.append(other)
    return stop in seen


def a_pair(random: Random) -> tuple[Manipulator, tuple[Fraction, ...], int, int, int] | None:
    """A random manipulator with a joint vector that has two poses with J of one sign."""
    values = [Fraction(random.randint(-300, 300), 10) for _ in range(3)]
    sides = [Fraction(random.randint(10, 400), 10) for _ in range(3)]
    try:
        manipulator = Manipulator(*values, *sides, orientation=random.choice(("ccw", "cw")))
    except InputError:
        return None
    leg, length = random.choice((1, 2, 3)), Fraction(random.randint(10, 500), 10)
    legs = Mover.of(manipulator, leg).legs(random.uniform(-3, 3), random.uniform(-3, 3), float(length))
    lengths = [Fraction(round(x * 100), 100) for x in legs]
    lengths[leg - 1] = length
    if min(lengths) <= 0:
        return None
    try:
        table = poses(manipulator, *lengths, digits=20).poses
    except SolverError:
        return None
    mover = Mover.of(manipulator, leg)
    signs = []
    for pose in table:
        at = [float(x) * pi / 180 for x in (pose.alpha_deg, pose.to_json()[f"theta{leg}_deg"])]
        signs.append(mover.determinant(at[0], at[1], float(length)) > 0)
    pairs = [(i, k) for i in range(len(signs)) for k in range(i) if signs[i] == signs[k]]
    if not pairs:
        return None
    i, k = random.choice(pairs)
    return manipulator, tuple(lengths), leg, i + 1, k + 1


def agrees(random: Random) -> bool | None:
    """Whether a random pair is joined, having compared it with the grid."""
    pair = a_pair(random)
    if pair is None:
        return None
    manipulator, (l1, l2, l3), leg, start, stop = pair
    found = joint_path(manipulator, l1, l2, l3, start, stop, fixed_leg=leg, samples=2)
    length = float((l1, l2, l3)[leg - 1])
    assert joined_on_a_grid(found, [length]) == isinstance(found, Path)
    if isinstance(found, Path):
        mover, samples = Mover.of(manipulator, leg), found.resampled(2001).samples
        for sample in samples:
            place = *angles_of(sample), legs_of(sample)[leg - 1]
            assert mover.legs(*place) == pytest.approx(legs_of(sample), rel=1e-6)
            assert mover.determinant(*place) * found.sign > 0
        assert max(apart(angles_of(x), angles_of(y)) for x, y in pairwise(samples)) < 0.5
    return isinstance(found, Path)


@pytest.mark.long
def test_a_hundred_random_pairs_agree_with_a_dense_grid() -> None:
    random, outcomes = Random(3), []
    while len(outcomes) < 100:
        outcome = agrees(random)
        if outcome is not None:
            outcomes.append(outcome)
    assert sum(outcomes) > 50
    assert outcomes.count(False) > 1


@pytest.mark.long
def test_ranges_agree_with_a_dense_grid() -> None:
    """Two poses of the island at L1 = 27, with leg 1 free in a range."""
    random, outcomes = Random(0), set()
    for _ in range(24):
        other = Fraction(random.randint(200, 340), 10)
        low, high = sorted((Fraction(27), other))
        between = (low, high if high > low else high + 1)
        found = joint_path(EXAMPLES["innocenti"], 27, "25.7", "9.2", 2, 4, between=between, samples=2)
        assert joined_on_a_grid(found, [27.0, float(other)]) == isinstance(found, Path)
        outcomes.add(isinstance(found, Path))
    assert outcomes == {True, False}
