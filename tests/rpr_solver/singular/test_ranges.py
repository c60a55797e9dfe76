"""Aspects of ranges of lengths: generic manipulators have two, islands join, families keep their own."""

from __future__ import annotations

from fractions import Fraction
from math import pi

import pytest

from rpr_solver import EXAMPLES, InputError, RangeAspect, range_aspects
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.floats import FloatSlice
from rpr_solver.singular.strands import UnionFind
from tests.support.singular import manipulator


@pytest.mark.parametrize(
    ("name", "leg", "start", "stop", "expected"),
    [
        ("right angles", 3, "3", "20", None),
        ("innocenti", 1, "27", "30", [(1, 2, 1), (-1, 1, 1)]),
        ("innocenti", 3, "8", "25", [(1, 2, 2), (-1, 1, 1)]),
        ("fourteen-cusps", 1, "5.96", "18", [(1, 2, 1), (-1, 1, 1)]),
        ("similar", 1, "18", "19", [(1, 1, 1), (1, 1, 1), (-1, 1, 1), (-1, 1, 1)]),
    ],
)
def test_aspects_of_ranges(
    name: str, leg: int, start: str, stop: str, expected: list[tuple[int, int, int]] | None
) -> None:
    found = range_aspects(manipulator(name), start, stop, fixed_leg=leg)
    assert list(found) == [RangeAspect(*x) for x in expected or raster(name, leg, start, stop)]


def raster(name: str, leg: int, start: str, stop: str, size: int = 150) -> list[tuple[int, int, int]]:
    """The same on a grid of α and θ: components of the points with one sign of J at either end."""
    slice_map = SliceMap.of(manipulator(name), leg)
    ends = [FloatSlice.of(slice_map, Fraction(x) * slice_map.scale) for x in (start, stop)]
    angles = [2 * pi * (k + 0.37) / size for k in range(size)]
    signs = []
    for end in ends:
        lines = [end.on_line(theta) for theta in angles]
        signs.append([[line.value_and_slope(alpha)[0] > 0 for alpha in angles] for line in lines])
    found = []
    for sign in (True, False):
        whole = joined(lambda i, k, sign=sign: any(s[i][k] is sign for s in signs), size)
        own = [joined(lambda i, k, s=s, sign=sign: s[i][k] is sign, size) for s in signs]
        for part in whole:
            members = set(part)
            counts = [sum(group[0] in members for group in groups) for groups in own]
            found.append((1 if sign else -1, *counts))
    return found


def joined(holds: object, size: int) -> list[list[tuple[int, int]]]:
    assert callable(holds)
    cells = [(i, k) for i in range(size) for k in range(size) if holds(i, k)]
    inside = set(cells)
    groups = UnionFind(cells)
    for i, k in cells:
        for other in (((i + 1) % size, k), (i, (k + 1) % size)):
            if other in inside:
                groups.join((i, k), other)
    return groups.classes()


def test_the_range_must_ascend() -> None:
    with pytest.raises(InputError, match="l2: the range ends at 3, which is not above its start 3"):
        range_aspects(EXAMPLES["innocenti"], 3, "3.0", fixed_leg=2)
    with pytest.raises(InputError, match="l1: is 0"):
        range_aspects(EXAMPLES["innocenti"], 0, 3)
