"""The sweep: every arc has two ends, every line is matched, and counts agree with a float raster of J."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import pi

import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, ball_of
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.line import between
from rpr_solver.singular.sweep import Sweep, sweep
from rpr_solver.singular.tracing import angle_of
from tests.support.families import family
from tests.support.sampling import sample
from tests.support.singular import SLICES, swept

EACH = pytest.mark.parametrize(("name", "leg", "length"), SLICES)


@EACH
def test_counts_agree_with_sign_changes_of_j(name: str, leg: int, length: str) -> None:
    found = swept(name, leg, length)
    chart = found.chart
    floats = FloatSlice.of(chart.slice_map, chart.length)
    for slab, low, high in _ranges(found):
        theta = (low + high) / 2 + chart.theta.angle
        line = floats.on_line(theta)
        values = [line.value_and_slope(2 * pi * k / 4000)[0] for k in range(4000)]
        changes = sum((a > 0) != (b > 0) for a, b in zip(values, [*values[1:], values[0]], strict=True))
        assert changes == len(found.slabs[slab].arcs)


def _ranges(found: Sweep) -> list[tuple[int, float, float]]:
    angles = [angle_of(line.root) for line in found.lines]
    ends = [*angles[1:], angles[0] + 2 * pi]
    wide = [(k, a, b) for k, (a, b) in enumerate(zip(angles, ends, strict=True)) if b - a > 0.02]
    assert wide
    return wide


def known(root: Fraction, bits: int) -> RealRoot:
    """A root that is known to so many bits."""
    ball = arb(ball_of(root).mid(), arb(2) ** -bits)
    return RealRoot(QuadraticPoly.rational([-root.numerator, root.denominator]), ball)


@given(
    st.fractions(-3, 3, max_denominator=12),
    st.integers(1, 9),
    st.integers(1, 120),
    st.sampled_from((64, 300, 700)),
)
def test_a_rational_between_roots_lies_between_them(low: Fraction, step: int, places: int, bits: int) -> None:
    """Also where the roots are nearer each other than the precision at which they are told apart."""
    high = low + Fraction(step, 10**places)
    assert low < between(known(low, bits), known(high, bits)) < high


SPECIAL = (10, 15, 20, 25, 30, 45, 60, 75)
"""Lengths about which the similar triangles of the family have lines, and arcs, as near as one likes."""


@pytest.mark.parametrize(
    ("leg", "length", "places"), sample(product((1, 2, 3), SPECIAL, (40, 70, 80, 100)), 14, 31, 62, 94)
)
def test_beside_a_special_length_things_are_as_farther_beside_it(leg: int, length: int, places: int) -> None:
    slice_map = SliceMap.of(family("similar"), leg)

    def topology(offset: Fraction) -> tuple[list[int], list[int]]:
        found = sweep(slice_map, (length + offset) * slice_map.scale)
        return [len(slab.arcs) for slab in found.slabs], [len(line.meetings) for line in found.lines]

    for sign in (-1, 1):
        assert topology(sign * Fraction(1, 10**places)) == topology(sign * Fraction(1, 10**9))
