"""The verifier's eliminant against the solver's."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import pytest

from rpr_solver import Manipulator, eliminate
from rpr_solver.verify.core.system import System
from rpr_solver.verify.eliminant import Eliminant
from tests.support.families import family
from tests.support.verified import geometry_of


def eliminant_of(manipulator: Manipulator, leg: int, length: Fraction) -> Eliminant:
    return Eliminant.of(System.of(geometry_of(manipulator), leg, length))


@pytest.mark.parametrize(
    ("name", "leg"), [("isosceles, irrational", 1), ("flat base", 2), ("right angles", 3)]
)
def test_two_ways_to_one_polynomial(name: str, leg: int) -> None:
    length = Fraction(13, 2)
    mine = eliminant_of(family(name), leg, length)
    theirs = eliminate(family(name), leg)
    q = theirs.at(length * theirs.slice_map.scale)
    # both square roots are of numbers that differ by a square
    square = Fraction(theirs.slice_map.radicand, mine.ring.radicand)
    k = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    assert k * k == square
    other = [
        (int(a) * k.denominator, int(b) * k.numerator) for a, b in zip(q.a, [*q.b, *[0] * 25], strict=False)
    ]
    ring = mine.ring
    assert [ring.times(x, other[0]) for x in mine.form] == [ring.times(y, mine.form[0]) for y in other]
    assert mine.generic
    assert mine.shape == {1: 24}
    assert mine.special_at_infinity == (len(mine.along) < 3)


def test_degenerate_slices() -> None:
    similar = eliminant_of(family("similar"), 1, Fraction(9))
    assert similar.shape == {3: 4, 6: 2}
    assert not similar.generic
    assert not similar.single_roots
    congruent = eliminant_of(family("congruent"), 1, Fraction(5))
    assert (congruent.form, congruent.cut.curves) == ((), ["alpha = 0 deg"])
    assert congruent.special_at_infinity
    assert len(congruent.rest) > 1
