"""Intervals hold every result of their numbers."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.verify.core.intervals import (
    Interval,
    cos_sin,
    degrees,
    halved,
    pi,
    radians,
)
from rpr_solver.verify.core.krawczyk import angle_of, enclosed
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
        assert (a * b).contains(end * y)
        assert a.scaled(-3).contains(-3 * end)
        assert halved(a, 3).contains(end / 8)
        if b.sign:
            assert a.over(b).contains(end / y)


def test_roots_signs_and_ends() -> None:
    two = Interval.of(2, BITS).root()
    assert two.lower**2 <= 2 << (2 * BITS) <= two.upper**2
    assert (Interval.of(1, BITS, 2).sign, two.sign, two.scaled(-1).sign) == (0, 1, -1)
    assert two.inside(Fraction(7, 5), Fraction(3, 2))
    assert two.meets(Interval.of(Fraction(3, 2), 12, Fraction(1, 10)))
    assert not two.meets(Interval.of(Fraction(3, 2), 90))
    assert two.greatest >= two.middle
    with pytest.raises(ZeroDivisionError):
        two.over(Interval.of(0, BITS, 1))
    with pytest.raises(ValueError, match="negative"):
        Interval.of(-1, BITS).root()


def near(x: Interval, value: mpmath.mpf, slack: int) -> bool:
    scaled = value * mpmath.mpf(2) ** x.bits
    return x.lower <= scaled <= x.upper and x.upper - x.lower <= slack


@pytest.mark.parametrize("bits", [20, 64, 500, 5000])
def test_pi_and_angles(bits: int) -> None:
    with mpmath.workprec(bits + 100):
        assert near(pi(bits), +mpmath.pi, 8)
        for angle in (
            Fraction(0),
            Fraction(1, 3),
            Fraction(-179),
            Fraction(180),
            Fraction(-90),
            Fraction(7, 10**9),
        ):
            value = mpmath.mpf(angle.numerator) / angle.denominator * mpmath.pi / 180
            x = radians(angle, bits)
            assert near(x, value, 2000)
            cos, sin = cos_sin(x)
            assert near(cos, mpmath.cos(value), 4000)
            assert near(sin, mpmath.sin(value), 4000)
            assert degrees(x).contains(angle)


def test_wide_angles() -> None:
    cos, sin = cos_sin(Interval.of(1, 50, Fraction(1, 10)))
    with mpmath.workprec(80):
        for angle in (0.9, 1, 1.1):
            assert near(cos, mpmath.cos(angle), 1 << 49)
            assert near(sin, mpmath.sin(angle), 1 << 49)


@pytest.mark.parametrize("angle", [40, -179, 180, 0])
def test_an_angle_by_its_direction(angle: int) -> None:
    bits = 400
    cos, sin = cos_sin(radians(Fraction(angle), bits))
    found = degrees(angle_of((cos, sin))).middle
    assert abs((found - angle + 180) % 360 - 180) < Fraction(1, 1 << (bits - 20))
    for most in (bits, 100):
        box = degrees(enclosed((cos.scaled(5), sin.scaled(5)), most))
        assert box.contains(angle) or box.contains(angle - 360)
        assert box.radius < Fraction(1, 1 << (most - 20))
    with pytest.raises(ArithmeticError):
        enclosed((Interval.of(0, bits, 1), sin))
