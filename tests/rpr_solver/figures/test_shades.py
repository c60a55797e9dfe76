"""The areas between curves cover a box, each with its number of poses."""

from __future__ import annotations

from math import cos, pi, sin
from random import Random

import pytest

from rpr_solver import EXAMPLES, singular_curves
from rpr_solver.figures.insets import areas
from rpr_solver.figures.strands import SliceCurves
from rpr_solver.notebook.scene import Box, Point, area


def circle(x: float, y: float, radius: float) -> list[Point]:
    """Counter-clockwise in a picture, where heights grow downwards; exactly closed."""
    turns = [2 * pi * (k % 60) / 60 for k in range(61)]
    return [(x + radius * cos(t), y - radius * sin(t)) for t in turns]


def covered(lines: list[tuple[list[Point], int]], box: Box) -> dict[int, float]:
    """The area of each number of poses."""
    total: dict[int, float] = {}
    for poses, ring in areas(lines, box):
        total[poses] = total.get(poses, 0.0) + abs(area(ring))
    return total


def test_two_circles_and_what_they_have_in_common() -> None:
    one, other = circle(100, 100, 60), circle(160, 100, 60)
    found = covered([(one, 1), (other, 1)], Box(0, 0, 300, 200))
    disc = abs(area(one[:-1]))
    assert sum(found.values()) == pytest.approx(300 * 200)
    assert 2 * found[4] + found[2] == pytest.approx(2 * disc)
    lens = 2 * 60**2 * (pi / 3) - 0.5 * 60 * 60 * 3**0.5  # of circles with the distance of their radius
    assert found[4] == pytest.approx(lens, rel=0.01)


def test_a_hole_and_a_box_inside_a_circle() -> None:
    ring = [(circle(100, 100, 60), 1), (circle(100, 100, 20), -1)]
    assert set(covered(ring, Box(0, 0, 200, 200))) == {0, 2}
    assert covered(ring, Box(90, 90, 110, 110)) == {0: pytest.approx(400)}
    assert covered(ring, Box(50, 95, 60, 105)) == {2: pytest.approx(100)}


@pytest.mark.parametrize(("name", "length"), [("innocenti", "27"), ("zein-flat", "3")])
def test_the_numbers_are_those_that_the_document_proves(name: str, length: str) -> None:
    document = singular_curves(EXAMPLES[name], length).to_json()
    curves = SliceCurves.of(document)
    lines = list(zip(curves.lines(curves.floats.lengths), curves.senses, strict=True))
    for region in document["regions"]:
        x, y = (float(region["point"][member]) for member in ("l2", "l3"))
        found = covered(lines, Box(x - 1e-6, y - 1e-6, x + 1e-6, y + 1e-6))
        assert list(found) == [region["poses"]]


def test_a_box_of_random_segments_is_covered_once() -> None:
    rng = Random(5)
    for _ in range(20):
        ring = [(rng.uniform(-50, 150), rng.uniform(-50, 150)) for _ in range(8)]
        found = covered([([*ring, ring[0]], 1)], Box(0, 0, 100, 100))
        assert sum(found.values()) == pytest.approx(100 * 100)
