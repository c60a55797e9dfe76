"""Insets are made for cusps that cannot be seen, and for no other.

A slice in joint space: its cusps lettered in the order of the table, insets where they are needed.
"""

from __future__ import annotations

from functools import cache
from math import cos, pi, sin

import pytest

from rpr_solver import EXAMPLES, Manipulator, SingularCurves, singular_curves
from rpr_solver.contract import letter
from rpr_solver.figures.joint_plane import CLEAR, Spot, joint_figure, windows
from rpr_solver.notebook.scene import Group, Path, Point, area
from tests.support.pictures import check, every, words


def spike(at: Point, reach: float = 120.0, width: float = 40.0) -> list[Point]:
    """Two branches that begin at a cusp, which is point 20."""
    x, y = at
    steps = [k / 20 for k in range(21)]
    left = [(x - reach * s**2, y + width * s**3) for s in reversed(steps)]
    return [*left, *((x - reach * s**2, y - width * s**3) for s in steps[1:])]


def test_a_single_spike_is_seen() -> None:
    assert windows([spike((300, 200))], [Spot(0, 20)], [], 160) == []


def test_two_cusps_that_are_near_share_an_inset_that_parts_them() -> None:
    lines = [spike((300, 200)), spike((303, 204))]
    [window] = windows(lines, [Spot(0, 20), Spot(1, 20)], [], 160)
    assert window.members == (0, 1)
    assert 5 * 160 / window.box.width > CLEAR
    assert (300, 200) in window.box
    assert (303, 204) in window.box


def test_pairs_far_from_each_other_have_insets_of_their_own() -> None:
    lines = [spike((300, 200)), spike((303, 204)), spike((300, 500)), spike((300, 502))]
    found = windows(lines, [Spot(k, 20) for k in range(4)], [], 160)
    assert [window.members for window in found] == [(0, 1), (2, 3)]


def test_a_pair_within_a_group_has_an_inset_of_its_own() -> None:
    lines = [spike((300, 200)), spike((310, 200)), spike((310.01, 200.01))]
    found = windows(lines, [Spot(k, 20) for k in range(3)], [], 160)
    assert [window.members for window in found] == [(0, 1, 2), (1, 2)]
    assert 0.014 * 160 / found[1].box.width > CLEAR


def test_corners_and_foreign_curves_crowd_a_cusp_too() -> None:
    line = spike((300, 200))
    assert len(windows([line], [Spot(0, 20)], [(306, 200)], 160)) == 1
    circle = [(340 + 36 * cos(k * pi / 50), 200 + 36 * sin(k * pi / 50)) for k in range(101)]
    assert len(windows([line, circle], [Spot(0, 20)], [], 160)) == 1
    far = [(x + 40, y) for x, y in circle]
    assert windows([line, far], [Spot(0, 20)], [], 160) == []


@cache
def curves(name: str, length: str) -> SingularCurves:
    return singular_curves(EXAMPLES[name], length)


LONG = pytest.mark.long
SLICES = [
    ("innocenti", "14.98", 6, 1),
    pytest.param("innocenti", "27", 8, 2, marks=LONG),
    ("innocenti", "28.1", 10, 3),
    pytest.param("innocenti", "34", 4, 0, marks=LONG),
    ("zein-flat", "3", 4, 0),
    pytest.param("fourteen-cusps", "5.96", 14, 4, marks=LONG),
]


@pytest.mark.parametrize(("name", "length", "count", "insets"), SLICES)
def test_the_figures_of_the_article_and_beyond(name: str, length: str, count: int, insets: int) -> None:
    figure = joint_figure(curves(name, length).to_json())
    check(figure)
    shown = [word for text in words(figure) for word in text.split(", ")]
    assert {letter(k) for k in range(1, count + 1)} <= set(shown)
    assert sum(word.startswith("×") for word in shown) >= insets
    assert (insets == 0) == (not any(word.startswith("×") for word in shown))
    assert figure.scene.title == f"Singular curves at L1 = {length}: {count} cusps"
    groups = [shape.name for shape in every(figure.scene.shapes) if isinstance(shape, Group)]
    assert {f"cusp {letter(k)}" for k in range(1, count + 1)} <= set(groups)


def test_letters_are_those_of_the_table() -> None:
    slices = curves("innocenti", "14.98")
    text = joint_figure(slices.to_json()).scene.description
    for k, cusp in enumerate(slices.table.cusps, 1):
        assert f"{letter(k)} at L2 = {float(cusp.l2):.6g}, L3 = {float(cusp.l3):.6g}" in text


def test_regions_with_their_numbers_of_poses() -> None:
    slices = curves("zein-flat", "3")
    figure = joint_figure(slices.to_json())
    shown = words(figure)
    assert {"no pose", "2 poses", "4 poses"} <= set(shown)
    assert shown.count("0") == 3  # outside, the hole, and the first tick
    painted = [shape for shape in every(figure.scene.shapes[:1]) if isinstance(shape, Path)]
    assert len(painted) == len(slices.regions)
    for path in painted:
        assert [area(ring) > 0 for ring in path.lines] == [k == 0 for k in range(len(path.lines))]


@LONG
def test_another_leg_and_a_slice_without_cusps() -> None:
    figure = singular_curves(EXAMPLES["innocenti"], 16, fixed_leg=2).figure()
    check(figure)
    assert {"L1", "L3"} <= set(words(figure))
    empty = singular_curves(Manipulator(10, 5, 8, 5, 4, 5), "0.05").figure()
    check(empty)
