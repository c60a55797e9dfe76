"""Poses of a path's joint vector by their numbers in the table of all poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.model.pose_table import PlatformPose, PoseTable
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths.routes import Angles, IsolatedPose, Legs

_MATCH_BITS = 96


@dataclass(frozen=True)
class PathPose:
    """A pose at an end of a path.

    Attributes:
        number: of the pose, from 1, in the table of all poses of the joint vector (:func:`poses`); None if
            the pose was given by its angles.
        alpha_deg: the orientation of the platform, in degrees in (−180, 180].
        theta_deg: the angle of the fixed leg, likewise.
        lengths: L1, L2 and L3, if the other end of the path has other ones: exact, but correctly rounded for
            the free legs of a pose that was given by its angles. None if they are those of the path.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).start.to_json(1)
    {'pose': 1, 'alpha_deg': '-19.0937319036636', 'theta1_deg': '145.442869910252'}
    """

    number: int | None
    alpha_deg: str
    theta_deg: str
    lengths: tuple[str, str, str] | None = None

    def __repr__(self) -> str:
        angles = f"alpha_deg={shortened(self.alpha_deg)} theta_deg={shortened(self.theta_deg)}"
        return f"<PathPose{'' if self.number is None else f' {self.number}'}: {angles}>"

    @property
    def name(self) -> str:
        """The pose in sentences: its number, and its lengths if they are its own."""
        name = "a given pose" if self.number is None else f"pose {self.number}"
        return name if self.lengths is None else f"{name} of {legs_text(self.lengths)}"

    @property
    def angles(self) -> tuple[str, str]:
        """α and the angle of the fixed leg."""
        return self.alpha_deg, self.theta_deg

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        lengths = {f"l{leg}": text for leg, text in enumerate(self.lengths or (), 1)}
        angles = {"alpha_deg": self.alpha_deg, f"theta{fixed_leg}_deg": self.theta_deg}
        return {"pose": self.number, **lengths, **angles}


def legs_text(lengths: Sequence[str]) -> str:
    """Leg lengths in sentences.

    >>> legs_text(("27", "20", "20"))
    'L1=27 L2=20 L3=20'
    """
    return " ".join(f"L{leg}={shortened(text)}" for leg, text in enumerate(lengths, 1))


def numbered(pose: IsolatedPose, table: PoseTable, fixed_leg: int) -> PathPose:
    """A pose with its number in the table of all poses of its joint vector.

    Raises:
        Unproved: it cannot be distinguished from another pose of the table.
    """
    angles = pose.refined(_MATCH_BITS)
    with ctx.workprec(_MATCH_BITS):
        digits, candidates = table.digits, enumerate(table.poses, 1)
        numbers = [k for k, other in candidates if _may_be(angles, other, fixed_leg, digits)]
    if len(numbers) != 1:
        raise Unproved("a pose could not be told from the others of its joint vector; ask for more digits")
    return of_table(table, numbers[0], fixed_leg)


def isolated(slice_map: SliceMap, legs: Legs, table: PoseTable, number: int) -> IsolatedPose:
    """The pose with this number in the table of scaled leg lengths, isolated at the working precision.

    Raises:
        Unproved: it could not be isolated.
    """
    pose = of_table(table, number, slice_map.fixed_leg)
    alpha, theta = (arb(text) * arb.pi() / 180 for text in pose.angles)
    found = IsolatedPose.near(slice_map, legs, (alpha, theta))
    if found is None or numbered(found, table, slice_map.fixed_leg) != pose:
        raise Unproved("a pose is too near a singularity")
    return found


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
