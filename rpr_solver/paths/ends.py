"""The poses at the ends of a path, by their numbers in the table of all poses of the joint vector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.kinematics.pose_table import PlatformPose, PoseTable
from rpr_solver.notebook import shortened
from rpr_solver.paths.isolated import Angles, IsolatedPose

_MATCH_BITS = 96


@dataclass(frozen=True)
class PathPose:
    """A pose at an end of a path.

    Attributes:
        number: of the pose, from 1, in the table of all poses of the joint vector (:func:`poses`).
        alpha_deg: the orientation of the platform, in degrees in (−180, 180].
        theta_deg: the angle of the fixed leg, likewise.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).start.to_json(1)
    {'pose': 1, 'alpha_deg': '-19.0937319036636', 'theta1_deg': '145.442869910252'}
    """

    number: int
    alpha_deg: str
    theta_deg: str

    def __repr__(self) -> str:
        angles = f"alpha_deg={shortened(self.alpha_deg)} theta_deg={shortened(self.theta_deg)}"
        return f"<PathPose {self.number}: {angles}>"

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        return {"pose": self.number, "alpha_deg": self.alpha_deg, f"theta{fixed_leg}_deg": self.theta_deg}


def numbered(pose: IsolatedPose, table: PoseTable, fixed_leg: int) -> PathPose:
    """A pose with its number in the table of all poses of its joint vector.

    Raises:
        Unproved: it cannot be told from another pose of the table.
    """
    angles = pose.refined(_MATCH_BITS)
    with ctx.workprec(_MATCH_BITS):
        digits, candidates = table.digits, enumerate(table.poses, 1)
        numbers = [k for k, other in candidates if _may_be(angles, other, fixed_leg, digits)]
    if len(numbers) != 1:
        raise Unproved("a pose could not be told from the others of its joint vector; ask for more digits")
    return of_table(table, numbers[0], fixed_leg)


def of_table(table: PoseTable, number: int, fixed_leg: int) -> PathPose:
    """The pose with this number in the table."""
    pose = table.poses[number - 1]
    return PathPose(number, pose.alpha_deg, _theta(pose, fixed_leg))


def _theta(pose: PlatformPose, fixed_leg: int) -> str:
    return str(pose.to_json()[f"theta{fixed_leg}_deg"])


def _may_be(angles: Angles, other: PlatformPose, fixed_leg: int, digits: int) -> bool:
    """Whether a pose may be one of the table, within the accuracy of the table's decimals."""
    doubt = arb(10) ** (4 - digits)
    for angle, text in zip(angles, (other.alpha_deg, _theta(other, fixed_leg)), strict=True):
        turns = (angle / arb.pi() * 180 - arb(text, doubt)) / 360
        if not turns.contains_integer():
            return False
    return True
