"""Poses in floats, and floats with bounds of their errors against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction
from math import atan2, degrees, ldexp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, eliminate, solve_slice
from rpr_solver.slices.cusp_table import SliceSolver
from rpr_solver.slices.fast.poses import Bounded, DoubleMap, HalfAngles, map_exponent, number_type
from rpr_solver.slices.fast.proofs import guesses, proved_boxes
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

LENGTHS = [Fraction(k, 3) for k in range(20, 100, 9)]


def angle(x: HalfAngles, place: int) -> float:
    cos, sin = (float(part[place]) for part in (x.turn.real, x.turn.imag))
    return degrees(atan2(sin, cos))


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_guesses_are_the_cusps(leg: int) -> None:
    eliminant = eliminant_of(EXAMPLES["zein-flat"], leg)
    scaled = [x * eliminant.slice_map.scale for x in LENGTHS]
    thetas = [guess.real for guess in guesses(eliminant, scaled)]
    exponent = map_exponent(eliminant.slice_map, scaled)
    double_map = DoubleMap.of(eliminant.slice_map, exponent)
    index = np.repeat(np.arange(len(thetas)), [len(x) for x in thetas])
    lengths = double_map.lengths(scaled)
    assert np.array_equal(lengths.astype(float), [ldexp(float(x), -exponent) for x in scaled])
    found = double_map.guessed(lengths[index], [pair for x in thetas for pair in x])
    for place, length in enumerate(LENGTHS):
        poses = [
            (angle(found.theta, k), angle(found.alpha, k)) for k in np.flatnonzero(index == place).tolist()
        ]
        cusps = solve_slice(eliminant, length, 15).cusps
        expected = [(float(c.coordinates[1]), float(c.alpha_deg)) for c in cusps]
        assert np.allclose(sorted(poses), expected, rtol=0, atol=1e-9)


def test_all_numbers_of_a_manipulator_are_at_most_1() -> None:
    slice_map = eliminant_of(EXAMPLES["innocenti"]).slice_map
    for longest in (Fraction(1, 100), Fraction(10**6)):
        exponent = map_exponent(slice_map, [Fraction(1, 7), longest])
        double_map = DoubleMap.of(slice_map, exponent)
        assert longest <= Fraction(2) ** exponent
        numbers = [x for leg in (double_map.f, double_map.g) for wave in leg for x in (wave.real, wave.imag)]
    assert all(x.size <= 1 for x in numbers)


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


def test_angles_ascend_from_half_a_turn_to_half_a_turn() -> None:
    turns = np.linspace(-3.14, 3.14, 101)
    angles = HalfAngles(np.sin(turns / 2), np.cos(turns / 2))
    assert (np.diff(angles.place()) > 0).all()
    assert (abs(angles.x) <= 1).all()
    angles.add(np.full(101, 1e-5))
    cos, sin = angles.turn.real, angles.turn.imag
    assert np.allclose(np.arctan2(sin, cos), turns + 1e-5, rtol=0, atol=1e-9)


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


def test_the_bound_is_close() -> None:
    third = Bounded(np.array([1.0]) / 3, np.array([2.0**-54]), 2.0**-53)
    total = third
    for _ in range(20):
        total = total * third + third
    assert total.error[0] < 8 * 2.0**-53
