"""Poses guessed above roots, against the cusps of the tables."""

from __future__ import annotations

from fractions import Fraction
from math import atan2, degrees, ldexp

import numpy as np
import pytest

from rpr_solver import EXAMPLES, eliminate, solve_slice
from rpr_solver.slices.chunk import SliceChunk
from rpr_solver.slices.discs import guesses
from rpr_solver.slices.double_poses import DoubleMap, HalfAngles, map_exponent, number_type
from rpr_solver.slices.pose_proofs import proved_boxes
from tests.support.shared import eliminant_of

LENGTHS = [Fraction(k, 3) for k in range(20, 100, 9)]


def angle(x: HalfAngles, place: int) -> float:
    cos, sin = (float(part[place]) for part in x.cos_sin())
    return degrees(atan2(sin, cos))


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_guesses_are_the_cusps(leg: int) -> None:
    eliminant = eliminant_of(EXAMPLES["zein-flat"], leg)
    scaled = [x * eliminant.slice_map.scale for x in LENGTHS]
    thetas = [guess.real for guess in guesses(eliminant, scaled)]
    exponent = map_exponent(eliminant.slice_map, scaled)
    double_map = DoubleMap.of(np, eliminant.slice_map, exponent)
    index = np.repeat(np.arange(len(thetas)), [len(x) for x in thetas])
    lengths = double_map.lengths(np, scaled)
    assert np.array_equal(lengths.astype(float), [ldexp(float(x), -exponent) for x in scaled])
    found = double_map.guessed(np, lengths[index], [pair for x in thetas for pair in x])
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
        double_map = DoubleMap.of(np, slice_map, exponent)
        assert longest <= Fraction(2) ** exponent
        assert all(x.size <= 1 for leg in (double_map.f, double_map.g) for x in leg.numbers)


def test_double_precision_alone_will_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a processor without extended precision: the same tables, and most of them by floats."""
    expected = [solve_slice(eliminant_of(EXAMPLES["zein-flat"]), x, 15) for x in LENGTHS]
    monkeypatch.setattr(np, "longdouble", np.float64)
    assert number_type(np) == (np.float64, 2.0**-53)
    eliminant = eliminate(EXAMPLES["zein-flat"])
    chunk = SliceChunk(eliminant, LENGTHS, 15)
    assert [chunk.table(place) for place in range(len(LENGTHS))] == expected
    scaled = [x * eliminant.slice_map.scale for x in LENGTHS]
    _, boxes = proved_boxes(eliminant, scaled, [guess.real for guess in guesses(eliminant, scaled)])
    assert sum(x is not None for x in boxes) > len(LENGTHS) // 2


def test_angles_ascend_from_half_a_turn_to_half_a_turn() -> None:
    turns = np.linspace(-3.14, 3.14, 101)
    angles = HalfAngles(np, np.sin(turns / 2), np.cos(turns / 2))
    assert (np.diff(angles.place(np)) > 0).all()
    assert (abs(angles.x) <= 1).all()
    angles.turn(np.full(101, 1e-5))
    cos, sin = angles.cos_sin()
    assert np.allclose(np.arctan2(sin, cos), turns + 1e-5, rtol=0, atol=1e-9)
