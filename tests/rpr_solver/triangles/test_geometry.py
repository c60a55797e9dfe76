import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import InputError, Manipulator
from rpr_solver.triangles import Geometry, Surd, read_geometry
from tests.support.strategies import manipulators, rationals

SIDES = {"sides": ["6", "7", "5"]}
BASE = {"equilateral": "10"}


@given(manipulators())
def test_six_rational_numbers_keep_their_form_and_their_hash(manipulator: Manipulator) -> None:
    geometry = read_geometry(manipulator.to_json())
    assert geometry.to_json() == manipulator.to_json()
    assert geometry.geometry_hash == manipulator.geometry_hash
    assert [x.rational for x in geometry.lengths] == list(manipulator.to_dict().values())[:6]


def test_the_hash_of_a_triangle_by_roots_is_the_same_on_every_machine_and_in_every_version() -> None:
    geometry = read_geometry({"base": BASE, "platform": SIDES})
    assert geometry.to_json() == {
        "base": ["10", "10", "10"],
        "base_orientation": "ccw",
        "platform": ["6", "7", "5"],
        "platform_orientation": "ccw",
    }
    assert geometry.geometry_hash == (
        "sha256:649e5955a64ac4821e9a50b29ea0025bf4bf6e4dfa71090dca59d478165eba5a"
    )


def turned(
    points: list[tuple[Surd, Surd]], c: Fraction, s: Fraction, shift: tuple[Fraction, Fraction]
) -> Any:
    """Points with rational coordinates in a turned and moved frame."""
    values = [(x.rational or Fraction(0), y.rational or Fraction(0)) for x, y in points]
    return [[str(c * x - s * y + shift[0]), str(s * x + c * y + shift[1])] for x, y in values]


TURNS = st.tuples(st.integers(1, 9), st.integers(-9, 9)).map(
    lambda m: (
        Fraction(m[0] ** 2 - m[1] ** 2, m[0] ** 2 + m[1] ** 2),
        Fraction(2 * m[0] * m[1], m[0] ** 2 + m[1] ** 2),
    )
)
NUMBERS = rationals(-20, 20, (1, 10))
CORNERS = st.lists(st.tuples(NUMBERS, NUMBERS), min_size=3, max_size=3)


@given(CORNERS, CORNERS, TURNS, TURNS, st.tuples(NUMBERS, NUMBERS))
def test_a_machine_has_one_hash_however_it_is_spelled_turned_and_moved(
    base: Any, platform: Any, first: Any, second: Any, shift: Any
) -> None:
    assume(len(set(base)) == 3 == len(set(platform)))
    base, platform = ([(Surd.of(x), Surd.of(y)) for x, y in points] for points in (base, platform))
    here, there = (Fraction(1), Fraction(0)), (Fraction(0), Fraction(0))
    by_points = read_geometry(
        {
            "base": {"points": turned(base, *here, there)},
            "platform": {"points": turned(platform, *here, there)},
        }
    )
    elsewhere = {"points": turned(base, *first, shift)}, {"points": turned(platform, *second, shift)}
    sides = [str(x) for x in by_points.platform.sides]
    six = [str(x) for x in by_points.lengths]
    spellings: list[dict[str, Any]] = [
        {"base": elsewhere[0], "platform": elsewhere[1]},
        {"base": elsewhere[0], "platform": {"sides": sides}, "orientation": by_points.platform.sense},
        {
            **dict(zip(("a2x", "a3x", "a3y", "d1", "d2", "d3"), six, strict=True)),
            "orientation": by_points.platform.sense,
        },
        {**by_points.to_json(), "name": "the same"},
        {"base": {"points": [["0", "0"], [six[0], "0"], six[1:3]]}, "platform": elsewhere[1], "unit": "mm"},
    ]
    for spelling in spellings:
        geometry = read_geometry(spelling)
        assert geometry == by_points
        assert geometry.to_json() == by_points.to_json()
        assert geometry.geometry_hash == by_points.geometry_hash


@given(rationals(1, 20, (1, 10)), rationals(0, 9, (1, 3)), rationals(1, 9, (1, 2)))
def test_an_equilateral_triangle_has_one_hash_in_five_spellings(
    side: Fraction, x: Fraction, y: Fraction
) -> None:
    s, half = str(side), str(side / 2)
    height = f"{side / 2}*sqrt(3)"
    spellings = [
        {"equilateral": s},
        {"circumradius": f"{side}*sqrt(1/3)"},
        {"sides": [s, s, s]},
        {"points": [["0", "0"], [s, "0"], [half, height]]},
        {"points": [["0", str(x)], ["0", str(x + side)], [f"-{height}", str(x + side / 2)]]},
        {"points": [[str(y), f"-{height}"], [str(y + side / 2), "0"], [str(y - side / 2), "0"]]},
    ]
    geometries = {read_geometry({"base": base, "platform": SIDES}) for base in spellings}
    assert len(geometries) == 1
    assert len({geometry.geometry_hash for geometry in geometries}) == 1


def test_scaled_mirrored_and_relabelled_machines_are_others() -> None:
    spellings: list[dict[str, Any]] = [
        {"base": BASE, "platform": SIDES},
        {"base": {"equilateral": 20}, "platform": {"sides": [12, 14, 10]}},
        {"base": BASE, "platform": SIDES, "orientation": "cw"},
        {"base": {"points": [[0, 0], [10, 0], [5, "-5*sqrt(3)"]]}, "platform": SIDES},
        {"base": BASE, "platform": {"sides": [7, 5, 6]}},
    ]
    assert len({read_geometry(spelling).geometry_hash for spelling in spellings}) == len(spellings)


WRONG: list[tuple[object, str, str]] = [
    (None, "geometry", "give an object"),
    ("robot", "geometry", "give an object"),
    ({}, "geometry", "describes no manipulator"),
    ({"base": BASE}, "geometry.platform", "is missing; give a triangle"),
    ({"platform": SIDES}, "geometry.base", "is missing; give a triangle"),
    ({"base": BASE, "platform": SIDES, "a2x": 3}, "geometry.a2x", "stands beside base and platform"),
    (
        {"base": BASE, "platform": SIDES, "orientation": "left"},
        "geometry.orientation",
        'neither "ccw" nor "cw"',
    ),
    ({"base": BASE, "platform": SIDES, "orientation": None}, "geometry.orientation", "neither"),
    (
        {"base": BASE, "platform": SIDES, "colour": 1},
        "geometry.colour",
        "known are base, platform, orientation",
    ),
    ({"base": BASE, "platform": SIDES, "name": 5}, "geometry.name", "give a text"),
    ({"base": BASE, "platform": SIDES, "unit": ["mm"]}, "geometry.unit", "give a text"),
    ({"points": [[0, 0], [1, 0], [0, 1]]}, "geometry.points", "a triangle has points"),
    ({"anchors": [[0, 0], [1, 0], [0, 1]]}, "geometry.anchors", "a triangle has points"),
    ({"A": [[0, 0], [1, 0], [0, 1]], "B": []}, "geometry.A", "a triangle has points"),
    ({"radius": 3}, "geometry.radius", "a triangle has circumradius"),
    ({"base": BASE, "platform": SIDES, "sides": 3}, "geometry.sides", "a triangle has sides"),
    (
        {"base": BASE, "platform": {"points": [[0, 0], [0, 1], [1, 0]]}, "orientation": "ccw"},
        "geometry.orientation",
        "the points of the platform are clockwise",
    ),
    ({"base": ["3", "4", "5"], "platform": ["3", "4", "5"]}, "geometry.base", '{"sides": ["3"'),
    ({"base": [[0, 0], [3, 0], [0, 4]], "platform": {"equilateral": 1}}, "geometry.base", '{"points": ['),
    (
        {"base": ["3", "4", "5"], "base_orientation": "ccw", "platform": ["3"], "platform_orientation": "cw"},
        "geometry.platform",
        "its three sides as a list",
    ),
    (
        {"base": BASE, "base_orientation": "cw", "platform": ["3", "4", "5"], "platform_orientation": "ccw"},
        "geometry.base",
        "its three sides as a list",
    ),
    (
        {
            "base": ["3", "4", "9"],
            "base_orientation": "cw",
            "platform": ["3", "4", "5"],
            "platform_orientation": "ccw",
        },
        "geometry.base[2]",
        "breaks the triangle inequality",
    ),
    ({"a2x": 0, "a3x": 1, "a3y": 1, "d1": 1, "d2": 1, "d3": 1}, "geometry.a2x", "leads through A3"),
    ({"a2x": 0, "a3x": 0, "a3y": 0, "d1": 1, "d2": 1, "d3": 1}, "geometry", "A1, A2 and A3 are one point"),
    ({"a2x": 0, "a3x": 1, "a3y": 0, "d1": 0, "d2": 1, "d3": 1}, "geometry.platform", "legs 1 and 2 are one"),
    ({"a2x": 1, "a3x": 1, "d1": 1, "d2": 1, "d3": 1}, "geometry.a3y", "is missing; give a number"),
    ({"a2x": 1, "a3x": 1, "a3y": "3√2", "d1": 1, "d2": 1, "d3": 1}, "geometry.a3y", 'write "3*sqrt(2)"'),
    (
        {"a2x": 1, "a3x": "sqrt(2)", "a3y": 1, "d1": 1, "d2": 1, "d3": 1},
        "geometry.a3x",
        "at odds with geometry.a2x",
    ),
    ({"a2x": 1, "a3x": 1, "a3y": 1, "d1": 1, "d2": 1, "d3": "2.1"}, "geometry.d3", "at most d1 + d2 = 2"),
    ({"a2x": 1, "a3x": 1, "a3y": 1, "d1": 0, "d2": 1, "d3": 2}, "geometry.d3", "at most d1 + d2 = 1"),
    (
        {"a2x": -10, "a3x": -5, "a3y": "-5*sqrt(3)", "d1": 1, "d2": 1, "d3": 1},
        "geometry.a2x",
        "a2x = 10, a3x = 5, a3y = sqrt(75)",
    ),
    ({"a2x": 1, "a3x": 1, "a3y": 1, "d1": 1, "d2": 1, "d3": 1, "d4": 1}, "geometry.d4", "did you mean d3"),
    (
        {"a2x": 1, "a3x": 1, "a3y": 1, "d1": 1, "d2": 1, "d3": 1, "colour": 1},
        "geometry.colour",
        "known are a2x",
    ),
]
"""Geometries that are none, the field at fault, and a part of what the message says."""


@pytest.mark.parametrize(("obj", "field", "message"), WRONG, ids=lambda part: str(part)[:40])
def test_a_bad_geometry_names_what_is_wrong_and_what_to_give(obj: object, field: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_geometry(obj)
    problems = {problem.field: problem.message for problem in caught.value.problems}
    assert message in problems[field]


def test_each_geometry_of_the_reference_values_has_its_own_hash() -> None:
    path = Path(__file__).parents[2] / "data" / "irrational.json"
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"]
    geometries: list[Geometry] = [read_geometry(row["geometry"]) for row in rows]
    assert len({geometry.geometry_hash for geometry in geometries}) == len(rows)
    assert all(read_geometry(geometry.to_json()) == geometry for geometry in geometries)
