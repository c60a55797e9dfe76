"""The slice in floats agrees with the jets in balls, and refuses what floats cannot hold."""

from __future__ import annotations

from fractions import Fraction
from math import cos, sin

import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, SolverError
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.float_slice import FloatSlice, newton
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap

ANGLES = st.floats(-3.1, 3.1)


@settings(max_examples=20)
@given(st.sampled_from(sorted(EXAMPLES)), st.sampled_from((1, 2, 3)), ANGLES, ANGLES)
def test_j_and_the_legs_are_those_of_the_jets(name: str, leg: int, alpha: float, theta: float) -> None:
    slice_map = SliceMap.of(EXAMPLES[name], leg)
    length = 7 * slice_map.scale
    floats = FloatSlice.of(slice_map, length)
    size = slice_map.scale / Fraction(floats.unit)
    pose = Pose(
        *map(arb, (cos(alpha), sin(alpha), cos(theta), sin(theta))),
        arb(int(length)),
        omega_ball(slice_map.radicand, 53),
    )
    local = LocalMap.at(slice_map, pose, 3)
    j = local.singularity()
    weight = float(size) ** 4 * floats.length
    line = floats.on_line(theta)
    value, slope = line.value_and_slope(alpha)
    own = float(j.value.mid()), float(j.alpha.value.mid()), float(j.alpha.alpha.value.mid())
    assert (value, slope) == pytest.approx([x / weight for x in own[:2]], abs=1e-9)
    assert line.slope_and_bend(alpha) == pytest.approx([x / weight for x in own[1:]], abs=1e-9)
    squares = [float(x.mid()) / float(size) ** 2 for x in local.squared_lengths()]
    assert [x * x for x in floats.joints(alpha, theta)] == pytest.approx(squares, abs=1e-9)


def test_lengths_beyond_floats_are_refused() -> None:
    huge = Manipulator(*(str(x) + "0" * 320 for x in (15, 1, 10, 17, 16, 20)))
    slice_map = SliceMap.of(huge)
    with pytest.raises(SolverError, match="double precision"):
        FloatSlice.of(slice_map, slice_map.scale)


def test_newton_gives_up_rather_than_wander() -> None:
    assert newton(lambda x: (x - 1, 1.0), 0.0) == pytest.approx(1)
    assert newton(lambda _: (1.0, 0.0), 0.0) is None
    assert newton(lambda x: (x - 5, 1.0), 0.0) is None
    assert newton(lambda x: (x * x + 1, 2 * x), 0.3) is None
