"""Laws of time, and the points of a path that they choose."""

from __future__ import annotations

from itertools import pairwise
from math import cos, dist, pi, sin

import pytest

from rpr_solver.paths.timing import TIMINGS, places

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("name", TIMINGS)
def test_a_law_covers_the_way_once_and_in_order(name: str) -> None:
    law = TIMINGS[name]
    covered = [law(k / 100) for k in range(101)]
    assert (covered[0], covered[50], covered[100]) == pytest.approx((0, 0.5, 1))
    assert covered == sorted(covered)
    assert law(0.3) + law(0.7) == pytest.approx(1)


@pytest.mark.parametrize("name", ["cosine", "trapezoid"])
def test_a_law_starts_from_rest(name: str) -> None:
    law = TIMINGS[name]
    assert law(1e-4) / 1e-4 < 1e-2


def test_places_are_spread_by_arc_length() -> None:
    def joint(arc: int, tau: float) -> tuple[float, float, float]:
        # a quarter of a circle of radius 2 at an uneven speed, then a straight line of length 1
        angle = tau**2 * pi / 2
        return (2 * cos(angle), 2 * sin(angle), 0.0) if arc == 0 else (-tau, 2.0, 0.0)

    points = [joint(*place) for place in map(places(joint, 2), [k / 50 for k in range(51)])]
    steps = [dist(p, q) for p, q in pairwise(points)]
    assert steps == pytest.approx([(pi + 1) / 50] * 50, rel=0.02)
