"""Points of a slice in decimals: the right number in the right place, rounded right, or none."""

from collections.abc import Sequence
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, JointPoint, PoseKind
from rpr_solver.article.couples import CuspBalls, point_of_balls
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.jets import Pose
from rpr_solver.model.joint_points import (
    ExactPose,
    coordinate_names,
    cos_sin,
    free_legs,
    joint_point,
    point_of_pose,
)
from rpr_solver.model.slice_map import SliceMap

RATIONALS = Field.rationals()
SLICE_MAPS = {leg: SliceMap.of(EXAMPLES["innocenti"], leg) for leg in (1, 2, 3)}


def pose(
    t: Algebraic | None, u: Algebraic | None, f: Algebraic, g: Algebraic, *, leg: int = 1, kind: str = "lips"
) -> ExactPose:
    """With any half tangents, None at 180°, and any squares of the free legs, in the user's unit."""
    field, slice_map = f.field, SLICE_MAPS[leg]
    place = Pose(*cos_sin(t, field, 1), *cos_sin(u, field, 1), field(1), field(1))
    squares = tuple(x * field(slice_map.scale**2) for x in (f, g))
    local: Any = SimpleNamespace(slice_map=slice_map, pose=place, squared_lengths=lambda: squares)
    return ExactPose(PoseKind(kind), local)


def rational_pose(first: Fraction, second: Fraction) -> ExactPose:
    return pose(RATIONALS(1), RATIONALS(Fraction(-1, 2)), RATIONALS(first**2), RATIONALS(second**2))


# names


@pytest.mark.parametrize(("leg", "others"), [(1, (2, 3)), (2, (1, 3)), (3, (1, 2))])
def test_names_follow_the_fixed_leg(leg: int, others: tuple[int, int]) -> None:
    first, second = others
    assert free_legs(leg) == others
    assert coordinate_names(leg) == ("alpha_deg", f"theta{leg}_deg", f"l{first}", f"l{second}")
    x = JointPoint(leg, ("10", "20", "30", "40"))
    assert x.to_json() == {
        "alpha_deg": "10", f"theta{leg}_deg": "20", f"l{first}": "30", f"l{second}": "40"
    }  # fmt: skip
    assert JointPoint.from_json({"kind": "lips", **x.to_json()}, leg) == x
    assert [getattr(x, name) for name in x.names] == ["10", "20", "30", "40"]
    for other in others:
        with pytest.raises(AttributeError, match=f"no theta{other}_deg"):
            getattr(x, f"theta{other}_deg")


def test_an_angle_that_rounds_to_minus_180_is_180() -> None:
    x = joint_point(["-180.000", "-180.000", "180.000", "17"], 1)
    assert x.coordinates == ("180.000", "180.000", "180.000", "17")
    assert joint_point(["-18.0", "-179.999", "1", "2"], 1).coordinates[:2] == ("-18.0", "-179.999")


# from balls


@given(st.lists(st.integers(-(10**9), 10**9).filter(bool), min_size=4, max_size=4), st.integers(2, 9))
def test_a_cusp_s_balls_are_rounded_each_in_its_place(values: Sequence[int], digits: int) -> None:
    with ctx.workprec(100):
        balls = [arb(x) / 10**7 + arb(0, 1e-20) for x in values]
        x = point_of_balls(CuspBalls(*balls), 2, digits)
    if x is None:  # a tie
        assert any(
            len(str(abs(value)).rstrip("0")) == digits + 1 and str(value).rstrip("0")[-1] == "5"
            for value in values
        )
        return
    assert (x.kind, x.point.fixed_leg) == (PoseKind.CUSP, 2)
    for text, value in zip(x.point.coordinates, values, strict=True):
        exact = Fraction(value, 10**7)
        assert abs(Fraction(text) - exact) <= abs(exact) * Fraction(5, 10**digits)
        assert len(text.lstrip("-0.").replace(".", "").split("e")[0]) == digits
    assert (x.alpha.overlaps(balls[0]), x.theta.overlaps(balls[1])) == (True, True)


@pytest.mark.parametrize("wide", range(4))
def test_one_wide_ball_and_there_is_no_point(wide: int) -> None:
    balls = [arb(x, 1e-12) for x in (10, 20, 30, 40)]
    assert point_of_balls(CuspBalls(*balls), 1, 9) is not None
    balls[wide] = arb(balls[wide].mid(), 1e-6)
    assert point_of_balls(CuspBalls(*balls), 1, 9) is None


# from exact poses


@pytest.mark.parametrize(
    ("length", "digits", "text"),
    [
        ("2.5", 1, "3"),
        ("0.15", 1, "0.2"),
        ("0.125", 2, "0.13"),
        ("7", 3, "7.00"),
        ("0", 4, "0"),
        ("1/3", 4, "0.3333"),
    ],
)
def test_a_rational_length_is_rounded_exactly(length: str, digits: int, text: str) -> None:
    """Halves away from zero, which balls would never decide, and zero itself."""
    x, y = (point_of_pose(rational_pose(*pair), digits).point for pair in pairs_with(Fraction(length)))
    assert x.coordinates[2] == y.coordinates[3] == text


def pairs_with(length: Fraction) -> tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]:
    return (length, Fraction(9)), (Fraction(9), length)


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_pose_has_its_angles_and_its_leg(leg: int) -> None:
    """tan(α/2) = 1 and tan(θ/2) = −1/2; then both at 180°."""
    squares = RATIONALS(25), RATIONALS(64)
    x = point_of_pose(pose(RATIONALS(1), RATIONALS(Fraction(-1, 2)), *squares, leg=leg), 12)
    assert x.point == JointPoint(leg, ("90.0000000000", "-53.1301023542", "5.00000000000", "8.00000000000"))
    assert x.kind is PoseKind.LIPS
    assert (x.alpha.contains(90), x.theta < -53) == (True, True)
    turned = point_of_pose(pose(None, None, *squares, leg=leg), 5)
    assert turned.point.coordinates[:2] == ("180.00", "180.00")


def test_irrational_coordinates_are_rounded() -> None:
    root = real_roots(QuadraticPoly.rational([-2, 0, 1]))[1]
    field = Field(root)
    x = field.generator
    irrational = pose(x, -x, x * x * x, field(2), kind="cusp")
    result = point_of_pose(irrational, 30)
    assert result.point.coordinates == (
        "109.471220634490691369245999340", "-109.471220634490691369245999340",
        "1.68179283050742908606225095247", "1.41421356237309504880168872421",
    )  # fmt: skip
