"""Landmarks: lengths without a pose of their own."""

from fractions import Fraction

from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.transitions.event_types import Event, Landmark


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


def test_a_rational_landmark_is_as_narrow_as_the_precision() -> None:
    event = Landmark(Field.rationals()(Fraction(1, 3)))
    assert event.exact_length.rational == Fraction(1, 3)
    assert (event.scaled_length(200) * 3).contains(1)
