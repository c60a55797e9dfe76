"""Zeros are proved, refined, and told apart, however near to each other they are."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import pytest
from flint import arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.boxes import Functions, Jet, Undecided, bits_of, monomials, search, turned
from rpr_solver.boxes.folds import fold_at


def variables(box: Sequence[Any], order: int) -> list[Jet[Any]]:
    n = len(box)
    rows = [{(0,) * n: x, tuple(int(i == k) for i in range(n)): arb(1)} for k, x in enumerate(box)]
    return [Jet(n, order, [row.get(m, arb(0)) for m in monomials(n, order)]) for row in rows]


class Parabolas:
    """y = x² + b x³ − height and y = slope · x: two zeros near (0, 0), or none."""

    def __init__(self, height: Fraction, cubic: Fraction = Fraction(0)) -> None:
        self.height, self.cubic = height, cubic

    @property
    def stages(self) -> Sequence[Functions]:
        return (self.functions,)

    def square(self, _box: object) -> Functions:
        return self.functions

    def functions(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        x, y = variables(box, order)
        one = Jet(2, order, [arb(1), *[arb(0)] * (len(monomials(2, order)) - 1)])
        height = arb(self.height.numerator) / self.height.denominator
        cubic = arb(self.cubic.numerator) / self.cubic.denominator
        curve = y - x * x - x * x * x * cubic + one * height
        return [curve, y + x * x * arb(0.5)]


@given(power=st.integers(4, 90), sign=st.sampled_from([1, -1]), cubic=st.fractions(-1, 1, max_denominator=9))
def test_two_zeros_that_nearly_meet_are_found_at_once(power: int, sign: int, cubic: Fraction) -> None:
    system = Parabolas(Fraction(sign, 10**power), cubic)
    found = search(system, [[arb(0.01, 0.1), arb(-0.02, 0.1)]], 2.0**-200, 800)
    assert not found.doubts
    assert len(found.zeros) == (2 if sign > 0 else 0)
    for zero in found.zeros:
        with ctx.workprec(1000):
            box = zero.within(400)
            assert bits_of(box) >= 400
            assert all(f.value.contains(0) for f in system.functions(box, 0))


def test_a_double_zero_is_in_doubt_and_soon() -> None:
    found = search(Parabolas(Fraction(0)), [[arb(0.01, 0.1), arb(-0.02, 0.1)]], 2.0**-200, 800)
    assert not found.zeros
    assert found.looked < 400
    assert any(all(x.contains(0) for x in box) for box in found.doubts)


class Cubics:
    """y = x² and x y + p x + q = 0: three zeros near (0, 0), or one."""

    def __init__(self, p: Fraction, q: Fraction) -> None:
        self.numbers = [arb(x.numerator) / x.denominator for x in (p, q)]

    @property
    def stages(self) -> Sequence[Functions]:
        return (self.functions,)

    def square(self, _box: object) -> Functions:
        return self.functions

    def functions(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        x, y = variables(box, order)
        p, q = self.numbers
        one = Jet(2, order, [arb(1), *[arb(0)] * (len(monomials(2, order)) - 1)])
        curve, line = y - x * x, x * y + x * p + one * q
        return [curve + line * arb(0.25), line + curve * arb(0.5)]


@given(power=st.integers(4, 38), p=st.sampled_from([-7, -3, 0, 3, 7]), q=st.sampled_from([-5, -1, 0, 1, 5]))
def test_three_zeros_that_nearly_meet_are_found_at_once(power: int, p: int, q: int) -> None:
    """To 10^-38 of each other; the numbers of nearer ones have not enough bits, and they are in doubt."""
    assume(p or q)
    with ctx.workprec(1000):
        system = Cubics(Fraction(p, 10 ** (2 * power)), Fraction(q, 10 ** (3 * power)))
    found = search(system, [[arb(0.001, 0.01), arb(-0.002, 0.01)]], 2.0**-250, 1500)
    assert not found.doubts
    # the discriminant of x³ + p x + q
    assert len(found.zeros) == (3 if 4 * p**3 + 27 * q**2 < 0 else 1)


def test_a_box_with_a_simple_zero_is_in_no_fold() -> None:
    def functions(box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        x, y = variables(box, order)
        return [x + y, x - y]

    box = [arb(0, 1e-6), arb(0, 1e-6)]
    with pytest.raises(Undecided):
        fold_at(functions, [arb(0, 0.01), arb(0, 0.01)], box)


class Waves:
    """sin (x − a) = sin (y − b) = 0 with cos > 0: one zero a turn in each variable."""

    def __init__(self, a: float, b: float) -> None:
        self.at = a, b

    @property
    def stages(self) -> Sequence[Functions]:
        return (self.functions,)

    def square(self, _box: object) -> Functions:
        return self.functions

    def functions(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        rows = []
        for k, (x, a) in enumerate(zip(box, self.at, strict=True)):
            sin, cos = ((x - a) / 2).sin_cos()
            powers = [sin, cos / 2, -sin / 8, -cos / 48]
            rows.append(
                Jet(
                    2,
                    order,
                    [powers[m[k]] if m[k] == sum(m) and m[k] < 4 else arb(0) for m in monomials(2, order)],
                )
            )
        return rows


@given(a=st.floats(-3, 3), b=st.floats(-3, 3))
def test_zeros_are_one_after_whole_turns(a: float, b: float) -> None:
    # the half angle has a zero in each turn
    start = [[arb(x, 3.2), arb(y, 3.2)] for x in (0, 6.4) for y in (0, 6.4)]
    found = search(Waves(a, b), start, 2.0**-60, 2000, turned(0, 1))
    assert len(found.zeros) == 1
    assert not found.doubts
