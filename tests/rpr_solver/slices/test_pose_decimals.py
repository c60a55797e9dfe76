"""Angles and lengths of a pose in decimals."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.slices.by_balls import SlicePoses
from rpr_solver.slices.pose_decimals import HalfAngle, MapBalls, SliceDecimals
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

BITS = 256
ONE = arb(1)


@given(st.fractions(-20, 20), st.booleans())
@examples(60)
def test_angles_are_those_of_half_tangents(x: Fraction, inverse: bool) -> None:
    with ctx.workprec(BITS):
        ball = arb(x.numerator) / x.denominator
        other = HalfTangent(ONE, ball) if inverse else HalfTangent(ball, ONE)
        angle = HalfAngle(ball, inverse)
        for mine, its in zip(angle.cos_sin(), other.cos_sin(), strict=True):
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
    with ctx.workprec(BITS):
        u, t = arb("0.37"), arb("-1.3")
        decimals = SliceDecimals(MapBalls.of(slice_map, BITS), arb(700), 40)
        pose = HalfAngle(t), HalfAngle(u)
        degrees = decimals.degrees(*pose)
        assert degrees is not None
        texts = decimals.texts(degrees, decimals.pose(*pose))
        poses = SlicePoses(slice_map, Fraction(700), BITS)
        squares = poses.local_map(u, HalfTangent(t, ONE), 1).squared_lengths()
        assert texts is not None
        for text, square in zip(texts[2:], squares, strict=True):
            assert abs(arb(text) / (square.sqrt() / slice_map.scale_ball()) - 1) < arb(10) ** -39
        wide = HalfAngle(arb("0.37", 1e-9))
        assert decimals.texts(degrees, decimals.pose(pose[0], wide)) is None
