"""The arrangement of polylines: faces, holes, nested curves, nodes, coinciding curves."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver.singular.arrangement import Point, Polyline, faces


def circle(x: float, y: float, r: float, *, turns: int = 1, name: object = None) -> Polyline:
    n = 40
    points = [(x + r * cos(2 * pi * turns * k / n), y + r * sin(2 * pi * turns * k / n)) for k in range(n)]
    end = name or (x, y, r)
    return Polyline((*points, points[0]), end, end)


def windings(*lines: Polyline) -> list[int]:
    return sorted(face.winding for face in faces(lines))


def test_circles_apart_nested_and_crossing() -> None:
    assert windings(circle(0, 0, 1)) == [0, 1]
    assert windings(circle(0, 0, 1), circle(5, 0, 1, turns=-1)) == [-1, 0, 1]
    assert windings(circle(0, 0, 3), circle(0, 0, 1)) == [0, 1, 2]
    assert windings(circle(0, 0, 3), circle(0, 0, 1, turns=-1)) == [0, 0, 1]
    assert windings(circle(0, 0, 1), circle(1, 0.1, 1)) == [0, 1, 1, 2]


def test_a_face_with_a_hole_has_two_rings() -> None:
    rings = {face.winding: len(face.rings) for face in faces([circle(0, 0, 3), circle(0, 0, 1)])}
    assert rings == {0: 1, 1: 2, 2: 1}
    unbounded = [face for face in faces([circle(0, 0, 1), circle(5, 5, 1)]) if not face.bounded]
    assert [len(face.rings) for face in unbounded] == [2]


def test_a_figure_eight_turns_both_ways() -> None:
    points = [(sin(2 * pi * k / 51), sin(4 * pi * k / 51)) for k in range(51)]
    assert windings(Polyline((*points, points[0]), "a", "a")) == [-1, 0, 1]


def test_polylines_that_meet_in_nodes() -> None:
    upper = Polyline(((1, 0), (0.5, 1), (-0.5, 1), (-1, 0)), "right", "left")
    lower = Polyline(((-1, 0), (-0.5, -1), (0.5, -1), (1, 0)), "left", "right")
    middle = Polyline(((-1, 0), (0, 0.1), (1, 0)), "left", "right")
    other = Polyline(((1, 0), (0, -0.2), (-1, 0)), "right", "left")
    assert windings(upper, lower, middle, other) == [0, 0, 1, 1]


def test_coinciding_curves_leave_only_slivers_between() -> None:
    found = faces([circle(0, 0, 1), circle(0, 0, 1, name="again")])
    wide = [face.winding for face in found if not face.bounded or abs(_area(face.rings[0])) > 1]
    assert sorted(wide) == [0, 2]


@settings(max_examples=15)
@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 2), min_size=3, max_size=14, unique=True))
def test_winding_numbers_are_those_of_the_definition(points: list[Point]) -> None:
    found = faces([Polyline((*points, points[0]), "a", "a")])
    for face in found:
        if face.bounded and len(face.rings) == 1:
            corner = _inside(list(face.rings[0]))
            if corner is not None:
                assert face.winding == _winding(corner, points)


def _inside(ring: list[Point]) -> Point | None:
    """The centre of a triangle of neighbouring corners that lies well inside a convex ring."""
    x, y = (sum(p[k] for p in ring[:-1]) / (len(ring) - 1) for k in (0, 1))
    turns = [_cross(a, b, (x, y)) for a, b in pairwise(ring)]
    return (x, y) if min(turns) > 1e-3 else None


def _cross(a: Point, b: Point, p: Point) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _winding(p: Point, points: list[Point]) -> int:
    total = 0
    for a, b in zip(points, [*points[1:], points[0]], strict=True):
        if (a[1] > p[1]) != (b[1] > p[1]):
            side = _cross(a, b, p)
            total += 1 if b[1] > a[1] and side > 0 else -1 if b[1] < a[1] and side < 0 else 0
    return total


def _area(ring: tuple[Point, ...]) -> float:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise(ring)) / 2
