"""Isolated poses against the exact table of all poses.

Routes backwards and in documents.

Expansions along arcs against the manipulator's own legs, in floats.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.routes import Arc, IsolatedPose, Point, bounded, expanded
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


Three = tuple[float, float, float]
CURVED: list[Three] = [(0.2, -1.1, 14.0), (1.5, 0.3, 15.0), (0.7, 2.0, 17.5)]


def arc_of(slice_map: SliceMap, points: list[Three]) -> Arc:
    scale = float(slice_map.scale)
    scaled: list[Point] = [(arb(a), arb(t), arb(x * scale)) for a, t, x in points]
    return Arc.over(scaled)


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
