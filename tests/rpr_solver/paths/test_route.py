"""Isolated poses against the exact table of all poses.

Routes backwards and in documents.

Expansions along arcs against the manipulator's own legs, in floats.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Path, cusp_loop, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.routes import Arc, DecimalPose, IsolatedPose, Point, Route, bounded, expanded
from tests.support.motions import Mover

pytestmark = pytest.mark.quick

FIRST = EXAMPLES["innocenti"]
LEGS = tuple(Fraction(x) for x in (27, 30, 20))


def near(leg: int, shift: float) -> list[tuple[IsolatedPose | None, tuple[str, str]]]:
    slice_map = SliceMap.of(FIRST, leg)
    free = [LEGS[i - 1] for i in (1, 2, 3) if i != leg]
    scaled = [x * slice_map.scale for x in (LEGS[leg - 1], *free)]
    found = []
    with ctx.workprec(128):
        for pose in poses(FIRST, *LEGS, digits=40).poses:
            texts = pose.alpha_deg, pose.to_json()[f"theta{leg}_deg"]
            start = tuple(arb(text) * arb.pi() / 180 + arb(shift) for text in texts)
            joint = scaled[0], scaled[1], scaled[2]
            found.append((IsolatedPose.near(slice_map, joint, (start[0], start[1])), texts))
    assert found
    return found


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_newton_leads_to_the_pose_and_the_box_holds_it(leg: int) -> None:
    for pose, texts in near(leg, 1e-3):
        assert pose is not None
        for bits in (100, 400):
            with ctx.workprec(bits + 64):
                for angle, text in zip(pose.refined(bits), texts, strict=True):
                    assert angle.rad() < arb(2) ** -bits
                    expected = arb(text, arb(10) ** -37) * arb.pi() / 180
                    assert angle.overlaps(expected)


def test_without_a_pose_there_is_no_proof() -> None:
    slice_map = SliceMap.of(FIRST)
    too_long = tuple(Fraction(x) * slice_map.scale for x in (1, 1, 1000))
    with ctx.workprec(128):
        assert IsolatedPose.near(slice_map, (too_long[0], too_long[1], too_long[2]), (arb(1), arb(1))) is None


@cache
def the_loop() -> Path:
    return cusp_loop(EXAMPLES["innocenti"], 27, 3, samples=2)


def bent() -> Route:
    """A route of two arcs between the ends of a loop."""
    [(_, middle, _)] = the_loop().route.arcs
    assert middle is not None
    corner = DecimalPose(middle.alpha_deg + 1, middle.theta_deg, middle.length)
    return Route(the_loop().route.start, the_loop().route.stop, ((None, middle, corner), (corner, None)))


@pytest.mark.parametrize("route_of", [lambda: the_loop().route, bent], ids=["a loop", "bent"])
def test_backwards_is_the_same_way(route_of: Callable[[], Route]) -> None:
    route = route_of()
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


Three = tuple[float, float, float]
CURVED: list[Three] = [(0.2, -1.1, 14.0), (1.5, 0.3, 15.0), (0.7, 2.0, 17.5)]


def arc_of(slice_map: SliceMap, points: list[Three]) -> Arc:
    scale = float(slice_map.scale)
    scaled: list[Point] = [(arb(a), arb(t), arb(x * scale)) for a, t, x in points]
    return Arc.over(scaled)


@pytest.mark.parametrize("points", [CURVED, CURVED[:2]])
def test_an_arc_runs_from_its_first_to_its_last_control_point(
    points: list[Three],
) -> None:
    arc = arc_of(SliceMap.of(FIRST), points)
    scale = float(SliceMap.of(FIRST).scale)
    for tau, expected in ((0, points[0]), (1, points[-1])):
        alpha, theta, length = (float(x) for x in arc.at(arb(tau)))
        assert (alpha, theta, length / scale) == pytest.approx(expected)


@pytest.mark.parametrize("leg", [1, 2, 3])
@pytest.mark.parametrize("tau", [0.0, 0.3, 1.0])
def test_an_expansion_begins_with_the_legs_and_their_determinant(leg: int, tau: float) -> None:
    slice_map, mover = SliceMap.of(FIRST, leg), Mover.of(FIRST, leg)
    scale, arc = float(slice_map.scale), arc_of(slice_map, CURVED)
    alpha, theta, length = (float(x) for x in arc.at(arb(tau)))
    at = expanded(slice_map, arc, arb(tau), 0)
    legs = [(2 * float(x)) ** 0.5 / scale for x in (at.first[0], at.second[0])]
    assert legs == pytest.approx(mover.free(alpha, theta, length / scale))
    determinant = float(at.singularity[0]) / (legs[0] * legs[1] * scale**3)
    assert determinant == pytest.approx(mover.determinant(alpha, theta, length / scale), rel=1e-6)


def test_a_bound_holds_on_the_whole_piece() -> None:
    slice_map = SliceMap.of(FIRST)
    arc = arc_of(slice_map, CURVED)
    centre, radius = Fraction(3, 8), Fraction(1, 8)
    middle, r = arb(float(centre)), arb(float(radius))
    near, wide = expanded(slice_map, arc, middle, 1), expanded(slice_map, arc, arb(middle, r), 2)
    for k in range(-10, 11):
        at = expanded(slice_map, arc, middle + r * k / 10, 0)
        for name in ("first", "second", "singularity"):
            values = (getattr(form, name) for form in (near, wide))
            assert bounded(*values, r).contains(getattr(at, name)[0])
