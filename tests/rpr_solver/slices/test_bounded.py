"""Floats with bounds of their errors, against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.slices.bounded import Bounded
from tests.support.strategies import examples

KINDS = {np.float64: 2.0**-53, np.longdouble: float(np.finfo(np.longdouble).eps) / 2}
DUST = Fraction(1, 2**600)
"""What may underflow; pose_proofs.py adds it in the end."""
Number = tuple[Bounded, Fraction]


def exact(x: np.floating) -> Fraction:
    high = float(x)
    return Fraction(high) + Fraction(float(x - high))


def is_bounded(x: Bounded, truth: Fraction) -> bool:
    return abs(exact(x.value[0]) - truth) <= Fraction(float(x.error[0])) + DUST


NUMBERS = st.tuples(st.floats(-1e6, 1e6), st.floats(0, 1e-3), st.floats(-1, 1))


@pytest.mark.parametrize("kind", KINDS, ids=["double", "extended"])
@given(st.lists(NUMBERS, min_size=2, max_size=2), st.lists(st.sampled_from("+-*"), max_size=8))
@examples(40)
def test_the_exact_value_is_within_the_error(
    kind: type[np.floating], numbers: list[tuple[float, float, float]], steps: list[str]
) -> None:
    if kind is np.longdouble and np.finfo(kind).nmant != 63:
        pytest.skip("this processor has no extended precision")
    unit = KINDS[kind]
    pairs: list[Number] = []
    for value, radius, place in numbers:
        ball = Bounded(np.array([value], dtype=kind) / 3, np.array([radius + abs(value) * unit]), unit)
        pairs.append((ball, exact(ball.value[0]) + Fraction(radius) * Fraction(place)))
    (x, truth), (y, other) = pairs
    for step in steps:
        if step == "*":
            x, truth = x * y, truth * other
        elif step == "+":
            x, truth = x + y, truth + other
        else:
            x, truth = y - x, other - truth
        assert is_bounded(x, truth)
        assert Fraction(float(x.least[0])) - DUST <= abs(truth)
        assert abs(truth) <= Fraction(float(x.greatest[0])) + DUST


def test_the_bound_is_close() -> None:
    third = Bounded(np.array([1.0]) / 3, np.array([2.0**-54]), 2.0**-53)
    total = third
    for _ in range(20):
        total = total * third + third
    assert total.error[0] < 8 * 2.0**-53
