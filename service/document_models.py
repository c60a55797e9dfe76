"""The models of documents that are computed in one piece."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.models import Digits, Document, Exact, Geometry, GeometryText, Point, optional, wanted_digits


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


DOCUMENT_MODELS: dict[str, type[BaseModel]] = {
    "PosesRequest": PosesRequest,
    "PoseTable": PoseTable,
    "CensusRequest": CensusRequest,
    "Census": Census,
}
