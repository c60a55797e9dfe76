"""Aspects: their numbers, their areas, and the sign of J in their polygons.

Aspects of ranges of lengths: generic manipulators have two, islands join, families keep their own.
"""

from __future__ import annotations

from fractions import Fraction
from math import radians
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rpr_solver import EXAMPLES, InputError, Manipulator, RangeAspect, SolverError, aspects
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.aspects import aspect_cells, number_of_aspects
from rpr_solver.singular.simple_lines import simple_chart
from rpr_solver.singular.sweep import sweep
from tests.rpr_solver.singular.test_raster import Raster
from tests.support.families import FAMILIES, family
from tests.support.sampling import long
from tests.support.singular import SLICES, manipulator, swept, traced
from tests.support.strategies import examples, lengths, manipulators


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


@given(manipulators(size=9, denominators=(1, 10)), st.sampled_from([1, 2, 3]), lengths())
@examples(20)
def test_lines_alone_give_the_number_of_the_sweep(m: Manipulator, leg: int, length: Fraction) -> None:
    slice_map = SliceMap.of(m, leg)
    scaled = length * slice_map.scale
    try:
        cells = aspect_cells(sweep(slice_map, scaled))
    except SolverError:
        assert simple_chart(slice_map, scaled) is None
    else:
        assert number_of_aspects(slice_map, scaled) == len(cells)


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


Mask = NDArray[np.bool_]
Found = list[tuple[int, int, int]]

SIZES = (211, 523, 1021, 2039)
NEARLY_OPEN = Fraction(1, 10**9), Fraction(10**9)
LONG = pytest.mark.long


def counts(manipulator: Manipulator, *span: object, leg: int = 1) -> Found:
    found = aspects(manipulator, *span, fixed_leg=leg)  # type: ignore[arg-type]
    return sorted((x.sign, x.at_start, x.at_stop) for x in found)


@pytest.mark.parametrize(
    ("name", "leg", "start", "stop", "expected"),
    [
        ("innocenti", 1, "27", "30", [(1, 2, 1), (-1, 1, 1)]),
        long("innocenti", 3, "8", "25", [(1, 2, 2), (-1, 1, 1)]),
        long("fourteen-cusps", 1, "5.96", "18", [(1, 2, 1), (-1, 1, 1)]),
        ("similar", 1, "18", "19", [(1, 1, 1), (1, 1, 1), (-1, 1, 1), (-1, 1, 1)]),
        ("innocenti", 1, None, None, [(1, 1, 1), (-1, 1, 1)]),
        long("innocenti", 3, "7", None, [(1, 2, 1), (-1, 1, 1)]),
        ("fourteen-cusps", 1, 0, "7", [(1, 1, 1), (-1, 1, 2)]),
        # its limit for great lengths has whole lines θ = const, so α = const is swept instead
        ("zein-flat", 2, "7", None, [(1, 1, 2), (-1, 1, 2)]),
    ],
)
def test_aspects_of_ranges(
    name: str, leg: int, start: str | None, stop: str | None, expected: list[tuple[int, int, int]]
) -> None:
    found = aspects(manipulator(name), start, stop, fixed_leg=leg)
    assert list(found) == [RangeAspect(*x) for x in expected]


@pytest.mark.parametrize(
    ("name", "leg", "span"),
    [
        long("similar", 2, ("23.5", "31")),
        long("both flat", 1, ("10.4", "14.6")),
        ("right angles", 3, (0, "9.1")),
    ],
)
def test_families_agree_with_a_raster(name: str, leg: int, span: tuple[str, str | None]) -> None:
    assert agrees(family(name), leg, span)


@LONG
@pytest.mark.parametrize("name", [*FAMILIES, *EXAMPLES])
def test_every_family_and_example_agrees_with_a_raster(name: str) -> None:
    random, checked = Random(name), 0
    for leg in (1, 2, 3):
        low = Fraction(random.randint(20, 300), 10)
        high = low + Fraction(random.randint(5, 200), 10)
        for span in ((low, high), (0, high), (low, None), (None, None)):
            if (None in span or 0 in span) and refused(manipulator(name), leg, span):
                continue
            assert agrees(manipulator(name), leg, span), (leg, span)
            checked += 1
    assert checked >= 8


def refused(manipulator: Manipulator, leg: int, span: tuple[object, object]) -> bool:
    try:
        counts(manipulator, *span, leg=leg)
    except SolverError:
        return True
    return False


def agrees(manipulator: Manipulator, leg: int, span: tuple[object, object]) -> bool:
    found = counts(manipulator, *span, leg=leg)
    start, stop = (Fraction(str(x or limit)) for x, limit in zip(span, NEARLY_OPEN, strict=True))
    return any(raster(manipulator, leg, (start, stop), size) == found for size in SIZES)


def raster(manipulator: Manipulator, leg: int, span: tuple[Fraction, Fraction], size: int) -> Found:
    """The same on a grid of α and θ: components of the points with one sign of J at either end."""
    slices = [Raster(manipulator, leg, length, size).j[:size, :size] for length in span]
    found = []
    for sign in (1, -1):
        ends = [surely(sign * j) for j in slices]
        own = [components(end) for end in ends]
        for part in components(ends[0] | ends[1]):
            start, stop = (sum(next(iter(group)) in part for group in groups) for groups in own)
            found.append((sign, start, stop))
    return sorted(found)


def surely(j: NDArray[np.float64]) -> Mask:
    """Where J > 0 not only at a point of the grid but all round it: else a step may cross a thin sector of
    J < 0 at a node, and join what only touches there."""
    slopes = sum(np.abs(np.roll(j, -1, axis) - np.roll(j, 1, axis)) / 2 for axis in (0, 1))
    return np.asarray(j > 0.75 * slopes)


def components(mask: Mask) -> list[set[tuple[int, int]]]:
    """The connected sets of points on the torus, but for specks."""
    size = len(mask)
    left = {(int(i), int(k)) for i, k in np.argwhere(mask)}
    found = []
    while left:
        queue = [left.pop()]
        group = set(queue)
        while queue:
            i, k = queue.pop()
            for other in (
                ((i + 1) % size, k),
                ((i - 1) % size, k),
                (i, (k + 1) % size),
                (i, (k - 1) % size),
            ):
                if other in left:
                    left.remove(other)
                    group.add(other)
                    queue.append(other)
        if len(group) > size * size // 10_000:
            found.append(group)
    return found


def test_a_limit_with_whole_lines_both_ways_is_refused_by_name() -> None:
    with pytest.raises(SolverError, match="ends of the range cannot be compared"):
        aspects(family("both flat"))


def test_the_range_must_ascend() -> None:
    with pytest.raises(InputError, match="stop: is 3; it must exceed 3"):
        aspects(EXAMPLES["innocenti"], 3, "3.0", fixed_leg=2)
    with pytest.raises(InputError, match="start: is -1; a length is at least 0"):
        aspects(EXAMPLES["innocenti"], -1, 3)
