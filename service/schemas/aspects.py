"""Aspects of a range of lengths: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pydantic import Field

from rpr_solver.contract import MIN_DIGITS
from service.schemas.lengths import Range, range_field
from service.schemas.model import Model
from service.schemas.numbers import Digits, FixedLeg, digits_field
from service.schemas.points import ClosedRange, DocumentHead
from service.schemas.questions import Examples, Question
from worker.answers.documents import ASPECTS
from worker.answers.requests import Kind


class RangeAspectsRequest(Question):
    """A manipulator, and the range within which the length of one leg may vary."""

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]] = (ASPECTS,)
    examples: ClassVar[Examples] = {
        "range": ("Leg 1 between 27 and 30", {"range": {"from": 27, "to": 30}}),
        "whole": ("Any length of leg 1", {}),
    }

    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length varies over the range.")
    range: Range = range_field()
    digits: Digits = digits_field(MIN_DIGITS)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return self.model_dump()


class RangeAspect(Model):
    """A connected set of poses without a singularity, while the length of the leg varies within the range."""

    sign: int = Field(description="The sign of J.")
    at_start: int = Field(
        description="How many aspects of the slice at the lower end belong to it; at an open end, of the "
        "limit of slices there."
    )
    at_stop: int = Field(description="How many aspects of the slice at the upper end, likewise.")


class RangeAspects(DocumentHead):
    """The aspects of a range of lengths."""

    range: ClosedRange
    aspects: list[RangeAspect] = Field(
        description="Those with J > 0 first. Between two poses of one aspect there is a motion without a "
        "singularity within the range, between those of different aspects there is none. Their number is "
        "exact."
    )
