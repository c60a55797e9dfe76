"""Cusp curves and margins: the questions, and the answers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from rpr_solver import MIN_DIGITS, exact_str
from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError
from service.schemas.answers import (
    CSV,
    DEGENERATE,
    JSON,
    JSON_FORM,
    ClosedRange,
    Counterexample,
    Decimal,
    Degeneracy,
    DocumentHead,
    FirstOrder,
    Forms,
    MarginCertificate,
    Point,
    TransitionEvent,
    csv_form,
)
from service.schemas.censuses import RequirementDocument
from service.schemas.document import Source, given
from service.schemas.lengths import (
    OF_THE_FIXED_LEG,
    Changes,
    OneSlice,
    OpenRange,
    Range,
    Slices,
    SlicesOfOneLeg,
    Tolerance,
    changes_json,
    range_field,
    slices_field,
)
from service.schemas.limits import Detail, Model
from service.schemas.numbers import Digits, FixedLeg, Length, Samples, digits_field
from service.schemas.questions import Question, check_one
from worker.answers.censuses import MARGIN
from worker.answers.documents import CUSP_CURVES


class CurveEnd(Detail):
    """Where a curve begins or ends.

    Attributes:
        l1: The length, with `fixed_leg` 1; 0 or null at an open end.
        l2: The length, with `fixed_leg` 2.
        l3: The length, with `fixed_leg` 3.
        kind: The kind of the transition; `open` at length 0 and at infinity; `undecided` where curves are cut
            at a degenerate pose, because it is not proved which cusps pass through it.
        joins: The curve that is proved to meet this one here; both are parts of one smooth curve that turns
            back in the fixed length.
        events: The degenerate poses; if there is only one, it is the end point of the curve.
    """

    l1: Decimal | None = None
    l2: Decimal | None = None
    l3: Decimal | None = None
    kind: str
    joins: str | None
    events: list[TransitionEvent]


class CurvePoint(Detail, Point):
    """A cusp of one slice. The fixed length is exact; all other numbers have `digits` significant digits."""

    cusp: int = Field(description="The number of the cusp, from 1, in the cusp table of the slice.")


class CuspCurve(Model):
    """A cusp followed through the lengths between two transitions."""

    name: str = Field(description="C1, C2, … in the order in which the curves begin.")
    start: CurveEnd = Field(alias="from")
    stop: CurveEnd = Field(alias="to")
    points: list[CurvePoint] = Field(description="Ascending in the fixed length.")


class CuspCurves(DocumentHead):
    """All cusp curves that meet the range."""

    range: ClosedRange
    curves: list[CuspCurve]
    degenerate: list[Degeneracy] = DEGENERATE


class CuspCurvesRequest(SlicesOfOneLeg, Question):
    """A manipulator, the leg whose length is the parameter, and the requested points. Give lengths for the
    fixed leg only: as `l1`, or `l2` with `fixed_leg` 2, or `l3` with `fixed_leg` 3.

    The cusp curves over the length of the fixed leg, each named and followed by proof: α, the fixed leg's
    angle and the lengths of the other two legs as functions of the fixed length.

    A name depends only on the manipulator and the fixed leg, not on the requested range or points. Points are
    given at the lengths `l1`, and with `samples` at that number of lengths in every window, however narrow;
    without either, in one slice of each window. The whole curves are computed once, by a job of a few
    seconds, and kept.

    Attributes:
        fixed_leg: The leg whose length is fixed in a slice, and the parameter of the curves.
        samples: Number of sample points of each curve in every window, however narrow; at most max_samples of
            /v1/limits.
    """

    kinds = (CUSP_CURVES,)
    path = "/v1/cusp-curves"
    tag = "cusp curves"
    summary = "Each cusp followed from the transition where it appears to the one where it vanishes"
    answer = CuspCurves
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("curves_csv", "point")}
    needs_slices = False

    fixed_leg: FixedLeg = 1
    digits: Digits = digits_field()
    range: Range = range_field()
    l1: Slices = slices_field(
        "Lengths of leg 1 at which points are requested, within the range: a number, a list or a range. With "
        "`fixed_leg` 2 or 3 use `l2` or `l3`."
    )
    l2: Slices = slices_field("The lengths, with `fixed_leg` 2.")
    l3: Slices = slices_field("The lengths, with `fixed_leg` 3.")
    samples: Samples | None = None

    @field_validator("l1", "l2", "l3")
    @classmethod
    def _are_within_the_range(
        cls, lengths: tuple[Fraction, ...], info: ValidationInfo
    ) -> tuple[Fraction, ...]:
        info.data.get("range", OpenRange()).check_inside(lengths)
        return lengths

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        lengths = [exact_str(x) for x in sorted(set(self.slices))]
        content = {name: value for name, value in super().content().items() if name not in LEGS}
        return {**content, "lengths": lengths}


class Margin(DocumentHead):
    """How far the lengths of a geometry may change before a property is lost. Radii multiply the weights.

    Attributes:
        asked: The slice (`l1`, `l2` or `l3`), the `requirement` or the `window`, and the `tolerance`.
        count: The number of cusps; null for a requirement that admits several.
        weights: What radii multiply, for each length: the tolerance if given.
        validity: The radius at which a platform is flat or two base points coincide, rounded down.
        proved: All geometries within this radius have the property; null if nothing is proved.
        verdict: Null without a tolerance.
        reason: Why the margin is 0, or nothing could be proved, if it is known.
    """

    asked: dict[str, Any]
    count: int | None
    weights: dict[str, str]
    validity: str | None
    first_order: FirstOrder | None
    proved: str | None
    counterexample: Counterexample | None
    verdict: Literal["proved", "refuted", "open"] | None
    reason: str | None
    certificate: MarginCertificate


class MarginRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator, a slice, a requirement or a window, and the changes of the lengths.

    For the number of cusps of a slice, for a requirement, or for the existence of a window with a number of
    cusps: the radius within which every geometry is proved to have it, an exact counter-example beyond, and
    the first-order estimate with the transitions that bind it. With `tolerance` it is only decided whether
    the property holds within it: `proved`, `refuted` (by a counter-example within it) or `open`.

    A job takes some seconds. The search ends after a fixed number of steps, so that the answer is the same on
    every machine.

    Attributes:
        fixed_leg: The leg whose length is fixed in a slice; a requirement names its own.
        l1: The length of leg 1 in a slice. With `fixed_leg` 2 or 3 use `l2` or `l3`.
        l2: The length, with `fixed_leg` 2.
        l3: The length, with `fixed_leg` 3.
        requirement: What all geometries must satisfy.
        window: A length between two transitions; a window with the number of cusps there must exist.
        tolerance: A change of all lengths, which multiplies the weights, or those of single lengths, the
            others being exact.
        weights: How much each length may change in comparison; 1 unless given, 0 for one that is exact.
    """

    model_config = ConfigDict(json_schema_extra=OF_THE_FIXED_LEG)

    expected = "send an object with geometry and one of l1, requirement and window"
    kinds = (MARGIN,)
    path = "/v1/margins"
    tag = "margins"
    summary = "How far the lengths may change before the number of cusps does"
    answer = Margin
    needs_slices = False

    fixed_leg: FixedLeg = 1
    l1: Length | None = given()
    l2: Length | None = given()
    l3: Length | None = given()
    requirement: RequirementDocument | None = given()
    window: Length | None = given()
    tolerance: Tolerance | None = given()
    weights: Changes | None = given()

    @model_validator(mode="after")
    def _is_one_question(self, info: ValidationInfo) -> Self:
        own = f"l{self.fixed_leg}"
        check_one({own: self.length, "requirement": self.requirement, "window": self.window}, Source.of(info))
        if self.requirement is not None:
            leg = self.requirement.fixed_leg
            if "fixed_leg" in self.model_fields_set and self.fixed_leg != leg:
                fault = f"is {self.fixed_leg}, but the requirement is about leg {leg}"
                raise InputError.of("fixed_leg", f"{fault}; leave one of them out")
            self.requirement.to_requirement().of_cusps_alone()
        changes_json(self.tolerance, self.weights)
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        asked: dict[str, Any] = {**self._of_slice(), "digits": MIN_DIGITS}
        if self.requirement is not None:
            asked["fixed_leg"] = self.requirement.fixed_leg
            asked["requirement"] = self.requirement.to_requirement().of_cusps_alone().to_json()
        if self.window is not None:
            asked["window"] = exact_str(self.window)
        name = "weights" if self.tolerance is None else "tolerance"
        return {**asked, name: changes_json(self.tolerance, self.weights)}
