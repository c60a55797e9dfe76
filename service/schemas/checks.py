"""Checks of requirements: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from rpr_solver import CHECK_DIGITS, Requirement
from service.schemas.document import Document, unnamed
from service.schemas.joint_limits import JointLimits
from service.schemas.lengths import Range, range_field
from service.schemas.model import Model
from service.schemas.numbers import Count, Digits, FixedLeg, digits_field
from service.schemas.points import DEGENERATE, Cusp, Degeneracy, FixedLength, GeometryText, Interval
from service.schemas.questions import Examples, Question
from worker.answers.censuses import CHECK
from worker.answers.requests import Kind

# As a condition, since generators of clients drop the members beside an `anyOf`.
_A_BOUND: dict[str, Any] = {
    "if": {"properties": {"max_cusps": {"type": "null"}}},
    "then": {"required": ["min_cusps"], "properties": {"min_cusps": {"type": "integer"}}},
}


class RequirementDocument(Document):
    """Bounds on the number of cusps in every slice of a range; give max_cusps, min_cusps or both."""

    model_config = ConfigDict(title="Requirement", json_schema_extra=_A_BOUND)

    expected: ClassVar[str] = "give an object with range and max_cusps or min_cusps"

    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length varies over the range.")
    range: Range = range_field()
    max_cusps: Count = Field(
        default=None,
        description="Maximum number of cusps in any slice; 0 requires a range without cusps, which does not "
        "prove that the assembly mode cannot change.",
    )
    min_cusps: Count = Field(default=None, description="Minimum number of cusps in any slice.")
    limits: JointLimits | None = Field(
        default=None, description="Only cusps strictly within these limits are counted."
    )
    degenerate: Literal["allowed", "refused"] = Field(
        default="allowed",
        description="With `refused` a manipulator fails if every slice of an interval has degenerate poses, "
        "or a slice a whole curve of them, within the limits or not. The report lists them in any case.",
    )

    def to_requirement(self) -> Requirement:
        """Returns the requirement as the solver takes it."""
        limits = {} if self.limits is None else self.limits.bounds()
        counts = self.max_cusps, self.min_cusps
        return Requirement(self.fixed_leg, *self.range.ends, *counts, limits, self.degenerate)

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        with unnamed("requirement"):
            self.to_requirement()
        return self


class CheckRequest(Question):
    """A manipulator and the requirement to check."""

    expected: ClassVar[str] = "send an object with geometry and requirement"
    kinds: ClassVar[Sequence[Kind]] = (CHECK,)
    examples: ClassVar[Examples] = {
        "at_most": (
            "At most eight cusps for L1 between 28 and 31",
            {
                "requirement": {"range": {"from": 28, "to": 31}, "max_cusps": 8},
            },
        ),
    }

    requirement: RequirementDocument
    digits: Digits = digits_field(CHECK_DIGITS)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return {**self.model_dump(), "requirement": self.requirement.to_requirement().to_json()}


class Example(FixedLength):
    """A slice of an interval; the fixed length is exact."""

    cusps: list[Cusp]


class Violation(Interval):
    """An interval whose slices violate the requirement, and one of these slices."""

    example: Example


class CheckReport(Model):
    """Whether a requirement is satisfied, by proof, and where it is violated."""

    geometry: GeometryText
    geometry_hash: str
    requirement: RequirementDocument
    passed: bool
    max_cusps_found: int
    min_cusps_found: int
    intervals: list[Interval]
    violations: list[Violation] = Field(
        description="The intervals with too many or too few cusps, ascending; empty if there are none."
    )
    degenerate: list[Degeneracy] = DEGENERATE
    solver_version: str
    digits: int
