"""How a path is sampled, and how fast its legs may move: members of the question and of the answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Self, TypeAlias

from pydantic import ConfigDict, Field, PlainValidator, ValidationInfo, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import LEAST_SAMPLES, MOST_SAMPLES
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.model.lengths import ROWS, MotionLimits
from service.schemas.answers import Form, compact
from service.schemas.document import Document, Source, given, part, unnamed
from service.schemas.model import Model
from service.schemas.numbers import Exact, exact_number, whole_from


class LegNumbers(Document):
    """Numbers for some legs."""

    expected: ClassVar[str] = "give an object with some of l1, l2, l3"

    l1: Exact = given("Of leg 1.")
    l2: Exact = given("Of leg 2.")
    l3: Exact = given("Of leg 3.")

    def given(self) -> dict[str, Fraction]:
        """Those that are given."""
        return {name: value for name, value in self if value is not None}


def _limit(value: object, info: ValidationInfo) -> Fraction | LegNumbers:
    if isinstance(value, Mapping):
        return part(LegNumbers.model_validate, value, Source.of(info))
    return exact_number(value, info)


_Limit: TypeAlias = Annotated[
    Fraction | LegNumbers, PlainValidator(_limit, json_schema_input_type=Exact | LegNumbers)
]


class AskedMotion(Document):
    """Limits of all legs, each a number for all of them or an object with numbers by leg."""

    expected: ClassVar[str] = "give an object with speed and acceleration"

    speed: _Limit = Field(description="The greatest speed of the legs; > 0.")
    acceleration: _Limit = Field(description="The greatest acceleration of the legs; > 0.")
    jerk: _Limit | None = given(
        "The greatest change of their acceleration in a unit of time; any if missing."
    )

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        with unnamed("motion"):
            self.limits()
        return self

    def limits(self) -> MotionLimits:
        """The limits.

        Raises:
            InputError: naming `motion` or its part.
        """
        return MotionLimits.of(
            {
                kind: limit.given() if isinstance(limit, LegNumbers) else limit
                for kind, limit in self
                if limit is not None
            }
        )


class AskedSampling(Document):
    """By what the samples are chosen: one of these."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "maxProperties": 1})

    expected: ClassVar[str] = f"give an object with one of {', '.join(ROWS)}"

    number: Annotated[int | None, whole_from(LEAST_SAMPLES, MOST_SAMPLES)] = given(
        "Their number, as `samples`."
    )
    step: Exact | None = given("The time between them; the last one may come sooner. > 0")
    chord: Exact | None = given(
        "As many as are needed for legs that move linearly from sample to sample to deviate from the path by "
        "no more than this length. > 0"
    )

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        own = [name for name, value in self if value is not None]
        if len(own) != 1:
            raise InputError.of("", f"has {' and '.join(own) or 'nothing'}; give one of {', '.join(ROWS)}")
        for name in ("step", "chord"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise InputError.of(name, f"is {exact_str(value)}; a {name} must be > 0")
        return self

    def content(self) -> dict[str, Any]:
        """The canonical form."""
        if self.number is not None:
            return {"samples": self.number}
        return {"sampling": {name: exact_str(value) for name, value in self if value is not None}}


def problems_of_sampling(value: Mapping[str, Any]) -> Iterator[FieldProblem]:
    """Members that say the same twice."""
    spare = {"motion": ("timing", "duration"), "sampling": ("samples",)}
    for name, others in spare.items():
        if name in value:
            yield from (FieldProblem(x, f"follows from {name}; leave it out") for x in others if x in value)


class LegDecimals(Model):
    """Numbers by leg, exact."""

    l1: str | None = None
    l2: str | None = None
    l3: str | None = None


class PathMotion(Model):
    """The limits of motion that all legs keep at any time, proved."""

    speed: LegDecimals
    acceleration: LegDecimals
    jerk: LegDecimals | None = None
    stops: list[str] = Field(
        description="The times at which the legs rest on the way: where arcs of the path meet at an angle, "
        "and with `jerk` where any arcs meet, as their curvatures differ."
    )


class PathSampling(Model):
    """By what the samples were chosen."""

    step: str | None = None
    chord: str | None = None


class RunMotion(Model):
    """The law of time from rest to rest, on one arc or on some that meet smoothly (see mathematics.md)."""

    shares: list[str] = Field(description="The shares of its arcs in the parameter of the run, exact.")
    tick: str = Field(description="The time of a tick, exact.")
    speeds: list[int] = Field(
        description="In proportion to the speed of τ at the ends of ticks, before averaging."
    )
    window: int = Field(description="The number of ticks over which speeds are averaged; 1 without `jerk`.")


def samples_ndjson(document: Mapping[str, Any]) -> bytes:
    """Returns the samples of a path, one JSON object per line."""
    return b"".join(compact(sample).encode() + b"\n" for sample in document["samples"])


SAMPLES_FORM = Form(samples_ndjson, "One sample per line.")
