"""Boxes of poses on a grid, and what is printed from them."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import acb, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.article.couples import CouplePoses
from rpr_solver.model.jets import HalfTangent
from rpr_solver.slices.grid import GridSlice, HalfAngle, MapBalls, SliceDecimals, cusp_proof, larger, on_grid
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

BITS = 256
ONE = arb(1)


@given(st.fractions(-50, 50), st.floats(-1, 1), st.integers(150, 200))
@examples(60)
def test_all_balls_of_a_number_have_the_same_box(x: Fraction, shift: float, accuracy: int) -> None:
    with ctx.workprec(BITS):
        exact = arb(x.numerator) / x.denominator
        radius = arb(2) ** -accuracy
        box = on_grid(HalfTangent(exact, ONE), BITS)
        assert box is not None
        assert abs(box.x.mid()) <= 1
        assert (box.x * exact - 1 if box.inverse else box.x - exact).contains(0)
        ball = arb(exact.mid() + radius * shift, radius)
        for other in (HalfTangent(ball, ONE), HalfTangent(arb(3), 3 / ball) if x else None):
            again = other and on_grid(other, BITS)
            if again is not None and x:
                assert str(again) == str(box)


def test_what_is_wide_has_no_box_and_what_is_0_stays_exact() -> None:
    with ctx.workprec(BITS):
        assert on_grid(HalfTangent(arb(0.3, 1e-9), ONE), BITS) is None
        box = on_grid(HalfTangent(arb(0), ONE), BITS)
        assert box is not None
        assert box.x.is_zero()
        assert not box.inverse


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_the_proof_is_that_of_the_jets(leg: int) -> None:
    """By the product rule, and by the closed formulas of derivatives that follow from it."""
    slice_map = eliminant_of(EXAMPLES["fourteen-cusps"], leg).slice_map
    poses = CouplePoses(slice_map, Fraction(700), BITS)
    with ctx.workprec(BITS):
        u, t = arb("0.37"), HalfTangent(arb("-1.3"), ONE)
        local = poses.local_map(u, t, 3)
        j = local.singularity()
        e = local.along(local.f, j)
        pose = acb(*t.cos_sin()), acb(*HalfTangent(u, ONE).cos_sin())
        proof = cusp_proof(MapBalls.of(slice_map, BITS), poses.length, pose)
        expected = {
            "rank_1": larger(local.f.alpha.value, local.f.theta.value),
            "grad_J": larger(j.alpha.value, j.theta.value),
            "v_grad_E": local.along(local.f, e).value,
        }
        for name, value in expected.items():
            assert value.overlaps(proof[name])
            assert proof[name].rel_accuracy_bits() > 200


def test_a_half_turn_is_not_decided() -> None:
    slice_map = eliminant_of(EXAMPLES["zein-flat"]).slice_map
    slice_ = GridSlice(slice_map, Fraction(700), 15, BITS)
    with ctx.workprec(BITS):
        alpha, theta = on_grid(HalfTangent(ONE, arb(0, 1e-90)), BITS), on_grid(HalfTangent(ONE, arb(2)), BITS)
        assert alpha is not None
        assert theta is not None
        assert slice_.point(alpha, theta) is None
        assert slice_.point(theta, theta) is not None


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
    with ctx.workprec(BITS):
        u, t = arb("0.37"), arb("-1.3")
        decimals = SliceDecimals(MapBalls.of(slice_map, BITS), arb(700), 40)
        pose = HalfAngle(t), HalfAngle(u)
        degrees = decimals.degrees(*pose)
        assert degrees is not None
        texts = decimals.texts(degrees, (pose[0].turn, pose[1].turn))
        poses = CouplePoses(slice_map, Fraction(700), BITS)
        squares = poses.local_map(u, HalfTangent(t, ONE), 1).squared_lengths()
        assert texts is not None
        for text, square in zip(texts[2:], squares, strict=True):
            assert abs(arb(text) / (square.sqrt() / slice_map.scale_ball()) - 1) < arb(10) ** -39
        wide = HalfAngle(arb("0.37", 1e-9))
        assert decimals.texts(degrees, (pose[0].turn, wide.turn)) is None
