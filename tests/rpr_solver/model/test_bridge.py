"""Half tangents, poses and jets in the coordinates of the forms, and what they are in the article's frame."""

import json
from fractions import Fraction
from pathlib import Path

import mpmath as mp
import pytest
from flint import acb, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.exact.number_field import exact_omega
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, Pose, pose_of
from rpr_solver.model.joint_points import ExactPose, cos_sin
from rpr_solver.model.slice_map import SliceMap
from tests.support.strategies import examples
from tests.support.triangle_oracle import Waves, corners_of

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
MACHINES = [Manipulator.from_json(row["geometry"]) for row in ROWS]
BITS = 200
halves = st.fractions(-5, 5, max_denominator=20)


def exact_pose(slice_map: SliceMap, t: Fraction, u: Fraction, length: Fraction) -> Pose:
    omega = exact_omega(slice_map.radicand)
    turns = (cos_sin(omega.field(x), omega.field, slice_map.rho) for x in (t, u))
    return Pose(*next(turns), *next(turns), omega.field(length * slice_map.scale), omega)


@given(st.sampled_from(MACHINES), halves, halves)
@examples(60)
def test_jets_in_a_field_are_derivatives_by_angles_times_powers_of_the_root(
    manipulator: Manipulator, t: Fraction, u: Fraction
) -> None:
    """Also the legs, and α and θ in degrees, are those of the article's frame."""
    slice_map, length = SliceMap.of(manipulator), Fraction(7)
    pose = exact_pose(slice_map, t, u, length)
    local, exact = LocalMap.at(slice_map, pose, 4), ExactPose.of(slice_map, pose)
    alpha, theta, *legs = exact.coordinates(BITS)
    with mp.workdps(40):
        angles = [mp.radians(mp.mpf(x.str(50, radius=False))) for x in (alpha, theta)]
        base, platform = corners_of(manipulator.geometry)
        tip, turn = length.numerator * mp.expj(angles[1]), mp.expj(angles[0])
        for k, leg in enumerate(legs, 1):
            known = abs(tip + turn * platform[k] - base[k])
            assert abs(known - number(leg)) < mp.mpf(10) ** -25
        scale = mp.mpf(slice_map.scale.numerator) / slice_map.scale.denominator
        waves = Waves.of(base, platform, mp.mpf(length.numerator))
        for k, jet in enumerate((local.f, local.g)):
            derivatives = waves.derivatives(k, *angles, mp.exp)
            for i, j in ((1, 0), (0, 1), (2, 0), (1, 1), (1, 2), (0, 3), (2, 2), (4, 0)):
                unit = scale**2 * mp.sqrt(slice_map.rho) ** (i + j)
                value = number(jet.table[i][j].ball(BITS))
                assert abs(value / unit - derivatives[i][j]) < mp.mpf(10) ** -25


def number(x: arb | Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mp.mpf(x.str(50, radius=False))


@given(st.sampled_from(MACHINES), halves, halves)
@examples(60)
def test_half_tangents_go_over_the_bridge_and_back(
    manipulator: Manipulator, t: Fraction, u: Fraction
) -> None:
    slice_map = SliceMap.of(manipulator)
    bridge = Bridge.of(slice_map)
    exact = ExactPose.of(slice_map, exact_pose(slice_map, t, u, Fraction(7)))
    with ctx.workprec(BITS):
        own = [HalfTangent(arb(x.numerator), arb(x.denominator)) for x in (t, u)]
        angles = bridge.alpha(own[0]), bridge.theta(own[1])
        for angle, degrees in zip(angles, exact.coordinates(BITS), strict=False):
            turn = acb(*angle.cos_sin())
            assert abs(turn - acb(0, degrees * arb.pi() / 180).exp()) < 1e-40
        for half, back in zip(
            (t, u), (bridge.from_alpha(angles[0]), bridge.from_theta(angles[1])), strict=True
        ):
            assert abs(back.numerator / back.denominator - arb(half.numerator) / half.denominator) < 1e-40


@given(st.sampled_from(MACHINES), halves, halves)
@examples(30)
def test_balls_in_the_article_frame_have_the_same_legs(
    manipulator: Manipulator, t: Fraction, u: Fraction
) -> None:
    slice_map = SliceMap.of(manipulator)
    bridge, pose = Bridge.of(slice_map), exact_pose(slice_map, t, u, Fraction(7))
    squares = LocalMap.at(slice_map, pose, 0).squared_lengths()
    with ctx.workprec(BITS):
        own = [HalfTangent(arb(x.numerator), arb(x.denominator)) for x in (t, u)]
        balls = pose_of(
            bridge.alpha(own[0]),
            bridge.theta(own[1]),
            pose.length.ball(BITS),
            omega_ball(slice_map.radicand, BITS),
        )
        for exact, ball in zip(squares, LocalMap.at(slice_map, balls, 0).squared_lengths(), strict=True):
            assert exact.ball(BITS).overlaps(ball)


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_six_rational_numbers_have_half_tangents_as_they_are(name: str) -> None:
    bridge = Bridge.of(SliceMap.of(EXAMPLES[name]))
    half = HalfTangent(arb(3), arb(7))
    assert bridge.is_along
    assert bridge.alpha(half) is half
    assert bridge.tangents(1) == "t = tan(alpha/2), u = tan(theta1/2)"


def test_axes_are_written_out() -> None:
    """The base of one's own points begins with an irrational side, so that its axis is not that of x."""
    manipulator = Manipulator(base={"points": [[0, 0], [1, 1], [-2, 3]]}, platform={"sides": [3, 4, 5]})
    assert "arg(" in Bridge.of(SliceMap.of(manipulator)).tangents(1)
    straight = Manipulator(base={"equilateral": 10}, platform={"equilateral": 3})
    assert Bridge.of(SliceMap.of(straight)).tangents(2) == (
        "t = tan(alpha/2)/sqrt(3), u = tan(theta2/2)/sqrt(3)"
    )
