"""Events: landmarks without a pose of their own, and lengths and poses as texts."""

from __future__ import annotations

from fractions import Fraction

from flint import arb, ctx

from rpr_solver import EXAMPLES, PoseKind
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.transitions.event_systems import BallPose, Event, Landmark, event_point, length_text
from tests.support.shared import eliminant_of


def test_a_landmark_is_its_exact_length_and_no_pose() -> None:
    root = Field(real_roots(QuadraticPoly.rational([-2, 0, 1]))[-1])
    event: Event = Landmark(root.generator)
    assert event.pose is None
    assert event.exact_length
    assert (event.exact_length * event.exact_length - 2).is_zero
    for bits in (64, 500):
        ball = event.scaled_length(bits)
        assert (ball * ball).contains(2)
        assert ball > 0
        assert ball.rel_accuracy_bits() > bits - 8


FLAT = eliminant_of(EXAMPLES["zein-flat"]).slice_map


def test_a_rational_length_is_rounded_once() -> None:
    tie = Landmark(Field.rationals()(Fraction("1.0000000000000005") * FLAT.scale))
    assert length_text(FLAT, [tie], 15) == "1.00000000000000"
    assert length_text(FLAT, [tie], 17) == "1.0000000000000005"


def test_an_irrational_length_has_the_digits_of_its_root() -> None:
    root = real_roots(QuadraticPoly.rational([-2 * int(FLAT.scale) ** 2, 0, 1]))[-1]
    assert length_text(FLAT, [Landmark(Field(root).generator)], 20) == "1.4142135623730950488"


def test_balls_are_refined_until_all_digits_are_proved() -> None:
    asked: list[int] = []

    def thirds(bits: int) -> tuple[arb, arb, arb, arb]:
        asked.append(bits)
        with ctx.workprec(2 * bits):
            return tuple(arb(n) / 3 + arb(0, arb(2) ** (-bits // 3)) for n in (-2, 1, 4, 5))  # type: ignore[return-value]

    point = event_point(BallPose(PoseKind.SWALLOWTAIL, thirds, exact=None), 2, 20)  # type: ignore[arg-type]
    assert point.to_json() == {
        "alpha_deg": "-0.66666666666666666667",
        "theta2_deg": "0.33333333333333333333",
        "l1": "1.3333333333333333333",
        "l3": "1.6666666666666666667",
    }
    assert asked == sorted(asked)
