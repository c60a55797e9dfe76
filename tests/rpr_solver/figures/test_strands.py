"""The slice in floats agrees with exact poses and exact cusps.

Strands are drawn smoothly at every magnification.
"""

from __future__ import annotations

from functools import cache

import pytest

from rpr_solver import EXAMPLES, poses, singular_curves
from rpr_solver.figures.strands import SliceCurves
from rpr_solver.notebook.scene import Box, distance

INNOCENTI = EXAMPLES["innocenti"]


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_poses_have_their_legs(leg: int) -> None:
    table = poses(INNOCENTI, "14.98", 16, 20, digits=15)
    free = [float(length) for name, length in table.lengths.items() if name != f"l{leg}"]
    lengths = {"geometry": INNOCENTI.to_json(), "fixed_leg": leg, f"l{leg}": table.lengths[f"l{leg}"]}
    curves = SliceCurves.of({**lengths, "components": []})
    for pose in (pose.to_json() for pose in table.poses):
        angles = float(pose["alpha_deg"]), float(pose[f"theta{leg}_deg"])
        assert curves.floats.lengths(angles) == pytest.approx(free)


def test_j_is_zero_at_cusps_and_its_slopes_are_right() -> None:
    curves = SliceCurves.of(singular_curves(INNOCENTI, 27).to_json())
    singular, step, radians = curves.floats.singular, 1e-4, 0.017453292519943295
    for alpha, theta in curves.poses:
        value, a, t = singular((alpha, theta))
        assert abs(value) < 1e-10
        assert singular((alpha + step, theta))[0] / (step * radians) == pytest.approx(a, abs=1e-4)
        assert singular((alpha, theta + step))[0] / (step * radians) == pytest.approx(t, abs=1e-4)
        assert abs(singular(curves.floats.onto_curve((alpha + 0.3, theta - 0.2)))[0]) < 1e-6


@cache
def the_curves() -> SliceCurves:
    return SliceCurves.of(singular_curves(EXAMPLES["zein-flat"], 3).to_json())


def test_every_cusp_is_a_vertex_where_the_document_says() -> None:
    assert [cusp["cusp"] for cusp in the_curves().cusps] == [1, 2, 3, 4]
    for strand in the_curves().strands:
        for vertex in strand.vertices:
            point = strand.points[vertex["index"]]
            assert distance(point, (float(vertex["l2"]), float(vertex["l3"]))) < 1e-8  # of ten digits


def test_samples_are_on_the_curve_and_more_are_found_between() -> None:
    lines = the_curves().lines(
        lambda pose: (100 * the_curves().floats.lengths(pose)[0], the_curves().floats.lengths(pose)[1])
    )
    for strand, line in zip(the_curves().strands, lines, strict=True):
        assert len(line) > 1.5 * len(strand.points)


def test_only_what_is_near_a_window_is_smooth() -> None:
    cusp = the_curves().cusps[0]
    centre = float(cusp["l2"]), float(cusp["l3"])
    box = Box.around([centre]).grown(0.01)

    lines = the_curves().lines(the_curves().floats.lengths, box)
    assert any(distance(point, centre) < 1e-9 for line in lines for point in line)
    samples = sum(len(strand.points) for strand in the_curves().strands)
    assert samples <= sum(map(len, lines)) < samples + 200
