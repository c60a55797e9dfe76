"""Verifications of documents: the question, and the answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, Field, PlainValidator, ValidationInfo, model_validator
from pydantic.json_schema import SkipJsonSchema

from rpr_solver import MAX_DIGITS, MIN_DIGITS, Manipulator
from rpr_solver.errors import InputError
from rpr_solver.verify.core.reader import check_texts
from service.schemas.answers import GeometryText, optional
from service.schemas.document import Expected, Source, json_kind, plain, unnamed
from service.schemas.numbers import whole_from
from service.schemas.questions import Examples, GeometryField, Question
from worker.answers.documents import VERIFICATION

_EXAMPLE: dict[str, Any] = {
    "geometry": {
        **{"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"},
        "orientation": "ccw",
    },
    "geometry_hash": "sha256:4a1f436b75ff0f42fbdf88a45157367229732340c0a95c36e0768583676bb06b",
    "fixed_leg": 1,
    "digits": 15,
    "solver_version": "5",
    "slices": [{"l1": "0.1", "count": 0, "cusps": [], "degenerate_points": []}],
}


def _document(value: object, info: ValidationInfo) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError.of("", f"is {json_kind(value)}; give a document of this service")
    from rpr_solver.verify.core.schema import kind_of  # the verifier is loaded when it is needed first

    limits = Source.of(info).limits
    check_texts(value, number_digits=limits.max_number_digits, most_digits=limits.max_digits)
    document: dict[str, Any] = plain(value)
    with unnamed("document"):
        kind_of(document)
        if not isinstance(document.get("geometry"), dict):
            raise InputError.of("geometry", "is missing; a document begins with its geometry")
        Manipulator.from_json(document["geometry"], max_digits=limits.max_number_digits)
    return document


MOST_EFFORT = 100


class VerifiedClaim(BaseModel):
    """A claim of the document, and its status."""

    at: str = Field(description="The member that makes it, a JSON pointer (RFC 6901).")
    claim: str
    status: Literal["proved", "checked", "not checked", "refused"]
    reason: str
    established: bool = Field(description="Whether it is proved.")
    error_probability: str | None = optional(
        "Of a claim that rests on random numbers, a bound such as `2^-200`; at present there is none."
    )


class VerifiedDocument(BaseModel):
    """Which document was verified."""

    kind: str
    geometry_hash: str
    solver_version: str = Field(description="Of the solver that made it.")


class ClaimCounts(BaseModel):
    """The number of claims of each status."""

    proved: int
    checked: int
    not_checked: int
    refused: int


class Verification(BaseModel):
    """The result of an independent verification of a document."""

    geometry: GeometryText
    geometry_hash: str
    verdict: Literal["accepted", "refused"] = Field(
        description="Accepted if no claim is refused; `outcome` says whether all are established."
    )
    outcome: Literal["established", "not established", "refused"] = Field(
        description="`established`: every claim is. `not established`: none is refused, but the claims "
        "named in `summary` are open; do not rely on them."
    )
    summary: str = Field(description="The outcome in one line, with all claims that are refused or open.")
    document: VerifiedDocument
    counts: ClaimCounts
    claims: list[VerifiedClaim]
    unread: list[str] = Field(
        description="Members that were not read, so that the verdict does not cover them, with * for places "
        "in lists."
    )


class VerificationRequest(Question):
    """A document to verify, as produced by this service or the command line.

    Checks a document of this service, or of the command line, without the solver and its libraries: the
    equations are derived from the legs by SymPy, and digits and counts are proved by exact integers and
    intervals.

    Every claim of the document is listed with its place and its status: `proved`, `checked` (short of a
    proof; the reason says how far), `not checked`, or `refused`. For a refused document the response is 200
    with `verdict` `refused`. The response waits for it, up to 10 seconds unless `Prefer` says otherwise;
    after that it is 202 with a job.
    """

    expected = "send an object with document"
    kinds = (VERIFICATION,)
    path = "/v1/verifications"
    name = "post_verification"
    tag = ("verifications", "Documents checked by independent means.")
    summary = "Whether a document is correct, claim by claim"
    answer = Verification
    known = "The verdict and its claims."
    implied_wait = 10
    examples: ClassVar[Examples] = {"table": ("A table without cusps", {"document": _EXAMPLE})}
    names_geometry = False

    geometry: SkipJsonSchema[GeometryField] = Field(exclude=True)
    document: Annotated[
        dict[str, Any],
        PlainValidator(_document, json_schema_input_type=dict[str, Any]),
        Expected("give a document of this service, with its geometry"),
    ] = Field(
        description="The document, its numbers as text: a cusp table, poses, a census, cusp curves or a "
        "report of a check."
    )

    effort: Annotated[int, whole_from(1, MOST_EFFORT, "how many times the usual work, ")] = Field(
        default=1,
        description="A factor for the work that the length of the document allows, which is about ten "
        "seconds for each 100 kB. Claims that are left then are not established.",
    )

    @model_validator(mode="before")
    @classmethod
    def _with_its_geometry(cls, value: Any) -> Any:
        """The geometry is that of the document; the document's validation reports any fault in it."""
        document = value.get("document")
        geometry = document.get("geometry") if isinstance(document, Mapping) else None
        try:
            manipulator = Manipulator.from_json(plain(geometry))
        except (InputError, RecursionError):
            manipulator = Manipulator.from_json(_EXAMPLE["geometry"])
        return {**value, "geometry": manipulator}

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
            **({} if self.effort == 1 else {"effort": self.effort}),
        }
