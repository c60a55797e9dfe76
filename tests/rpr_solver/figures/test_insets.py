"""Insets are made for cusps that cannot be seen, and for no other; they hide nothing, nor each other."""

from __future__ import annotations

from itertools import combinations
from math import cos, pi, sin

from rpr_solver.figures.insets import CLEAR, Spot, Window, placed, windows
from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.notebook.scene import Box, Point
from tests.support.pictures import meet


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


def test_insets_that_the_plot_has_no_room_for_stand_below_it() -> None:
    room = OccupancyGrid(Box(0, 0, 700, 500))
    room.add_box(Box(0, 0, 700, 300))
    found = [Window(Box(x, 350, x + 4, 354), (k,)) for k, x in enumerate((60, 300, 500, 560, 640))]
    insets = placed(found, room, Box(0, 600, 700, 600))
    assert sorted(inset.window.members for inset in insets) == [(k,) for k in range(5)]
    assert {inset.is_below for inset in insets} == {True, False}
    for one, other in combinations(insets, 2):
        assert not meet(one.area, other.area)
    for inset in insets:
        assert inset.box.width >= 120
        assert inset.box.y0 >= 600 if inset.is_below else Box(0, 300, 700, 500).y0 <= inset.box.y0
        assert inset.place(inset.window.box.centre) == inset.box.centre
