"""Isolated poses against the exact table of all poses."""

from fractions import Fraction

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.isolated import IsolatedPose

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
