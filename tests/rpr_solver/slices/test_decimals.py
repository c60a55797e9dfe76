"""Half angles in balls, and the points that are printed from them."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.article.couples import CouplePoses
from rpr_solver.model.jets import HalfTangent
from rpr_solver.slices.decimals import HalfAngle, PointDecimals
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

BITS = 256
ONE = arb(1)


@given(st.fractions(-50, 50))
@examples(60)
def test_an_angle_is_given_by_whichever_is_small(x: Fraction) -> None:
    with ctx.workprec(BITS):
        exact = arb(x.numerator) / x.denominator
        angle = HalfAngle.of(HalfTangent(exact, ONE), BITS // 2)
        assert angle is not None
        assert abs(angle.x) < 1.6
        assert (angle.x * exact - 1 if angle.inverse else angle.x - exact).contains(0)


def test_what_is_wide_has_no_angle_and_what_is_0_stays_exact() -> None:
    with ctx.workprec(BITS):
        for wide in (HalfTangent(arb(0.3, 1e-9), ONE), HalfTangent(ONE, arb(0.3, 1e-9))):
            assert HalfAngle.of(wide, 60) is None
            assert HalfAngle.of(wide, 20) is not None
        assert HalfAngle.of(HalfTangent(arb(0, 1), arb(0, 1)), 1) is None
        angle = HalfAngle.of(HalfTangent(arb(0), ONE), BITS)
        assert angle is not None
        assert angle.x.is_zero()
        assert not angle.inverse


def test_a_half_turn_is_not_decided() -> None:
    decimals = PointDecimals(eliminant_of(EXAMPLES["zein-flat"]).slice_map, 15, BITS)
    with ctx.workprec(BITS):
        half_turn = HalfAngle.of(HalfTangent(ONE, arb(0, 1e-90)), 200)
        theta = HalfAngle.of(HalfTangent(ONE, arb(2)), 200)
        assert half_turn is not None
        assert theta is not None
        assert decimals.cusp(arb(700), half_turn, theta) is None
        assert decimals.cusp(arb(700), theta, theta) is not None


@given(st.fractions(-20, 20), st.booleans())
@examples(60)
def test_angles_are_those_of_half_tangents(x: Fraction, inverse: bool) -> None:
    with ctx.workprec(BITS):
        ball = arb(x.numerator) / x.denominator
        other = HalfTangent(ONE, ball) if inverse else HalfTangent(ball, ONE)
        angle = HalfAngle(ball, inverse)
        for mine, its in zip((angle.turn.real, angle.turn.imag), other.cos_sin(), strict=True):
            assert (mine - its).contains(0)
            assert mine.rad() < 1e-70
        degrees = angle.degrees(360 / arb.pi())
        if inverse and not x:
            assert degrees is None
        else:
            assert degrees is not None
            assert (degrees - other.degrees()).contains(0)


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_lengths_are_those_of_the_jets(leg: int) -> None:
    slice_map = eliminant_of(EXAMPLES["fourteen-cusps"], leg).slice_map
    decimals = PointDecimals(slice_map, 40, BITS)
    with ctx.workprec(BITS):
        u, t = arb("0.37"), arb("-1.3")
        cusp = decimals.cusp(arb(700), HalfAngle(t), HalfAngle(u))
        poses = CouplePoses(slice_map, Fraction(700), BITS)
        squares = poses.local_map(u, HalfTangent(t, ONE), 1).squared_lengths()
        assert cusp is not None
        for text, square in zip(cusp.point.coordinates[2:], squares, strict=True):
            assert abs(arb(text) / (square.sqrt() / slice_map.scale_ball()) - 1) < arb(10) ** -39
        assert decimals.cusp(arb(700), HalfAngle(t), HalfAngle(arb("0.37", 1e-9))) is None
