"""Cusp curves: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, ClassVar

from pydantic import Field, ValidationInfo, field_validator

from rpr_solver import exact_str
from service.schemas.lengths import (
    OpenRange,
    Range,
    Slices,
    SlicesOfOneLeg,
    range_field,
    slices_field,
)
from service.schemas.model import Model
from service.schemas.numbers import Digits, FixedLeg, Samples, digits_field
from service.schemas.points import (
    DEGENERATE,
    ClosedRange,
    Decimal,
    Degeneracy,
    DocumentHead,
    Point,
    TransitionEvent,
)
from service.schemas.questions import Examples, Question
from worker.answers import curves
from worker.answers.requests import Kind


class CuspCurvesRequest(SlicesOfOneLeg, Question):
    """A manipulator, the leg whose length is the parameter, and the requested points.

    Lengths are given for the fixed leg alone: as `l1`, or `l2` with `fixed_leg` 2, or `l3` with `fixed_leg`
    3.
    """

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]] = (curves.KIND,)
    needs_slices: ClassVar[bool] = False
    examples: ClassVar[Examples] = {
        "scan": (
            "Points of all curves for L1 from 27 to 29 in steps of 0.1",
            {
                "digits": 15,
                "range": {"from": 27, "to": 29},
                "l1": {"from": 27, "to": 29, "step": "0.1"},
            },
        ),
        "samples": (
            "Four points of each curve in every interval between transitions",
            {"digits": 15, "samples": 4},
        ),
    }

    fixed_leg: FixedLeg = Field(
        default=1, description="The leg whose length is fixed in a slice, and the parameter of the curves."
    )
    digits: Digits = digits_field()
    range: Range = range_field()
    l1: Slices = slices_field(
        "Lengths of leg 1 at which points are requested, within the range: a number, a list or a range. With "
        "`fixed_leg` 2 or 3 use `l2` or `l3`."
    )
    l2: Slices = slices_field("The lengths, with `fixed_leg` 2.")
    l3: Slices = slices_field("The lengths, with `fixed_leg` 3.")
    samples: Samples = Field(
        default=None,
        description="Number of sample points of each curve in every interval between transitions, however "
        "narrow; at most max_samples of /v1/limits.",
    )

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
        return {**self.model_dump(exclude={"l1", "l2", "l3"}), "lengths": lengths}

    def _asked(self) -> dict[str, Any]:
        content = self.content()
        lengths = content.pop("lengths")
        return {**content, **({f"l{self.fixed_leg}": lengths} if lengths else {})}


class CurveEnd(Model):
    """Where a curve begins or ends."""

    l1: Decimal | None = Field(
        default=None, description="The length, with `fixed_leg` 1; 0 or null at an open end."
    )
    l2: Decimal | None = Field(default=None, description="The length, with `fixed_leg` 2.")
    l3: Decimal | None = Field(default=None, description="The length, with `fixed_leg` 3.")
    kind: str = Field(
        description="The kind of the transition; `open` at length 0 and at infinity; `undecided` where "
        "curves are cut at a degenerate pose, since it is not proved which cusps pass through it."
    )
    joins: str | None = Field(
        description="The curve that is proved to meet this one here; both are parts of one smooth curve that "
        "turns back in the fixed length."
    )
    events: list[TransitionEvent] = Field(
        description="The degenerate poses; if there is only one, it is the end point of the curve."
    )


class CurvePoint(Point):
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
