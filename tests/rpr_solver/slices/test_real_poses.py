"""Poses above real roots, from places to look."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from flint import ctx

from rpr_solver import EXAMPLES, solve_slice
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.slices.real_poses import PoseFinder
from tests.support.shared import eliminant_of

BITS = 400
LENGTH = Fraction(27)


def test_the_poses_are_those_of_the_table() -> None:
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    scaled = LENGTH * eliminant.slice_map.scale
    finder = PoseFinder(eliminant, BITS).at(scaled)
    roots = [float(x.refined(60)) for x in real_roots(eliminant.at(scaled))]
    poses = finder.poses([(u, 1.0) for u in roots])
    assert poses is not None
    with ctx.workprec(BITS):
        angles = sorted(tuple(float(x.degrees()) for x in pose)[::-1] for pose in poses)
        assert all(x.numerator.rel_accuracy_bits() > 250 for _, x in poses)
    cusps = solve_slice(eliminant, LENGTH, 15).cusps
    expected = [(float(c.theta1_deg), float(c.alpha_deg)) for c in cusps]
    assert [x for pair in angles for x in pair] == pytest.approx([x for pair in expected for x in pair])
    for wrong in (roots[:1] * 2, [roots[0] + 1e-6], [math.nan], [math.inf], [0.123]):
        assert finder.poses([(u, 1.0) for u in wrong]) is None
