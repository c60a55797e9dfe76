"""Designs: the question, and the answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PlainValidator, ValidationInfo, model_validator

from rpr_solver import MIN_DIGITS, Requirement
from rpr_solver.designs import Plan
from rpr_solver.designs.plan import (
    DEFAULT_BUDGET,
    DEFAULT_SEED,
    LEAST_BUDGET,
    MOST_ASPECTS,
    MOST_CENSUSES,
    MOST_CUSPS,
    MOST_SEED,
)
from rpr_solver.designs.space import DEFAULT_DECIMALS, DEFAULT_VARY, MOST_DECIMALS
from rpr_solver.errors import InputError
from service.schemas.answers import (
    CSV,
    JSON,
    JSON_FORM,
    DocumentHead,
    Forms,
    GeometryText,
    csv_form,
    optional,
)
from service.schemas.censuses import Census, CheckReport, RequirementDocument
from service.schemas.curves import Margin
from service.schemas.document import Document, Source, given, json_kind, named, part
from service.schemas.limits import Detail, Model
from service.schemas.motions import Path
from service.schemas.numbers import Exact, whole_from
from service.schemas.questions import Question
from worker.answers.designs import DESIGN, PLAIN_OPTIONS


class VaryRange(Document):
    """The least and the greatest value of a length, or of another parameter of a family."""

    expected: ClassVar[str] = 'give an object with "from" and "to"'

    start: Exact = Field(alias="from")
    stop: Exact = Field(alias="to")


def _vary(value: object, info: ValidationInfo) -> str | dict[str, VaryRange]:
    if isinstance(value, str):
        return value
    if not isinstance(value, Mapping):
        raise InputError.of("", f'is {json_kind(value)}; give a share such as "15%", or bounds by name')
    found: dict[str, VaryRange] = {}
    for name, ends in value.items():
        with named(name):
            found[name] = part(VaryRange.model_validate, ends, Source.of(info))
    return found


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list | tuple):
        raise InputError.of("", f"is {json_kind(value)}; give a list of names such as a2x")
    for k, name in enumerate(value):
        if not isinstance(name, str):
            raise InputError.of(f"[{k}]", f"is {json_kind(name)}; give a name such as a2x")
    return tuple(value)


class Budget(Document):
    """How long a search may take.

    Attributes:
        censuses: The number of geometries that are examined, including the given one.
    """

    expected: ClassVar[str] = "give an object with censuses"

    censuses: Annotated[int, whole_from(LEAST_BUDGET, MOST_CENSUSES)] = DEFAULT_BUDGET


class Improvement(Detail):
    """A geometry that was better than all before."""

    census: int = Field(description="The number of geometries examined until then, including this one.")
    value: str = Field(description="What it reaches, as the search sees it: a float, windows ignored.")
    met: bool = Field(description="Whether it satisfies the requirement, as the search sees it.")
    geometry: GeometryText


class Start(Detail):
    """What the given geometry reaches, as the search sees it."""

    value: str
    met: bool
    census: Census = Field(description="Its census over the range.")


class KeptConstraints(Detail):
    """What is proved of the constraints on the whole range.

    Attributes:
        met: Whether all of them are proved.
        loop: A loop round a cusp in a slice of the range, within the joint limits, as `POST /v1/paths` gives
            it; null if none is required, or none was proved.
        min_aspects_found: The least number of aspects in the range; null if it was not asked for, or not
            proved in every interval.
        max_aspects_found: The greatest one.
    """

    met: bool
    loop: Path | None
    min_aspects_found: int | None
    max_aspects_found: int | None


class BestFound(Model):
    """The best geometry found, with the proof of what it does.

    Attributes:
        value: What it is proved to reach: the length of the longest admitted part of the range, the largest
            number of cusps, the margin; or how much it is changed, as a share of what is allowed.
        met: Whether a part of the range is admitted (`longest-range`), a slice has the least number of cusps
            (`most-cusps`), or the requirement is proved.
        change: What was added to each length of the given geometry.
        census: Its census over the range.
        check: The check of the requirement, with the windows that it ignores.
        margin: If it is met: how far it may change before the requirement is lost, or the requirement within
            the longest part but for a tenth at each end, or the largest number of cusps.
        constraints: What is proved of `loop`, `min_aspects` and `max_aspects`, if one of them was asked for.
    """

    geometry: GeometryText
    value: str
    met: bool
    change: dict[str, str]
    census: Census
    check: CheckReport
    margin: Margin | None
    constraints: KeptConstraints | None = optional()


class Design(DocumentHead):
    """The best geometry that a search found; nothing says that there is no better one.

    Attributes:
        asked: The question, with the bounds of all that varies.
        trace: The improvements, from the given geometry to the best.
        censuses: How many geometries were examined.
        stopped: Why the search ended. One that met its deadline or was canceled has the best found so far;
            asked again, it continues.
    """

    asked: dict[str, Any]
    start: Start
    best: BestFound
    trace: list[Improvement]
    censuses: int
    stopped: Literal["budget", "converged", "deadline", "canceled"]


class DesignRequest(Question):
    """A manipulator, the goal for its cusps, and what may vary.

    Searches near a geometry for one with the longest range in which a requirement holds, the least change
    that meets it, the largest margin, or the most cusps. Every candidate is examined by an exact census. The
    best one found is proved anew: by a check, a census and a margin.

    It is always a job, of a minute or more, which up to four workers share. Its events report
    each improvement, with the geometry. If it is canceled, or shortly before its deadline, it ends with the
    proof of the best geometry so far, as the answer of that job alone; canceled again, it ends at once. The
    same question always has the same answer.

    Attributes:
        objective: The goal, within the range, the counts and the joint limits of the requirement.
        requirement: Numbers of cusps, a range, and joint limits. It may be missing for `most-cusps`.
        vary: How far lengths may change: a share of each, such as `15%` (of a3x and a3y: of |A1A3|), or
            bounds by name, the others keeping their values.
        fixed: Names of lengths that keep their values.
        family: A tie between the lengths, which then depend on fewer parameters.
        decimals: The number of decimals to which what varies is rounded.
        min_height: The least height of both triangles; a hundredth of their longest sides if missing.
        loop: `required`: in some slice of the range, a loop round a cusp must be proved within the joint
            limits. `excluded`: no slice of the range may have one.
        min_aspects: The least number of aspects of every slice of the range, whatever the joint limits.
        max_aspects: The greatest number of aspects of any slice of the range, whatever the joint limits.
        seed: Where the random numbers begin.
    """

    expected = "send an object with geometry, objective and requirement"
    kinds = (DESIGN,)
    path = "/v1/designs"
    tag = "designs"
    summary = "The best geometry that a search finds for a goal about its cusps"
    answer = Design
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("design_csv", "improvement")}

    objective: Literal["longest-range", "least-change", "largest-margin", "most-cusps"]
    requirement: RequirementDocument | None = given()
    vary: Annotated[
        str | dict[str, VaryRange], PlainValidator(_vary, json_schema_input_type=str | dict[str, VaryRange])
    ] = DEFAULT_VARY
    fixed: Annotated[tuple[str, ...], PlainValidator(_names, json_schema_input_type=list[str])] = ()
    family: Literal["isosceles-1", "isosceles-2", "isosceles-3", "similar", "congruent", "mirror"] | None = (
        given()
    )
    decimals: Annotated[int, whole_from(0, MOST_DECIMALS)] = DEFAULT_DECIMALS
    min_height: Exact | None = given()
    loop: Literal["required", "excluded"] | None = given()
    min_aspects: Annotated[int, whole_from(1, MOST_ASPECTS)] | None = given()
    max_aspects: Annotated[int, whole_from(1, MOST_ASPECTS)] | None = given()
    budget: Budget = Field(default_factory=Budget)
    seed: Annotated[int, whole_from(0, MOST_SEED)] = DEFAULT_SEED

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        self._plan()
        return self

    def _plan(self) -> Plan:
        if self.requirement is not None:
            wish = self.requirement.to_requirement().of_cusps_alone()
        elif self.objective == MOST_CUSPS:
            wish = Requirement(min_cusps=0)
        else:
            raise InputError.of("requirement", "is missing; give the range and max_cusps or min_cusps")
        vary = self.vary
        return Plan.of(
            self.geometry,
            self.objective,
            wish,
            vary=vary if isinstance(vary, str) else {name: (x.start, x.stop) for name, x in vary.items()},
            fixed=self.fixed,
            budget=self.budget.censuses,
            **{name: getattr(self, name) for name in PLAIN_OPTIONS},
        )

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        plan = self._plan()
        leg = plan.goal.requirement.fixed_leg
        head = {"geometry": self.geometry.to_json(), "fixed_leg": leg, "digits": MIN_DIGITS}
        return {**head, **plan.to_json()}
