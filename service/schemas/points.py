"""Building blocks of several kinds of answers."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import ConfigDict, Field

from service.schemas.model import Model

Decimal = str
"""A decimal string with `digits` significant digits."""


def _without_null(schema: dict[str, Any]) -> None:
    """Describe a field that may be missing but is never null."""
    del schema["default"]
    [given] = [part for part in schema.pop("anyOf") if part != {"type": "null"}]
    schema.update({key: value for key, value in given.items() if key not in schema})


def optional(description: str) -> Any:
    """Returns a field that may be missing."""
    return Field(default=None, description=description, json_schema_extra=_without_null)


class GeometryText(Model):
    """The geometry in its canonical form: each number as a terminating decimal, otherwise as
    p/q."""

    model_config = ConfigDict(extra="forbid")

    a2x: str
    a3x: str
    a3y: str
    d1: str
    d2: str
    d3: str
    orientation: Literal["ccw", "cw"]


class Point(Model):
    """A point of a slice: the platform's orientation, the angle of the fixed leg and the lengths of the
    other two legs (theta1_deg, l2, l3 with `fixed_leg` 1)."""

    alpha_deg: Decimal | None = optional("Orientation of the platform, degrees in (−180, 180].")
    theta1_deg: Decimal | None = optional("Angle of leg 1, degrees in (−180, 180].")
    theta2_deg: Decimal | None = optional("Angle of leg 2, with `fixed_leg` 2.")
    theta3_deg: Decimal | None = optional("Angle of leg 3, with `fixed_leg` 3.")
    l1: Decimal | None = optional("Length of leg 1, in the unit of the geometry.")
    l2: Decimal | None = optional("Length of leg 2, in the unit of the geometry.")
    l3: Decimal | None = optional("Length of leg 3, in the unit of the geometry.")


class FixedLength(Model):
    """The length of the fixed leg."""

    l1: Decimal | None = optional("The fixed length, with `fixed_leg` 1.")
    l2: Decimal | None = optional("The fixed length, with `fixed_leg` 2.")
    l3: Decimal | None = optional("The fixed length, with `fixed_leg` 3.")


class Cusp(Point):
    """A cusp of the slice."""


class TransitionEvent(Point):
    """A degenerate pose at the length of a transition."""

    kind: str = Field(description="For example swallowtail, lips, beak-to-beak.")


class Degeneracy(Model):
    """Degenerate poses that every slice of an interval has, or a whole curve of degenerate poses."""

    kind: str = Field(
        description="The kind of the poses, such as `node` or `quadruple`; `curve` for a curve."
    )
    start: str = Field(alias="from", description="The lower end of the interval.")
    stop: str | None = Field(
        alias="to", description="Its upper end, null if it is open; equal to `from` for a single length."
    )
    count: int | None = optional("The number of such poses in each slice; missing for a curve.")
    equation: str | None = optional("The exact equation of a curve, unless it is at one irrational length.")


DEGENERATE: Any = Field(
    description="What is degenerate in every slice of an interval, or along a whole curve of poses of a "
    "slice, as for flat or congruent triangles: curves, then poses by interval. Mostly empty."
)
"""The field of documents over a range of lengths."""


class ClosedRange(Model):
    """The requested range."""

    start: str = Field(alias="from")
    stop: str | None = Field(alias="to", description="null: no upper end.")


class DocumentHead(Model):
    """The manipulator, the fixed leg and the precision of a document."""

    geometry: GeometryText
    geometry_hash: str
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str


class Interval(ClosedRange):
    """An interval without transitions; all its slices have the same number of cusps."""

    count: int
