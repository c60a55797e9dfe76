"""Verdicts on couples and their reasons, at poses made to be a cusp, a fold, or a known exception."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import Manipulator
from rpr_solver.article.couples import (
    DEGENERATE,
    KEPT,
    REJECTED,
    CoupleReport,
    count_real,
    exact_couple,
    rejected_by_balls,
)
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model import jets
from rpr_solver.model.jets import HalfTangent, LocalMap, pose_of
from rpr_solver.model.joint_points import ClassifiedPoint, ExactPose
from rpr_solver.model.slice_map import SliceMap
from tests.support import constructed
from tests.support.constructed import Constructed
from tests.support.strategies import examples

pytestmark = pytest.mark.quick

BITS = 256
TRIPLE = "three direct kinematic solutions coincide"
TWO = "v.grad J != 0: only two solutions coincide"
B1B3 = "leg 3 along B1B3, leg 1 along B1B3"

EXCEPTIONS = [
    pytest.param(
        constructed.legs_1_and_3_in_line,
        None,
        f"k2 = k4 = 0 ({B1B3}), so the adjugate's first column vanishes; {TWO}",
        id="legs 1 and 3 in line",
    ),
    pytest.param(
        constructed.legs_2_and_3_in_line,
        None,
        "k1 = k3 = 0 (leg 2 along B2B3, leg 3 along B2B3), so the adjugate's first column vanishes; " + TWO,
        id="legs 2 and 3 in line",
    ),
    pytest.param(
        constructed.lines_meet_in_b1,
        None,
        "k2 = k5 = 0 (leg 3 along B1B3, leg 2 along B1B2), so the adjugate's first row vanishes; " + TWO,
        id="lines meet in B1",
    ),
    pytest.param(
        constructed.lines_meet_in_b3,
        None,
        "k1 = k4 = 0 (leg 2 along B2B3, leg 1 along B1B3), so the adjugate's first column vanishes; " + TWO,
        id="lines meet in B3",
    ),
    pytest.param(constructed.leg_2_closed, 2, f"leg 2 has length zero; {TWO}", id="leg 2 closed"),
    pytest.param(constructed.leg_3_closed, 3, f"leg 3 has length zero; {TWO}", id="leg 3 closed"),
]


@pytest.fixture(autouse=True)
def _precision() -> object:
    with ctx.workprec(BITS), mp.workdps(30):
        yield


def exactly(at: Constructed, digits: int = 20) -> tuple[CoupleReport, ClassifiedPoint | None]:
    slice_map, field = SliceMap.of(at.manipulator), Field.rationals()
    numbers = map(field, (*at.pose.alpha, *at.pose.theta, at.pose.l1 * slice_map.scale, 1))
    return exact_couple(ExactPose.of(slice_map, jets.Pose(*numbers)), digits)


def by_balls(at: Constructed, radius: float = 0.0) -> tuple[LocalMap[arb], arb, HalfTangent]:
    """The jets at the pose, its u and its t, all less exact by a radius."""
    slice_map = SliceMap.of(at.manipulator)
    assert at.pose.t is not None
    assert at.pose.u is not None
    t, u = (ball_of(x) + arb(0, radius or 1e-60) for x in (at.pose.t, at.pose.u))
    alpha, theta = HalfTangent(t, arb(1)), HalfTangent(u, arb(1))
    pose = pose_of(alpha, theta, ball_of(at.pose.l1 * slice_map.scale), arb(1))
    return LocalMap.at(slice_map, pose, 2), u, alpha


def report(alpha: str, theta1: str, verdict: str, reason: str) -> CoupleReport:
    return {"alpha_deg": alpha, "theta1_deg": theta1, "verdict": verdict, "reason": reason}


def angles(at: Constructed) -> tuple[str, str]:
    """In degrees, to as many digits as couples show."""
    texts = [
        mp.nstr(mp.degrees(mp.atan2(real(sin), real(cos))), 15, strip_zeros=False)
        for cos, sin in (at.pose.alpha, at.pose.theta)
    ]
    return texts[0], texts[1]


def real(x: Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator


class TestExactly:
    def test_where_a3_is_the_centre_of_curvature_the_couple_is_kept(self) -> None:
        couple, point = exactly(constructed.cusp())
        assert couple == report(*angles(constructed.cusp()), KEPT, TRIPLE)
        assert point is not None
        assert point.kind == "cusp"

    @pytest.mark.parametrize(("construct", "closed", "reason"), EXCEPTIONS)
    def test_exceptions_are_rejected_with_their_reason(
        self, construct: Callable[[], Constructed], closed: int | None, reason: str
    ) -> None:
        couple, point = exactly(construct())
        assert couple == report(*angles(construct()), REJECTED, reason)
        assert point is None
        assert (closed is not None) == ("length zero" in reason)

    def test_a_swallowtail_at_half_a_turn_is_degenerate(self) -> None:
        slice_map = SliceMap.of(Manipulator(2, -4, 4, 1, 4, 3, orientation="cw"))
        numbers = map(Field.rationals(), (1, 0, -1, 0, slice_map.scale, 1))
        couple, point = exact_couple(ExactPose.of(slice_map, jets.Pose(*numbers)), 20)
        assert couple == report("0", "180.000000000000", DEGENERATE, "swallowtail")
        assert point is not None
        assert point.kind == "swallowtail"


class TestByBalls:
    @pytest.mark.parametrize(("construct", "closed", "reason"), EXCEPTIONS)
    def test_exceptions_are_rejected_as_exactly(
        self, construct: Callable[[], Constructed], closed: int | None, reason: str
    ) -> None:
        couple = rejected_by_balls(*by_balls(construct()), closed)
        assert couple == exactly(construct())[0]
        assert couple is not None
        assert couple["reason"] == reason

    @pytest.mark.parametrize(
        "construct",
        [constructed.cusp, constructed.fold, constructed.ordinary, constructed.legs_along_both_sides],
    )
    def test_nothing_else_is_rejected(self, construct: Callable[[], Constructed]) -> None:
        """Least of all a cusp; and where more vanishes than is needed, balls do not tell."""
        assert rejected_by_balls(*by_balls(construct()), None) is None

    def test_wide_balls_do_not_tell(self) -> None:
        at = constructed.lines_meet_in_b1()
        assert rejected_by_balls(*by_balls(at, 1e-30), None) is not None
        assert rejected_by_balls(*by_balls(at, 1e-3), None) is None


class TestCountOfRealRoots:
    @given(
        st.lists(st.integers(-9, 9), max_size=4, unique=True),
        st.lists(st.tuples(st.integers(-5, 5), st.integers(1, 5)), max_size=2, unique=True),
        st.sampled_from([-3, 1]),
    )
    @examples(40)
    def test_of_products_of_factors(self, real: list[int], pairs: list[tuple[int, int]], lead: int) -> None:
        coefficients = [lead]
        for root in real:
            coefficients = times(coefficients, [-root, 1])
        for a, b in pairs:  # a ± b i
            coefficients = times(coefficients, [a * a + b * b, -2 * a, 1])
        assert count_real([arb(c) for c in coefficients]) == len(real)

    def test_a_double_root_is_not_decided(self) -> None:
        assert count_real([arb(1), arb(-2), arb(1)]) is None
        close = [arb(1), arb(-2), arb(1) - arb(2) ** -100]
        assert count_real(close) == 2


def times(p: list[int], q: list[int]) -> list[int]:
    return [
        sum(p[i] * q[k - i] for i in range(len(p)) if 0 <= k - i < len(q)) for k in range(len(p) + len(q) - 1)
    ]
