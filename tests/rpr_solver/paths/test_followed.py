"""Poses carried along by a path, against Newton's method in floats and against each other.

The curve of a pose that is carried along: its slopes against differences, its points, its fold.
"""

from __future__ import annotations

from functools import cache

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Path, cusp_loop, poses
from rpr_solver.paths.other_poses import Followed, follow
from rpr_solver.paths.routes import IsolatedPose
from tests.support.motions import Mover, apart, legs_of

BITS = 160


@cache
def the_loop() -> Path:
    return cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=401)


def followed(path: Path, number: int) -> Followed:
    pose = poses(path.manipulator, *path.lengths, digits=40).poses[number - 1]
    with ctx.workprec(BITS):
        angles = [arb(text) * arb.pi() / 180 for text in (pose.alpha_deg, pose.theta1_deg)]
        isolated = IsolatedPose.near(path.route.slice_map, path.route.start.legs, (angles[0], angles[1]))
        assert isolated is not None
        return follow(path.route.slice_map, path.route.at(BITS), isolated.refined(BITS - 32))


def test_a_pose_that_lives_is_where_newton_leads_it() -> None:
    outcome = followed(the_loop(), 4)
    assert outcome.end is not None
    start = poses(the_loop().manipulator, *the_loop().lengths, digits=20).poses[3]
    pose = float(arb(start.alpha_deg) * arb.pi() / 180), float(arb(start.theta1_deg) * arb.pi() / 180)
    reached = Mover.of(the_loop().manipulator).followed(
        pose, [legs_of(sample) for sample in the_loop().samples]
    )
    assert apart((float(outcome.end[0]), float(outcome.end[1])), reached) < 1e-6


def test_a_pose_ends_on_a_fold() -> None:
    outcome = followed(the_loop(), 3)
    assert outcome.fold is not None
    arc, (alpha, theta, tau) = outcome.fold
    assert (arc, outcome.end) == (0, None)
    assert float(tau) == pytest.approx(0.0143589, abs=1e-6)
    length = 27.0
    assert abs(Mover.of(the_loop().manipulator).determinant(float(alpha), float(theta), length)) < 1e-5
