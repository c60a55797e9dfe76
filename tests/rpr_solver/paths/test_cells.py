"""Cells and ways: signs, aspects and straight lines against J in floats."""

from fractions import Fraction
from itertools import pairwise
from math import pi

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.cells import Cells
from tests.support.motions import Mover

FIRST = EXAMPLES["innocenti"]


def cells_at(length: str, leg: int = 1) -> Cells:
    slice_map = SliceMap.of(FIRST, leg)
    return Cells.of(slice_map, Fraction(length) * slice_map.scale)


@pytest.mark.parametrize(("length", "leg", "aspects"), [("27", 1, 3), ("14.98", 1, 2), ("20", 3, 3)])
def test_cells_have_the_sign_of_j_and_ways_stay_in_an_aspect(length: str, leg: int, aspects: int) -> None:
    cells, mover = cells_at(length, leg), Mover.of(FIRST, leg)
    assert len(set(cells.aspects.values())) == aspects
    spots = [(2 * pi * i / 7 - 3, 2 * pi * k / 5 - 3) for i in range(7) for k in range(5)]
    with ctx.workprec(128):
        places = [cells.cell_of((arb(alpha), arb(theta))) for alpha, theta in spots]
    for (alpha, theta), cell in zip(spots, places, strict=True):
        assert mover.determinant(alpha, theta, float(Fraction(length))) * cells.sign(cell) > 0
    joined = 0
    for first, last in ((0, 9), (3, 20), (5, 31), (12, 33), (7, 26), (2, 16)):
        way = cells.way(spots[first], places[first], spots[last], places[last])
        if way is None:
            assert cells.aspects[places[first]] != cells.aspects[places[last]]
            continue
        joined += 1
        for x, y in zip(way[-1], spots[last], strict=True):
            assert (x - y) / (2 * pi) == pytest.approx(round((x - y) / (2 * pi)), abs=1e-9)
        for (a, b), (c, d) in pairwise(way):
            for share in (0.0, 0.3, 0.7):
                at = a + share * (c - a), b + share * (d - b), float(Fraction(length))
                assert mover.determinant(*at) * cells.sign(places[first]) > -1e-9
    assert joined
