"""Closed formulas of derivatives, in floats against differences of the functions, and against jets."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import cos, isclose, sin

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.article.couples import CouplePoses
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.jets import HalfTangent
from rpr_solver.slices.fast.derivatives import LegPoints, PoseDerivatives, singularity_and_coalescence
from tests.support.shared import eliminant_of

F, G = LegPoints(0.3, 0.8, -0.7, 0.2), LegPoints(-0.5, 0.1, 0.4, 0.9)
STEP = 1e-4


def at(alpha: float, theta: float) -> PoseDerivatives[float]:
    return PoseDerivatives.at(F, G, (1.25, cos(alpha), sin(alpha), cos(theta), sin(theta)))


@pytest.mark.parametrize(
    ("value", "slopes"),
    [
        (lambda a, t: at(a, t).j, ("j_alpha", "j_theta")),
        (lambda a, t: at(a, t).e, ("e_alpha", "e_theta")),
    ],
    ids=["J", "E"],
)
def test_slopes(value: Callable[[float, float], float], slopes: tuple[str, str]) -> None:
    for alpha, theta in ((0.4, 1.1), (-2.0, 0.3), (3.0, -2.5)):
        steps = ((STEP, 0.0), (0.0, STEP))
        for (da, dt), name in zip(steps, slopes, strict=True):
            slope = (value(alpha + da, theta + dt) - value(alpha - da, theta - dt)) / (2 * STEP)
            assert isclose(slope, getattr(at(alpha, theta), name), rel_tol=1e-6, abs_tol=1e-6)


def test_the_values_alone_are_the_same() -> None:
    d = at(0.7, -1.2)
    assert singularity_and_coalescence(F, G, (1.25, cos(0.7), sin(0.7), cos(1.2), -sin(1.2))) == (d.j, d.e)


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_they_are_those_of_the_jets(leg: int) -> None:
    """By the product rule, and by the closed formulas that follow from it."""
    bits = 256
    slice_map = eliminant_of(EXAMPLES["fourteen-cusps"], leg).slice_map
    poses, omega = CouplePoses(slice_map, Fraction(700), bits), omega_ball(slice_map.radicand, bits)
    with ctx.workprec(bits):
        u, t = arb("0.37"), HalfTangent(arb("-1.3"), arb(1))
        local = poses.local_map(u, t, 3)
        j = local.singularity()
        e = local.along(local.f, j)
        f, g = (LegPoints.of(leg, lambda a, b: omega * b + a) for leg in (slice_map.f, slice_map.g))
        found = PoseDerivatives.at(f, g, (poses.length, *t.cos_sin(), *HalfTangent(u, arb(1)).cos_sin()))
        expected = [(x.value, x.alpha.value, x.theta.value) for x in (j, e)]
        for value, own in zip((x for row in expected for x in row), found, strict=True):
            assert value.overlaps(own)
            assert own.rel_accuracy_bits() > 200
