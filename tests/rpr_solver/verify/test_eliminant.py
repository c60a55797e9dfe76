"""The verifier's eliminant against the solver's."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import pytest

from rpr_solver import EXAMPLES, Manipulator, cusp_table, eliminate
from rpr_solver.verify.core.intervals import cos_sin, radians
from rpr_solver.verify.core.krawczyk import direction
from rpr_solver.verify.core.roots import Root
from rpr_solver.verify.core.surds import Ring, rational
from rpr_solver.verify.core.system import System
from rpr_solver.verify.eliminant import Eliminant, nearby, opposite, unlisted
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
    assert not mine.special_at_infinity


def test_degenerate_slices() -> None:
    similar = eliminant_of(family("similar"), 1, Fraction(9))
    assert similar.shape == {3: 4, 6: 2}
    assert not similar.generic
    assert not similar.single_roots
    congruent = eliminant_of(family("congruent"), 1, Fraction(5))
    assert (congruent.form, congruent.cut.curves) == ((), ["alpha = 0 deg"])
    assert congruent.special_at_infinity
    assert len(congruent.rest) > 1


BITS = 160


def test_a_line_through_a_cusp_is_clear_once_the_cusp_is_listed() -> None:
    [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=30)
    system = System.of(geometry_of(EXAMPLES["zein-flat"]), 1, Fraction(10))
    alpha, theta = (radians(Fraction(x), BITS) for x in (table.cusps[0].alpha_deg, table.cusps[0].theta1_deg))
    line = cos_sin(theta)
    found = unlisted(system, line, [], 0)
    assert found is not None
    assert abs(found - alpha.middle) < Fraction(1, 10**6)
    assert unlisted(system, line, [nearby(alpha)], 0) is None
    assert unlisted(system, opposite(BITS), [], 0) is None


def test_the_direction_of_a_line() -> None:
    # u² = 3, θ = ±120°, by u and by 1/u
    for root in (Root(Fraction(1), Fraction(2), False), Root(Fraction(1, 2), Fraction(1), True)):
        cos, sin = direction(Ring(1), rational([-3, 0, 1]), root, 60)
        assert cos.contains(Fraction(-1, 2))
        assert sin.contains(Fraction(866025403784438647, 10**18)) or sin.sign == 1
