"""Points of a slice in decimals: the right number in the right place, rounded right, or none."""

from collections.abc import Sequence
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, PoseKind
from rpr_solver.article.couples import CuspBalls, point_of_balls
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.model.jets import Pose
from rpr_solver.model.joint_points import (
    ExactPose,
    cos_sin,
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
