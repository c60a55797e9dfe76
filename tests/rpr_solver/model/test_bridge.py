"""Half tangents, poses and jets in the coordinates of the forms, and what they are in the article's frame."""

import json
from fractions import Fraction
from pathlib import Path

import mpmath as mp
from flint import acb, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import Manipulator
from rpr_solver.exact.number_field import exact_omega
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, Pose
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
