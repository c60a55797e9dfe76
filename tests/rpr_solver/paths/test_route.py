"""Isolated poses against the exact table of all poses.

Routes backwards and in documents.

Expansions along arcs against the manipulator's own legs, in floats.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.routes import Arc, Point, bounded, expanded

pytestmark = pytest.mark.quick

FIRST = EXAMPLES["innocenti"]


Three = tuple[float, float, float]
CURVED: list[Three] = [(0.2, -1.1, 14.0), (1.5, 0.3, 15.0), (0.7, 2.0, 17.5)]


def arc_of(slice_map: SliceMap, points: list[Three]) -> Arc:
    scale = float(slice_map.scale)
    scaled: list[Point] = [(arb(a), arb(t), arb(x * scale)) for a, t, x in points]
    return Arc.over(scaled)


def test_a_bound_holds_on_the_whole_piece() -> None:
    slice_map = SliceMap.of(FIRST)
    arc = arc_of(slice_map, CURVED)
    centre, radius = Fraction(3, 8), Fraction(1, 8)
    middle, r = arb(float(centre)), arb(float(radius))
    near, wide = expanded(slice_map, arc, middle, 1), expanded(slice_map, arc, arb(middle, r), 2)
    for k in range(-10, 11):
        at = expanded(slice_map, arc, middle + r * k / 10, 0)
        for name in ("first", "second", "singularity"):
            values = (getattr(form, name) for form in (near, wide))
            assert bounded(*values, r).contains(getattr(at, name)[0])
