"""The slice in floats agrees with exact poses and cusps; windings with proved numbers of poses.

Strands are drawn smoothly at every magnification.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure as Sheet

from rpr_solver import EXAMPLES, poses, singular_curves
from rpr_solver.figures.joint_plane import _JointPlane, _View
from rpr_solver.figures.strands import SliceCurves

INNOCENTI = EXAMPLES["innocenti"]


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_poses_have_their_legs(leg: int) -> None:
    table = poses(INNOCENTI, "14.98", 16, 20, digits=15)
    free = [float(length) for name, length in table.lengths.items() if name != f"l{leg}"]
    lengths = {"geometry": INNOCENTI.to_json(), "fixed_leg": leg, f"l{leg}": table.lengths[f"l{leg}"]}
    curves = SliceCurves.of({**lengths, "components": []})
    rows = [pose.to_json() for pose in table.poses]
    angles = np.array([[float(row["alpha_deg"]), float(row[f"theta{leg}_deg"])] for row in rows])
    assert curves.floats.lengths(angles) == pytest.approx(np.array([free] * len(rows)))


def test_j_is_zero_at_cusps_and_its_slopes_are_right() -> None:
    curves = SliceCurves.of(singular_curves(INNOCENTI, 27).to_json())
    singular, step = curves.floats.singular, 1e-4
    value, a, t = singular(curves.cusps)
    assert len(value) == 8
    assert np.abs(value).max() < 1e-10
    for slope, shift in ((a, (step, 0)), (t, (0, step))):
        moved, *_ = singular(curves.cusps + shift)
        assert moved / np.radians(step) == pytest.approx(slope, abs=1e-4)
    near = curves.floats.onto_curve(curves.cusps + np.array((0.3, -0.2)))
    assert np.abs(singular(near)[0]).max() < 1e-6


@pytest.fixture(scope="module")
def flat() -> Any:
    return singular_curves(EXAMPLES["zein-flat"], 3).to_json()


def test_chords_are_halved_where_the_curve_leaves_them(flat: Any) -> None:
    curves = SliceCurves.of(flat)
    fine = curves.lines(lambda pose: 100 * curves.floats.lengths(pose))
    window = (
        *curves.floats.lengths(curves.cusps[:1])[0] - 0.01,
        *curves.floats.lengths(curves.cusps[:1])[0] + 0.01,
    )
    coarse = curves.lines(curves.floats.lengths, window)
    for strand, some, all_ in zip(curves.strands, coarse, fine, strict=True):
        assert len(strand.poses) <= len(some) < len(strand.poses) + 200 < 1.4 * len(all_)
        value, a, t = curves.floats.singular(all_)
        assert (np.abs(value) < 1e-3 * np.hypot(a, t)).all()


@pytest.mark.parametrize(("name", "length"), [("innocenti", "27"), ("zein-flat", "3")])
def test_windings_are_the_numbers_that_the_document_proves(name: str, length: str) -> None:
    document = singular_curves(EXAMPLES[name], length).to_json()
    plane = _JointPlane(document, SliceCurves.of(document))
    for region in document["regions"]:
        x, y = (float(region["point"][member]) for member in ("l2", "l3"))
        ax = Sheet(dpi=72).add_subplot()
        ax.set(xlim=(x - 1e-6, x + 1e-6), ylim=(y - 1e-6, y + 1e-6))
        assert set(_View.of(ax, plane, 118.0).winding(20).ravel()) == {region["poses"]}


def test_areas_of_windings_are_those_of_regions(flat: Any) -> None:
    plane = _JointPlane(flat, SliceCurves.of(flat))
    ax = Sheet(dpi=72).add_subplot()
    x0, y0, x1, y1 = plane.limits
    ax.set(xlim=(x0, x1), ylim=(y0, y1))
    counts = _View.of(ax, plane, 118.0).winding(400)
    dot = (x1 - x0) * (y1 - y0) / counts.size
    for poses_ in (2, 4):
        known = sum(_size(region) for region in flat["regions"] if region["poses"] == poses_)
        assert dot * (counts == poses_).sum() == pytest.approx(known, rel=0.02)


def _size(region: Any) -> float:
    """The area of a region: that of its outline without those of its holes."""
    sizes = []
    for ring in region["rings"]:
        x, y = np.array(ring["l2"], dtype=float), np.array(ring["l3"], dtype=float)
        sizes.append(abs((np.roll(x, 1) * y - x * np.roll(y, 1)).sum()) / 2)
    return float(sizes[0] - sum(sizes[1:]))
