"""Pictures, and verifications of documents: the questions, and the answers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import (
    ConfigDict,
    Field,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import SkipJsonSchema

from rpr_solver import EXAMPLES, MAX_DIGITS, MIN_DIGITS, Manipulator, exact_str
from rpr_solver.contract import LEGS, document_head
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.verify.reader import check_bounds
from service.schemas.answers import (
    JSON,
    JSON_FORM,
    NEAR,
    SVG,
    CanonicalGeometry,
    DocumentHead,
    Form,
    Forms,
    NearShape,
)
from service.schemas.document import Document, Expected, Source, given, json_kind, plain, shown, unnamed
from service.schemas.geometry import GeometryField, points_member
from service.schemas.lengths import (
    LIMIT_COLUMNS,
    NEEDED,
    PHI_COLUMNS,
    RANGE_COLUMNS,
    JointLimits,
    OneSlice,
    Range,
    range_field,
)
from service.schemas.limits import Detail, Model
from service.schemas.numbers import (
    POSITIVE_NUMBER,
    CuspNumber,
    FixedLeg,
    Length,
    PoseNumber,
    cusp_field,
    fixed_leg_field,
    number_where,
)
from service.schemas.questions import Examples, Question
from service.schemas.workspaces import Phi, limits_of_workspace
from worker.answers.documents import DIGITS, OF_ALL_SLICES, PLOT, VERIFICATION

_ONE_SLICE = ("slice", "torus", "loop")
_WITH_CUSP = ("loop", "mechanism")

_OF_WORKSPACE = ("phi", "limits")
_NOT_OF_WORKSPACE = (*LEGS, "range", "cusp", "pose")
_OTHERS: dict[str, Any] = {
    "if": {"properties": {"plot": {"enum": [*_ONE_SLICE]}}},
    "then": {
        **NEEDED,
        "properties": {"range": False, "pose": False},
        "dependentSchemas": {
            **NEEDED["dependentSchemas"],
            "cusp": {"properties": {"plot": {"const": "loop"}}, "required": ["plot"]},
        },
    },
    "else": {
        "if": {"properties": {"plot": {"enum": [*OF_ALL_SLICES]}}},
        "then": {"properties": dict.fromkeys((*LEGS, "cusp", "pose"), False)},
        "else": {
            "if": {"required": ["cusp"]},
            "then": {**NEEDED, "properties": {"range": False, "pose": False}},
            "else": {"required": [*LEGS], "properties": {"range": False}},
        },
    },
}


_SCHEMA: dict[str, Any] = {
    "if": {"required": ["plot"], "properties": {"plot": {"const": "workspace"}}},
    "then": {"required": [*_OF_WORKSPACE], "properties": dict.fromkeys(_NOT_OF_WORKSPACE, False)},
    "else": {"allOf": [_OTHERS, {"properties": dict.fromkeys(_OF_WORKSPACE, False)}]},
}


NARROWEST_MM, WIDEST_MM = 80, 400
Labels = Literal["both", "title", "caption", "none"]
LABELS: tuple[Labels, ...] = get_args(Labels)
"""What stands above and below a picture: title and geometry."""
UNIT_PATTERN = "^[a-zA-Zµμ]{0,12}$"


_WIDTH = number_where(
    f"give {NARROWEST_MM} to {WIDEST_MM} millimetres", lambda width: NARROWEST_MM <= width <= WIDEST_MM
)
PrintWidth = Annotated[Annotated[Fraction, _WIDTH] | None, WithJsonSchema(POSITIVE_NUMBER)]
"""The width of a picture in print, or None."""


def _unit(value: object) -> str:
    if not isinstance(value, str) or not re.fullmatch(UNIT_PATTERN, value):
        raise InputError.of("", f"is {shown(value)}; give up to 12 letters, such as mm or in")
    return value


Unit = Annotated[str, PlainValidator(_unit), WithJsonSchema({"type": "string", "pattern": UNIT_PATTERN})]
"""The name of a unit of length, or nothing."""


class Plot(DocumentHead):
    """A picture."""

    plot: str = Field(description="What is drawn.")
    theme: str
    title: str = Field(description="A title in one line.")
    description: str = Field(description="A text description, for readers who cannot see the picture.")
    width: float = Field(description="In pixels, like the height.")
    height: float
    svg: str = Field(description="The picture as an SVG document.")


class Setting(Document):
    """How a picture is set.

    Attributes:
        width_mm: For print: the width in millimetres, 80 to 400. Type then has 8 to 12 points.
        style: `paper` has symbols in italics with subscripts, and a serif font.
        unit: The unit of lengths, for the labels of axes.
        labels: Whether the title stands above the picture, the geometry below it, both, or neither.
    """

    width_mm: PrintWidth = None
    style: Literal["page", "paper"] = "page"
    unit: Unit = ""
    labels: Labels = "both"

    def setting(self) -> dict[str, Any]:
        """Returns what differs from a picture for a page, in canonical form."""
        setting = {
            "width_mm": None if self.width_mm is None else exact_str(self.width_mm),
            "has_symbols": self.style == "paper",
            "unit": self.unit,
            "labels": "" if self.labels == "both" else self.labels,
        }
        return {name: value for name, value in setting.items() if value}


class PlotRequest(OneSlice, Setting):
    """A manipulator, and the picture to draw. `slice` and `torus` take the length of the fixed leg, `loop`
    also a `cusp`; `census`, `sensitivities`, `margin`, `locus` and `projections` take a `range`; `mechanism`
    takes all three lengths and optionally a `pose`, or the length of the fixed leg and a `cusp`;
    `workspace` takes `phi` and `limits`.

    Draws the answers of other calls. The response is JSON with the picture as SVG text, its title and a text
    description, or only the SVG with `Accept: image/svg+xml`; GET gives it by a URL.

    Equal questions give the same bytes, as long as the service has the same version. A census or the cusp
    curves take a few seconds, margins half a minute, everything else less than one second.

    Attributes:
        plot: The type of picture: a slice in the plane of the free legs (`slice`) or on the torus of poses
            (`torus`), the number of cusps against the length of the fixed leg (`census`), how fast its
            transitions move with each length (`sensitivities`), how far the lengths may be off before that
            number changes (`margin`: first order, and proved in the widest windows), the cusp curves in joint
            space (`locus`) or in three plane projections of it (`projections`), a loop round a cusp (`loop`),
            the mechanism at a pose (`mechanism`), or the places that joint limits allow at an orientation
            (`workspace`).
        theme: The paper, `light` or `dark`.
        l1: The length of leg 1.
        l2: The length of leg 2.
        l3: The length of leg 3.
        pose: The number of the pose, from 1, in the answer of /v1/poses.
        phi: The orientation of a workspace in degrees, as in /v1/workspaces.
        limits: The joint limits of a workspace.
    """

    model_config = ConfigDict(json_schema_extra=_SCHEMA)

    expected = "send an object with geometry, and l1 for a slice"
    kinds = (PLOT,)
    path = "/v1/plots"
    tag = "plots"
    summary = "A picture of a slice, a census, the cusp curves, a loop, or the mechanism"
    answer = Plot
    forms: ClassVar[Forms] = {
        JSON: JSON_FORM,
        SVG: Form(lambda document: document["svg"].encode(), "The picture."),
    }

    plot: Literal[
        "slice",
        "torus",
        "census",
        "sensitivities",
        "margin",
        "locus",
        "projections",
        "loop",
        "mechanism",
        "workspace",
    ] = "slice"
    theme: Literal["light", "dark"] = "light"
    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = given()
    l2: Length = given()
    l3: Length = given()
    range: Range = range_field()
    cusp: CuspNumber = cusp_field()
    pose: PoseNumber = 1
    phi: Phi = given()
    limits: JointLimits = given()

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.plot in ("slice", "torus"):
            self.geometry.geometry.with_drawn_curves(self.fixed_leg)
        problems = list(self._problems())
        if problems:
            raise InputError(problems)
        if self.plot == "workspace":
            limits_of_workspace(self.limits)
        return self

    def _problems(self) -> Iterator[FieldProblem]:
        given = self.model_fields_set
        own = f"l{self.fixed_leg}"
        needed: tuple[str, ...] = ()
        useless: tuple[str, ...] = ()
        if self.plot == "workspace":
            needed = _OF_WORKSPACE
            useless = (*_NOT_OF_WORKSPACE, *(() if self.fixed_leg == 1 else ("fixed_leg",)))
        elif self.plot in OF_ALL_SLICES:
            useless = (*LEGS, "cusp", "pose")
        elif self._has_legs:
            needed, useless = LEGS, ("range", *(() if self.fixed_leg == 1 else ("fixed_leg",)))
        else:
            needed = (own,)
            others = [leg for leg in LEGS if leg != own]
            useless = (*others, "range", "pose", *(() if self.plot in _WITH_CUSP else ("cusp",)))
        for name in needed:
            if name not in given:
                wanted = "the limits of legs" if name == "limits" else "a number"
                yield FieldProblem(name, f"is missing; give {wanted}")
        for name in useless if needed is _OF_WORKSPACE else (*useless, *_OF_WORKSPACE):
            if name in given:
                yield FieldProblem(name, f"says nothing about the plot {self.plot!r}; leave it out")

    @property
    def takes_shared_joints(self) -> bool:
        """Its poses and slices are drawn."""
        return self._has_legs or self.plot in ("slice", "torus", "workspace")

    @property
    def _has_legs(self) -> bool:
        return self.plot == "mechanism" and "cusp" not in self.model_fields_set

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        drawn: dict[str, Any] = {"plot": self.plot, "theme": self.theme, "digits": DIGITS}
        if setting := self.setting():
            drawn["style"] = setting
        if self._has_legs:
            lengths = {leg: exact_str(getattr(self, leg)) for leg in LEGS}
            head = {"geometry": self.geometry.to_json(), "fixed_leg": 1}
            return {**head, **drawn, **lengths, "pose": self.pose}
        if self.plot == "workspace":
            asked = {"phi": exact_str(self.phi), **limits_of_workspace(self.limits)}
            head = {"geometry": self.geometry.to_json(), "fixed_leg": 1, **points_member(self.geometry)}
            return {**head, **drawn, **asked}
        if self.plot in OF_ALL_SLICES:
            drawn["range"] = self.range.model_dump()
        elif self.plot in _WITH_CUSP:
            drawn["cusp"] = self.cusp
        return {**self._of_slice(), **drawn}

    @classmethod
    def by_query(cls) -> type[Question]:
        """Returns the picture alone, for pages that show it."""
        return PictureRequest


class PictureRequest(PlotRequest):
    """A picture by its URL."""

    path = "/v1/plots"
    name = PlotRequest.name
    forms: ClassVar[Forms] = {SVG: PlotRequest.forms[SVG]}
    columns = (
        *("plot", "theme", *LEGS, *RANGE_COLUMNS, "fixed_leg", "cusp", "pose"),
        *("width_mm", "style", "unit", "labels", PHI_COLUMNS[0], *LIMIT_COLUMNS),
    )


_EXAMPLE: dict[str, Any] = {
    **document_head(EXAMPLES["innocenti"], MIN_DIGITS, 1),
    "slices": [{"l1": "0.1", "count": 0, "cusps": [], "degenerate_points": []}],
}


def _document(value: object, info: ValidationInfo) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError.of("", f"is {json_kind(value)}; give a document of this service")
    from rpr_solver.verify.documents import kind_of  # loaded when it is needed first

    limits = Source.of(info).limits
    with named_as_members():
        check_bounds(value, number_digits=limits.max_number_digits, most_digits=limits.max_digits)
    document: dict[str, Any] = plain(value)
    with unnamed("document"):
        kind_of(document)
        if not isinstance(document.get("geometry"), dict):
            raise InputError.of("geometry", "is missing; a document begins with its geometry")
        Manipulator.from_json(document["geometry"], max_digits=limits.max_number_digits)
    return document


@contextmanager
def named_as_members() -> Iterator[None]:
    """Name members of a document as those of questions, such as ``slices[0].l1``, not by JSON pointers.

    Raises:
        InputError: the one that is raised within, with other names.
    """
    try:
        yield
    except InputError as error:
        problems = [FieldProblem(_member(problem.field), problem.message) for problem in error.problems]
        raise InputError(problems) from None


def _member(pointer: str) -> str:
    steps = pointer.split("/")[1:]
    return "".join(f"[{step}]" if step.isdecimal() else f".{step}" for step in steps).removeprefix(".")


class VerifiedClaim(Detail):
    """A claim of the document, and its status.

    Attributes:
        at: The member that makes it, a JSON pointer (RFC 6901).
        reason: Why it has this status, in a sentence.
    """

    at: str
    claim: str
    status: Literal["proved", "open", "refused"]
    reason: str


class VerifiedDocument(Detail):
    """Which document was verified."""

    kind: str
    geometry_hash: str
    solver_version: str = Field(description="Of the solver that made it.")


class Verification(Model):
    """The result of an independent verification of a document.

    Attributes:
        verdict: `verified`: every claim is proved. `not verified`: none is refused, but those in `open` are
            not proved; do not rely on them.
        summary: The verdict in one line, with all claims that are refused or open.
        open: The members whose claims are neither proved nor refused, as JSON pointers.
        refused: The members whose claims contradict what is proved, as JSON pointers.
        no_claims: The members that claim nothing, with * for places in lists: how the answer was found, and
            drawings of it.
    """

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    verdict: Literal["verified", "not verified", "refused"]
    summary: str
    document: VerifiedDocument
    claims: list[VerifiedClaim]
    open: list[str]
    refused: list[str]
    no_claims: list[str]


class VerificationRequest(Question):
    """A document to verify, as produced by this service or the command line.

    Everything in the document is computed again from its geometry alone, with equations that SymPy derives
    from the legs, without the solver.

    Every claim of the document is listed with its place and its status: `proved`, `open` or `refused`. For a
    refused document the response is 200 with `verdict` `refused`.

    Attributes:
        document: The document, its numbers as text.
    """

    expected = "send an object with document"
    kinds = (VERIFICATION,)
    path = "/v1/verifications"
    tag = "verifications"
    summary = "Whether a document is correct, claim by claim"
    answer = Verification
    examples: ClassVar[Examples] = {"table": ("A table without cusps", {"document": _EXAMPLE})}
    names_geometry = False

    geometry: SkipJsonSchema[GeometryField] = Field(default=EXAMPLES["innocenti"], exclude=True)
    document: Annotated[
        dict[str, Any],
        PlainValidator(_document, json_schema_input_type=dict[str, Any]),
        Expected("give a document of this service, with its geometry"),
    ]

    @property
    def takes_shared_joints(self) -> bool:
        """The document may be about one."""
        return True

    @model_validator(mode="after")
    def _has_its_geometry(self) -> Self:
        self.geometry = Manipulator.from_json(self.document["geometry"], max_digits=1 << 20)
        return self

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        return [name for name in super()._members(value) if name != "geometry"]

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        digits = self.document.get("digits")
        whole = isinstance(digits, int) and MIN_DIGITS <= digits <= MAX_DIGITS
        return {
            "geometry": self.geometry.to_json(),
            "digits": digits if whole else MIN_DIGITS,
            "document": self.document,
        }
