"""The workspace at one orientation, or swept over orientations: the question, and the answers."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    Field,
    PlainSerializer,
    PlainValidator,
    RootModel,
    ValidationInfo,
    model_validator,
)

from rpr_solver import MIN_DIGITS, exact_str
from rpr_solver.workspaces.question import orientation, orientations, workspace_limits
from service.schemas.answers import (
    CSV,
    JSON,
    JSON_FORM,
    NEAR,
    PICTURE_FORM,
    SVG,
    CanonicalGeometry,
    Decimal,
    Forms,
    NearShape,
    csv_form,
    optional,
)
from service.schemas.document import Expected, Source, part, unnamed
from service.schemas.geometry import points_member
from service.schemas.lengths import (
    LIMIT_COLUMNS,
    PHI_COLUMNS,
    JointLimits,
    KeptLimits,
    SliceRange,
    limits_member,
)
from service.schemas.limits import Detail, Model
from service.schemas.numbers import Digits, Exact, digits_field, exact_number
from service.schemas.questions import Question
from worker.answers.workspaces import WORKSPACE

ConicName = Literal[
    "ellipse", "circle", "hyperbola", "parabola", "two lines", "parallel lines", "double line", "line",
    "point", "plane",
]  # fmt: skip


class SingularConic(Detail):
    """The places with J = 0 at this orientation.

    Attributes:
        kind: What it is, decided exactly; `plane`: J is 0 at every place, so that all poses of this
            orientation are singular.
        coefficients: Those of J, by `xx`, `xy`, `yy`, `x`, `y` and `1`.
    """

    kind: ConicName
    coefficients: dict[str, Decimal]


class WorkspaceArea(Detail):
    """The areas in which J > 0 and J < 0; or `singular`, where J is 0 everywhere."""

    positive: Decimal | None = optional()
    negative: Decimal | None = optional()
    singular: Decimal | None = optional()


class WorkspaceVertex(Detail):
    """A common point of curves.

    Attributes:
        x: x of the place.
        y: y of the place.
        b1_x: Where base or platform are given by points: x of B1 in the frame of the article.
        b1_y: y of B1, likewise.
        on: The curves through it: `l1_min`, `l1_max`, …, `singular`.
    """

    x: Decimal
    y: Decimal
    b1_x: Decimal | None = optional()
    b1_y: Decimal | None = optional()
    on: list[str]


class WorkspaceArc(Detail):
    """A piece of a boundary.

    Attributes:
        on: Its curve: `l1_min`, `l1_max`, …, or `singular`.
        start: The number of its first vertex, from 1; null of a whole circle or ellipse.
        stop: The number of its last vertex.
        ccw: Of a circle: whether it runs counter-clockwise.
        through: Of the conic: a point of it between the ends, x and y, for drawing.
    """

    on: str
    start: int | None = Field(alias="from")
    stop: int | None = Field(alias="to")
    ccw: bool | None = optional()
    through: dict[str, str] | None = optional()


class WorkspaceRegion(Detail):
    """A connected region of allowed places in which no pose is singular: an aspect at this orientation.

    Attributes:
        sign: The sign of J, as in slices of leg 1; 0 where J is 0 everywhere.
        area: Its area.
        boundary: The outer loop, then those of holes; the region is at the left.
    """

    sign: Literal[1, -1, 0]
    area: Decimal
    boundary: list[list[WorkspaceArc]]


class WorkspaceAt(Model):
    """The workspace at one orientation.

    Attributes:
        phi_deg: The orientation in degrees, exact, as asked: the angle of the platform's frame in the frame
            of the base.
        alpha_deg: The same as α of the article, in (−180, 180].
        frame: That of places: `points`, of those by which base or platform are given, or `article`.
        points: These points, exact.
        area: The areas by the sign of J.
        vertices: The common points of curves on boundaries.
        regions: Those with J > 0 first, then by area. Their number is exact.
        isolated: The numbers of vertices that are allowed, while no place near them is.
        thin: Arcs that are allowed, while no place beside them is.
    """

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    digits: int
    solver_version: str
    phi_deg: str
    alpha_deg: Decimal
    frame: Literal["article", "points"]
    points: dict[str, list[list[str]]] | None = optional()
    limits: KeptLimits
    conic: SingularConic
    area: WorkspaceArea
    vertices: list[WorkspaceVertex]
    regions: list[WorkspaceRegion]
    isolated: list[int]
    thin: list[WorkspaceArc]


class SweptOrientation(Detail):
    """The workspace at an orientation, in numbers.

    Attributes:
        phi_deg: The orientation, exact.
        conic: What the places with J = 0 are.
        positive_regions: The number of regions with J > 0.
        positive: The sum of their areas.
        negative_regions: The number of regions with J < 0.
        negative: The sum of their areas.
        singular_regions: Where J is 0 everywhere: the number of regions.
        singular: The sum of their areas.
    """

    phi_deg: str
    conic: ConicName
    positive_regions: int | None = optional()
    positive: Decimal | None = optional()
    negative_regions: int | None = optional()
    negative: Decimal | None = optional()
    singular_regions: int | None = optional()
    singular: Decimal | None = optional()


class SweptRange(Model):
    """The requested orientations, in degrees."""

    start: str = Field(alias="from")
    stop: str = Field(alias="to")
    step: str


class WorkspaceSweep(Model):
    """The workspaces at several orientations, in numbers."""

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    digits: int
    solver_version: str
    phi_deg: SweptRange
    limits: KeptLimits
    orientations: list[SweptOrientation]


class Workspace(RootModel[WorkspaceAt | WorkspaceSweep]):
    """The workspace at one orientation; or, with a range, at several ones in numbers."""


def _orientation(value: object, info: ValidationInfo) -> Fraction:
    with unnamed("phi"):
        return orientation(exact_number(value, info))


def _orientation_or_range(value: object, info: ValidationInfo) -> Fraction | SliceRange:
    if isinstance(value, Mapping | SliceRange):
        found = part(SliceRange.model_validate, value, Source.of(info))
        orientations(found.start, found.stop, found.step)
        return found
    return _orientation(value, info)


def _canonical(value: Fraction | SliceRange) -> object:
    if isinstance(value, Fraction):
        return exact_str(value)
    return {"from": exact_str(value.start), "to": exact_str(value.stop), "step": exact_str(value.step)}


ORIENTATION = Expected("give degrees from -360 to 360")
Phi = Annotated[
    Fraction,
    PlainValidator(_orientation, json_schema_input_type=Exact),
    PlainSerializer(_canonical),
    ORIENTATION,
]
"""An orientation in degrees."""
PhiOrRange = Annotated[
    Fraction | SliceRange,
    PlainValidator(_orientation_or_range, json_schema_input_type=Exact | SliceRange),
    PlainSerializer(_canonical),
    ORIENTATION,
]
"""An orientation in degrees, or several in steps."""


def limits_of_workspace(limits: JointLimits) -> dict[str, Any]:
    """Returns the member of a canonical question.

    Raises:
        InputError: naming `limits` or a part of it.
    """
    workspace_limits(limits.bounds())
    return limits_member(limits)


class WorkspaceRequest(Question):
    """A manipulator, an orientation of its platform, and limits of its legs' lengths.

    For one orientation φ, the places (x, y) of the platform that the limits of all legs allow: regions
    bounded by arcs of circles, divided by the singular conic, the places with J = 0, into regions with J > 0
    and J < 0. Vertices, numbers of regions and areas are exact.

    With a range for `phi`, the areas, the numbers of regions and the kind of the conic at each orientation.

    Where base or platform are given by points, φ and places are those of their frames; otherwise φ is α and
    the place is B1, in the frame of the article. A worker takes a tenth of a second for an orientation.

    Attributes:
        phi: The orientation in degrees, -360 to 360, exact; or several in steps.
        limits: The least and the greatest length of legs, an end of which may be missing. At least one leg
            needs a greatest length.
    """

    expected = "send an object with geometry, phi and limits"
    kinds = (WORKSPACE,)
    path = "/v1/workspaces"
    tag = "workspaces"
    summary = "The places that the limits of legs allow at an orientation, and the singular conic"
    answer = Workspace
    forms: ClassVar[Forms] = {
        JSON: JSON_FORM,
        CSV: csv_form("workspace_csv", "region or orientation"),
        SVG: PICTURE_FORM,
    }
    columns = (*PHI_COLUMNS, *LIMIT_COLUMNS, "digits")

    phi: PhiOrRange
    limits: JointLimits
    digits: Digits = digits_field(MIN_DIGITS)

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered."""
        return True

    @model_validator(mode="after")
    def _limits_bound_it(self) -> Self:
        limits_of_workspace(self.limits)
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question, with the points in whose frame places are told."""
        limits = limits_of_workspace(self.limits)
        return {**super().content(), **limits, **points_member(self.geometry)}
