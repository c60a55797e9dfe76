"""Intervals hold every result of their numbers."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.verify.core.intervals import Interval
from tests.support.strategies import examples

NUMBERS = st.fractions(-50, 50, max_denominator=1000)
BITS = 40


@examples(60)
@given(NUMBERS, NUMBERS, st.fractions(0, 2, max_denominator=50))
def test_operations_hold_their_results(x: Fraction, y: Fraction, radius: Fraction) -> None:
    a, b = Interval.of(x, BITS, radius), Interval.of(y, BITS)
    for end in (x - radius, x, x + radius):
        assert (a + b).contains(end + y)
        assert (a - b).contains(end - y)
        assert (-a).contains(-end)
        assert (a * b).contains(end * y)
        assert a.scaled(-3).contains(-3 * end)
        if b.sign:
            assert a.over(b).contains(end / y)


def test_roots_signs_and_ends() -> None:
    two = Interval.of(2, BITS).root()
    assert two.lower**2 <= 2 << (2 * BITS) <= two.upper**2
    assert (Interval.of(1, BITS, 2).sign, two.sign, (-two).sign) == (0, 1, -1)
    assert two.inside(Fraction(7, 5), Fraction(3, 2))
    assert two.meets(Interval.of(Fraction(3, 2), 12, Fraction(1, 10)))
    assert not two.meets(Interval.of(Fraction(3, 2), 90))
    assert two.greatest >= two.middle
    with pytest.raises(ZeroDivisionError):
        two.over(Interval.of(0, BITS, 1))
    with pytest.raises(ValueError, match="negative"):
        Interval.of(-1, BITS).root()
