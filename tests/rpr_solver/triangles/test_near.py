from fractions import Fraction
from itertools import permutations
from math import isqrt, sqrt
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.triangles import Effect, Geometry, SpecialShape, near_shapes, own_shapes, read_geometry
from tests.support.triangle_spellings import geometries

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


SHAPES: list[tuple[dict[str, Any], str, str, Effect]] = [
    (
        {"a2x": 30, "a3x": 0, "a3y": "40.0001", "d1": 15, "d2": 25, "d3": 20},
        "similar",
        "0.0000012",
        Effect.CONTRADICTS,
    ),
    (
        {"a2x": 3, "a3x": 0, "a3y": 4, "d1": 3, "d2": "5.001", "d3": 4},
        "congruent",
        "0.00020",
        Effect.CONTRADICTS,
    ),
    (
        {"a2x": 3, "a3x": 0, "a3y": 4, "d1": 3, "d2": "5.001", "d3": 4, "orientation": "cw"},
        "mirrored",
        "0.00020",
        Effect.WEAKENS,
    ),
    (
        {"a2x": 7, "a3x": 2, "a3y": 5, "d1": 3, "d2": "3.0006", "d3": 4},
        "isosceles",
        "0.00010",
        Effect.HARMLESS,
    ),
    (
        {"a2x": 7, "a3x": 2, "a3y": 5, "d1": 3, "d2": "4.2426", "d3": 3},
        "right isosceles",
        "0.0000048",
        Effect.HARMLESS,
    ),
    (
        {"a2x": 7, "a3x": 2, "a3y": 5, "d1": 3, "d2": "3.0006", "d3": "3.0003"},
        "equilateral",
        "0.00010",
        Effect.HARMLESS,
    ),
    ({"a2x": 7, "a3x": 2, "a3y": 5, "d1": 3, "d2": "4.001", "d3": 7}, "flat", "0.000071", Effect.HARMLESS),
    (
        {"a2x": 7, "a3x": 2, "a3y": "0.01", "d1": 3, "d2": "4.001", "d3": 7},
        "flat",
        "0.000071",
        Effect.CONTRADICTS,
    ),
]


@pytest.mark.parametrize(("spelling", "name", "distance", "effect"), SHAPES)
def test_a_shape_is_named_with_its_distance_and_what_it_means(
    spelling: dict[str, Any], name: str, distance: str, effect: Effect
) -> None:
    shape = found(spelling)[name]
    assert (shape.distance, shape.effect) == (distance, effect)
    assert name in held(shape.spelling)
    assert shape.to_json().keys() == {"shape", "distance", "says", "spelling", "effect"}


@pytest.mark.parametrize(("spelling", "name"), [row[:2] for row in SHAPES])
def test_the_exact_shape_is_not_near_itself(spelling: dict[str, Any], name: str) -> None:
    exact = found(spelling)[name].spelling
    again = near_shapes(read_geometry(exact))
    mine = [shape for shape in again if shape.shape == name and shape.says == found(spelling)[name].says]
    assert mine == []


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


@given(geometries())
def test_each_exact_spelling_has_the_shape_and_is_near(geometry: Geometry) -> None:
    for shape in near_shapes(geometry):
        exact = read_geometry(shape.spelling)
        assert shape.shape in {name for name, _ in own_shapes(exact)}
        assert 0 < float(shape.distance) < 1e-3
        old, new = ((*g.base.squares, *g.platform.squares) for g in (geometry, exact))
        pairs = zip(old, new, strict=True)
        assert all(abs(sqrt(x / y) - 1) < 5e-3 for x, y in pairs)


@given(geometries(), st.integers(1, 300), st.sampled_from([1, -1]))
def test_a_similar_platform_with_a_changed_side_is_near(geometry: Geometry, n: int, sign: int) -> None:
    base = geometry.base
    assume(base.area16 > base.squares[0] ** 2 / 100)
    change = 1 + sign * Fraction(n, 10**6)
    a, b, c = (square / 9 for square in base.squares)
    platform = type(base)((a, b * change**2, c), base.sense)
    shapes = {shape.shape: shape for shape in near_shapes(Geometry(base, platform))}
    expected = n / 1e6 / 2
    assert abs(float(shapes["similar"].distance) / expected - 1) < 0.06
    assert shapes["similar"].effect is Effect.CONTRADICTS
