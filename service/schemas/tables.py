"""Cusp tables: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from rpr_solver import exact_str
from rpr_solver.errors import InputError
from service.schemas.article_audit import Audit
from service.schemas.document import Source
from service.schemas.lengths import Slices, SlicesOfOneLeg, own_slices_only, slices_field
from service.schemas.limits import LimitError
from service.schemas.numbers import Digits, FixedLeg, digits_field
from service.schemas.points import Cusp, GeometryText, Point, optional
from service.schemas.questions import EXAMPLE_GEOMETRY, Examples, Question
from worker.answers import article, tables
from worker.answers.requests import Kind

ARTICLE = "article"
METHODS = ("fast", ARTICLE)

_SCAN = {"start": "0.1", "stop": "50.1", "step": "0.1"}
_TURNED = {**EXAMPLE_GEOMETRY, "d1": "426/25", "orientation": "ccw"}


class CuspTableRequest(SlicesOfOneLeg, Question):
    """One manipulator, and the slices of its joint space in which the cusps are wanted."""

    model_config = ConfigDict(json_schema_extra=own_slices_only(required=True))

    expected: ClassVar[str] = "send an object with geometry and l1"
    kinds: ClassVar[Sequence[Kind]] = (tables.KIND, article.KIND)
    needs_slices: ClassVar[bool] = True
    examples: ClassVar[Examples] = {
        "slice": ("The article's first manipulator, one slice", {"l1": 14.98}),
        "scan": ("The same manipulator, 501 slices", {"l1": _SCAN, "digits": 30}),
        "exact": ("Quotients and many digits", {"geometry": _TURNED, "l1": ["14.98", 27], "digits": 200}),
        "article": (
            "By the article's own algorithm, with its audit",
            {"l1": 14.98, "digits": 30, "method": "article"},
        ),
    }

    l1: Slices = slices_field(
        "The slices: the fixed length L1 as one number, as a list, or as a range. With `fixed_leg` 2 or 3 it "
        "is called `l2` or `l3`. A value that is given twice counts once.",
        examples=["14.98", ["14.98", 27], _SCAN],
    )
    l2: Slices = slices_field("The slices when `fixed_leg` is 2.")
    l3: Slices = slices_field("The slices when `fixed_leg` is 3.")
    digits: Digits = digits_field()
    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length is fixed in a slice.")
    method: Literal["fast", "article"] = Field(
        default="fast",
        description="`article` follows the article's own algorithm with its eliminant of degree 96, which "
        "takes a second or more for a slice, and audits it; only with `fixed_leg` 1.",
    )

    @field_validator("method")
    @classmethod
    def _article_fixes_leg_1(cls, method: str, info: ValidationInfo) -> str:
        leg = info.data.get("fixed_leg", 1)
        if method == ARTICLE and leg != 1:
            raise InputError.of("", f"is article, which fixes leg 1, but fixed_leg is {leg}")
        return method

    @model_validator(mode="after")
    def _article_takes_few_slices(self, info: ValidationInfo) -> Self:
        limits, count = Source.of(info).limits, len(self.slices)
        if self.method == ARTICLE and count > limits.max_article_slices:
            sent = f"asks for {count} slices by the article's method"
            raise LimitError.exceeded(limits, "max_article_slices", sent, "l1")
        return self

    @property
    def kind(self) -> Kind:
        """By the article's algorithm it is a document of its own kind."""
        return article.KIND if self.method == ARTICLE else tables.KIND

    def body(self) -> dict[str, Any]:
        """The question as it is posted."""
        content = self.content()
        return {f"l{self.fixed_leg}": content.pop("l1"), **content, "method": self.method}

    def content(self) -> dict[str, Any]:
        """The question in canonical form; duplicate slices are removed."""
        leg = {} if self.method == ARTICLE else {"fixed_leg": self.fixed_leg}
        slices = list(dict.fromkeys(map(exact_str, self.slices)))
        return {"geometry": self.geometry.to_json(), **leg, "digits": self.digits, "l1": slices}


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
