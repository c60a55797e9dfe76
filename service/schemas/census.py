"""Censuses: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from rpr_solver.contract import FULL
from service.schemas.lengths import Range, range_field
from service.schemas.model import Model
from service.schemas.numbers import Digits, FixedLeg, digits_field, fixed_leg_field
from service.schemas.points import (
    DEGENERATE,
    ClosedRange,
    Degeneracy,
    DocumentHead,
    FixedLength,
    Interval,
    TransitionEvent,
    optional,
)
from service.schemas.questions import Examples, Question
from worker.answers.censuses import CENSUS, CERTIFIED_CENSUS
from worker.answers.requests import Kind


class CensusRequest(Question):
    """A manipulator, the fixed leg, and the range of its lengths."""

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]] = (CENSUS, CERTIFIED_CENSUS)
    examples: ClassVar[Examples] = {
        "whole": ("The article's first manipulator, all lengths", {"digits": 30}),
        "range": (
            "A range of lengths of leg 1",
            {"digits": 30, "range": {"from": 28, "to": "31"}},
        ),
        "full": (
            "With all that a checker of the proof needs",
            {"digits": 30, "range": {"from": 28, "to": "31"}, "certificate": "full"},
        ),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    digits: Digits = digits_field()
    range: Range = range_field()

    certificate: Literal["short", "full"] = Field(
        default="short",
        description="`full` adds to the certificate what somebody else needs to check it: the eliminants of "
        "the transitions, isolating intervals of all their real roots, a box of each event, and the length "
        "at which the cusps of each interval were counted.",
    )

    @property
    def kind(self) -> Kind:
        """The kind of the document; one with a full certificate is kept by itself."""
        return CERTIFIED_CENSUS if self.certificate == FULL else CENSUS

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return self.model_dump(exclude={"certificate"})

    def _asked(self) -> dict[str, Any]:
        full = {"certificate": FULL} if self.certificate == FULL else {}
        return {**self.content(), **full}


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


class EventSystem(Model):
    """Equations whose common zeros are events, by their eliminant."""

    name: str = Field(
        description="`swallowtails`, `critical poses` (lips and beaks), or `beside shared angles`."
    )
    polynomial: dict[str, Any] = Field(
        description="The eliminant in tan(theta), exact: integer coefficients as text, from the constant one "
        "on, and those of the square root `omega`."
    )
    squarefree: dict[str, str] | None = Field(
        description="A prime, and the square root modulo it, that prove the eliminant squarefree and of full "
        "degree; null if it is not."
    )
    real_roots: list[dict[str, Any]] = Field(
        description="An isolating interval of each finite real root, exact, with its multiplicity."
    )


class FullCensusCertificate(Model):
    """What somebody else needs to check a census; present with `certificate` `full`."""

    model_config = ConfigDict(extra="allow")

    systems: list[EventSystem] = Field(description="Empty with the method `components`.")
    events: list[dict[str, Any]] = Field(
        description="For each event of all lengths, or with the method `components` of the transitions, its "
        "`kind`, and the centre and the radius of a box in the fixed length and both angles."
    )
    samples: list[str] = Field(description="For each interval the length at which the cusps were counted.")


class CensusCertificate(Model):
    """The proof that a census is complete."""

    model_config = ConfigDict(extra="allow")

    method: str = Field(
        description="`events` if the degenerate poses of all slices are isolated, else `components`."
    )
    lengths_examined: int = Field(description="The number of lengths at which cusps may be born or die.")
    counts_by: str
    full: FullCensusCertificate | None = optional("Present with `certificate` `full`.")


class Census(DocumentHead):
    """All transitions in a range, ascending, and the proved numbers of cusps between them."""

    range: ClosedRange
    transitions: list[Transition]
    intervals: list[CensusInterval]
    degenerate: list[Degeneracy] = DEGENERATE
    certificate: CensusCertificate = Field(description="The proof that the census is complete.")
