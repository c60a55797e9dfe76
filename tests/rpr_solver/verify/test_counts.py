"""Counts of slices without their cusps, and short numbers between others."""

from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.verify.counts import cusps_counted, simplest_between
from rpr_solver.verify.manipulator import Geometry
from tests.support.families import family


def counted(manipulator: Manipulator, length: str) -> tuple[int, bool] | None:
    return cusps_counted(Geometry.of(manipulator.identity_json()), 1, Fraction(length))


def test_counts() -> None:
    assert counted(EXAMPLES["zein-flat"], "34.5") == (8, True)
    assert counted(family("congruent"), "9") is None


@pytest.mark.long
def test_cusps_are_searched_for_beside_multiple_roots() -> None:
    assert counted(family("similar"), "9") == (0, False)


def test_short_numbers() -> None:
    low = Fraction("9.1868068")
    for high in (Fraction("9.1868069"), Fraction("9.3"), Fraction(200)):
        between = simplest_between(low, high)
        assert low < between < high
        assert between.denominator <= 10 / (high - low) + 1
