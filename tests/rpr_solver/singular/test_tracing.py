"""Samples lie on J = 0, keep the tolerance, and are denser where it is smaller."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import atan, hypot, tan

import pytest

from rpr_solver import Manipulator, SingularCurves, SolverError, singular_curves, trace_slice
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.singular import tracing
from rpr_solver.singular.tracing import ArcPoints, arcs_at, arcs_beside
from tests.support.sampling import long
from tests.support.shared import eliminant_of
from tests.support.singular import SLICES, manipulator, swept


@pytest.mark.parametrize(("name", "leg", "length"), SLICES[1:5:3])
def test_a_finer_curve_is_within_the_tolerance_of_a_coarser_one(name: str, leg: int, length: str) -> None:
    eliminant = eliminant_of(manipulator(name), leg)
    rough, smooth = (trace_slice(eliminant, length, tolerance=x) for x in ("0.01", "0.0001"))
    pairs = list(zip(rough.strands, smooth.strands, strict=True))
    extent = max(max(axis) - min(axis) for axis in _joined(rough))
    for coarse, fine in pairs:
        chords = list(pairwise(zip(coarse.first, coarse.second, strict=True)))
        for p in list(zip(fine.first, fine.second, strict=True))[::7]:
            assert min(_distance(a, b, p) for a, b in chords) <= 0.01 * extent


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_arcs_found_from_those_beside_them_are_those_that_are_isolated(
    name: str, leg: int, length: str
) -> None:
    found = swept(name, leg, length)
    points, given = ArcPoints(found), 0
    for slab in range(len(found.slabs)):
        low, high = (x - found.chart.theta.angle for x in points.span(slab))
        places = [low + (high - low) * k / 16 for k in range(-1, 18)]
        for theta, other in pairwise(places):
            arcs = arcs_beside(points.floats, found, slab, other, arcs_at(found, slab, theta))
            if arcs is None:
                continue
            given += 1
            assert low < other < high
            roots = real_roots(found.chart.above(Fraction(tan(other / 2))))
            own = [2 * atan(float(root.refined(64).mid())) for root in roots]
            assert arcs == pytest.approx(own, abs=1e-9)
    assert given > 5 * len(found.slabs) or found.chart.repeated


@pytest.mark.parametrize("limit", [2000, long(tracing._MOST_WORK)])
def test_the_roundings_of_floats_are_not_drawn(limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracing, "_MOST_WORK", limit)
    tiny_base = Manipulator("1e-10", "2e-10", "1e-10", 1, 1, 1)
    with pytest.raises(SolverError, match="differ too much for a drawing"):
        singular_curves(tiny_base, 1)


def _joined(curves: SingularCurves) -> list[list[float]]:
    strands = list(curves.strands)
    return [[x for s in strands for x in s.first], [x for s in strands for x in s.second]]


def _distance(a: tuple[float, float], b: tuple[float, float], p: tuple[float, float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    part = max(0.0, min(1.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square)) if square else 0.0
    return hypot(p[0] - a[0] - part * dx, p[1] - a[1] - part * dy)
