"""Pose connections: the question which poses are joined, and the answer."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import PATH_DIGITS
from rpr_solver.model.lengths import Bounds, limits_json, read_limits
from service.schemas.answers import (
    JSON,
    JSON_FORM,
    PICTURE_FORM,
    SVG,
    ClosedRange,
    DocumentHead,
    Forms,
    optional,
)
from service.schemas.document import given
from service.schemas.ends import AskedJoints, Between
from service.schemas.lengths import LEGS, JointLimits, KeptLimits
from service.schemas.model import Model
from service.schemas.numbers import Digits, FixedLeg, Length, digits_field, fixed_leg_field
from service.schemas.path_answers import NearbyPose, PathResolution, PoseOnPath
from service.schemas.questions import Examples, Question
from worker.answers.connections import CONNECTIONS


class ConnectedPose(PoseOnPath):
    """A pose of one of the joint vectors; with its own lengths, if there are two."""

    sign: Literal[1, 0, -1] | None = Field(
        description="The sign of J; 0 for a singular pose, null for one too near a singularity."
    )


class UndecidedPair(Model):
    """Two poses for which it stays undecided, and where."""

    poses: list[int] = Field(description="Their places in `poses`, from 1.")
    near: NearbyPose


class PoseConnections(DocumentHead):
    """Which poses are joined by paths without a singularity."""

    l1: str | None = optional("Length of leg 1, exact; missing if there are two joint vectors.")
    l2: str | None = optional("Length of leg 2.")
    l3: str | None = optional("Length of leg 3.")
    between: ClosedRange | None = Field(
        description="The lengths between which the fixed leg was free; null if it was held."
    )
    limits: KeptLimits | None = Field(description="The joint limits that the paths keep; null if none.")
    poses: list[ConnectedPose] = Field(
        description="All poses of the joint vector in the order of /v1/poses, then those of `to`."
    )
    groups: list[list[int]] = Field(
        description="The places in `poses`, from 1, of poses that are joined with each other, proved. Poses "
        "of different groups are not joined, or it is undecided. Singular poses and those outside the limits "
        "are in none."
    )
    matrix: list[
        list[
            Literal[
                "joined",
                "singular-pose",
                "outside-limits",
                "opposite-signs",
                "other-aspect",
                "separated-by-limits",
                "undecided",
            ]
        ]
    ] = Field(
        description="For each pose a row, and in it for each pose whether a path joins the two, or why none "
        "does. The words are those of `obstacle` in /v1/paths; all but `undecided` are proved. "
        "`singular-pose`: one of both poses is singular."
    )
    resolution: PathResolution | None = Field(
        description="If joint limits separate poses, or leave them undecided: the size of the smallest boxes "
        "of poses that were examined."
    )
    undecided: list[UndecidedPair] | None = optional(
        "Pairs that joint limits leave undecided, with a pose near which they do; missing if there are none. "
        "Pairs that follow from others may be left out."
    )


class PoseConnectionsRequest(Question):
    """A manipulator, one joint vector or two, and what paths between their poses must keep."""

    expected = "send an object with geometry, l1, l2 and l3"
    kinds = (CONNECTIONS,)
    path = "/v1/pose-connections"
    name = "post_pose_connections"
    tag = ("pose connections", "Which poses are joined by paths without a singularity.")
    summary = "Which poses of a joint vector, or of two, are joined by paths without a singularity"
    description = """\
All pairs of poses at once: for each, whether a path without a singularity joins them, or the proved reason
why none does, as `/v1/paths` gives it for one pair. The fixed leg is held, or may vary within `between`; with
two joint vectors it may vary between its lengths at both. With `limits` the paths keep joint limits. `groups`
has the poses that are joined with each other. With `Accept: image/svg+xml` the matrix is drawn.

The response waits for a worker, which takes a fraction of a second without limits and some seconds with
limits in a range, up to 10 seconds unless `Prefer` says otherwise; after that it is 202 with a job.
"""
    answer = PoseConnections
    known = "The answer."
    forms: ClassVar[Forms] = {JSON: JSON_FORM, SVG: PICTURE_FORM}
    implied_wait = 10
    examples: ClassVar[Examples] = {
        "slice": (
            "The poses of one joint vector, with leg 1 held",
            {"l1": 27, "l2": "25.7", "l3": "9.2"},
        ),
        "two": (
            "The poses of two joint vectors",
            {"l1": 27, "l2": 20, "l3": 20, "to": {"l1": 30, "l2": 21, "l3": 19}},
        ),
        "limits": (
            "Within joint limits",
            {"l1": 27, "l2": 20, "l3": 20, "limits": {"l2": {"min": 5, "max": 21}}},
        ),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = Field(description="Length of leg 1; > 0.")
    l2: Length = Field(description="Length of leg 2; > 0.")
    l3: Length = Field(description="Length of leg 3; > 0.")
    to: AskedJoints = given("A second joint vector, whose poses are included.")
    between: Between = given(
        "Lengths between which the fixed leg may vary; without them it is held, or varies between its "
        "lengths at both joint vectors."
    )
    limits: JointLimits = given(
        "Joint limits that the paths keep, of any legs: `min` and `max`, either of which may be missing."
    )
    digits: Digits = digits_field(PATH_DIGITS)

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        self._bounds()
        return self

    def _bounds(self) -> dict[int, Bounds]:
        if self.limits is None:
            return {}
        return read_limits(self.limits.bounds(), "limits", held=self.fixed_leg)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        own: dict[str, Any] = {leg: exact_str(getattr(self, leg)) for leg in LEGS}
        if self.to is not None:
            own["to"] = self.to.lengths()
        if self.between is not None:
            own["between"] = {"from": exact_str(self.between.start), "to": exact_str(self.between.stop)}
        if bounds := self._bounds():
            own["limits"] = limits_json(bounds)
        return {
            "geometry": self.geometry.to_json(),
            "fixed_leg": self.fixed_leg,
            **own,
            "digits": self.digits,
        }
