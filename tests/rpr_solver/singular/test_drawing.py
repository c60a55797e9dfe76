"""Strands as drawn: continuous, closed where they say so, J > 0 on their left.

Strands use every arc once; at the ends of open strands are nodes.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import hypot, radians

import pytest

from rpr_solver import Manipulator, singular_curves
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.slice_map import SliceMap
from tests.support.singular import SLICES, manipulator, traced


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_strands_are_continuous_with_j_positive_on_the_left(name: str, leg: int, length: str) -> None:
    slice_map = SliceMap.of(manipulator(name), leg)
    floats = FloatSlice.of(slice_map, Fraction(length) * slice_map.scale)
    for strand in traced(name, leg, length).strands:
        angles = list(zip(strand.alpha_deg, strand.theta_deg, strict=True))
        assert -180 < angles[0][0] <= 180
        assert -180 < angles[0][1] <= 180
        for (a, b), (c, d) in pairwise(angles):
            assert hypot(c - a, d - b) < 120
            if hypot(c - a, d - b) > 0.01:
                x, y = radians((a + c) / 2), radians((b + d) / 2)
                across = _slope(floats, x, y, radians(b - d), radians(c - a))
                assert across > -1e-4
        if strand.closed:
            turns = [(b - a) / 360 for a, b in zip(angles[0], angles[-1], strict=True)]
            assert turns == pytest.approx(strand.turns, abs=1e-6)
            assert (strand.first[0], strand.second[0]) == pytest.approx(
                (strand.first[-1], strand.second[-1]), abs=1e-4
            )


def _slope(floats: FloatSlice, alpha: float, theta: float, dx: float, dy: float) -> float:
    """The derivative of J along the unit vector of (dx, dy)."""
    h, size = 1e-5, hypot(dx, dy)
    values = [
        floats.on_line(theta + s * h * dy / size).value_and_slope(alpha + s * h * dx / size)[0]
        for s in (1, -1)
    ]
    return (values[0] - values[1]) / (2 * h)


def test_special_points_that_are_alike_in_floats_have_a_sample_each() -> None:
    """10^-31 beside a beak-to-beak a cusp and a turning point are 10^-16 apart."""
    m = Manipulator(1, -4, -2, 1, 4, 4, orientation="cw")
    curves = singular_curves(m, "7.8979048115615589557438301731466439", fixed_leg=2)
    for strand in curves.strands:
        assert all(a < b for (a, _), (b, _) in pairwise(strand.vertices))
