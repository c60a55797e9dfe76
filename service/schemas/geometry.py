"""The geometry of a question: how a body describes it, and the manipulator that is read from it.

The library reads all spellings; the models are what the contract says of them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PlainSerializer, PlainValidator, RootModel, ValidationInfo

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.contract import LENGTHS
from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.numerals import digit_count
from rpr_solver.triangles.surds import SQUARE
from service.schemas.answers import TrianglesText, optional
from service.schemas.document import Expected, Source, at, json_kind, together, unnamed
from service.schemas.limits import DEFERRED, LimitError, Limits, Model
from service.schemas.numbers import PositiveRoot, Root, Side

_CLOSED = ConfigDict(extra="forbid")
_EXPECTED = (
    'give an object with base and platform, such as {"base": {"points": [[0, 0], [10, 0], [5, 8]]}, '
    f'"platform": {{"sides": [3, 4, 5]}}}}, or with {", ".join(LENGTHS)}'
)
_NOTES = {
    "name": "The name of the manipulator. It is not part of its identity.",
    "unit": "The unit of its lengths, for readers; nothing is converted.",
}
_LISTED = 20
"""The most problems of a geometry that are told."""


def _with_notes(schema: dict[str, Any]) -> None:
    schema["properties"] |= {name: {"type": "string", "description": text} for name, text in _NOTES.items()}


_NOTED = ConfigDict(extra="forbid", json_schema_extra=_with_notes)


class SixNumbers(Model):
    """A planar 3-RPR manipulator in the frame of the article: base points A1 = (0, 0), A2 = (a2x, 0),
    A3 = (a3x, a3y), and a platform B1B2B3 with sides d1 = |B1B2|, d2 = |B2B3|, d3 = |B3B1|. All lengths in
    one unit of your choice.

    Attributes:
        a2x: x of the base point A2; > 0 if a number is irrational. If it is 0, A1 and A2 are one point, and
            the x-axis leads through A3.
        a3x: x of the base point A3.
        a3y: y of the base point A3; negative for a clockwise base.
        d1: |B1B2|, a side of the platform; 0 if legs 1 and 2 share their joint.
        d2: |B2B3|, a side of the platform; 0 if legs 2 and 3 share their joint.
        d3: |B3B1|, a side of the platform; 0 if legs 3 and 1 share their joint.
        orientation: Whether B1, B2, B3 run counter-clockwise or clockwise.
    """

    model_config = _NOTED

    a2x: Root
    a3x: Root
    a3y: Root
    d1: Side
    d2: Side
    d3: Side
    orientation: Literal["ccw", "cw"] = "ccw"


class TriangleBySides(Model):
    """A triangle by its sides.

    Attributes:
        sides: The sides between the corners 1 and 2, 2 and 3, 3 and 1. One may be 0, where legs share a
            joint.
    """

    model_config = _CLOSED

    sides: list[Side] = Field(min_length=3, max_length=3, examples=[[3, 4, 5], ["sqrt(2)", 1, 1]])


class TriangleByPoints(Model):
    """A triangle by its corners, in any frame: that of the drawing, or of the hand.

    Attributes:
        points: The corners 1, 2 and 3, each as [x, y]. The squares of the three sides must be rational.
    """

    model_config = _CLOSED

    points: list[Annotated[list[Root], Field(min_length=2, max_length=2)]] = Field(
        min_length=3, max_length=3, examples=[[[1, 2], [4, 6], [1, 10]], [[0, 0], [10, 0], [5, "5*sqrt(3)"]]]
    )


class EquilateralTriangle(Model):
    """An equilateral triangle by its side.

    Attributes:
        equilateral: The length of each side.
    """

    model_config = _CLOSED

    equilateral: PositiveRoot


class TriangleInCircle(Model):
    """An equilateral triangle by the circle through its corners.

    Attributes:
        circumradius: The radius of the circle.
    """

    model_config = _CLOSED

    circumradius: PositiveRoot


class Triangle(RootModel[TriangleBySides | TriangleByPoints | EquilateralTriangle | TriangleInCircle]):
    """A triangle, in one of four spellings. Given by points it has their sense; otherwise it is
    counter-clockwise."""

    model_config = DEFERRED


class TwoTriangles(Model):
    """A planar 3-RPR manipulator by its base A1A2A3 and its platform B1B2B3, each a triangle in a spelling of
    its own. All lengths in one unit of your choice.

    Attributes:
        base: The base A1A2A3.
        platform: The platform B1B2B3.
        orientation: Of a platform that is not given by points: whether B1, B2, B3 run counter-clockwise or
            clockwise.
    """

    model_config = _NOTED

    base: Triangle
    platform: Triangle
    orientation: Literal["ccw", "cw"] | None = optional()


class Geometry(RootModel[SixNumbers | TwoTriangles | TrianglesText]):
    """A planar 3-RPR manipulator: its base and its platform as two triangles, or six numbers in the frame of
    the article, or the `geometry` of an answer. All spellings of one manipulator are one geometry with one
    hash; answers have its canonical form."""

    model_config = ConfigDict(
        defer_build=True,
        json_schema_extra={
            "examples": [
                {
                    "base": {"points": [[0, 0], [10, 0], [5, "5*sqrt(3)"]]},
                    "platform": {"circumradius": "sqrt(3)"},
                },
                {"base": {"equilateral": 10}, "platform": {"sides": [3, 4, 5]}, "orientation": "cw"},
                {"a2x": 15.91, "a3x": 0, "a3y": 10, "d1": 17.04, "d2": 16.54, "d3": 20.84},
            ]
        },
    )


def schema_of_geometry(address: str) -> dict[str, Any]:
    """Returns the JSON Schema of a file with a geometry, which may name that schema."""
    schema = Geometry.model_json_schema()
    for model in (SixNumbers, TwoTriangles, TrianglesText):
        properties = schema["$defs"][model.__name__]["properties"]
        schema["$defs"][model.__name__]["properties"] = {"$schema": {"type": "string"}, **properties}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": address, **schema}


def _manipulator(value: object, info: ValidationInfo) -> Manipulator:
    if isinstance(value, Manipulator):
        return value
    if isinstance(value, str) and value in EXAMPLES:
        lengths = json.dumps(EXAMPLES[value].to_json())
        raise InputError.of("", f"is {value!r}, a name of the command line; here give its lengths: {lengths}")
    if not isinstance(value, Mapping):
        raise InputError.of("", f"is {json_kind(value)}; {_EXPECTED}")
    limits = Source.of(info).limits
    with unnamed("geometry"):
        try:
            return Manipulator.from_json(value, max_digits=limits.max_number_digits)
        except InputError as error:
            raise _in_words_of_json(error, value, limits) from None


def _in_words_of_json(error: InputError, geometry: Mapping[str, Any], limits: Limits) -> InputError:
    """The same error about JSON: with its words for values, and the limit that a number exceeds."""
    values = dict(_parts(geometry, "geometry"))
    errors: list[InputError] = []
    for problem in error.problems[:_LISTED]:
        value, message = values.get(problem.field, ""), problem.message
        field = problem.field.encode("utf-8", "backslashreplace").decode()
        if isinstance(value, str) and (digits := _digits_beyond(value, limits.max_number_digits)):
            errors.append(at(LimitError.of_digits(limits, digits), field))
            continue
        if not isinstance(value, str):
            message = _of_other_kind(message, value)
        errors.append(InputError([FieldProblem(field, message)]))
    return together(errors)


def _of_other_kind(message: str, value: object) -> str:
    """What is said of a value that is no text, with the name of its kind in JSON."""
    if message.endswith("not an exact number"):
        return f'is {json_kind(value)}; give a number such as 17.04, "17.04" or "5*sqrt(3)"'
    return message.replace(shown(value), json_kind(value), 1)


def _parts(value: object, place: str) -> Iterator[tuple[str, object]]:
    """A value and all values in it, by their places."""
    yield place, value
    if isinstance(value, Mapping):
        for name, member in value.items():
            yield from _parts(member, f"{place}.{name}")
    elif isinstance(value, list | tuple):
        for k, member in enumerate(value):
            yield from _parts(member, f"{place}[{k}]")


def _digits_beyond(text: str, most: int) -> int:
    """The digits of a number, or of one in a root, that has more than it may have; 0 if none has."""
    before, _, after = text.partition("sqrt(")
    under, _, over = after.partition(")")
    counts = [digit_count(before.rstrip("*")), digit_count(over.lstrip("/"))]
    return max((count for count in (*counts, digit_count(under) // SQUARE) if count > most), default=0)


def points_member(manipulator: Manipulator) -> dict[str, Any]:
    """The member of a canonical question with the points in whose frame poses are told; empty without."""
    geometry = manipulator.geometry
    given = {name: points for name in ("base", "platform") if (points := geometry.points_of(name))}
    return {"points": given} if given else {}


GeometryField = Annotated[
    Manipulator,
    PlainValidator(_manipulator, json_schema_input_type=Geometry),
    PlainSerializer(Manipulator.to_json),
    Expected(_EXPECTED),
]
"""A manipulator, read from its geometry."""
