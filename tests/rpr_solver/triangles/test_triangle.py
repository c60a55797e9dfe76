from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.triangles import Surd, Triangle, read_triangle
from tests.support.strategies import rationals

POINTS = st.lists(st.tuples(rationals(-9, 9, (1, 4)), rationals(-9, 9, (1, 4))), min_size=3, max_size=3)


def read(value: object) -> Triangle:
    return read_triangle(value, "geometry.base")


def test_the_four_spellings_of_an_equilateral_triangle_are_equal() -> None:
    spelled = [
        {"equilateral": "sqrt(3)"},
        {"circumradius": 1},
        {"sides": ["sqrt(3)", "2*sqrt(3)/2", "sqrt(12)/2"]},
        {"points": [["1", "0"], ["-1/2", "sqrt(3)/2"], ["-0.5", "-sqrt(0.75)"]]},
    ]
    assert len({read(value) for value in spelled}) == 1
    assert read(spelled[0]).squares == (3, 3, 3)


def test_points_have_their_sense_and_other_spellings_are_counter_clockwise() -> None:
    assert read({"points": [[0, 0], [0, 1], [1, 0]]}).sense == "cw"
    assert read({"points": [[0, 0], [1, 0], ["0.5", "-sqrt(3)"]]}).sense == "cw"
    assert read({"points": [["sqrt(2)", 0], [0, "sqrt(2)"], [0, 0]]}).sense == "ccw"
    assert {read(value).sense for value in ({"sides": [3, 4, 5]}, {"equilateral": 1})} == {"ccw"}


def test_flat_triangles_are_allowed_and_have_no_sense() -> None:
    assert read({"sides": [1, 2, 3]}).area16 == 0
    flat = read({"points": [[0, 0], ["sqrt(2)", 0], ["-3*sqrt(2)", 0]]})
    assert (flat.area16, flat.sense, flat.mirrored()) == (0, "ccw", flat)


def test_roots_that_cancel_in_a_side_are_allowed() -> None:
    turned = read({"points": [["3", "sqrt(2)"], ["sqrt(2)", "-3"], [0, 0]]})
    assert turned.squares == (22, 11, 11)


@given(POINTS)
def test_the_third_corner_is_that_of_the_points(points: list[tuple[Fraction, Fraction]]) -> None:
    (ax, ay), (bx, by), (cx, cy) = points
    assume(len(set(points)) == 3)
    triangle = read({"points": [list(map(str, point)) for point in points]})
    x, y = triangle.corner3
    (u, v), (p, q) = (bx - ax, by - ay), (cx - ax, cy - ay)
    square = u * u + v * v
    assert x == (u * p + v * q) / square
    assert y == Surd.of((u * q - v * p) / square)


TRIANGLES: list[tuple[object, str, str]] = [
    (5, "geometry.base", "give an object"),
    (["3", "4", "5"], "geometry.base", "give an object"),
    (None, "geometry.base", "give an object"),
    ({}, "geometry.base", "has nothing; give one of sides, points"),
    ({"sides": [3, 4, 5], "equilateral": 1}, "geometry.base", "has sides and equilateral; give one"),
    ({"side": 3}, "geometry.base.side", '{"equilateral": "10"}'),
    ({"radius": 3}, "geometry.base.radius", '{"circumradius": "sqrt(3)"}'),
    ({"vertices": []}, "geometry.base.vertices", '{"points": [["0", "0"]'),
    ({"anchors": []}, "geometry.base.anchors", '{"points": [["0", "0"]'),
    ({"s12": 3, "s23": 4, "s31": 5}, "geometry.base.s23", '{"sides": ["3", "4", "5"]}'),
    ({"colour": "red"}, "geometry.base.colour", "known are sides, points, equilateral, circumradius"),
    ({"sides": "3, 4, 5"}, "geometry.base.sides", "give the list of the three lengths A1A2, A2A3, A3A1"),
    ({"sides": 3}, "geometry.base.sides", "give the list of the three lengths"),
    ({"sides": [3, 4]}, "geometry.base.sides", "has 2 lengths; give three, A1A2, A2A3, A3A1"),
    ({"sides": [3, 4, 5, 6]}, "geometry.base.sides", "has 4 lengths"),
    ({"sides": {"12": 3}}, "geometry.base.sides", "give the list of the three lengths"),
    ({"sides": [3, "4,5", 5]}, "geometry.base.sides[1]", 'write a decimal point, "4.5"'),
    ({"sides": [3, 4, "5√2"]}, "geometry.base.sides[2]", 'write "5*sqrt(2)"'),
    ({"sides": [3, 4.5, 5]}, "geometry.base.sides[1]", 'write "4.5"'),
    ({"sides": [3, None, 5]}, "geometry.base.sides[1]", "not an exact number"),
    ({"sides": [0, 4, 5]}, "geometry.base.sides[2]", "A1A2 + A2A3 = 4"),
    ({"sides": [0, 0, "0*sqrt(3)"]}, "geometry.base", "A1, A2 and A3 are one point"),
    ({"sides": [3, -4, 5]}, "geometry.base.sides[1]", "is -4; the side A2A3 must be > 0"),
    ({"sides": [3, "-sqrt(2)", 5]}, "geometry.base.sides[1]", "the side A2A3 must be > 0"),
    ({"sides": [3, 4, "7.0001"]}, "geometry.base.sides[2]", "A1A2 + A2A3 = 7"),
    ({"sides": [9, 4, 3]}, "geometry.base.sides[0]", "at most A2A3 + A3A1 = 7"),
    ({"sides": ["sqrt(2)", "3.2", "sqrt(3)"]}, "geometry.base.sides[1]", "A1A2 + A3A1 = about 3.146264370"),
    ({"sides": ["sqrt(2)", "sqrt(3)", "3.1462643699419723423292"]}, "geometry.base.sides[2]", "A1A2 + A2A3"),
    ({"points": "0,0 1,0 0,1"}, "geometry.base.points", "the list of the three corners A1, A2, A3"),
    ({"points": [[0, 0], [1, 0]]}, "geometry.base.points", "has 2 corners; give three, A1, A2, A3"),
    ({"points": [[0, 0], [1, 0], [0, 1], [1, 1]]}, "geometry.base.points", "has 4 corners"),
    ({"points": [[0, 0], [1], [0, 1]]}, "geometry.base.points[1]", "the two coordinates [x, y]"),
    ({"points": [[0, 0], "10", [0, 1]]}, "geometry.base.points[1]", "the two coordinates [x, y]"),
    ({"points": [[0, 0], [1, 2, 3], [0, 1]]}, "geometry.base.points[1]", "the two coordinates [x, y]"),
    ({"points": [[0, 0], {"x": 1, "y": 2}, [0, 1]]}, "geometry.base.points[1]", "coordinates [x, y]"),
    ({"points": [[0, 0], 5, [0, 1]]}, "geometry.base.points[1]", "the two coordinates [x, y]"),
    ({"points": [[0, 0], [1.5, 0], [0, 1]]}, "geometry.base.points[1][0]", 'write "1.5"'),
    ({"points": [[0, "north"], [1, 0], [0, 1]]}, "geometry.base.points[0][1]", "write a decimal"),
    ({"points": [[0, 0], [1, 0], [0, "2sqrt(3)"]]}, "geometry.base.points[2][1]", 'write "2*sqrt(3)"'),
    ({"points": [[3, 4], [3, 4], ["3.0", "8/2"]]}, "geometry.base", "A1, A2 and A3 are one point"),
    ({"points": [["sqrt(2)", 0], [1, 1], ["2/sqrt(2)", 0]]}, "geometry.base.points[2][0]", "write a decimal"),
    (
        {"points": [["sqrt(2)", 0], [1, 0], [0, 0]]},
        "geometry.base.points[1][0]",
        "1 is at odds with geometry.base.points[0][0] = sqrt(2)",
    ),
    (
        {"points": [[0, 3], [10, "sqrt(3)"], [5, 0]]},
        "geometry.base.points[1][1]",
        "give y of A1 and A2 as multiples of one root, or the sides",
    ),
    (
        {"points": [[0, 0], [1, "sqrt(3)"], [2, "sqrt(5)"]]},
        "geometry.base.points[2][1]",
        "sqrt(5) is at odds with geometry.base.points[1][1] = sqrt(3)",
    ),
    ({"points": [["3", "sqrt(2)"], ["sqrt(2)", "3"], [0, 0]]}, "geometry.base.points[1][1]", "is at odds"),
    ({"equilateral": 0}, "geometry.base.equilateral", "the side of a triangle must be > 0"),
    ({"equilateral": "-sqrt(3)"}, "geometry.base.equilateral", "the side of a triangle must be > 0"),
    ({"equilateral": ["1", "1", "1"]}, "geometry.base.equilateral", "not an exact number"),
    ({"equilateral": "10 mm"}, "geometry.base.equilateral", "write a decimal"),
    ({"circumradius": "-1"}, "geometry.base.circumradius", "the radius of a circle must be > 0"),
    ({"circumradius": "0.37m"}, "geometry.base.circumradius", "write a decimal"),
    ({"circumradius": 0.37}, "geometry.base.circumradius", 'write "0.37"'),
]
"""Triangles that are none, the field at fault, and a part of what the message says."""


@pytest.mark.parametrize(("value", "field", "message"), TRIANGLES, ids=lambda part: str(part)[:40])
def test_a_bad_triangle_names_its_corner_side_or_number(value: object, field: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read(value)
    problems = {problem.field: problem.message for problem in caught.value.problems}
    assert message in problems[field]
    assert "\n" not in str(caught.value)
