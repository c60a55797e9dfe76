from fractions import Fraction
from typing import Any

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.triangles import (
    CommonFrame,
    Corner,
    Geometry,
    Triangle,
    own_shapes,
    read_geometry,
)
from tests.support.strategies import examples
from tests.support.triangle_oracle import corners_of, cusps, wrapped
from tests.support.triangle_spellings import geometries
from tests.support.twisted import Slices, article_angle

BITS = 300


def frame_of(spelling: dict[str, Any]) -> CommonFrame:
    return CommonFrame.of(read_geometry(spelling))


def is_that_of(corners: tuple[Corner, Corner, Corner], triangle: Triangle) -> bool:
    """Whether corners have exactly the squared sides of a triangle, and its sense."""
    sides = []
    for n in range(3):
        first, second = corners[n], corners[(n + 1) % 3]
        sides.append(Corner(second.x - first.x, second.y - first.y, first.rho).norm)
    if [(side.a, side.b) for side in sides] != [(square, 0) for square in triangle.squares]:
        return False
    _, second, third = corners
    twice = second.x * third.y - second.y * third.x
    with ctx.workprec(BITS):
        ball = arb(twice.a.numerator) / twice.a.denominator
        ball += arb(twice.radicand).sqrt() * twice.b.numerator / twice.b.denominator
        if not triangle.area16:
            return not twice.a and not twice.b
        return bool(ball > 0 if triangle.sense == "ccw" else ball < 0)


def check(geometry: Geometry) -> CommonFrame:
    frame = CommonFrame.of(geometry)
    assert is_that_of(frame.base, geometry.base)
    assert is_that_of(frame.platform, geometry.platform)
    return frame


@given(geometries())
def test_both_triangles_have_exact_coordinates_over_one_field(geometry: Geometry) -> None:
    refusal, frame = "", None
    try:
        frame = check(geometry)
    except InputError as error:
        refusal = str(error)
    if frame is None:
        assert "two roots at once" in refusal
    else:
        assert check(read_geometry(geometry.to_json())) == frame


@pytest.mark.parametrize(
    ("base", "platform", "rho", "radicand"),
    [
        ({"equilateral": 10}, {"circumradius": 1}, 3, 1),
        ({"equilateral": 10}, {"sides": [6, 7, 5]}, 3, 2),
        ({"points": [[0, 0], [5, 0], [0, 6]]}, {"sides": [3, "3*sqrt(2)", 3]}, 1, 1),
        ({"points": [[0, 0], ["3.4", "0.33"], [2, 3]]}, {"equilateral": 1}, 1, 3),
        ({"sides": ["sqrt(2)", "sqrt(2)", 2]}, {"sides": [1, 1, "sqrt(2)"]}, 1, 1),
        ({"equilateral": "5*sqrt(2)"}, {"circumradius": "3.53"}, 3, 2),
        ({"points": [[-2, 4], [1, 8], [9, 2]]}, {"equilateral": "3*sqrt(6)"}, 1, 3),
        ({"sides": ["sqrt(2)", "sqrt(8)", "sqrt(18)"]}, {"sides": [1, 2, 3]}, 2, 1),
        ({"sides": ["sqrt(2)", "sqrt(8)", "sqrt(18)"]}, {"sides": ["sqrt(3)", "sqrt(12)", "sqrt(27)"]}, 2, 6),
        ({"sides": ["sqrt(2)", "sqrt(8)", "sqrt(18)"]}, {"equilateral": "sqrt(5)"}, 3, 2),
        ({"equilateral": "sqrt(2)"}, {"equilateral": "sqrt(5)"}, 3, 2),
        ({"equilateral": "1.000000000000000000000000000000000000000000001"}, {"equilateral": "0.3"}, 3, 1),
    ],
)
def test_the_field_is_as_small_as_the_triangles_allow(
    base: Any, platform: Any, rho: int, radicand: int
) -> None:
    frame = check(read_geometry({"base": base, "platform": platform}))
    assert (frame.rho, frame.radicand) == (rho, radicand)


def test_points_of_any_length_have_a_frame_and_long_sides_are_refused() -> None:
    long = [f"0.{3**k * 10**9 + 7}" for k in range(90, 96)]
    points = {"points": [long[:2], long[2:4], long[4:]]}
    geometry = read_geometry({"base": points, "platform": {"sides": [3, 4, 5]}})
    assert check(geometry).rho == 1
    with pytest.raises(InputError, match=r"geometry.base: no side is rational.*give points, with x rational"):
        CommonFrame.of(read_geometry(geometry.to_json()))


def test_two_roots_at_once_are_refused_by_name() -> None:
    with pytest.raises(
        InputError, match=r"geometry.base: .*beside sqrt\(397\).* give a base with a rational side"
    ):
        frame_of({"base": {"equilateral": "4*sqrt(5)"}, "platform": {"sides": [10, "sqrt(3)", 10]}})


def angles_of(geometry: Geometry, length: Fraction, fixed_leg: int = 1) -> list[Any]:
    """The directions of the fixed leg at the cusps, from the real roots of Q, in degrees; ascending."""
    frame = CommonFrame.of(geometry)
    roots = Slices.of(frame, fixed_leg).roots(length)
    balls = [article_angle(root.refined(BITS), frame.axes[0], BITS) for root in roots]
    return sorted(balls, key=lambda ball: float(ball.mid()))


def agree(geometry: Geometry, length: Fraction) -> bool:
    """Whether Q and the witness, which knows no field, give the same directions at cusps."""
    with mp.workdps(30):
        base, platform = corners_of(geometry)
        found = sorted(
            theta for _, theta in cusps(base, platform, mp.mpf(length.numerator) / length.denominator)
        )
        angles = [mp.radians(mp.mpf(angle.str(25, radius=False))) for angle in angles_of(geometry, length)]
        return len(found) == len(angles) and all(
            abs(wrapped(x - y)) < 1e-8 for x, y in zip(found, sorted(angles), strict=True)
        )


LENGTHS = st.integers(20, 250).map(lambda n: Fraction(n, 10))


@given(geometries(), LENGTHS)
@examples(3)
def test_random_machines_have_the_cusps_of_a_witness_that_knows_no_field(
    geometry: Geometry, length: Fraction
) -> None:
    assume(not own_shapes(geometry))
    try:
        CommonFrame.of(geometry)
    except InputError:
        assume(False)
    assert agree(geometry, length)


@pytest.mark.parametrize("fixed_leg", [2, 3])
def test_the_fixed_leg_may_be_any(fixed_leg: int) -> None:
    spelling = {"base": {"equilateral": "5*sqrt(2)"}, "platform": {"sides": [3, "2*sqrt(2)", "5*sqrt(2)/2"]}}
    geometry = read_geometry(spelling)
    # legs and corners are numbered anew, so that the fixed leg is the first one
    order = [fixed_leg - 1, fixed_leg % 3, (fixed_leg + 1) % 3]

    def renumbered(triangle: Triangle) -> Triangle:
        a, b, c = (triangle.squares[n] for n in order)
        return Triangle((a, b, c), triangle.sense)

    frame = CommonFrame.of(geometry)
    number = len(Slices.of(frame, fixed_leg).roots(Fraction(6)))
    with mp.workdps(20):
        base, platform = corners_of(Geometry(renumbered(geometry.base), renumbered(geometry.platform)))
        assert number == len(cusps(base, platform, mp.mpf(6))) > 0
