"""Curves of cusps of manipulators with roots, against those of rational ones very near and all slices."""

import json
from pathlib import Path
from typing import Any

import pytest

from rpr_solver import Manipulator, cusp_curves
from tests.support.sampling import long
from tests.support.triangle_spellings import rational_near

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]


GENERIC = [row for row in ROWS if "equilateral" not in str(row["geometry"])]
"""Of a special one the least change parts transitions that come together."""


@pytest.mark.parametrize("row", [GENERIC[1], *map(long, GENERIC[2::6])])
def test_the_curves_are_those_of_a_rational_manipulator(row: dict[str, Any]) -> None:
    m = Manipulator.from_json(row["geometry"])
    found, known = (cusp_curves(x, digits=15) for x in (m, rational_near(m)))
    assert [curve.name for curve in found.curves] == [curve.name for curve in known.curves]
    for own, other in zip(found.curves, known.curves, strict=True):
        assert (own.start.kind, own.stop.kind) == (other.start.kind, other.stop.kind)
        assert len(own.points) == len(other.points)
        for x, y in zip(own.points, other.points, strict=True):
            assert float(x.length) == pytest.approx(float(y.length), rel=1e-9)
            if x.length == y.length:
                assert x.point.coordinates == y.point.coordinates
