"""Boxes proved by floats, against balls: what they hold, and what is not proved."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.jets import HalfTangent
from rpr_solver.slices.eliminant import Eliminant
from rpr_solver.slices.fast.proofs import NearPose, guesses, proved_boxes
from rpr_solver.slices.reference import SlicePoses
from tests.support.shared import eliminant_of

BITS = 320
LENGTHS = [Fraction(k, 3) for k in range(20, 100, 4)]


def boxes_of(eliminant: Eliminant) -> tuple[list[Fraction], list[list[NearPose] | None]]:
    scaled = [x * eliminant.slice_map.scale for x in LENGTHS]
    thetas = [guess.real for guess in guesses(eliminant, scaled)]
    return scaled, proved_boxes(eliminant, scaled, thetas)


def poses_of(eliminant: Eliminant, length: Fraction) -> list[tuple[HalfTangent, HalfTangent]]:
    """The poses (α, θ) above the real roots of a slice, by the way of the reference."""
    slice_poses = SlicePoses(eliminant.slice_map, length, BITS)
    poses = []
    for root in real_roots(eliminant.at(length)):
        u = root.refined(BITS - 64)
        with ctx.workprec(BITS):
            alpha = slice_poses.alpha(u)
        assert alpha is not None
        poses.append((alpha, HalfTangent(u, arb(1))))
    return poses


@pytest.mark.parametrize("name", ["zein-flat", "fourteen-cusps"])
def test_each_box_holds_one_pose(name: str) -> None:
    eliminant = eliminant_of(EXAMPLES[name])
    scaled, slices = boxes_of(eliminant)
    assert sum(x is None for x in slices) <= 6, "most is proved"
    for length, boxes in zip(scaled, slices, strict=True):
        poses = poses_of(eliminant, length)
        for box in boxes or ():
            with ctx.workprec(BITS):
                angles = [
                    (arb(box.t, box.t_reach), box.t_inverse),
                    (arb(box.u, box.u_reach), box.u_inverse),
                ]
                inside = [
                    pose
                    for pose in poses
                    if all(
                        x.contains(y.denominator / y.numerator if inverse else y.numerator / y.denominator)
                        for (x, inverse), y in zip(angles, pose, strict=True)
                    )
                ]
                assert len(inside) == 1
