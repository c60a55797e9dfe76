"""The documents of the contract as models: what OpenAPI and its examples are made of.

Requests are read by :mod:`service.schemas.table_requests`, which keeps every number exact; a test
holds the two together.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema

from service.schemas.article_models import Audit

NUMBER_PATTERN = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,9})?\s*$|^\s*[+-]?\d+/\d+\s*$"

EXACT_NUMBER: dict[str, Any] = {
    "oneOf": [{"type": "number"}, {"type": "string", "pattern": NUMBER_PATTERN}],
    "description": "An exact number: a JSON number, or a string with a decimal or a quotient. Every "
    "digit counts; nothing is rounded to a binary float.",
    "examples": [17.04, "17.04", "426/25", "1.704e1"],
}
"""The schema of every number in a request."""

Exact = Annotated[Any, WithJsonSchema(EXACT_NUMBER)]
Digits = str
"""A decimal with as many significant digits as were asked for."""


def _without_null(schema: dict[str, Any]) -> None:
    """Say that a field may be missing; it is never null."""
    del schema["default"]
    [given] = [part for part in schema.pop("anyOf") if part != {"type": "null"}]
    schema.update({key: value for key, value in given.items() if key not in schema})


def optional(description: str) -> Any:
    """A field that may be missing."""
    return Field(default=None, description=description, json_schema_extra=_without_null)


class Document(BaseModel):
    """Base of the models."""

    model_config = ConfigDict(extra="forbid")


class Geometry(Document):
    """A planar 3-RPR manipulator: base points A1 = (0, 0), A2 = (a2x, 0), A3 = (a3x, a3y), and a platform
    B1B2B3 with sides d1 = |B1B2|, d2 = |B2B3|, d3 = |B3B1|. All lengths in one unit of your choice."""

    a2x: Exact = Field(description="x of the base point A2; not 0.")
    a3x: Exact = Field(description="x of the base point A3.")
    a3y: Exact = Field(description="y of the base point A3.")
    d1: Exact = Field(description="|B1B2|, a side of the platform; > 0.")
    d2: Exact = Field(description="|B2B3|, a side of the platform; > 0.")
    d3: Exact = Field(description="|B3B1|, a side of the platform; > 0.")
    orientation: Literal["ccw", "cw"] = Field(
        "ccw", description="Whether B1, B2, B3 run counter-clockwise or clockwise."
    )


class SliceRange(Document):
    """The values start, start + step, …, up to stop, which is included when it is hit exactly."""

    start: Exact
    stop: Exact
    step: Exact = Field(description="> 0")


def _without_default(schema: dict[str, Any]) -> None:
    del schema["default"]


Slices = Exact | Annotated[list[Exact], Field(min_length=1)] | SliceRange


def wanted_digits(default: int) -> Any:
    """How many digits are asked for."""
    return Field(
        default=default, ge=15, le=1000, description="Significant digits of every number in the answer."
    )


def wanted_slices(description: str, **more: Any) -> Any:
    """Lengths of the fixed leg."""
    return Field(default=None, description=description, json_schema_extra=_without_default, **more)


def own_slices_only(*, required: bool) -> dict[str, Any]:
    """The schema of requests that give lengths of the fixed leg, and of no other."""

    def one_leg(leg: int) -> dict[str, Any]:
        own = [f"l{leg}"] if required else []
        return {
            "title": f"fixed_leg {leg}",
            "properties": {"fixed_leg": {"const": leg}},
            "required": own if leg == 1 else [*own, "fixed_leg"],
            "not": {"anyOf": [{"required": [f"l{other}"]} for other in (1, 2, 3) if other != leg]},
        }

    return {"oneOf": [one_leg(leg) for leg in (1, 2, 3)]}


class CuspTableRequest(Document):
    """One manipulator, and the slices of its joint space in which the cusps are wanted."""

    model_config = ConfigDict(extra="forbid", json_schema_extra=own_slices_only(required=True))

    geometry: Geometry
    l1: Slices = wanted_slices(
        "The slices: the fixed length L1 as one number, as a list, or as a range. With `fixed_leg` 2 or 3 it "
        "is called `l2` or `l3`. A value that is given twice counts once.",
        examples=["14.98", ["14.98", 27], {"start": "0.1", "stop": "50.1", "step": "0.1"}],
    )
    l2: Slices = wanted_slices("The slices when `fixed_leg` is 2.")
    l3: Slices = wanted_slices("The slices when `fixed_leg` is 3.")
    digits: int = wanted_digits(90)
    fixed_leg: Literal[1, 2, 3] = Field(default=1, description="The leg whose length is fixed in a slice.")
    method: Literal["fast", "article"] = Field(
        default="fast",
        description="`article` follows the article's own algorithm with its eliminant of degree 96, which "
        "takes a second or more for a slice, and audits it; only with `fixed_leg` 1.",
    )


class GeometryText(Document):
    """The geometry in its canonical form: each number as a plain decimal, or as p/q when that does not
    end."""

    a2x: str
    a3x: str
    a3y: str
    d1: str
    d2: str
    d3: str
    orientation: Literal["ccw", "cw"]


class Point(BaseModel):
    """A point of a slice. The angle is that of the fixed leg, the lengths are those of the other two:
    theta1_deg, l2, l3 with `fixed_leg` 1."""

    alpha_deg: Digits | None = optional("Orientation of the platform, degrees in (−180, 180].")
    theta1_deg: Digits | None = optional("Angle of leg 1, degrees in (−180, 180].")
    theta2_deg: Digits | None = optional("Angle of leg 2, when it is the fixed one.")
    theta3_deg: Digits | None = optional("Angle of leg 3, when it is the fixed one.")
    l1: Digits | None = optional("Length of leg 1, in the unit of the geometry.")
    l2: Digits | None = optional("Length of leg 2, in the unit of the geometry.")
    l3: Digits | None = optional("Length of leg 3, in the unit of the geometry.")


class Cusp(Point):
    """One cusp of the slice."""


class DegeneratePoint(Point):
    """A point, or a curve, at which the cusp equations hold but which is no ordinary cusp."""

    kind: str = Field(description="For example swallowtail, beak-to-beak, lips, node, quadruple.")
    equation: str | None = optional("Of a whole curve of such points.")


class SliceErrorDetail(BaseModel):
    """Why one slice has no answer."""

    type: str
    detail: str


class Factor(BaseModel):
    """A factor of the resultant, and where it comes from."""

    degree: int
    multiplicity: int
    origin: str = Field(description="cusps, or the reason why its roots are none.")


class Certificate(BaseModel):
    """How the answer was proved."""

    model_config = ConfigDict(extra="allow")

    eliminant_degree: int
    real_roots: int
    factors: list[Factor]
    method: str
    working_bits: int = Field(description="Precision at which everything could be decided.")
    proofs: list[dict[str, str]] = Field(description="For each cusp the balls, none of which holds zero.")


class Slice(BaseModel):
    """The cusps of one slice, sorted by the angle of the fixed leg; or the error of this slice, which does
    not spoil the others."""

    l1: str | None = optional("The fixed length, exactly.")
    l2: str | None = optional("The fixed length, when `fixed_leg` is 2.")
    l3: str | None = optional("The fixed length, when `fixed_leg` is 3.")
    count: int | None = optional("Number of cusps.")
    cusps: list[Cusp] | None = optional("The cusps.")
    degenerate_points: list[DegeneratePoint] | None = optional("What is no ordinary cusp.")
    certificate: Certificate | None = optional("How the answer was proved.")
    method: Literal["article"] | None = optional("Only by the article's method.")
    audit: Audit | None = optional("Only by the article's method.")
    error: SliceErrorDetail | None = optional("Only when the slice has no answer.")


class CuspTable(BaseModel):
    """The answer. Every decimal has `digits` significant digits and an error under one unit in the last."""

    geometry: GeometryText
    geometry_hash: str = Field(
        pattern="^sha256:[0-9a-f]{64}$", description="Names the geometry, in any spelling."
    )
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str = Field(description="Changes whenever an answer could.")
    method: Literal["article"] | None = optional("Only by the article's method.")
    slices: list[Slice] = Field(description="In the order in which they were asked for.")


class Progress(BaseModel):
    """How far a job is."""

    done: int = Field(description="Slices, or steps, that are done.")
    total: int = Field(description="Slices of the job, or its steps as far as they are known.")


class JobError(BaseModel):
    """Why a job failed."""

    type: str = Field(description="timeout, worker-lost, resource-exhausted, solver-error, input-error, …")
    detail: str


class JobLinks(BaseModel):
    """Where the parts of a job are."""

    self: str
    result: str
    events: str


class Job(BaseModel):
    """An answer that is being computed, or was."""

    id: str
    kind: Literal["cusp-table", "article-table", "poses", "census", "check", "cusp-curves"] = Field(
        description="What it computes."
    )
    status: Literal["queued", "running", "succeeded", "failed", "canceled"]
    progress: Progress
    created_at: str = Field(description="ISO 8601, UTC.", json_schema_extra={"format": "date-time"})
    started_at: str | None = Field(description="ISO 8601, UTC; null before.")
    finished_at: str | None = Field(description="ISO 8601, UTC; null before.")
    error: JobError | None = Field(description="Only when the job failed.")
    links: JobLinks


class FieldError(BaseModel):
    """One field at fault."""

    field: str = Field(description="Its dotted name, for example geometry.d1.")
    message: str = Field(description="What is wrong with it and what would be right.")


class LimitInfo(BaseModel):
    """The limit that was exceeded."""

    name: str
    value: int


class ProblemDocument(BaseModel):
    """An error (RFC 9457)."""

    model_config = ConfigDict(extra="allow", title="Problem")

    type: str = Field(description="Names the kind of problem; its page documents it.")
    title: str
    status: int
    detail: str
    errors: list[FieldError]
    instance: str | None = optional("The path that was asked for.")
    limit: LimitInfo | None = optional("Only when a limit was exceeded.")
    job: str | None = optional("The job that this is about.")


class Health(BaseModel):
    """The process runs."""

    status: Literal["ok"]


class Readiness(BaseModel):
    """Requests can be served."""

    status: Literal["ready"]
    workers: int = Field(description="Workers that are alive.")


class Version(BaseModel):
    """What computes the answers."""

    service: str
    solver_version: str
    python: str
    libraries: dict[str, str | None]


class Limit(BaseModel):
    """One limit."""

    value: int
    description: str


class LimitsDocument(BaseModel):
    """All limits of requests."""

    model_config = ConfigDict(title="Limits")

    max_slices: Limit
    max_article_slices: Limit
    max_samples: Limit
    min_digits: Limit
    max_digits: Limit
    default_digits: Limit
    max_number_digits: Limit
    max_body_bytes: Limit
    max_wait_seconds: Limit


MODELS: dict[str, type[BaseModel]] = {
    "CuspTableRequest": CuspTableRequest,
    "CuspTable": CuspTable,
    "Job": Job,
    "Problem": ProblemDocument,
    "Health": Health,
    "Readiness": Readiness,
    "Version": Version,
    "Limits": LimitsDocument,
}
