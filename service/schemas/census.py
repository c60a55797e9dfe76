"""Censuses: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

from pydantic import BaseModel, Field

from service.schemas.lengths import Range, range_field
from service.schemas.numbers import Digits, FixedLeg, digits_field
from service.schemas.points import ClosedRange, Decimal, GeometryText, Interval, TransitionEvent, optional
from service.schemas.questions import Examples, Question
from worker.answers import censuses
from worker.answers.requests import Kind


class CensusRequest(Question):
    """One manipulator, the leg whose length is fixed in a slice, and the lengths of interest."""

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]] = (censuses.KIND,)
    examples: ClassVar[Examples] = {
        "whole": ("All of the article's first manipulator", {"digits": 30}),
        "range": (
            "A range of leg 1",
            {"digits": 30, "range": {"from": 28, "to": "31"}},
        ),
    }

    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length is fixed in a slice.")
    digits: Digits = digits_field()
    range: Range = range_field()

    def content(self) -> dict[str, Any]:
        """The question in canonical form."""
        return self.model_dump()


class Transition(BaseModel):
    """A length at which the number of cusps changes, or a degenerate pose is passed."""

    l1: Decimal | None = optional("The length of the fixed leg.")
    l2: Decimal | None = optional("The length, when `fixed_leg` is 2.")
    l3: Decimal | None = optional("The length, when `fixed_leg` is 3.")
    kind: str = Field(description="The kind of its events, or several.")
    count_before: int = Field(description="Cusps in the slices just below.")
    count_after: int = Field(description="Cusps in the slices just above.")
    events: list[TransitionEvent]


class Census(BaseModel):
    """All transitions in a range, ascending, and the proved numbers of cusps between them."""

    geometry: GeometryText
    geometry_hash: str
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str
    range: ClosedRange
    transitions: list[Transition]
    intervals: list[Interval]
    certificate: dict[str, Any] = Field(description="How the census was proved to be complete.")
