"""Short smooth routes from polylines."""

from fractions import Fraction
from math import radians

from rpr_solver import EXAMPLES, cusp_loop
from rpr_solver.paths.path_limits import PathLimits
from rpr_solver.paths.straightened import Corner, Straightener

LOOP = cusp_loop(EXAMPLES["innocenti"], 27, "C", samples=2)
START, STOP = LOOP.route.start, LOOP.route.stop


def corners() -> list[Corner]:
    """From the start over places beside the middle to the stop."""
    [(_, middle, _)] = LOOP.route.arcs
    assert middle is not None
    inner = radians(middle.alpha_deg), radians(middle.theta_deg)
    ends = [(float(pose.angles[0]), float(pose.angles[1])) for pose in (START, STOP)]
    beside = [((x + inner[0]) / 2, (y + inner[1]) / 2) for x, y in ends]
    return [(x, y, Fraction(27)) for x, y in (ends[0], *beside, ends[1])]


def test_a_route_is_proved_along_a_polyline() -> None:
    found = Straightener(LOOP.route.slice_map, LOOP.sign).route(START, STOP, corners())
    assert found is not None
    route, proof = found
    assert proof.sign == LOOP.sign
    assert len(route.arcs) <= 3
    assert (route.start, route.stop) == (START, STOP)


def test_no_route_has_the_other_sign() -> None:
    assert Straightener(LOOP.route.slice_map, -LOOP.sign).route(START, STOP, corners()) is None


def test_a_route_beyond_a_limit_is_refused() -> None:
    legs = START.legs
    for bounds, is_free in (({2: (None, Fraction(1))}, False), ({2: (Fraction(1), None)}, True)):
        limits = PathLimits.of(LOOP.route.slice_map, bounds, legs)
        found = Straightener(LOOP.route.slice_map, LOOP.sign, limits).route(START, STOP, corners())
        assert (found is not None) is is_free
