"""What several kinds of answers are made of."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Decimal = str
"""A decimal with as many significant digits as were asked for."""


def _without_null(schema: dict[str, Any]) -> None:
    """Say that a field may be missing; it is never null."""
    del schema["default"]
    [given] = [part for part in schema.pop("anyOf") if part != {"type": "null"}]
    schema.update({key: value for key, value in given.items() if key not in schema})


def optional(description: str) -> Any:
    """A field that may be missing."""
    return Field(default=None, description=description, json_schema_extra=_without_null)


class GeometryText(BaseModel):
    """The geometry in its canonical form: each number as a plain decimal, or as p/q when that does not
    end."""

    model_config = ConfigDict(extra="forbid")

    a2x: str
    a3x: str
    a3y: str
    d1: str
    d2: str
    d3: str
    orientation: Literal["ccw", "cw"]


class Point(BaseModel):
    """A point of a slice. The angle is that of the fixed leg, the lengths are those of the other two:
    theta1_deg, l2, l3 with `fixed_leg` 1."""

    alpha_deg: Decimal | None = optional("Orientation of the platform, degrees in (−180, 180].")
    theta1_deg: Decimal | None = optional("Angle of leg 1, degrees in (−180, 180].")
    theta2_deg: Decimal | None = optional("Angle of leg 2, when it is the fixed one.")
    theta3_deg: Decimal | None = optional("Angle of leg 3, when it is the fixed one.")
    l1: Decimal | None = optional("Length of leg 1, in the unit of the geometry.")
    l2: Decimal | None = optional("Length of leg 2, in the unit of the geometry.")
    l3: Decimal | None = optional("Length of leg 3, in the unit of the geometry.")


class Cusp(Point):
    """One cusp of the slice."""


class TransitionEvent(Point):
    """A degenerate pose of a transition."""

    kind: str = Field(description="For example swallowtail, lips, beak-to-beak.")


class ClosedRange(BaseModel):
    """The range that was asked for."""

    start: str = Field(alias="from")
    stop: str | None = Field(alias="to", description="null: without end.")


class Interval(ClosedRange):
    """An interval without transitions. All its slices have the same number of cusps."""

    count: int
