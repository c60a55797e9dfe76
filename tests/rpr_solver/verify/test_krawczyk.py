"""Krawczyk's test in one and three unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import pytest

from rpr_solver.verify.core.intervals import Interval, degrees, radians
from rpr_solver.verify.core.krawczyk import Equations, proved_zero, zero_near
from rpr_solver.verify.core.system import Trig
from rpr_solver.verify.cusps import around
from tests.support.verified import printed

BITS = 120


class Square:
    """x² = 2, or another number."""

    def __init__(self, target: Fraction | int = 2) -> None:
        self.target = target

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        return [box[0] * box[0] - Interval.of(self.target, box[0].bits)]

    def jacobian(self, box: Sequence[Interval]) -> list[list[Interval]]:
        return [[box[0].scaled(2)]]


class Coupled:
    """x + y + z = 6, x y = 2, y z = 6."""

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        x, y, z = box
        return [x + y + z - Interval.of(6, BITS), x * y - Interval.of(2, BITS), y * z - Interval.of(6, BITS)]

    def jacobian(self, box: Sequence[Interval]) -> list[list[Interval]]:
        x, y, z = box
        zero, one = Interval.of(0, BITS), Interval.of(1, BITS)
        return [[one, one, one], [y, x, zero], [zero, z, y]]


def test_zeros_are_proved() -> None:
    root = proved_zero(Square(), [Interval.of(Fraction(7, 5), BITS)], 90)
    assert root is not None
    assert (root[0] * root[0]).contains(2)
    assert root[0].radius < Fraction(1, 1 << 80)
    start = [Interval.of(Fraction(x, 10), BITS) for x in (11, 19, 31)]
    zero = proved_zero(Coupled(), start, 60)
    assert zero is not None
    assert [x.contains(k) for k, x in enumerate(zero, 1)] == [True] * 3


@pytest.mark.parametrize("target", [2, Fraction(1, 1 << 300)])
def test_zeros_of_many_bits_are_proved_by_slopes_of_few_unless_they_are_small(target: Fraction | int) -> None:
    start = 2**-150 if target != 2 else Fraction(7, 5)
    near = Interval.of(Fraction(start) * Fraction(1001, 1000), 4000)
    root = proved_zero(Square(target), [near], 3000)
    assert root is not None
    assert (root[0] * root[0]).contains(target)
    assert root[0].radius < Fraction(1, 1 << 2990)


def test_no_zero_and_a_double_one_are_not_proved() -> None:
    assert proved_zero(Square(-1), [Interval.of(1, BITS)], 60) is None
    assert proved_zero(Square(0), [Interval.of(Fraction(1, 100), BITS)], 60) is None
    assert proved_zero(Square(), [Interval.of(0, BITS)], 60) is None


SUM: Trig = {(1, 0, 0, 0): (2, 0), (0, 0, 0, 0): (-1, 0)}
"""2 cos α − 1."""
SINE: Trig = {(0, 0, 0, 1): (2, 0), (0, 0, 0, 0): (0, -1)}
"""2 sin θ − √2."""


def at(alpha: float | str, theta: float | str) -> tuple[Interval, Interval]:
    """Two angles in radians."""
    return radians(Fraction(alpha), 300), radians(Fraction(theta), 300)


def test_a_zero_and_its_neighbours() -> None:
    equations = Equations.of(SUM, SINE, 2)
    box = zero_near(equations, *at("60.1", "44.9"), 200)
    assert box is not None
    assert degrees(box.alpha).contains(60)
    assert degrees(box.theta).contains(45)
    assert degrees(box.alpha).radius < Fraction(1, 1 << 190)
    assert box.meets(box)
    other = zero_near(equations, *at(-60, 45), 100)
    assert other is not None
    assert not box.meets(other)
    assert box.meets(around(printed("60.00"), printed("45.0"), 80, 2))


def test_no_box_without_a_regular_zero() -> None:
    assert zero_near(Equations.of(SUM, SUM, 2), *at(60, 45), 60) is None
    one: Trig = {(0, 0, 0, 0): (1, 0), (1, 0, 0, 0): (-1, 0)}
    assert zero_near(Equations.of(one, SINE, 2), *at(1, 45), 60) is None
