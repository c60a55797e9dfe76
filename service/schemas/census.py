"""Censuses: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pydantic import Field

from service.schemas.lengths import Range, range_field
from service.schemas.numbers import Digits, FixedLeg, digits_field, fixed_leg_field
from service.schemas.points import (
    DEGENERATE,
    ClosedRange,
    Degeneracy,
    DocumentHead,
    FixedLength,
    Interval,
    TransitionEvent,
)
from service.schemas.questions import Examples, Question
from worker.answers import censuses
from worker.answers.requests import Kind


class CensusRequest(Question):
    """A manipulator, the fixed leg, and the range of its lengths."""

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]] = (censuses.KIND,)
    examples: ClassVar[Examples] = {
        "whole": ("The article's first manipulator, all lengths", {"digits": 30}),
        "range": (
            "A range of lengths of leg 1",
            {"digits": 30, "range": {"from": 28, "to": "31"}},
        ),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    digits: Digits = digits_field()
    range: Range = range_field()

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return self.model_dump()


class Transition(FixedLength):
    """A length of the fixed leg at which the number of cusps changes, or a degenerate pose occurs."""

    kind: str = Field(description="The kind of its events; `several` if they differ.")
    count_before: int = Field(description="Number of cusps just below this length.")
    count_after: int = Field(description="Number of cusps just above this length.")
    events: list[TransitionEvent]


class CensusInterval(Interval):
    """An interval without transitions, with the number of cusps and of aspects of its slices."""

    aspects: int | None = Field(
        default=None,
        description="The number of aspects: connected regions of poses without a singularity, of one sign of "
        "J. null: it is not proved to be the same in all slices of the interval.",
    )


class Census(DocumentHead):
    """All transitions in a range, ascending, and the proved numbers of cusps between them."""

    range: ClosedRange
    transitions: list[Transition]
    intervals: list[CensusInterval]
    degenerate: list[Degeneracy] = DEGENERATE
    certificate: dict[str, Any] = Field(description="The proof that the census is complete.")
