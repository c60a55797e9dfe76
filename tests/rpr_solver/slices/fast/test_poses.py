"""Poses in floats, and floats with bounds of their errors against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, eliminate, solve_slice
from rpr_solver.slices.cusp_table import SliceSolver
from rpr_solver.slices.fast.poses import Bounded, number_type
from rpr_solver.slices.fast.proofs import guesses, proved_boxes
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

LENGTHS = [Fraction(k, 3) for k in range(20, 100, 9)]


def test_double_precision_alone_will_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a processor without extended precision: the same tables, and most of them by floats."""
    expected = [solve_slice(eliminant_of(EXAMPLES["zein-flat"]), x, 15) for x in LENGTHS]
    monkeypatch.setattr(np, "longdouble", np.float64)
    assert number_type() == (np.float64, 2.0**-53)
    eliminant = eliminate(EXAMPLES["zein-flat"])
    chunk = SliceSolver(eliminant, LENGTHS, 15)
    assert [chunk.table(place) for place in range(len(LENGTHS))] == expected
    scaled = [x * eliminant.slice_map.scale for x in LENGTHS]
    boxes = proved_boxes(eliminant, scaled, [guess.real for guess in guesses(eliminant, scaled)])
    assert sum(x is not None for x in boxes) > len(LENGTHS) // 2


KINDS = {np.float64: 2.0**-53, np.longdouble: float(np.finfo(np.longdouble).eps) / 2}
DUST = Fraction(1, 2**600)
"""What may underflow; proofs.py adds it in the end."""
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
