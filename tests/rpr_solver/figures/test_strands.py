"""The slice in floats agrees with exact poses and exact cusps.

Strands are drawn smoothly at every magnification.
"""

from __future__ import annotations

import pytest

from rpr_solver import EXAMPLES, cusp_table, poses, singular_curves
from rpr_solver.figures.strands import SliceFloats, cusps_of, drawn, strands_of
from rpr_solver.notebook.scene import Box, Point, distance

INNOCENTI = EXAMPLES["innocenti"]


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_poses_have_their_legs(leg: int) -> None:
    table = poses(INNOCENTI, "14.98", 16, 20, digits=15)
    free = [float(length) for name, length in table.lengths.items() if name != f"l{leg}"]
    floats = SliceFloats.of(INNOCENTI.to_json(), leg, table.lengths[f"l{leg}"])
    for pose in (pose.to_json() for pose in table.poses):
        angles = float(pose["alpha_deg"]), float(pose[f"theta{leg}_deg"])
        assert floats.lengths(angles) == pytest.approx(free)


def test_j_is_zero_at_cusps_and_its_slopes_are_right() -> None:
    [table] = cusp_table(INNOCENTI, 27, digits=15)
    floats = SliceFloats.of(INNOCENTI.to_json(), 1, "27")
    radians = 0.017453292519943295
    for cusp in table.cusps:
        alpha, theta = float(cusp.alpha_deg), float(cusp.theta1_deg)
        value, a, t = floats.singular((alpha, theta))
        assert abs(value) < 1e-10
        step = 1e-4
        assert floats.singular((alpha + step, theta))[0] / (step * radians) == pytest.approx(a, abs=1e-4)
        assert floats.singular((alpha, theta + step))[0] / (step * radians) == pytest.approx(t, abs=1e-4)
        assert abs(floats.singular(floats.onto_curve((alpha + 0.3, theta - 0.2)))[0]) < 1e-6


CURVES = singular_curves(EXAMPLES["zein-flat"], 3).to_json()
FLOATS = SliceFloats.of(CURVES["geometry"], 1, "3")
STRANDS = strands_of(CURVES)


def test_every_cusp_is_a_vertex_where_the_document_says() -> None:
    cusps = cusps_of(STRANDS)
    assert [cusp["cusp"] for cusp in cusps] == [1, 2, 3, 4]
    for strand in STRANDS:
        for vertex in strand.vertices:
            point = strand.points[vertex["index"]]
            assert distance(point, (float(vertex["l2"]), float(vertex["l3"]))) < 1e-8  # of ten digits


def test_samples_are_on_the_curve_and_more_are_found_between() -> None:
    for strand in STRANDS:
        [line] = drawn(strand, FLOATS, lambda pose: (100 * FLOATS.lengths(pose)[0], FLOATS.lengths(pose)[1]))
        assert len(line) > 1.5 * len(strand.points)


def test_only_what_is_near_a_window_is_drawn() -> None:
    cusp = cusps_of(STRANDS)[0]
    centre = float(cusp["l2"]), float(cusp["l3"])
    box = Box.around([centre]).grown(0.01)

    def place(pose: Point) -> Point:
        return FLOATS.lengths(pose)

    lines = [line for strand in STRANDS for line in drawn(strand, FLOATS, place, box)]
    assert any(distance(point, centre) < 1e-9 for line in lines for point in line)
    assert sum(map(len, lines)) < sum(len(strand.points) for strand in STRANDS) / 2
