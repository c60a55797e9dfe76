"""Samples lie on the path, are correctly rounded, and bound their distance from singularity.

The clearance is a lower bound: no singular pose of the slice is nearer.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from math import cos, degrees, pi, sin

import pytest

from rpr_solver import EXAMPLES, Manipulator, Path, cusp_loop, cusp_table
from tests.support.motions import Mover, angles_of

pytestmark = pytest.mark.quick

FIRST = EXAMPLES["innocenti"]


@cache
def the_loop() -> Path:
    return cusp_loop(FIRST, "28.1", "F", samples=9, digits=20)


def test_more_digits_agree_with_fewer() -> None:
    more = cusp_loop(FIRST, "28.1", "F", samples=9, digits=50)
    for short, long in zip(the_loop().samples, more.samples, strict=True):
        for name, text in short.to_json(1).items():
            if name not in ("time", "clearance_deg"):
                accuracy = abs(Fraction(text)) / 10**19
                assert abs(Fraction(text) - Fraction(long.to_json(1)[name])) <= accuracy


@pytest.mark.parametrize("timing", ["cosine", "trapezoid", "constant"])
def test_times_are_exact_and_even(timing: str) -> None:
    path = the_loop().resampled(7, timing=timing, duration="1.5")
    assert [sample.time for sample in path.samples] == [Fraction(k, 4) for k in range(7)]
    assert (path.timing, path.duration) == (timing, Fraction(3, 2))


def test_a_symmetric_loop_has_its_middle_sample() -> None:
    """There α is exactly 0, which cannot be rounded; the sample lies beside it."""
    symmetric = Manipulator(6, 3, 7, 8, 5, 5)
    [table] = cusp_table(symmetric, 9, digits=15, fixed_leg=3)
    assert table.count
    for cusp in range(1, table.count + 1):
        path = cusp_loop(symmetric, 9, cusp, fixed_leg=3, samples=3)
        assert len(path.samples) == 3


@pytest.mark.parametrize(("name", "length", "cusp"), [("fourteen-cusps", "5.96", 3)])
def test_no_singular_pose_is_nearer(name: str, length: str, cusp: int) -> None:
    manipulator: Manipulator = EXAMPLES[name]
    mover, path = Mover.of(manipulator), cusp_loop(manipulator, length, cusp, samples=5)
    for sample in path.samples:
        alpha, theta = angles_of(sample)
        clearance = float(sample.clearance_deg)
        found = min(
            first_zero(mover, alpha, theta, float(length), 2 * pi * k / 8, path.sign) for k in range(8)
        )
        assert 0 < clearance <= found
        # and not a bad one: near the curve both are |J| / |∇J|
        assert found < 30 * clearance


def first_zero(mover: Mover, alpha: float, theta: float, length: float, direction: float, sign: int) -> float:
    """The distance to the first change of sign in a direction, in degrees, to 1 %."""
    x, y, step = cos(direction), sin(direction), 1e-5
    distance = 0.0
    while distance < pi:
        if mover.determinant(alpha + distance * x, theta + distance * y, length) * sign < 0:
            break
        distance, step = distance + step, step * 1.05
    return degrees(distance)
