"""Krawczyk's test in one and three unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import proved_zero

BITS = 120


class Square:
    """x² = 2."""

    def __init__(self, target: int = 2) -> None:
        self.target = target

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        return [box[0] * box[0] - Interval.of(self.target, BITS)]

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


def test_no_zero_and_a_double_one_are_not_proved() -> None:
    assert proved_zero(Square(-1), [Interval.of(1, BITS)], 60) is None
    assert proved_zero(Square(0), [Interval.of(Fraction(1, 100), BITS)], 60) is None
    assert proved_zero(Square(), [Interval.of(0, BITS)], 60) is None
