"""The numbers of poses in the table of their joint vector."""

import pytest

from rpr_solver import EXAMPLES, Unproved, cusp_loop, poses
from rpr_solver.paths.ends import numbered, of_table

LOOP = cusp_loop(EXAMPLES["innocenti"], 27, 4, samples=2)
TABLE = poses(EXAMPLES["innocenti"], *LOOP.lengths, digits=15)


def test_a_pose_has_the_number_of_its_line() -> None:
    for isolated, end in ((LOOP.route.start, LOOP.start), (LOOP.route.stop, LOOP.stop)):
        assert numbered(isolated, TABLE, 1) == of_table(TABLE, end.number, 1) == end
        assert TABLE.poses[end.number - 1].theta1_deg == end.theta_deg


def test_a_pose_of_other_legs_has_none() -> None:
    other = poses(EXAMPLES["innocenti"], 27, 30, 20, digits=15)
    with pytest.raises(Unproved):
        numbered(LOOP.route.start, other, 1)
