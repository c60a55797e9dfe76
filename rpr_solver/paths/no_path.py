"""Why two poses of one joint vector are not joined by a path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from rpr_solver.contract import document_head
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.model.classify import Kind
from rpr_solver.model.lengths import Bounds, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.paths.ends import PathPose
from rpr_solver.paths.path import document_lengths, span_json


@dataclass(frozen=True)
class Resolution:
    """The size of a box of poses.

    Attributes:
        angle_deg: its width in α and in the fixed leg's angle.
        length: its width in the length of the fixed leg; None if that is held.

    >>> Resolution(Fraction(45, 64)).to_json()
    {'angle_deg': '0.703125', 'length': None}
    """

    angle_deg: Fraction
    length: Fraction | None = None

    def to_json(self) -> dict[str, str | None]:
        """The document's object."""
        return {"angle_deg": exact_str(self.angle_deg), "length": exact_or_none(self.length)}


class Obstacle(Kind):
    """Why there is no path between two poses.

    >>> Obstacle.OPPOSITE_SIGNS == "opposite-signs"
    True
    """

    OPPOSITE_SIGNS = "opposite-signs"
    """J has different signs at both poses: every path between them meets a singularity, in any slices."""
    OTHER_ASPECT = "other-aspect"
    """The poses lie in different aspects of the slice, or of the range in which the fixed leg may move:
    every path in it meets a singularity."""
    OUTSIDE_LIMITS = "outside-limits"
    """The joint vector of both poses does not keep the joint limits."""
    SEPARATED_BY_LIMITS = "separated-by-limits"
    """Every path between the poses meets a singularity or exceeds a joint limit."""
    UNDECIDED = "undecided"
    """No path was found, and none is excluded: the singular curves at the ends of the range are not
    supported, or joint limits leave only ways that are too narrow for the resolution."""


@dataclass(frozen=True)
class NoPath:
    """The reason why two poses are not joined by a path; false, as ``if path := joint_path(…)`` wants it.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held in the slice.
        digits: significant digits of the angles.
        lengths: L1, L2 and L3, exact, in the user's unit.
        start: the first pose.
        stop: the second pose.
        obstacle: the reason; all but ``UNDECIDED`` are proved.
        between: the lengths between which the fixed leg was free; None if it was held.
        limits: the joint limits, by legs.
        connecting: for another aspect, the ends of a range of the fixed leg within which a path exists, one
            of them being the length of the slice; None if none was found, or with joint limits.
        resolution: where joint limits separate the poses, or leave it undecided: the size of the smallest
            boxes of poses that were examined. None otherwise.

    >>> from rpr_solver import EXAMPLES, joint_path
    >>> joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    <NoPath from pose 1 to pose 3: opposite-signs>
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    lengths: tuple[Fraction, Fraction, Fraction]
    start: PathPose
    stop: PathPose
    obstacle: Obstacle
    between: tuple[Fraction, Fraction] | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)
    connecting: tuple[Fraction, Fraction] | None = None
    resolution: Resolution | None = None

    def __bool__(self) -> bool:
        return False

    def __repr__(self) -> str:
        return f"<NoPath from pose {self.start.number} to pose {self.stop.number}: {self.obstacle}>"

    def to_json(self) -> dict[str, Any]:
        """The document: that of a :class:`Path` without a path, and with its ``obstacle``."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            **document_lengths(self.lengths),
            "connected": None if self.obstacle is Obstacle.UNDECIDED else False,
            "obstacle": self.obstacle.value,
            "between": span_json(self.between),
            "limits": limits_json(self.limits) or None,
            "connecting_range": span_json(self.connecting),
            "resolution": self.resolution and self.resolution.to_json(),
            "from": self.start.to_json(leg),
            "to": self.stop.to_json(leg),
            "samples": [],
        }
