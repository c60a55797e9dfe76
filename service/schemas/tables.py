"""Cusp tables: the question, and the answer."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError, clipped
from service.schemas.answers import (
    CSV,
    JSON,
    JSON_FORM,
    NDJSON,
    Cusp,
    DocumentHead,
    FixedLength,
    Form,
    Forms,
    Point,
    csv_form,
    csv_pieces,
    ndjson_bytes,
    ndjson_pieces,
    ndjson_size,
    optional,
)
from service.schemas.document import Source
from service.schemas.lengths import NEEDED, SLICE_COLUMNS, Slices, SlicesOfOneLeg, slices_field
from service.schemas.limits import Detail, LimitError, Model
from service.schemas.numbers import Digits, FixedLeg, digits_field, fixed_leg_field
from service.schemas.questions import Question
from worker.answers.tables import ARTICLE_TABLE, CUSP_TABLE, METHODS, content

_, ARTICLE = METHODS


class Couple(Model):
    """A couple (α, θ1): a real solution above a root of the article's eliminant."""

    alpha_deg: str
    theta1_deg: str
    verdict: Literal["kept", "degenerate", "rejected"]
    reason: str


class ArticleFactor(Model):
    """A factor of the article's eliminant, the couples (α, θ1) above its real roots, and their origin."""

    origin: str
    degree: int
    multiplicity: int
    irreducible: list[dict[str, int]]
    reason: str
    real_roots: int
    rejected_in_step_6: int | None
    couples: list[Couple]


class Audit(Detail):
    """The article's algorithm, audited step by step.

    Attributes:
        conjecture: Whether the factor Q alone yields all cusps, with the reason.
    """

    equations: str
    eliminant_degree: int
    h: str
    factors: list[ArticleFactor]
    conjecture: dict[str, Any]


_SCAN = {"from": "0.1", "to": "50.1", "step": "0.1"}


class DegeneratePoint(Detail, Point):
    """A degenerate pose or a curve of them: J = E = 0, but not a cusp."""

    kind: str = Field(description="For example swallowtail, beak-to-beak, lips, node, quadruple.")
    equation: str | None = optional("The equation of a whole curve of such points.")


class SliceErrorDetail(Detail):
    """Why one slice has no answer."""

    type: str
    detail: str


class Factor(Model):
    """A factor of the resultant, and where it comes from."""

    degree: int
    multiplicity: int
    origin: str = Field(description="`cusps`, or the reason why its roots are not cusps.")


class Certificate(Detail):
    """What the answer rests on.

    Attributes:
        eliminant_degree: The degree of the factors whose roots are cusps.
        real_roots: The number of their real roots.
        factors: Those of the resultant of J and E.
        method: `balls` if all roots are simple, else `exact`: poses are classified in number fields.
            `shared-joints` where legs share joints, so that no slice has a cusp; `article` for the article's
            algorithm.
        nonzero: What is proved not to be 0 at every cusp, where J = E = 0: the kernel vector `v` of the map,
            so that it has rank 1; `grad_J`, so that the singular curve is smooth; and `v_grad_E`, so that
            exactly three poses coalesce.
    """

    model_config = ConfigDict(extra="allow")

    eliminant_degree: int
    real_roots: int
    factors: list[Factor]
    method: str
    nonzero: list[str]


class Slice(FixedLength):
    """The cusps of one slice, sorted by the angle of the fixed leg, or an error that does not affect the
    other slices. The fixed length is exact."""

    count: int | None = optional("Number of cusps.")
    cusps: list[Cusp] | None = optional("The cusps.")
    degenerate_points: list[DegeneratePoint] | None = optional("Degenerate poses, and curves of them.")
    certificate: Certificate | None = optional("What the answer rests on.")
    method: Literal["article"] | None = optional("Present with method `article`.")
    audit: Audit | None = optional("Present with method `article`.")
    error: SliceErrorDetail | None = optional("Present if the slice has no answer.")


class CuspTable(DocumentHead):
    """The cusps of all requested slices; every decimal is correctly rounded to `digits` digits.

    Attributes:
        geometry_hash: Identifies the geometry, however its numbers are written.
        solver_version: Changes whenever an answer may change.
        method: Present with method `article`.
        slices: In the order of the request.
    """

    geometry_hash: str = Field(pattern="^sha256:[0-9a-f]{64}$")
    solver_version: str
    method: Literal["article"] | None = optional()
    slices: list[Slice]


EXAMPLE_TABLE: dict[str, Any] = json.loads(
    Path(__file__).with_name("example-table.json").read_text(encoding="utf-8")
)
"""The table of the article's first manipulator at L1 = 0.2 with 15 digits."""


class CuspTableRequest(SlicesOfOneLeg, Question):
    """A manipulator and the slices of its joint space whose cusps are requested. The slices are lengths of
    the fixed leg: give `l1`, or `l2` with `fixed_leg` 2, or `l3` with `fixed_leg` 3, and neither of the other
    two.

    Answers 200 with the table if every slice is known or computed within 0.25 seconds, or within the N
    seconds of `Prefer: wait=N`. Otherwise answers 202 with a job that computes the missing slices; follow its
    `Location`.

    The `Content-Location` of the answer is a URL for GET, with `If-None-Match` and in other forms.
    `If-None-Match` has no meaning for POST and is ignored.

    Equal requests share one job, and slices that requests have in common are computed once. Numbers are
    exact: `17.04` is 426/25, never a binary float.

    Attributes:
        method: `article` uses and audits the article's own algorithm, with its eliminant of degree 96; it
            takes a second or more per slice and requires `fixed_leg` 1.
    """

    model_config = ConfigDict(json_schema_extra=NEEDED)

    expected = "send an object with geometry and l1"
    kinds = (CUSP_TABLE, ARTICLE_TABLE)
    path = "/v1/cusp-tables"
    tag = "cusp tables"
    summary = "The cusps of a manipulator in one or more slices"
    answer = CuspTable
    columns = (*LEGS, *SLICE_COLUMNS, "fixed_leg", "digits", "method")
    example = EXAMPLE_TABLE
    forms: ClassVar[Forms] = {
        JSON: JSON_FORM,
        CSV: replace(csv_form("table_csv", "cusp and degenerate point"), pieces=csv_pieces),
        NDJSON: Form(ndjson_bytes, "One slice per line.", ndjson_pieces, ndjson_size),
    }
    needs_slices = True

    l1: Slices = slices_field(
        "The slices: the fixed length L1 as a number, a list or a range. With `fixed_leg` 2 or 3 use `l2` "
        "or `l3`. Duplicate values are removed. A length <= 0 has an error instead of an answer; a request "
        "with no other lengths is refused.",
        examples=["14.98", ["14.98", 27], _SCAN],
    )
    l2: Slices = slices_field("The slices, with `fixed_leg` 2.")
    l3: Slices = slices_field("The slices, with `fixed_leg` 3.")
    digits: Digits = digits_field()
    fixed_leg: FixedLeg = fixed_leg_field()
    method: Literal["fast", "article"] = "fast"

    @field_validator("method")
    @classmethod
    def _article_fixes_leg_1(cls, method: str, info: ValidationInfo) -> str:
        leg = info.data.get("fixed_leg", 1)
        if method == ARTICLE and leg != 1:
            raise InputError.of("", f"is article, which fixes leg 1, but fixed_leg is {leg}")
        return method

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered, but not by the article's method."""
        return self.method != ARTICLE

    @model_validator(mode="after")
    def _has_a_slice(self) -> Self:
        """A slice without an answer leaves the others alone; but there must be others."""
        if not any(x > 0 for x in self.slices):
            shown = ", ".join(clipped(exact_str(x)) for x in self.slices[:3]) + (
                "" if len(self.slices) < 4 else ", …"
            )
            raise InputError.of(f"l{self.fixed_leg}", f"is {shown}; a leg length must be > 0")
        return self

    @model_validator(mode="after")
    def _article_takes_few_slices(self, info: ValidationInfo) -> Self:
        limits, count = Source.of(info).limits, len(self.slices)
        if self.method == ARTICLE and count > limits.max_article_slices:
            sent = f"asks for {count} slices by the article's method"
            raise LimitError.exceeded(limits, "max_article_slices", sent, "l1")
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question; duplicate slices are removed."""
        leg = None if self.method == ARTICLE else self.fixed_leg
        return dict(content(self.geometry, self.digits, self.slices, leg))
