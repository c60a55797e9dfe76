from fractions import Fraction
from itertools import permutations
from math import isqrt
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.triangles import Effect, SpecialShape, near_shapes, own_shapes, read_geometry

EQUILATERAL: dict[str, Any] = {
    "a2x": "10", "a3x": "5", "a3y": "8.6603", "d1": "1.7321", "d2": "1.7321", "d3": "1.7321",
}  # fmt: skip


def found(spelling: dict[str, Any]) -> dict[str, SpecialShape]:
    return {shape.shape: shape for shape in near_shapes(read_geometry(spelling))}


def held(spelling: dict[str, Any]) -> set[str]:
    return {shape for shape, _ in own_shapes(read_geometry(spelling))}


@pytest.mark.parametrize("digits", [4, 8, 15, 16, 30, 60])
@pytest.mark.parametrize("rounded_up", [0, 1])
def test_a_rounded_equilateral_machine_is_named_with_its_exact_spelling(digits: int, rounded_up: int) -> None:
    height, side = (str(Fraction(isqrt(n * 100**digits) + rounded_up, 10**digits)) for n in (75, 3))
    shape = near_shapes(read_geometry({**EQUILATERAL, "a3y": height, "d1": side, "d2": side, "d3": side}))[0]
    assert (shape.shape, shape.effect) == ("similar", Effect.CONTRADICTS)
    assert shape.spelling == {"base": {"equilateral": "10"}, "platform": {"equilateral": "sqrt(3)"}}
    assert "no slice has a cusp" in shape.says
    assert 0 < Fraction(shape.distance) < Fraction(1, 10**digits)


def test_a_relabelled_similar_platform_is_nothing_special() -> None:
    base = {"points": [[0, 0], [30, 0], [0, 40]]}
    for sides in permutations(["3", "5.0001", "4"]):
        shapes = found({"base": base, "platform": {"sides": list(sides)}})
        assert ("similar" in shapes) == (sides == ("3", "5.0001", "4"))


def test_equilateral_triangles_of_opposite_senses_are_not_similar() -> None:
    spelling = {"base": {"equilateral": 10}, "platform": {"sides": [3, 3, "3.0001"]}, "orientation": "cw"}
    assert "similar" not in found(spelling)
    assert "similar" not in held(
        {"base": {"equilateral": 10}, "platform": {"equilateral": 3}, "orientation": "cw"}
    )


def test_the_built_in_manipulators_are_not_near_a_shape_that_contradicts_them() -> None:
    for manipulator in EXAMPLES.values():
        shapes = near_shapes(read_geometry(manipulator.to_json()))
        assert all(shape.effect is Effect.HARMLESS for shape in shapes)


@pytest.mark.parametrize("exponent", [4, 5, 12, 40, 300])
@given(factor=st.integers(1, 9))
def test_distances_of_any_size_are_right(exponent: int, factor: int) -> None:
    change = Fraction(factor, 10**exponent) * Fraction(1, 2)
    side = str(3 + 3 * change)
    shapes = found({"base": {"points": [[0, 0], [7, 0], [2, 5]]}, "platform": {"sides": [3, side, 4]}})
    half = change / 2
    # (R − 1) / (R + 1) with R = 1 + change
    assert abs(Fraction(shapes["isosceles"].distance) / half - 1) < Fraction(6, 100)
