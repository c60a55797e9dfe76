"""Krawczyk's test on equations with known zeros."""

from fractions import Fraction

from rpr_solver.verify.core.angles import degrees
from rpr_solver.verify.core.boxes import Equations, around, zero_near
from rpr_solver.verify.core.system import Trig
from tests.support.verified import printed

SUM: Trig = {(1, 0, 0, 0): (2, 0), (0, 0, 0, 0): (-1, 0)}
"""2 cos α − 1."""
SINE: Trig = {(0, 0, 0, 1): (2, 0), (0, 0, 0, 0): (0, -1)}
"""2 sin θ − √2."""


def test_a_zero_and_its_neighbours() -> None:
    equations = Equations.of(SUM, SINE, 2)
    box = zero_near(equations, Fraction(601, 10), Fraction(449, 10), 200)
    assert box is not None
    assert degrees(box.alpha).contains(60)
    assert degrees(box.theta).contains(45)
    assert degrees(box.alpha).radius < Fraction(1, 1 << 190)
    assert box.meets(box)
    other = zero_near(equations, Fraction(-60), Fraction(45), 100)
    assert other is not None
    assert not box.meets(other)
    assert box.meets(around(printed("60.00"), printed("45.0"), 80, 2))


def test_no_box_without_a_regular_zero() -> None:
    assert zero_near(Equations.of(SUM, SUM, 2), Fraction(60), Fraction(45), 60) is None
    one: Trig = {(0, 0, 0, 0): (1, 0), (1, 0, 0, 0): (-1, 0)}
    assert zero_near(Equations.of(one, SINE, 2), Fraction(1), Fraction(45), 60) is None
