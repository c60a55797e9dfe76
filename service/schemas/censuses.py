"""Censuses, and checks of requirements: the questions, and the answers."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from rpr_solver import CHECK_DIGITS, Requirement, exact_str
from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import parse_not_negative
from service.schemas.answers import (
    CSV,
    DEGENERATE,
    JSON,
    JSON_FORM,
    NEAR,
    CanonicalGeometry,
    ClosedRange,
    Counterexample,
    Cusp,
    Decimal,
    Degeneracy,
    DocumentHead,
    FirstOrder,
    FixedLength,
    Forms,
    Interval,
    MarginCertificate,
    NearShape,
    TransitionEvent,
    csv_form,
    optional,
)
from service.schemas.document import Document, given, unnamed
from service.schemas.lengths import RANGE_COLUMNS, JointLimits, Range, Tolerance, changes_json, range_field
from service.schemas.limits import Detail, Model
from service.schemas.modes import ModeChange
from service.schemas.numbers import Count, Digits, Exact, FixedLeg, Flag, digits_field, fixed_leg_field
from service.schemas.questions import Question
from worker.answers.censuses import CENSUS, CHECK


class Sensitivity(Detail):
    """How fast the length of a transition changes with each length of the geometry: its derivatives, with
    all digits that are proved. Null if none is, as for 0, or if there is no derivative, as with respect to
    the sides of a flat platform."""

    a2x: str | None
    a3x: str | None
    a3y: str | None
    d1: str | None
    d2: str | None
    d3: str | None


class CensusEvent(TransitionEvent):
    """A degenerate pose at the length of a transition, with `sensitivities` also how it moves.

    Attributes:
        sensitivity: Missing unless requested; null where the pose is `singular`.
        singular: Present where the pose is not proved to be a simple one, such as a node: changes of the
            geometry may resolve it at once, so the margin there is 0.
    """

    sensitivity: Sensitivity | None = None
    singular: Literal[True] | None = optional()


class Transition(FixedLength):
    """A length of the fixed leg at which the number of cusps changes, or a degenerate pose occurs.

    Attributes:
        kind: The kind of its events; `several` if they differ.
        count_before: Number of cusps just below this length.
        count_after: Number of cusps just above this length.
        from_: With a `tolerance`, a lower bound of the length at which every geometry within it has these
            events; null if that is not proved.
        to: An upper bound, likewise.
    """

    kind: str
    count_before: int
    count_after: int
    events: list[CensusEvent]
    from_: str | None = Field(default=None, alias="from")
    to: str | None = None


class CensusInterval(Interval):
    """A window, an interval without transitions, with the number of cusps and of aspects of its slices.

    Attributes:
        aspects: The number of aspects, the connected sets of poses with one sign of J; null if it is not
            proved to be the same in all slices of the window.
    """

    aspects: int | None = None


class IgnoredWindow(Detail, ClosedRange):
    """A window that is ignored since it is narrow.

    Attributes:
        width: Its width within the range, rounded to six digits.
        counts: The numbers of cusps of the intervals that make it up, ascending in length.
    """

    width: Decimal
    counts: list[int]


class OpenRange(Model):
    """Lengths about which not all is proved."""

    from_: str = Field(alias="from")
    to: str | None = Field(description="Null: without end.")
    reason: str = Field(description="What is not proved, and why if it is known.")


class CensusCertificate(Detail):
    """What the completeness of a census rests on."""

    model_config = ConfigDict(extra="allow")

    method: str = Field(
        description="`events` if the degenerate poses of all slices are isolated, else `components`; "
        "`shared-joints` where legs share joints, so that no slice has a cusp."
    )
    lengths_examined: int = Field(description="The number of lengths at which cusps may be born or vanish.")
    counts_by: str
    boxes: int | None = optional("With a `tolerance`, the number of boxes of the proof.")


class Census(DocumentHead):
    """All transitions in a range, ascending, and the proved numbers of cusps between them.

    Attributes:
        certificate: What the completeness of the census rests on.
        ignore_windows: Present if the question has it.
        ignored_windows: Present with `ignore_windows`: the intervals that are narrower.
        tolerance: The greatest change of each length, if the question has one.
        complete: Present with a `tolerance`: whether every geometry within it has these transitions, in this
            order, each between its `from` and `to`, with these numbers of cusps between, and no others.
        open: Present with a `tolerance`: the lengths about which that is not proved, ascending. Outside of
            these it is.
    """

    range: ClosedRange
    transitions: list[Transition]
    intervals: list[CensusInterval]
    degenerate: list[Degeneracy] = DEGENERATE
    certificate: CensusCertificate
    ignore_windows: str | None = optional()
    ignored_windows: list[IgnoredWindow] | None = optional()
    tolerance: dict[str, str] | None = optional()
    complete: bool | None = optional()
    open: list[OpenRange] | None = optional()


# As a condition, since generators of clients drop the members beside an `anyOf`.
_A_BOUND: dict[str, Any] = {
    "if": {"properties": {"max_cusps": {"type": "null"}, "mode_change": {"type": "null"}}},
    "then": {"required": ["min_cusps"], "properties": {"min_cusps": {"type": "integer"}}},
}


class RequirementDocument(Document):
    """Bounds on the number of cusps in every slice of a range; give max_cusps, min_cusps or mode_change.

    Attributes:
        fixed_leg: The leg whose length varies over the range.
        max_cusps: Maximum number of cusps in any slice; 0 requires a range without cusps, which does not
            prove that the assembly mode cannot change.
        min_cusps: Minimum number of cusps in any slice.
        limits: Only cusps strictly within these limits are counted.
        degenerate: With `refused`, a manipulator fails if every slice of a range of lengths has degenerate
            poses, or a slice has a whole curve of them, whether within the limits or not. The report lists
            them in any case.
        mode_change: Whether a change of assembly mode without a singularity must be possible, or impossible,
            while the fixed leg keeps the range, within the limits. The range then begins at a length > 0; it
            may have no upper end.
        clearance: With `mode_change`: how far, in degrees, a change keeps from singular poses, as for
            `/v1/assembly-modes`.
        ignore_windows: A width in the unit of the lengths. A window of the requirement is a longest stretch
            of lengths in the range whose slices all have another number of cusps than is required; one that
            is narrower is ignored, and listed.
    """

    model_config = ConfigDict(title="Requirement", json_schema_extra=_A_BOUND)

    expected: ClassVar[str] = "give an object with range and max_cusps or min_cusps"

    fixed_leg: FixedLeg = 1
    range: Range = range_field()
    max_cusps: Count | None = None
    min_cusps: Count | None = None
    limits: JointLimits | None = None
    degenerate: Literal["allowed", "refused"] = "allowed"
    mode_change: Literal["required", "excluded"] | None = None
    ignore_windows: Exact | None = given()
    clearance: Exact | None = given()

    def to_requirement(self) -> Requirement:
        """Returns the requirement as the solver takes it."""
        limits = {} if self.limits is None else self.limits.bounds()
        counts = self.max_cusps, self.min_cusps
        last = self.degenerate, self.mode_change
        narrow, wide = self.ignore_windows or 0, self.clearance or 0
        return Requirement(
            self.fixed_leg, *self.range.ends, *counts, limits, *last, ignore_windows=narrow, clearance=wide
        )

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        with unnamed("requirement"):
            self.to_requirement()
        return self


class Example(Detail, FixedLength):
    """A slice of an interval; the fixed length is exact."""

    cusps: list[Cusp]


class Violation(Detail, Interval):
    """A window whose slices violate the requirement, and one of these slices."""

    example: Example


class ToleranceReport(Detail):
    """Whether the requirement is satisfied by every geometry within the tolerance, and by which it is not.

    Attributes:
        tolerance: The greatest change of each length; radii multiply it.
        reason: Why it is open, or no counter-example is given, if it is known.
        validity: The radius at which a platform is flat or two base points coincide, rounded down.
        counterexample: A geometry within the tolerance that does not satisfy the requirement; null as well if
            the given one does not.
        certificate: Null if the given geometry fails.
    """

    tolerance: dict[str, str]
    verdict: Literal["proved", "refuted", "open"]
    reason: str | None
    validity: str | None
    first_order: FirstOrder | None
    counterexample: Counterexample | None
    certificate: MarginCertificate | None


class CheckReport(Model):
    """Whether a requirement is satisfied, by proof, and where it is violated.

    Attributes:
        passed: Whether the requirement is proved; with a tolerance, for every geometry within it.
        max_cusps_found: The largest number of cusps, outside of ignored windows.
        min_cusps_found: The smallest one.
        violations: The intervals with too many or too few cusps, ascending, without ignored ones; empty if
            there are none.
        ignored_windows: Present with `ignore_windows` in the requirement: the windows that are narrower.
        margin: Present with a `tolerance` in the question.
        mode_change: Present with `mode_change` in the requirement.
    """

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    requirement: RequirementDocument
    passed: bool
    max_cusps_found: int
    min_cusps_found: int
    intervals: list[Interval]
    violations: list[Violation]
    ignored_windows: list[IgnoredWindow] | None = optional()
    degenerate: list[Degeneracy] = DEGENERATE
    solver_version: str
    digits: int
    margin: ToleranceReport | None = optional()
    mode_change: ModeChange | None = optional()


class CensusRequest(Question):
    """A manipulator, the fixed leg, and the range of its lengths.

    The census of a manipulator: all transitions of its slices, each with its kind and its degenerate poses,
    and the numbers of cusps and of aspects in every window between them. The list of transitions is proved
    complete.

    The whole census is computed once, by a job of a few seconds, and kept; ranges of it, or fewer digits, are
    then answered immediately. `Prefer: wait=N` waits for the job.

    With `tolerance` it is a census of all geometries within it: each transition has bounds of its length,
    `from` and `to`, and outside of these and of the ranges in `open` all geometries have the same number of
    cusps.

    Attributes:
        sensitivities: Whether each event says how fast its transition moves when the lengths of the geometry
            change.
        tolerance: A change of all lengths of the geometry, or those of single lengths, the others being
            exact: the census must hold for every geometry within it.
        ignore_windows: A width: the intervals between transitions that are narrower are listed. Not for a
            census with a tolerance.
    """

    kinds = (CENSUS,)
    path = "/v1/censuses"
    tag = "censuses"
    summary = "Every length at which the number of cusps changes"
    answer = Census
    columns = (*RANGE_COLUMNS, "fixed_leg", "digits", "sensitivities", "tolerance", "ignore_windows")
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("census_csv", "interval")}

    fixed_leg: FixedLeg = fixed_leg_field()
    digits: Digits = digits_field()
    range: Range = range_field()

    sensitivities: Flag = False
    tolerance: Tolerance | None = given()
    ignore_windows: Exact | None = given()

    @model_validator(mode="after")
    def _is_of_one_geometry(self) -> Self:
        if self.tolerance is not None and self.ignore_windows is not None:
            raise InputError.of("ignore_windows", "is for censuses without a tolerance; a margin takes both")
        parse_not_negative(self.ignore_windows or 0, "ignore_windows")
        return self

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered, but not for neighbouring geometries."""
        return not self.sensitivities and self.tolerance is None

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        content = self.model_dump(exclude={"tolerance", "ignore_windows"})
        if not content["sensitivities"]:
            del content["sensitivities"]
        if self.ignore_windows:
            content["ignore_windows"] = exact_str(self.ignore_windows)
        return content if self.tolerance is None else {**content, "tolerance": changes_json(self.tolerance)}


class CheckRequest(Question):
    """A manipulator and the requirement to check.

    Proves or refutes a requirement: a maximum or minimum number of cusps in every slice of a range, counted
    strictly within the joint limits of the other legs.

    The report lists the intervals of the range with their numbers of cusps and, for each interval that
    violates the requirement, a slice with its cusps. With `mode_change` it says whether the assembly mode can
    change; undecided is not passed. If the requirement is violated, the response is 200 with `passed` false.

    With `tolerance` it passes only if the requirement is proved for every geometry within it. `margin` then
    has the verdict: `proved`, `refuted` (by a counter-example within the tolerance) or `open`. A change of
    assembly mode must be possible, or impossible, for every geometry within it, too.

    Attributes:
        tolerance: A change of all lengths of the geometry, or those of single lengths, the others being
            exact: the requirement must hold for every geometry within it.
    """

    expected = "send an object with geometry and requirement"
    kinds = (CHECK,)
    path = "/v1/checks"
    tag = "checks"
    summary = "Whether a manipulator satisfies a requirement on its cusps"
    answer = CheckReport

    requirement: RequirementDocument
    digits: Digits = digits_field(CHECK_DIGITS)
    tolerance: Tolerance | None = given()

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered, but not for neighbouring geometries."""
        return self.tolerance is None

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        own = self.model_dump(exclude={"tolerance"})
        content = {**own, "requirement": self.requirement.to_requirement().to_json()}
        return content if self.tolerance is None else {**content, "tolerance": changes_json(self.tolerance)}
