"""Polylines that are simplified stay where they were; those that are clipped stay inside."""

from itertools import pairwise
from math import cos, hypot, pi, sin

import pytest

from rpr_solver.notebook.scene import Box, clipped, distance, simplified

CIRCLE = [(100 * cos(k * pi / 180), 100 * sin(k * pi / 180)) for k in range(361)]


@pytest.mark.parametrize("tolerance", [0.05, 1.0])
def test_a_simplified_circle_is_still_one(tolerance: float) -> None:
    line = simplified(CIRCLE, tolerance)
    assert (line[0], line[-1]) == (CIRCLE[0], CIRCLE[-1])
    assert len(line) < 150
    for (ax, ay), (bx, by) in pairwise(line):
        assert abs(hypot((ax + bx) / 2, (ay + by) / 2) - 100) < 1.01 * tolerance


def test_a_line_that_returns_to_its_start_keeps_its_far_point() -> None:
    assert simplified([(0, 0), (5, 1), (9, 0), (5, -1), (0, 0)], 0.1) == [
        (0, 0),
        (5, 1),
        (9, 0),
        (5, -1),
        (0, 0),
    ]
    assert simplified([(0, 0), (1, 1)], 5) == [(0, 0), (1, 1)]


def test_pieces_in_a_box() -> None:
    box = Box(-50, -200, 50, 200)
    pieces = list(clipped(CIRCLE, box))
    assert len(pieces) == 2
    for piece in pieces:
        assert {round(abs(piece[0][0]), 6), round(abs(piece[-1][0]), 6)} == {50}
        assert all(point in box.grown(1e-9) for point in piece)


def test_a_line_inside_is_one_piece_and_one_outside_is_none() -> None:
    assert [len(piece) for piece in clipped(CIRCLE, Box(-101, -101, 101, 101))] == [361]
    assert list(clipped(CIRCLE, Box(200, 0, 300, 100))) == []
    assert list(clipped([(0, 0), (0, 9)], Box(1, 1, 2, 2))) == []


def test_boxes() -> None:
    assert Box.around([(3, 1), (-1, 4)]) == Box(-1, 1, 3, 4)
    assert Box(0, 0, 2, 2).meets(Box(1, 1, 3, 3))
    assert not Box(0, 0, 2, 2).meets(Box(2, 0, 3, 3))
    assert distance((0, 0), (3, 4)) == 5
