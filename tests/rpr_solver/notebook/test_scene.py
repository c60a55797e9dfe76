"""Polylines that are simplified stay where they were; those that are clipped stay inside.

The roles of a scene are those of all its shapes.

Text is legible on every ground, areas differ in lightness, and hues survive colour-blindness.
"""

from __future__ import annotations

from itertools import combinations, pairwise
from math import cos, dist, hypot, pi, sin

import pytest

from rpr_solver.notebook.scene import (
    COLOURS,
    Box,
    Disc,
    Group,
    Paint,
    Path,
    Text,
    clipped,
    colour,
    distance,
    roles,
    simplified,
)

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
    assert distance((0, 0), (3, 4)) == 5


LINE = [(0.0, 0.0), (1.0, 1.0)]


def test_roles_of_shapes_in_groups() -> None:
    shapes = (
        Group((Path((LINE,), Paint(stroke="curve")), Group((Disc((0, 0), 1, Paint("cusp", "ink")),)))),
        Text((0, 0), "A", role="soft", halo="paper"),
    )
    assert set(roles(shapes)) == {
        ("stroke", "curve"), ("fill", "cusp"), ("stroke", "ink"), ("fill", "soft"), ("stroke", "paper"),
    }  # fmt: skip


def rgb(code: str) -> list[float]:
    parts = [int(code[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    return [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]


def light(role: str, theme: str) -> float:
    red, green, blue = rgb(colour(role, "dark" if theme == "dark" else "light"))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(a: str, b: str, theme: str) -> float:
    first, second = sorted((light(a, theme), light(b, theme)))
    return (second + 0.05) / (first + 0.05)


def lab(channels: list[float]) -> list[float]:
    """CIELAB, in which distances are differences that are seen."""
    rows = ((0.4124, 0.3576, 0.1805, 0.9505), (0.2126, 0.7152, 0.0722, 1), (0.0193, 0.1192, 0.9505, 1.089))
    x, y, z = (
        max(sum(m * c for m, c in zip(row[:3], channels, strict=True)) / row[3], 1e-3) ** (1 / 3)
        for row in rows
    )
    return [116 * y - 16, 500 * (x - y), 200 * (y - z)]


THEMES = pytest.mark.parametrize("theme", ["light", "dark"])


@THEMES
def test_text_is_legible(theme: str) -> None:
    for role in ("ink", "soft", "cusp", *(f"line{k}" for k in range(1, 6))):
        assert contrast(role, "paper", theme) >= 4.5, role
    for ground in COLOURS:
        if ground.startswith(("poses", "plus", "minus", "tint")):
            assert contrast("ink", ground, theme) >= 4.5, ground


@THEMES
def test_curves_and_marks_stand_out_from_every_area(theme: str) -> None:
    for ground in ("paper", "poses0", "poses2", "poses4", "poses6"):
        assert contrast("curve", ground, theme) >= 3, ground


@THEMES
def test_neighbouring_areas_differ_in_grey(theme: str) -> None:
    areas = ["poses0", "poses2", "poses4", "poses6"]
    for a, b in pairwise(areas):
        assert contrast(a, b, theme) >= 1.15, (a, b)
    for k in (1, 2):
        assert contrast("plus1", f"minus{k}", theme) >= 1.05


@THEMES
def test_colours_of_curves_differ_for_those_who_see_no_red_or_no_green(theme: str) -> None:
    matrices = (  # Viénot, Brettel and Mollon: protanopia, deuteranopia
        ((0.11238, 0.88762, 0), (0.11238, 0.88762, 0), (0.00401, -0.00401, 1)),
        ((0.29275, 0.70725, 0), (0.29275, 0.70725, 0), (-0.02234, 0.02234, 1)),
    )
    for matrix in matrices:
        seen = {}
        for k in range(1, 6):
            channels = rgb(colour(f"line{k}", "dark" if theme == "dark" else "light"))
            seen[k] = lab([sum(m * c for m, c in zip(row, channels, strict=True)) for row in matrix])
        for a, b in combinations(seen, 2):
            assert dist(seen[a], seen[b]) > 18, (a, b)
