"""Points of a slice in decimals: the right number in the right place, rounded right, or none."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, JointPoint, PoseKind
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.by_balls import CuspBalls, CuspProof
from rpr_solver.slices.by_fields import ExactPose
from rpr_solver.slices.joint_points import (
    ClassifiedPoint,
    coordinate_names,
    cusps_and_degenerate,
    free_legs,
    in_order,
    joint_point,
    point_of_balls,
    point_of_pose,
)

PROOF = CuspProof(rank=arb(2), gradient=arb(-3, 1), transversal=arb("123456.789"))
RATIONALS = Field.rationals()
SLICE_MAPS = {leg: SliceMap.of(EXAMPLES["innocenti"], leg) for leg in (1, 2, 3)}


def cusp(alpha: arb, theta: arb, first: arb, second: arb) -> CuspBalls:
    return CuspBalls(alpha, theta, first, second, PROOF)


def pose(
    t: Algebraic | None, u: Algebraic, first: Fraction, second: Fraction, *, offset: int = 0, leg: int = 1
) -> ExactPose:
    """A pose whose lengths are rational, in the user's unit."""
    scale = SLICE_MAPS[leg].scale
    f, g = (u.field((x * scale) ** 2) for x in (first, second))
    return ExactPose(PoseKind.LIPS, t, u, offset, f, g, SLICE_MAPS[leg])


def rational_pose(first: Fraction, second: Fraction) -> ExactPose:
    return pose(RATIONALS(1), RATIONALS(Fraction(-1, 2)), first, second)


def point(kind: PoseKind, theta: arb, alpha: arb, name: str = "1") -> ClassifiedPoint:
    return ClassifiedPoint(kind, theta, alpha, JointPoint(1, (name, "2", "3", "4")), {}, 64)


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
        x = point_of_balls(cusp(*balls), 2, digits, 100)
    if x is None:  # a tie
        assert any(
            len(str(abs(value)).rstrip("0")) == digits + 1 and str(value).rstrip("0")[-1] == "5"
            for value in values
        )
        return
    assert (x.kind, x.bits, x.point.fixed_leg) == (PoseKind.CUSP, 100, 2)
    for text, value in zip(x.point.coordinates, values, strict=True):
        exact = Fraction(value, 10**7)
        assert abs(Fraction(text) - exact) <= abs(exact) * Fraction(5, 10**digits)
        assert len(text.lstrip("-0.").replace(".", "").split("e")[0]) == digits
    assert (x.alpha.overlaps(balls[0]), x.theta.overlaps(balls[1])) == (True, True)


@pytest.mark.parametrize("wide", range(4))
def test_one_wide_ball_and_there_is_no_point(wide: int) -> None:
    balls = [arb(x, 1e-12) for x in (10, 20, 30, 40)]
    assert point_of_balls(cusp(*balls), 1, 9, 53) is not None
    balls[wide] = arb(balls[wide].mid(), 1e-6)
    assert point_of_balls(cusp(*balls), 1, 9, 53) is None


def test_the_proof_is_shown_in_five_digits() -> None:
    x = point_of_balls(cusp(*map(arb, (1, 2, 3, 4))), 1, 9, 53)
    assert x is not None
    assert list(x.proof) == ["rank_1", "grad_J", "v_grad_E"]
    assert x.proof["rank_1"] == "2.0000"
    assert "+/-" in x.proof["grad_J"]
    assert x.proof["v_grad_E"].startswith("[1.2346e+5 +/-")


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
    """tan(α/2) = 1 and tan(θ/2) = −1/2; then α = 180°, and u = 0 turned by half a turn."""
    lengths = Fraction(5), Fraction(8)
    x = point_of_pose(pose(RATIONALS(1), RATIONALS(Fraction(-1, 2)), *lengths, leg=leg), 12)
    assert x.point == JointPoint(leg, ("90.0000000000", "-53.1301023542", "5.00000000000", "8.00000000000"))
    assert x.kind is PoseKind.LIPS
    assert (x.alpha.contains(90), x.theta < -53) == (True, True)
    assert x.proof == {"field_degree": "1"}
    turned = point_of_pose(pose(None, RATIONALS(0), *lengths, offset=180, leg=leg), 5)
    assert turned.point.coordinates[:2] == ("180.00", "180.00")


def test_irrational_coordinates_are_rounded_and_their_field_is_named() -> None:
    root = real_roots(QuadraticPoly.rational([-2, 0, 1]))[1]
    field = Field.of_root(root)
    x = field.generator
    scale = SLICE_MAPS[1].scale
    irrational = ExactPose(
        PoseKind.CUSP, x, -x, 0, x * x * x * field(scale**2), field(scale**2 * 2), SLICE_MAPS[1]
    )
    result = point_of_pose(irrational, 30)
    assert result.point.coordinates == (
        "109.471220634490691369245999340", "-109.471220634490691369245999340",
        "1.68179283050742908606225095247", "1.41421356237309504880168872421",
    )  # fmt: skip
    assert result.proof == {"field_degree": "2"}
    assert result.bits >= 30 * 3.32


# many points


def test_points_ascend_by_the_fixed_leg_s_angle_then_by_alpha() -> None:
    """Angles that balls do not tell apart count as equal."""
    a, b, c, d = (
        point(PoseKind.CUSP, arb(theta, 1e-6), arb(alpha), name)
        for theta, alpha, name in ((-3, 9, "a"), (5, -8, "b"), (5, 1, "c"), (7, -9, "d"))
    )
    for order in ((a, b, c, d), (d, c, b, a), (c, a, d, b)):
        assert in_order(order) == [a, b, c, d]


def test_cusps_are_told_from_other_points() -> None:
    kinds = [PoseKind.CUSP, PoseKind.NODE, PoseKind.CUSP, PoseKind.SWALLOWTAIL]
    points = [point(kind, arb(0), arb(0), name) for kind, name in zip(kinds, "abcd", strict=True)]
    cusps, degenerate = cusps_and_degenerate(points)
    assert cusps == [points[0], points[2]]
    expected: list[dict[str, Any]] = [
        {"kind": kind, "alpha_deg": name, "theta1_deg": "2", "l2": "3", "l3": "4"}
        for kind, name in (("node", "b"), ("swallowtail", "d"))
    ]
    assert degenerate == expected
    assert [type(x["kind"]) for x in degenerate] == [str, str]
