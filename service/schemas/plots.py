"""Pictures: the question, and the answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, PlainValidator, ValidationInfo, model_validator

from rpr_solver import exact_str
from rpr_solver.errors import FieldProblem, InputError
from service.schemas.document import Source
from service.schemas.lengths import LEGS, NEEDED, Range, range_field
from service.schemas.numbers import FixedLeg, Length, positive_length, whole_number
from service.schemas.paths import cusp_number, cusp_schema
from service.schemas.points import DocumentHead
from service.schemas.questions import Examples, Question
from worker.answers import plots
from worker.answers.requests import Kind

MOST_POSES = 6

_ONE_SLICE = ("slice", "torus", "loop")
_ALL_SLICES = ("census", "locus")
_WITH_CUSP = ("loop", "mechanism")
_SCHEMA: dict[str, Any] = {
    "if": {"properties": {"plot": {"enum": [*_ONE_SLICE]}}},
    "then": {
        **NEEDED,
        "properties": {"range": False, "pose": False},
        "dependentSchemas": {
            **NEEDED["dependentSchemas"],
            "cusp": {"properties": {"plot": {"const": "loop"}}, "required": ["plot"]},
        },
    },
    "else": {
        "if": {"properties": {"plot": {"enum": [*_ALL_SLICES]}}},
        "then": {"properties": dict.fromkeys((*LEGS, "cusp", "pose"), False)},
        "else": {
            "if": {"required": ["cusp"]},
            "then": {**NEEDED, "properties": {"range": False, "pose": False}},
            "else": {"required": [*LEGS], "properties": {"range": False}},
        },
    },
}


def _pose(value: object, info: ValidationInfo) -> int:
    expected = f"1 to {MOST_POSES}"
    pose = whole_number(value, expected, is_text=Source.of(info).is_text)
    if not 1 <= pose <= MOST_POSES:
        raise InputError.of("", f"is {str(pose)[:40]}; give {expected}")
    return pose


OneLength = Annotated[Fraction | None, PlainValidator(positive_length, json_schema_input_type=Length)]


class PlotRequest(Question):
    """A manipulator, and what is to be drawn of it.

    `slice` and `torus` take the length of the fixed leg, `loop` also a `cusp`; `census` and `locus` take a
    `range`; `mechanism` takes all three lengths and perhaps a `pose`, or the length of the fixed leg and a
    `cusp`.
    """

    model_config = ConfigDict(json_schema_extra=_SCHEMA)

    expected: ClassVar[str] = "send an object with geometry, and l1 for a slice"
    kinds: ClassVar[Sequence[Kind]] = (plots.KIND,)
    examples: ClassVar[Examples] = {
        "slice": ("The article's figure 4", {"l1": 27}),
        "census": ("The number of cusps against L1", {"plot": "census"}),
        "mechanism": (
            "A pose of three leg lengths",
            {"plot": "mechanism", "l1": 14.98, "l2": 16, "l3": 20, "pose": 2},
        ),
    }

    plot: Literal["slice", "torus", "census", "locus", "loop", "mechanism"] = Field(
        "slice",
        description="What is drawn: a slice in the plane of the free legs, the same on the torus of the "
        "angles, the number of cusps against the length of the fixed leg, the curves of cusps in joint "
        "space, a loop round a cusp in motion, or the mechanism at a pose.",
    )
    theme: Literal["auto", "light", "dark"] = Field(
        "auto", description="`auto` follows the reader's setting, light or dark."
    )
    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length is fixed in a slice.")
    l1: OneLength = Field(default=None, description="The length of leg 1.")
    l2: OneLength = Field(default=None, description="The length of leg 2.")
    l3: OneLength = Field(default=None, description="The length of leg 3.")
    range: Range = range_field()
    cusp: Annotated[int, PlainValidator(cusp_number, json_schema_input_type=cusp_schema)] = Field(
        default=1,
        description="The cusp: its number, from 1, in the cusp table of the slice, or its letter.",
    )
    pose: Annotated[
        int, PlainValidator(_pose, json_schema_input_type=Annotated[int, Field(ge=1, le=MOST_POSES)])
    ] = Field(default=1, description="The number of the pose, from 1, in the answer of /v1/poses.")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        problems = list(self._problems())
        if problems:
            raise InputError(problems)
        return self

    def _problems(self) -> Iterator[FieldProblem]:
        given = self.model_fields_set
        own = f"l{self.fixed_leg}"
        if self.plot in _ALL_SLICES:
            needed: tuple[str, ...] = ()
            useless: tuple[str, ...] = (*LEGS, "cusp", "pose")
        elif self._has_legs:
            needed, useless = LEGS, ("range",)
        else:
            needed = (own,)
            others = [leg for leg in LEGS if leg != own]
            useless = (*others, "range", "pose", *(() if self.plot in _WITH_CUSP else ("cusp",)))
        for name in needed:
            if name not in given:
                yield FieldProblem(name, "is missing; give a number")
        for name in useless:
            if name in given:
                yield FieldProblem(name, f"says nothing about the plot {self.plot!r}; leave it out")

    @property
    def _has_legs(self) -> bool:
        return self.plot == "mechanism" and "cusp" not in self.model_fields_set

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        head = {
            "geometry": self.geometry.to_json(),
            "plot": self.plot,
            "theme": self.theme,
            "fixed_leg": 1 if self._has_legs else self.fixed_leg,
            "digits": plots.DIGITS,
        }
        if self.plot in _ALL_SLICES:
            return {**head, "range": self.model_dump(include={"range"})["range"]}
        if self._has_legs:
            lengths = {leg: exact_str(getattr(self, leg)) for leg in LEGS}
            return {**head, **lengths, "pose": self.pose}
        cusp = {"cusp": self.cusp} if self.plot in _WITH_CUSP else {}
        return {**head, "length": exact_str(getattr(self, f"l{self.fixed_leg}")), **cusp}

    def _asked(self) -> dict[str, Any]:
        content = self.content()
        del content["digits"]
        length = {f"l{self.fixed_leg}": content.pop("length")} if "length" in content else {}
        return {**length, **content}


class Plot(DocumentHead):
    """A picture."""

    plot: str = Field(description="What is drawn.")
    theme: str
    title: str = Field(description="What it shows, in a line.")
    description: str = Field(description="What is in it, in sentences, for those who do not see it.")
    width: float = Field(description="In pixels, as the height.")
    height: float
    svg: str = Field(description="The picture as an SVG document.")
