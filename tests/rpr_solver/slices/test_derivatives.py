"""Closed formulas of derivatives, in floats against differences of the functions; by jets in test_grid.py."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, isclose, sin

import pytest

from rpr_solver.slices.grid import LegPoints, PoseDerivatives, singularity_and_coalescence

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
