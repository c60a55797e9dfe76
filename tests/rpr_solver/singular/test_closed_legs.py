"""Poses with a free leg of length 0: those of the triangle that is left, by exact arithmetic and by balls."""

from __future__ import annotations

from fractions import Fraction
from math import acos, atan2, degrees, hypot

import pytest

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.closed_legs import closed_legs
from rpr_solver.singular.sweep import sweep

INNOCENTI = EXAMPLES["innocenti"]


def poses_of(manipulator: Manipulator, length: str) -> list[tuple[float, ...]]:
    slice_map = SliceMap.of(manipulator, 1)
    swept = sweep(slice_map, Fraction(length) * slice_map.scale)
    return [tuple(map(float, vertex.point.coordinates)) for vertex, _ in closed_legs(swept, 15)]


@pytest.mark.parametrize("length", ["14.98", "27"])
def test_they_are_the_corners_of_triangles(length: str) -> None:
    """With B2 on A2 the triangle A1 A2 B1 has the sides a2x, d1 and L1; with B3 on A3 likewise."""
    poses, l1 = poses_of(INNOCENTI, length), float(length)
    expected = []
    for x, y, side in ((15.91, 0.0, 17.04), (0.0, 10.0, 20.84)):
        base = hypot(x, y)
        cosine = (base**2 + l1**2 - side**2) / (2 * base * l1)
        for sign in (1, -1) if abs(cosine) < 1 else ():
            expected.append(degrees(atan2(y, x) + sign * acos(cosine)))
    found = sorted(theta % 360 for _, theta, *_ in poses)
    assert found == pytest.approx(sorted(theta % 360 for theta in expected))
    assert [min(legs) for _, _, *legs in poses] == [0.0] * len(poses)


def test_an_angle_of_exactly_0_is_decided_exactly() -> None:
    """B3 = (5, 12) on the platform closes on A3 = (8, 16) with B1 = (3, 4); balls round 0 have no digits."""
    poses = poses_of(Manipulator(10, 8, 16, 14, 15, 13), "5")
    [pose] = [pose for pose in poses if pose[0] == 0]
    assert pose[1:] == (pytest.approx(degrees(atan2(4, 3))), pytest.approx(hypot(7, 4)), 0.0)
