"""Margins: the question, and the answer."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from rpr_solver import MIN_DIGITS, exact_str
from rpr_solver.contract import SHORT
from rpr_solver.errors import InputError
from service.schemas.answers import Counterexample, DocumentHead, FirstOrder, MarginCertificate
from service.schemas.censuses import RequirementDocument
from service.schemas.document import given
from service.schemas.lengths import (
    OF_THE_FIXED_LEG,
    Changes,
    OneSlice,
    SlicesOfOneLeg,
    Tolerance,
    changes_json,
)
from service.schemas.numbers import FixedLeg, Length
from service.schemas.questions import Examples
from worker.answers.censuses import MARGIN


class Margin(DocumentHead):
    """How far the lengths of a geometry may change before a property is lost. Radii multiply the weights."""

    asked: dict[str, Any] = Field(
        description="The slice (`l1`, `l2` or `l3`), the `requirement` or the `window`, and the `tolerance`."
    )
    count: int | None = Field(description="The number of cusps; null for a requirement that admits several.")
    weights: dict[str, str] = Field(
        description="What radii multiply, for each length: the tolerance if given."
    )
    validity: str | None = Field(
        description="The radius at which a platform is flat or two base points coincide, rounded down."
    )
    first_order: FirstOrder | None
    proved: str | None = Field(
        description="All geometries within this radius have the property; null if nothing is proved."
    )
    counterexample: Counterexample | None
    verdict: Literal["proved", "refuted", "open"] | None = Field(description="Null without a tolerance.")
    reason: str | None = Field(description="Why the margin is 0, or nothing could be proved, if it is known.")
    certificate: MarginCertificate


class MarginRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator, a slice, a requirement or a window, and the changes of the lengths."""

    model_config = ConfigDict(json_schema_extra=OF_THE_FIXED_LEG)

    expected = "send an object with geometry and one of l1, requirement and window"
    kinds = (MARGIN,)
    path = "/v1/margins"
    name = "post_margin"
    tag = ("margins", "How exactly a manipulator must be made.")
    summary = "How far the lengths may change before the number of cusps does"
    description = """\
For the number of cusps of a slice, for a requirement, or for the existence of a window with a number of
cusps: the radius within which every geometry is proved to have it, an exact counter-example beyond, and the
first-order estimate with the transitions that bind it. With `tolerance` it is only decided whether the
property holds within it: `proved`, `refuted` (by a counter-example within it) or `open`.

A job takes some seconds. The search ends after a fixed number of steps, so that the answer is the same on
every machine.
"""
    answer = Margin
    known = "The margin."
    needs_slices = False
    examples: ClassVar[Examples] = {
        "slice": ("The ten cusps of the article's first manipulator at L1 = 28.1", {"l1": "28.1"}),
        "tolerance": ("Whether they stay within 0.0005", {"l1": "28.1", "tolerance": "0.0005"}),
        "full": (
            "With the proof, for an independent checker",
            {"l1": "28.1", "tolerance": "0.0005", "certificate": "full"},
        ),
        "requirement": (
            "At most six cusps for L1 between 21 and 26, with exact sides of the platform",
            {
                "requirement": {"range": {"from": 21, "to": 26}, "max_cusps": 6},
                "weights": {"d1": 0, "d2": 0, "d3": 0},
            },
        ),
    }

    fixed_leg: FixedLeg = Field(
        default=1, description="The leg whose length is fixed in a slice; a requirement names its own."
    )
    l1: Length | None = given("The length of leg 1 in a slice. With `fixed_leg` 2 or 3 use `l2` or `l3`.")
    l2: Length | None = given("The length, with `fixed_leg` 2.")
    l3: Length | None = given("The length, with `fixed_leg` 3.")
    requirement: RequirementDocument | None = given("What all geometries are to satisfy.")
    window: Length | None = given("A length between two transitions, whose number of cusps is to exist.")
    tolerance: Tolerance | None = given(
        "A change of all lengths, which multiplies the weights, or those of single lengths, the others "
        "being exact."
    )
    weights: Changes | None = given(
        "How much each length may change in comparison; 1 unless given, 0 for one that is exact."
    )
    certificate: Literal["short", "full"] = Field(
        default="short",
        description="`full` adds to the certificate what an independent checker of the proof needs.",
    )

    @model_validator(mode="after")
    def _is_one_question(self) -> Self:
        asked = [x for x in (self.length, self.requirement, self.window) if x is not None]
        if len(asked) != 1:
            own = f"l{self.fixed_leg}"
            raise InputError.of(own, f"give exactly one of {own}, requirement and window")
        if self.requirement is not None and self.fixed_leg not in (1, self.requirement.fixed_leg):
            raise InputError.of("fixed_leg", f"is {self.fixed_leg}, but the requirement has its own")
        if self.requirement is not None:
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
        if self.certificate != SHORT:
            asked["certificate"] = self.certificate
        name = "weights" if self.tolerance is None else "tolerance"
        return {**asked, name: changes_json(self.tolerance, self.weights)}
