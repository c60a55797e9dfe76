"""The models of documents that are computed in one piece."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.schemas.models import (
    Cusp,
    Digits,
    Document,
    Exact,
    Geometry,
    GeometryText,
    Point,
    Slices,
    optional,
    own_slices_only,
    wanted_digits,
    wanted_slices,
)


class PosesRequest(Document):
    """One manipulator and the lengths of its legs."""

    geometry: Geometry
    l1: Exact = Field(description="Length of leg 1; > 0.")
    l2: Exact = Field(description="Length of leg 2; > 0.")
    l3: Exact = Field(description="Length of leg 3; > 0.")
    digits: int = wanted_digits(90)


class Pose(BaseModel):
    """A pose of the platform. Angles are degrees in (−180, 180]."""

    alpha_deg: Digits = Field(description="Orientation of the platform.")
    theta1_deg: Digits = Field(description="Angle of leg 1.")
    theta2_deg: Digits = Field(description="Angle of leg 2.")
    theta3_deg: Digits = Field(description="Angle of leg 3.")
    b1_x: Digits = Field(description="x of the platform's point B1.")
    b1_y: Digits = Field(description="y of the platform's point B1.")
    multiplicity: int = Field(
        description="How many poses coalesce here: 1 regular, 2 on a singular curve, 3 at a cusp."
    )


class PoseCurve(BaseModel):
    """A whole curve of poses: congruent triangles with equal legs have one."""

    kind: str
    alpha_deg: str
    description: str


class PosePolynomial(BaseModel):
    """The polynomial of direct kinematics, exact: Σ (coefficients[i] + omega · omega_coefficients[i]) tⁱ."""

    variable: str
    degree: int
    coefficients: list[str]
    omega: str | None = optional("The square root; missing where it is rational.")
    omega_coefficients: list[str] | None = optional("The multiples of the square root.")


class PoseCertificate(BaseModel):
    """How the count was proved."""

    model_config = ConfigDict(extra="allow")

    method: str
    factors: list[dict[str, Any]]
    working_bits: int


class PoseTable(BaseModel):
    """All real poses of one joint vector, sorted by α, then θ1."""

    geometry: GeometryText
    geometry_hash: str
    digits: int
    solver_version: str
    l1: str
    l2: str
    l3: str
    count: int = Field(description="The number of different isolated poses.")
    count_with_multiplicity: int
    poses: list[Pose]
    curves: list[PoseCurve]
    polynomial: PosePolynomial
    certificate: PoseCertificate


class OpenRange(Document):
    """A range of lengths; an end that is missing or null is open."""

    start: Exact | None = Field(default=None, alias="from", description="Lower end; 0 when missing.")
    stop: Exact | None = Field(default=None, alias="to", description="Upper end; all lengths when missing.")


class CensusRequest(Document):
    """One manipulator, the leg whose length is fixed in a slice, and the lengths of interest."""

    geometry: Geometry
    fixed_leg: Literal[1, 2, 3] = Field(default=1, description="The leg whose length is fixed in a slice.")
    digits: int = wanted_digits(90)
    range: OpenRange | None = Field(default=None, description="All lengths when missing.")


class TransitionEvent(Point):
    """A degenerate pose of a transition."""

    kind: str = Field(description="For example swallowtail, lips, beak-to-beak.")


class Transition(BaseModel):
    """A length at which the number of cusps changes, or a degenerate pose is passed."""

    l1: Digits | None = optional("The length of the fixed leg.")
    l2: Digits | None = optional("The length, when `fixed_leg` is 2.")
    l3: Digits | None = optional("The length, when `fixed_leg` is 3.")
    kind: str = Field(description="The kind of its events, or several.")
    count_before: int = Field(description="Cusps in the slices just below.")
    count_after: int = Field(description="Cusps in the slices just above.")
    events: list[TransitionEvent]


class ClosedRange(BaseModel):
    """The range that was asked for."""

    start: str = Field(alias="from")
    stop: str | None = Field(alias="to", description="null: without end.")


class Interval(ClosedRange):
    """An interval without transitions. All its slices have the same number of cusps."""

    count: int


class Census(BaseModel):
    """All transitions in a range, ascending, and the proved numbers of cusps between them."""

    geometry: GeometryText
    geometry_hash: str
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str
    range: ClosedRange
    transitions: list[Transition]
    intervals: list[Interval]
    certificate: dict[str, Any] = Field(description="How the census was proved to be complete.")


class CuspCurvesRequest(Document):
    """One manipulator, the leg whose length is the parameter, and the points that are wanted."""

    model_config = ConfigDict(extra="forbid", json_schema_extra=own_slices_only(required=False))

    geometry: Geometry
    fixed_leg: Literal[1, 2, 3] = Field(
        default=1, description="The leg whose length is fixed in a slice, and the parameter of the curves."
    )
    digits: int = wanted_digits(90)
    range: OpenRange | None = Field(default=None, description="All lengths when missing.")
    l1: Slices = wanted_slices(
        "Lengths of leg 1 at which points are wanted, within the range: a number, a list or a range. With "
        "`fixed_leg` 2 or 3 it is called `l2` or `l3`."
    )
    l2: Slices = wanted_slices("The lengths when `fixed_leg` is 2.")
    l3: Slices = wanted_slices("The lengths when `fixed_leg` is 3.")
    samples: int | None = Field(
        default=None,
        ge=1,
        description="So many points of each curve in every interval between transitions, however narrow. "
        "The limit is max_samples of /v1/limits.",
    )


class CurveEnd(BaseModel):
    """Where a curve begins or ends."""

    l1: Digits | None = Field(default=None, description="The length; 0, or null for a curve without end.")
    l2: Digits | None = Field(default=None, description="The length, when `fixed_leg` is 2.")
    l3: Digits | None = Field(default=None, description="The length, when `fixed_leg` is 3.")
    kind: str = Field(
        description="That of the transition; open at 0 and without end; undecided where curves are cut at a "
        "degenerate pose, since it is not proved which cusps pass it."
    )
    joins: str | None = Field(
        description="The curve that meets this one here, where that is proved: both are parts of one smooth "
        "curve, which turns back in the fixed length."
    )
    events: list[TransitionEvent] = Field(
        description="The degenerate poses; a single one is the end point of the curve."
    )


class CurvePoint(Point):
    """A cusp of one slice. The fixed length is exact, all others have `digits` significant digits."""

    cusp: int = Field(description="Its number, from 1, in the cusp table of the slice.")


class CuspCurve(BaseModel):
    """A cusp followed over the lengths between two transitions."""

    name: str = Field(description="C1, C2, … in the order in which the curves begin.")
    start: CurveEnd = Field(alias="from")
    stop: CurveEnd = Field(alias="to")
    points: list[CurvePoint] = Field(description="Ascending in the fixed length.")


class CuspCurves(BaseModel):
    """All cusp curves that meet the range."""

    geometry: GeometryText
    geometry_hash: str
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str
    range: ClosedRange
    curves: list[CuspCurve]


class JointLimit(Document):
    """The lengths that a leg can have; an end that is missing or null is open."""

    min: Exact | None = None
    max: Exact | None = None


class JointLimits(Document):
    """Limits of the legs that are not fixed."""

    l1: JointLimit | None = None
    l2: JointLimit | None = None
    l3: JointLimit | None = None


class RequirementDocument(Document):
    """How many cusps every slice of a range may have, or must have; give one of the two, or both."""

    model_config = ConfigDict(extra="forbid", title="Requirement")

    fixed_leg: Literal[1, 2, 3] = Field(default=1, description="The leg whose length runs over the range.")
    range: OpenRange | None = Field(default=None, description="All lengths when missing.")
    max_cusps: int | None = Field(default=None, ge=0, description="At most so many; 0: free of cusps.")
    min_cusps: int | None = Field(default=None, ge=0, description="At least so many.")
    limits: JointLimits | None = Field(
        default=None, description="Only cusps strictly within these limits are counted."
    )


class CheckRequest(Document):
    """One manipulator, and what is required of it."""

    geometry: Geometry
    requirement: RequirementDocument
    digits: int = wanted_digits(30)


class Example(BaseModel):
    """A slice of an interval."""

    l1: str | None = optional("Its length, exactly.")
    l2: str | None = optional("Its length, when `fixed_leg` is 2.")
    l3: str | None = optional("Its length, when `fixed_leg` is 3.")
    cusps: list[Cusp]


class Violation(Interval):
    """An interval whose slices do not satisfy the requirement, and one of them."""

    example: Example


class CheckReport(BaseModel):
    """The proof that a requirement is satisfied, or where it is not."""

    geometry: GeometryText
    geometry_hash: str
    requirement: RequirementDocument
    passed: bool
    max_cusps_found: int
    min_cusps_found: int
    intervals: list[Interval]
    violations: list[Violation] = Field(description="Ascending; empty when passed.")
    solver_version: str
    digits: int


DOCUMENT_MODELS: dict[str, type[BaseModel]] = {
    "PosesRequest": PosesRequest,
    "PoseTable": PoseTable,
    "CensusRequest": CensusRequest,
    "Census": Census,
    "CuspCurvesRequest": CuspCurvesRequest,
    "CuspCurves": CuspCurves,
    "Requirement": RequirementDocument,
    "CheckRequest": CheckRequest,
    "CheckReport": CheckReport,
}
