"""Vertices satisfy their defining conditions, and stand at the right place of the curve.

Poses with a free leg of length 0: those of the triangle that is left, by exact arithmetic and by balls.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import acos, atan2, cos, degrees, hypot, radians, sin
from random import Random

import pytest
from flint import arb

from rpr_solver import EXAMPLES, Manipulator, PoseKind, VertexKind, singular_curves
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.sweep import sweep
from rpr_solver.singular.vertices import closed_legs
from tests.support.sampling import sample
from tests.support.singular import SLICES, manipulator, traced

EACH = pytest.mark.parametrize(("name", "leg", "length"), SLICES)


@EACH
def test_vertices_satisfy_their_conditions(name: str, leg: int, length: str) -> None:
    curves = traced(name, leg, length)
    slice_map = SliceMap.of(manipulator(name), leg)
    scaled = ball_of(Fraction(length) * slice_map.scale)
    size = float(slice_map.scale) ** 4 * float(length) * 1e5
    for vertex in curves.vertices:
        alpha, theta, *lengths = map(float, vertex.point.coordinates)
        angles = (f(radians(x)) for x in (alpha, theta) for f in (cos, sin))
        pose = Pose(*map(arb, angles), scaled, omega_ball(slice_map.radicand, 53))
        j = LocalMap.at(slice_map, pose, 3).singularity()
        value, across, along = (abs(float(x.mid())) / size for x in (j.value, j.alpha.value, j.theta.value))
        assert value < 1e-11
        if vertex.kind is VertexKind.TURNING:
            assert across < 1e-11 < along
        elif vertex.kind is VertexKind.CLOSED_LEG:
            assert min(lengths) == 0
        elif vertex.kind is not PoseKind.CUSP:
            assert max(across, along) < 1e-11


@EACH
def test_vertices_stand_at_their_samples(name: str, leg: int, length: str) -> None:
    curves = traced(name, leg, length)
    for strand in curves.strands:
        for index, vertex in strand.vertices:
            alpha, theta, first, second = map(float, vertex.point.coordinates)
            assert (strand.alpha_deg[index] - alpha + 180) % 360 == pytest.approx(180, abs=1e-5)
            assert (strand.theta_deg[index] - theta + 180) % 360 == pytest.approx(180, abs=1e-5)
            assert (strand.first[index], strand.second[index]) == pytest.approx((first, second), abs=1e-4)


def test_a_cusp_at_angles_of_exactly_0_has_its_place() -> None:
    curves = singular_curves(Manipulator(1, 3, 0, 1, 1, 1), 5)
    assert curves.table.cusps[0].coordinates[:2] == ("0", "0")
    assert {vertex.cusp for vertex in curves.vertices if vertex.cusp} == {1, 2, 3, 4}


@EACH
def test_every_cusp_and_degenerate_point_of_the_table_is_a_vertex(name: str, leg: int, length: str) -> None:
    curves = traced(name, leg, length)
    cusps = {vertex.cusp: vertex.point for vertex in curves.vertices if vertex.kind is PoseKind.CUSP}
    assert cusps == dict(enumerate(curves.table.cusps, 1))
    points = {(vertex.kind.value, vertex.point.coordinates) for vertex in curves.vertices}
    for point in curves.table.degenerate_points:
        if point["kind"] != "curve":
            coordinates = tuple(text for key, text in point.items() if key != "kind")
            assert (point["kind"], coordinates) in points


INNOCENTI = EXAMPLES["innocenti"]


def poses_of(manipulator: Manipulator, length: str) -> list[tuple[float, ...]]:
    slice_map = SliceMap.of(manipulator, 1)
    swept = sweep(slice_map, Fraction(length) * slice_map.scale)
    return [tuple(map(float, vertex.point.coordinates)) for vertex, _ in closed_legs(swept, 15)]


@pytest.mark.parametrize("length", ["14.98", "27"])
def test_they_are_the_corners_of_triangles(length: str) -> None:
    """With B2 on A2 the triangle A1 A2 B1 has the sides a2x, d1 and L1; with B3 on A3 likewise."""
    poses, l1 = poses_of(INNOCENTI, length), float(length)
    expected = []
    for x, y, side in ((15.91, 0.0, 17.04), (0.0, 10.0, 20.84)):
        base = hypot(x, y)
        cosine = (base**2 + l1**2 - side**2) / (2 * base * l1)
        for sign in (1, -1) if abs(cosine) < 1 else ():
            expected.append(degrees(atan2(y, x) + sign * acos(cosine)))
    found = sorted(theta % 360 for _, theta, *_ in poses)
    assert found == pytest.approx(sorted(theta % 360 for theta in expected))
    assert [min(legs) for _, _, *legs in poses] == [0.0] * len(poses)


def test_an_angle_of_exactly_0_is_decided_exactly() -> None:
    """B3 = (5, 12) on the platform closes on A3 = (8, 16) with B1 = (3, 4); balls round 0 have no digits."""
    poses = poses_of(Manipulator(10, 8, 16, 14, 15, 13), "5")
    [pose] = [pose for pose in poses if pose[0] == 0]
    assert pose[1:] == (pytest.approx(degrees(atan2(4, 3))), pytest.approx(hypot(7, 4)), 0.0)


def test_a_leg_that_closes_in_the_direction_of_a_node_is_listed() -> None:
    """Congruent triangles have nodes at 180 degrees; leg 2 closes in the same two directions of leg 3."""
    curves = singular_curves(Manipulator(30, 0, 40, 30, 50, 40), "13.9", fixed_leg=3)
    nodes = {v.point.coordinates[1] for v in curves.vertices if v.kind is PoseKind.NODE}
    closed = [v.point.coordinates for v in curves.vertices if v.kind is VertexKind.CLOSED_LEG]
    assert {theta for _, theta, _, second in closed if second == "0"} == nodes
    assert len(closed) == 4


SMALL = [
    # In the direction of a turning point, on another arc; and where tan(theta/2) is -2.
    (Manipulator(5, 0, 12, 4, 13, 15, orientation="cw"), 2, 10),
    (Manipulator(9, 3, 7, 17, 10, 12), 1, 10),
    *(
        (m, leg, 5)
        for m, leg in product((Manipulator(16, 0, 12, 15, 14, 13), EXAMPLES["zein-flat"]), (1, 2, 3))
    ),
]
_PYTHAGOREAN = [(3, 4), (5, 12), (8, 6), (8, 15), (16, 12), (-5, 12), (-9, 12), (0, 12)]


def pythagorean_slices(count: int) -> list[tuple[Manipulator, int, int]]:
    """Slices of manipulators of small integers, whose special poses often have rational directions."""
    draw, found = Random("closed legs"), []
    while len(found) < count:
        x, y = draw.choice(_PYTHAGOREAN)
        d1, d2, d3 = (draw.randint(4, 20) for _ in range(3))
        if abs(d1 - d2) < d3 < d1 + d2:
            m = Manipulator(draw.randint(3, 20), x, y, d1, d2, d3)
            found.append((m, draw.choice((1, 2, 3)), draw.randint(3, 20)))
    return found


def is_triangle(first: Fraction, second: Fraction, third: Fraction) -> bool:
    """Whether a triangle that is not flat has sides with these squares."""
    return (first - second - third) ** 2 < 4 * second * third


@pytest.mark.parametrize(("m", "leg", "length"), sample([*SMALL, *pythagorean_slices(24)], *range(12)))
def test_every_pose_with_a_closed_leg_is_listed(m: Manipulator, leg: int, length: int) -> None:
    """With Bk on Ak, the fixed leg and its sides to Ak and to Bk are a triangle, either way up.

    Where that is flat, the leg closes while it is stretched along its base line: no special point.
    """
    base = {(1, 2): m.a2x**2, (1, 3): m.a3x**2 + m.a3y**2, (2, 3): (m.a3x - m.a2x) ** 2 + m.a3y**2}
    platform = {(1, 2): m.d1**2, (2, 3): m.d2**2, (1, 3): m.d3**2}
    triangles = [
        is_triangle(Fraction(length) ** 2, base[pair], platform[pair]) for pair in base if leg in pair
    ]
    curves = singular_curves(m, length, fixed_leg=leg)
    assert len([v for v in curves.vertices if v.kind is VertexKind.CLOSED_LEG]) == 2 * sum(triangles)
