"""Routes backwards and in documents."""

from fractions import Fraction

import pytest
from flint import arb

from rpr_solver import EXAMPLES, cusp_loop
from rpr_solver.paths.route import ControlPoint, Route

LOOP = cusp_loop(EXAMPLES["innocenti"], 27, 3, samples=2)


def bent() -> Route:
    """A route of two arcs between the ends of a loop."""
    [(_, middle, _)] = LOOP.route.arcs
    assert middle is not None
    corner = ControlPoint(middle.alpha_deg + 1, middle.theta_deg, middle.length)
    return Route(LOOP.route.start, LOOP.route.stop, ((None, middle, corner), (corner, None)))


@pytest.mark.parametrize("route", [LOOP.route, bent()])
def test_backwards_is_the_same_way(route: Route) -> None:
    back = route.reversed()
    assert back.reversed() == route
    for arc, other in zip(route.at(100), reversed(back.at(100)), strict=True):
        for tau in (arb(0), arb(0.25), arb(1)):
            assert all(x.overlaps(y) for x, y in zip(arc.at(tau), other.at(1 - tau), strict=True))


def test_arcs_follow_one_another() -> None:
    first, second = bent().at(100)
    assert all(x.overlaps(y) for x, y in zip(first.at(arb(1)), second.at(arb(0)), strict=True))


def test_the_document_names_the_ends_and_has_exact_points_between() -> None:
    first, second = bent().to_json()
    assert (first[0], second[-1]) == ("from", "to")
    assert first[-1] == second[0]
    assert isinstance(first[1], dict)
    assert Fraction(first[1]["l1"]) == 27
