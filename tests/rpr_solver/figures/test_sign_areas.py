"""The areas of a torus between curves: they cover it, and are connected over its sides."""

from collections.abc import Callable
from math import cos, pi, sin

import pytest

from rpr_solver.figures.plane import Box, Point
from rpr_solver.figures.sign_areas import areas

BOX = Box(0, 0, 360, 360)


def circle(x: float, y: float, r: float) -> list[Point]:
    return [(x + r * cos(k * pi / 180), y + r * sin(k * pi / 180)) for k in range(361)]


def inside(x: float, y: float, r: float) -> Callable[[Point], int]:
    def sign(point: Point) -> int:
        dx, dy = ((p - c + 180) % 360 - 180 for p, c in zip(point, (x, y), strict=True))
        return 1 if dx * dx + dy * dy < r * r else -1

    return sign


@pytest.mark.parametrize(("x", "y"), [(180.0, 170.0), (5.0, 100.0), (200.0, 350.0), (3.0, 2.0)])
def test_a_disc_and_the_rest_wherever_the_disc_is(x: float, y: float) -> None:
    r = 50.0
    found = areas([circle(x, y, r)], [x - r, x + r], BOX, inside(x, y, r))
    assert [area.sign for area in found] == [-1, 1]
    assert found[1].size == pytest.approx(pi * r * r, rel=0.01)
    assert found[0].size + found[1].size == pytest.approx(360 * 360, rel=1e-3)
    for area in found:
        assert inside(x, y, r)(area.middle) == area.sign


def test_two_bands_round_the_torus() -> None:
    lines = [[(-20.0, 100.0), (400.0, 100.0)], [(0.0, 250.0), (360.0, 250.0)]]
    found = areas(lines, [], BOX, lambda point: 1 if 100 < point[1] < 250 else -1)
    assert [(area.sign, round(area.size / 360)) for area in found] == [(-1, 210), (1, 150)]


def test_without_curves_there_is_one_area() -> None:
    [area] = areas([], [], BOX, lambda _: 1)
    assert area.size == pytest.approx(360 * 360)
