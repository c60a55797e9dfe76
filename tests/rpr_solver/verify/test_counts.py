"""Counts of slices without their cusps, and short numbers between others."""

from fractions import Fraction

from rpr_solver import EXAMPLES
from rpr_solver.verify.counts import cusps_counted, simplest_between
from rpr_solver.verify.manipulator import Geometry
from tests.support.families import family


def test_counts() -> None:
    flat = Geometry.of(EXAMPLES["zein-flat"].identity_json())
    assert cusps_counted(flat, 1, Fraction("34.5")) == (8, True)
    assert cusps_counted(Geometry.of(family("similar").identity_json()), 1, Fraction(9)) == (0, False)
    assert cusps_counted(Geometry.of(family("congruent").identity_json()), 1, Fraction(9)) is None


def test_short_numbers() -> None:
    low = Fraction("9.1868068")
    for high in (Fraction("9.1868069"), Fraction("9.3"), Fraction(200)):
        between = simplest_between(low, high)
        assert low < between < high
        assert between.denominator <= 10 / (high - low) + 1
