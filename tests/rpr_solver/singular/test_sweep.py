"""The sweep: every arc has two ends, every line is matched, and counts agree with a float raster of J."""

from __future__ import annotations

from math import pi

import pytest

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.sweep import Sweep
from rpr_solver.singular.tracing import angle_of
from tests.support.singular import SLICES, swept

EACH = pytest.mark.parametrize(("name", "leg", "length"), SLICES)


@EACH
def test_every_arc_begins_and_ends_once(name: str, leg: int, length: str) -> None:
    found = swept(name, leg, length)
    for number, line in enumerate(found.lines):
        before, after = found.slabs[number - 1], found.slabs[number]
        assert sorted(arc for m in line.meetings for arc in m.left) == list(range(len(before.arcs)))
        assert sorted(arc for m in line.meetings for arc in m.right) == list(range(len(after.arcs)))
        low, high = map(ball_of, line.around)
        assert low < line.root.refined(64) < high


@EACH
def test_signs_alternate_and_continue_through_lines(name: str, leg: int, length: str) -> None:
    found = swept(name, leg, length)
    for number, line in enumerate(found.lines):
        before, after = found.slabs[number - 1], found.slabs[number]
        assert all(before.signs[left] == after.signs[right] for left, right in line.links)
    for slab in found.slabs:
        assert len(slab.arcs) in (0, 2, 4)
        assert all(a == -b for a, b in zip(slab.signs, slab.signs[1:], strict=False))


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
