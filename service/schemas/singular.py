"""Singular curves: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated, Any, ClassVar

from pydantic import ConfigDict, Field, PlainValidator, ValidationInfo

from rpr_solver import MIN_DIGITS, exact_str
from rpr_solver.contract import COARSEST_TOLERANCE, DEFAULT_TOLERANCE, FINEST_TOLERANCE
from rpr_solver.errors import InputError
from service.schemas.document import given
from service.schemas.lengths import NEEDED, OneSlice, SlicesOfOneLeg
from service.schemas.model import Model
from service.schemas.numbers import Digits, FixedLeg, Length, digits_field, exact_number, fixed_leg_field
from service.schemas.points import DocumentHead, FixedLength, Point, optional
from service.schemas.questions import Examples
from worker.answers.documents import SINGULAR_CURVES
from worker.answers.requests import Kind


def _tolerance(value: object, info: ValidationInfo) -> Fraction:
    tolerance = exact_number(value, info)
    if not FINEST_TOLERANCE <= tolerance <= COARSEST_TOLERANCE:
        expected = f"{exact_str(FINEST_TOLERANCE)} to {exact_str(COARSEST_TOLERANCE)}"
        raise InputError.of("", f"is {exact_str(tolerance)}; give {expected}")
    return tolerance


class SingularCurvesRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator and a slice.

    The slice is the length of the fixed leg: give `l1`, or `l2` with `fixed_leg` 2, or `l3` with `fixed_leg`
    3, and neither of the other two.
    """

    model_config = ConfigDict(json_schema_extra=NEEDED)

    expected: ClassVar[str] = "send an object with geometry and l1"
    kinds: ClassVar[Sequence[Kind]] = (SINGULAR_CURVES,)
    needs_slices: ClassVar[bool] = True
    hint_of_slices: ClassVar[str] = "give a number"
    examples: ClassVar[Examples] = {
        "slice": ("The article's first manipulator at L1 = 14.98", {"l1": 14.98}),
        "fine": ("The same, drawn ten times as finely", {"l1": 14.98, "tolerance": "0.0001"}),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = given("The length of leg 1. With `fixed_leg` 2 or 3 use `l2` or `l3`.")
    l2: Length = given("The length, with `fixed_leg` 2.")
    l3: Length = given("The length, with `fixed_leg` 3.")
    tolerance: Annotated[Fraction, PlainValidator(_tolerance, json_schema_input_type=Length)] = Field(
        default=DEFAULT_TOLERANCE,
        description="How far a drawn curve may be from the true one, relative to the size of the picture, in "
        "the plane of the angles and in that of the free legs; 0.000001 to 0.1.",
    )
    digits: Digits = digits_field(MIN_DIGITS)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return {
            "geometry": self.geometry.to_json(),
            "fixed_leg": self.fixed_leg,
            "length": exact_str(self.length),
            "tolerance": exact_str(self.tolerance),
            "digits": self.digits,
        }


class Samples(Model):
    """Points in columns: numbers in double precision, for drawing."""

    alpha_deg: list[float] | None = optional("The orientation of the platform.")
    theta1_deg: list[float] | None = optional("The angle of leg 1, with `fixed_leg` 1.")
    theta2_deg: list[float] | None = optional("The angle of leg 2, with `fixed_leg` 2.")
    theta3_deg: list[float] | None = optional("The angle of leg 3, with `fixed_leg` 3.")
    l1: list[float] | None = optional("The length of leg 1, if it is free.")
    l2: list[float] | None = optional("The length of leg 2, if it is free.")
    l3: list[float] | None = optional("The length of leg 3, if it is free.")


class Turns(Model):
    """The full turns of the angles along a closed strand."""

    alpha: int
    theta1: int | None = optional("With `fixed_leg` 1.")
    theta2: int | None = optional("With `fixed_leg` 2.")
    theta3: int | None = optional("With `fixed_leg` 3.")


class Vertex(Point):
    """A special point of the singular curves, with proved digits."""

    index: int = Field(description="The number of its sample in the strand, from 0.")
    kind: str = Field(
        description="`cusp`; `turning`, an extremum of the fixed leg's angle along the curve; `closed-leg`, "
        "a free leg of length 0; or the kind of a degenerate pose, such as `node` or `isolated-point`."
    )
    cusp: int | None = optional("The number of a cusp, from 1, in the cusp table of the slice.")


class Strand(Samples):
    """A closed curve, or a piece of one from node to node. J > 0 lies on its left in the plane of α and θ.

    Its angles are continuous, beyond ±180 degrees. The last sample of a closed strand is the first one again,
    ahead by `turns`.
    """

    closed: bool
    turns: Turns
    vertices: list[Vertex]


class SingularComponent(Model):
    """A connected component of the singular curves: one closed strand, or several that meet in nodes."""

    strands: list[Strand]


class RegionPoint(Model):
    """A joint vector: the exact lengths of the free legs, decimals or quotients p/q."""

    l1: str | None = optional("Length of leg 1, if it is free.")
    l2: str | None = optional("Length of leg 2, if it is free.")
    l3: str | None = optional("Length of leg 3, if it is free.")


class Region(Model):
    """A region of the plane of the free legs, in which the number of poses is constant."""

    poses: int = Field(description="The number of real poses at each of its points, half of them with J > 0.")
    bounded: bool
    point: RegionPoint = Field(description="A point of the region, at which the number is proved.")
    rings: list[Samples] = Field(
        description="Closed polylines of the free legs' lengths: its outer boundary first, then its holes; "
        "the unbounded region has only holes."
    )


class Aspect(Model):
    """A connected region of the torus of α and θ on which J has one sign."""

    sign: int
    share: float = Field(description="The part of the torus that it covers, about.")
    polygons: list[Samples] = Field(
        description="Polygons of α and θ in degrees, from −180 to 180, that together cover the aspect."
    )


class SingularCurves(DocumentHead, FixedLength):
    """The singular curves of a slice: components, regions and aspects."""

    tolerance: str = Field(description="Exact, as asked.")
    components: list[SingularComponent]
    regions: list[Region] = Field(description="By falling number of poses, then by falling area.")
    thin_regions: int = Field(
        description="The number of faces of the drawing that are too thin, for the tolerance, to be regions "
        "by proof."
    )
    aspects: list[Aspect] = Field(
        description="Those with J > 0 first, then by falling size. Their number is proved."
    )
