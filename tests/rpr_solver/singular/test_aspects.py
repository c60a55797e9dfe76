"""Aspects: their numbers, their areas, and the sign of J in their polygons."""

from __future__ import annotations

from fractions import Fraction
from math import radians

import pytest

from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.aspects import aspect_cells
from rpr_solver.singular.floats import FloatSlice
from tests.support.singular import SLICES, manipulator, swept, traced


@pytest.mark.parametrize(
    ("name", "leg", "length", "signs"),
    [
        ("innocenti", 1, "14.98", [1, -1]),
        ("innocenti", 1, "27", [1, 1, -1]),
        ("fourteen-cusps", 1, "5.96", [1, 1, -1]),
        ("similar", 1, "18", [1, 1, -1, -1]),
    ],
)
def test_numbers_of_aspects(name: str, leg: int, length: str, signs: list[int]) -> None:
    assert [sign for sign, _ in aspect_cells(swept(name, leg, length))] == signs


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_polygons_cover_the_torus_with_the_right_sign(name: str, leg: int, length: str) -> None:
    curves = traced(name, leg, length)
    slice_map = SliceMap.of(manipulator(name), leg)
    floats = FloatSlice.of(slice_map, Fraction(length) * slice_map.scale)
    assert sum(aspect.share for aspect in curves.aspects) == pytest.approx(1, abs=2e-3)
    assert [aspect.sign for aspect in curves.aspects] == [
        s for s, _ in aspect_cells(swept(name, leg, length))
    ]
    for aspect in curves.aspects:
        for polygon in aspect.polygons:
            assert all(-180 <= x <= 180 for point in polygon for x in point)
        for alpha, theta in [(a, b) for a in range(-175, 180, 41) for b in range(-171, 180, 53)]:
            if any(_deep_inside(polygon, alpha, theta) for polygon in aspect.polygons):
                value, _ = floats.on_line(radians(theta)).value_and_slope(radians(alpha))
                assert (value > 0) == (aspect.sign > 0)


def _deep_inside(polygon: tuple[tuple[float, float], ...], x: float, y: float) -> bool:
    shifts = ((0, 0), (1.5, 0), (-1.5, 0), (0, 1.5), (0, -1.5))
    return all(_holds(polygon, x + dx, y + dy) for dx, dy in shifts)


def _holds(polygon: tuple[tuple[float, float], ...], x: float, y: float) -> bool:
    inside = False
    for (ax, ay), (bx, by) in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside
