"""π, sines and cosines, against mpmath."""

from fractions import Fraction

import mpmath
import pytest

from rpr_solver.verify.core.angles import angle_near, cos_sin, degrees, pi, radians
from rpr_solver.verify.core.intervals import Interval


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


@pytest.mark.parametrize(("angle", "guess"), [(40, 41), (-179, 179), (180, Fraction(1799, 10)), (0, 0)])
def test_an_angle_by_its_direction(angle: int, guess: Fraction) -> None:
    bits = 400
    cos, sin = cos_sin(radians(Fraction(angle), bits))
    found = degrees(angle_near(cos, sin, radians(Fraction(guess), bits))).middle
    assert abs((found - angle + 180) % 360 - 180) < Fraction(1, 1 << (bits - 20))
