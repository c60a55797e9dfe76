"""Paths of manipulators with roots: loops round all cusps, and poses in the frame of points."""

import json
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

import pytest

from rpr_solver import (
    Change,
    Manipulator,
    assembly_modes,
    cusp_loop,
    cusp_table,
    pose_path,
    poses,
)
from tests.support.motions import Mover, angles_of, arrives, legs_of, turns
from tests.support.sampling import long

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
A, B = ((1.0, 2.0), (11.0, 3.0), (4.0, 9.0)), ((3.0, 1.0), (3.0, 8.0), (-2.0, 4.0))
BY_POINTS = Manipulator(
    base={"points": [[1, 2], [11, 3], [4, 9]]}, platform={"points": [[3, 1], [3, 8], [-2, 4]]}
)


@pytest.mark.parametrize("row", [ROWS[0], ROWS[12], *map(long, ROWS[3:12:3]), *map(long, ROWS[15::3])])
def test_loops_go_round_their_cusps(row: dict[str, Any]) -> None:
    m = Manipulator.from_json(row["geometry"])
    [table] = cusp_table(m, row["l1"], digits=20)
    for number, cusp in list(enumerate(table.cusps, 1))[:2]:
        path = cusp_loop(m, row["l1"], number)
        first, second = map(float, cusp.coordinates[2:])
        assert turns(path, (first, second)) == pytest.approx(path.winding)
        assert arrives(path, 301) < 1e-6


@pytest.mark.parametrize("leg", [1, long(2), 3])
def test_samples_are_told_in_the_frame_of_the_points(leg: int) -> None:
    """The corners of the platform, placed by x, y and φ, are as far from those of the base as the legs are
    long."""
    path = cusp_loop(BY_POINTS, 8, 1, fixed_leg=leg, samples=7, digits=20)
    last = None
    for sample in path.samples:
        row = sample.to_json(leg)
        x, y, phi = float(row["x"]), float(row["y"]), radians(float(row["phi_deg"]))
        for k, ((u, v), (p, q)) in enumerate(zip(A, B, strict=True)):
            corner = x + p * cos(phi) - q * sin(phi), y + p * sin(phi) + q * cos(phi)
            length = ((corner[0] - u) ** 2 + (corner[1] - v) ** 2) ** 0.5
            assert length == pytest.approx(float(sample.lengths[k]), rel=1e-12)
        turned = phi - radians(float(sample.alpha_deg))
        assert last is None or turned == pytest.approx(last, abs=1e-12)
        last = turned
    assert path.lengths is not None
    table = poses(BY_POINTS, *path.lengths, digits=20)
    for sample, end in ((path.samples[0], path.start), (path.samples[-1], path.stop)):
        assert end.number is not None
        pose = table.poses[end.number - 1]
        assert sample.given is not None
        assert sample.given[:2] == (pose.x, pose.y)
        assert pose.phi_deg is not None
        assert (float(sample.given[2]) - float(pose.phi_deg)) % 360 == pytest.approx(0, abs=1e-9)


def test_a_path_within_limits() -> None:
    start, stop = ({"alpha_deg": a, "theta1_deg": t, "l1": 8} for a, t in ((20, 40), (25, 60)))
    mover = Mover.of(BY_POINTS)
    ends = [mover.legs(a * pi / 180, t * pi / 180, 8.0) for a, t in ((20, 40), (25, 60))]
    limits = {
        f"l{k + 1}": (f"{min(x[k] for x in ends) - 1:.2f}", f"{max(x[k] for x in ends) + 1:.2f}")
        for k in (1, 2)
    }
    path = pose_path(BY_POINTS, start, stop, limits=limits)
    for sample in path.samples:
        assert mover.legs(*angles_of(sample), 8.0) == pytest.approx(legs_of(sample))
        assert all(
            float(limits[f"l{k}"][0]) < legs_of(sample)[k - 1] < float(limits[f"l{k}"][1]) for k in (2, 3)
        )


@pytest.mark.parametrize("side", ["4", long("5*sqrt(3)"), "sqrt(2)"])
def test_the_mode_of_similar_triangles_cannot_change(side: str) -> None:
    m = Manipulator(base={"equilateral": "sqrt(300)"}, platform={"equilateral": side})
    for span in ((1, 20), (1, None)):
        answer = assembly_modes(m, between=span)
        assert (answer.change, answer.pairs) == (Change.IMPOSSIBLE, None)
