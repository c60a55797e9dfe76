"""How a path is sampled, and how fast its legs may move: members of the question and of the answer; and the
other parts of answers about paths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Self, TypeAlias

from pydantic import ConfigDict, Field, model_validator

from rpr_solver.contract import LEAST_SAMPLES, MOST_SAMPLES
from rpr_solver.errors import FieldProblem
from rpr_solver.model.lengths import ROWS, MotionLimits, rows_of
from service.schemas.answers import ClosedRange, Decimal, DocumentHead, FixedLength, Form, compact, optional
from service.schemas.conditions import PathCondition
from service.schemas.document import Document, Expected, given, unnamed
from service.schemas.lengths import KeptLimits, number_or, numbers_of
from service.schemas.limits import Detail, Model
from service.schemas.numbers import Exact, whole_from


class LegNumbers(Document):
    """Numbers for some legs."""

    expected: ClassVar[str] = "give an object with some of l1, l2, l3"

    l1: Exact = given("Of leg 1.")
    l2: Exact = given("Of leg 2.")
    l3: Exact = given("Of leg 3.")


_Limit: TypeAlias = Annotated[
    Fraction | LegNumbers,
    number_or(LegNumbers),
    Expected("give a number > 0, or numbers for some of l1, l2, l3"),
]


class AskedMotion(Document):
    """Limits of all legs, each a number for all of them or an object with numbers by leg.

    Attributes:
        speed: The greatest speed of the legs; > 0.
        acceleration: The greatest acceleration of the legs; > 0.
        jerk: The greatest change of their acceleration in a unit of time; any if missing.
    """

    expected: ClassVar[str] = "give an object with speed and acceleration"

    speed: _Limit
    acceleration: _Limit
    jerk: _Limit | None = given()

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
        return MotionLimits.of({kind: numbers_of(limit) for kind, limit in self.given().items()})


class AskedSampling(Document):
    """By what the samples are chosen: one of these.

    Attributes:
        number: Their number, as `samples`.
        step: The time between them; the last one may come sooner. > 0
        chord: As many as are needed for legs that move linearly from sample to sample to deviate from the
            path by no more than this length. > 0
    """

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "maxProperties": 1})

    expected: ClassVar[str] = f"give an object with one of {', '.join(ROWS)}"

    number: Annotated[int | None, whole_from(LEAST_SAMPLES, MOST_SAMPLES)] = given()
    step: Exact | None = given()
    chord: Exact | None = given()

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        with unnamed("sampling"):
            rows_of(self.given())
        return self

    def content(self) -> dict[str, Any]:
        """The canonical form."""
        if self.number is not None:
            return {"samples": self.number}
        return {"sampling": self.model_dump(exclude_none=True)}


def problems_of_sampling(value: Mapping[str, Any]) -> Iterator[FieldProblem]:
    """Members that say the same twice."""
    spare = {"motion": ("timing", "duration"), "sampling": ("samples",)}
    for name, others in spare.items():
        if name in value:
            yield from (FieldProblem(x, f"follows from {name}; leave it out") for x in others if x in value)


class LegDecimals(Detail):
    """Numbers by leg, exact."""

    l1: str | None = None
    l2: str | None = None
    l3: str | None = None


class PathMotion(Detail):
    """The limits of motion that all legs keep at any time, proved.

    Attributes:
        stops: The times at which the legs rest on the way: where arcs of the path meet at an angle, and with
            `jerk` where any arcs meet, as their curvatures differ.
    """

    speed: LegDecimals
    acceleration: LegDecimals
    jerk: LegDecimals | None = None
    stops: list[str]


class PathSampling(Detail):
    """By what the samples were chosen."""

    step: str | None = None
    chord: str | None = None


class RunMotion(Model):
    """The law of time from rest to rest, on one arc or on some that meet smoothly (see mathematics.md).

    Attributes:
        shares: The shares of its arcs in the parameter of the run, exact.
        tick: The time of a tick, exact.
        speeds: In proportion to the speed of τ at the ends of ticks, before averaging.
        window: The number of ticks over which speeds are averaged; 1 without `jerk`.
    """

    shares: list[str]
    tick: str
    speeds: list[int]
    window: int


def samples_ndjson(document: Mapping[str, Any]) -> bytes:
    """Returns the samples of a path, one JSON object per line."""
    return b"".join(compact(sample).encode() + b"\n" for sample in document["samples"])


SAMPLES_FORM = Form(samples_ndjson, "One sample per line.")


class _Angles(Model):
    alpha_deg: Decimal
    theta1_deg: Decimal | None = None
    theta2_deg: Decimal | None = None
    theta3_deg: Decimal | None = None


class Legs(Model):
    """A joint vector."""

    l1: Decimal
    l2: Decimal
    l3: Decimal


class _Numbered(Model):
    pose: int | None = Field(
        description="The number of the pose, from 1, in the answer of /v1/poses; null for a pose that was "
        "given by its angles."
    )


class _Timed(Model):
    time: str = Field(description="Exact, from 0 to the duration.")


class PoseOnPath(Detail, _Angles, _Numbered):
    """A pose at an end of the path; with its own lengths, if those of the other end are different."""

    l1: str | None = optional("Length of leg 1, exact, or correctly rounded if the pose was given by angles.")
    l2: str | None = optional("Length of leg 2.")
    l3: str | None = optional("Length of leg 3.")


class PathSample(_Angles, Legs, _Timed):
    """A point of the path at its time. Angles are continuous along the path: they may leave (−180°, 180°].

    Attributes:
        determinant: J / (L1 L2 L3), in the unit of the geometry: up to its sign, the determinant of the
            partial derivatives of L1, L2, L3 by the translation of the platform and its rotation in radians.
        clearance_deg: A proved lower bound, of 6 digits, of the distance to the nearest singular pose with
            the same fixed length: α and the fixed leg's angle may both change by less than this, in degrees.
        condition: The condition number of the Jacobian; missing unless requested.
        place: Where on the arcs of `certificate`, exact: the number of the arc, from 0, plus its parameter τ.
        x: Where base or platform are given by points: x of the origin of the platform's frame in the frame of
            the base.
        y: y of this origin.
        phi_deg: The angle of the platform's frame in the frame of the base; it begins in (−180°, 180°].
    """

    determinant: Decimal
    clearance_deg: Decimal
    condition: Decimal | None = optional()
    place: str
    x: Decimal | None = optional()
    y: Decimal | None = optional()
    phi_deg: Decimal | None = optional()


class FoldPoint(_Angles, Legs):
    """A fold, where the pose meets another one and both vanish: a point of a singular curve."""


class OtherPose(Detail):
    """Another pose of the joint vector, followed along the path.

    Attributes:
        stop: null if it vanishes before, or is not followed.
        fold: Where it vanishes. If this and `to` are null, neither is decided.
    """

    start: PoseOnPath = Field(alias="from")
    stop: PoseOnPath | None = Field(alias="to")
    fold: FoldPoint | None


class PathTurns(Model):
    """Whole turns by which the angles on the arcs exceed those of a pose."""

    alpha: int
    theta1: int | None = None
    theta2: int | None = None
    theta3: int | None = None


class EndTurns(Model):
    """The turns of both ends of the path."""

    start: PathTurns = Field(alias="from", description="Always 0: the path begins in the turn (−180°, 180°].")
    stop: PathTurns = Field(alias="to")


class PathCertificate(Detail):
    """How the path runs, and what is proved of it.

    Attributes:
        arcs: The control points of the Bézier arcs of the path, exact; `from` and `to` are its ends.
        pieces: Number of pieces on each of which balls prove the sign of J.
        least_determinant: A lower bound of the absolute value of the determinant.
        motion: The laws of time, if limits of motion were requested.
    """

    model_config = ConfigDict(extra="allow")

    arcs: list[list[Any]]
    turns: EndTurns
    pieces: int
    least_determinant: Decimal
    motion: list[RunMotion] | None = optional()


class PathResolution(Detail):
    """The size of a box of poses, exact."""

    angle_deg: str = Field(description="Its width in α and in the fixed leg's angle.")
    length: str | None = Field(description="Its width in the fixed leg's length; null if that leg is fixed.")


class PathClearance(Detail):
    """How far the path keeps from all singular poses with the same fixed length.

    Attributes:
        asked: What was asked for: `best`, or a number of degrees.
        proved: From any pose of the path, α and the fixed leg's angle may change together (in the Euclidean
            norm) by less than this, in degrees, and no singular pose is met. Rounded down.
        bound: No path from or to these poses has a greater clearance, since an end is so near to a singular
            pose, proved; null if that is not proved, and for loops.
        legs: From any pose of the path, both free legs may change together (in the Euclidean norm) by less
            than this before a fold can be met.
        radius: The least radius of curvature of the path, in degrees; null if it is straight, or has a
            corner.
    """

    asked: str
    proved: Decimal
    bound: Decimal | None
    legs: Decimal
    radius: Decimal | None


class NearbyPose(Detail, _Angles, FixedLength):
    """A pose near which it stays undecided whether there is a path; six digits."""


class Path(DocumentHead):
    """A path without a singularity; or, from pose to pose, the reason why there is none, without samples.

    Attributes:
        l1: Length of leg 1 at both ends, exact; missing if `from` and `to` have lengths of their own.
        l2: Length of leg 2.
        l3: Length of leg 3.
        connected: Whether there is a path, proved; null if neither a path nor an obstacle is proved.
        obstacle: Why there is no path: `opposite-signs` of J at both poses, so that no path exists in any
            slices; `other-aspect` of the slice, or of the range between the lengths of `between`;
            `outside-limits`: a pose itself exceeds the joint limits; `separated-by-limits`: every path meets
            a singularity or exceeds a joint limit; `too-narrow`: no path has the clearance that is required;
            `ill-conditioned`: a pose itself has a greater condition number than is allowed; or `undecided`:
            the singular curves at the ends of that range are not supported, the poses within the limits are
            too narrowly connected for the `resolution`, or the path that was found has less clearance, or a
            greater condition number, than is required.
        limits: The joint limits that the path keeps, proved; null if none were given.
        resolution: If joint limits separate the poses, or leave the answer undecided: the size of the
            smallest boxes of poses that were examined.
        near_pose: Where joint limits leave the answer undecided: a pose near which the ways within them are
            too narrow for the `resolution`; or a pose at an end, if it is too near to what is not allowed.
        clearance: The clearance of the path, if it was asked for.
        condition: The condition numbers along the path, if they were asked for.
        between: The requested lengths between which the fixed leg was free.
        connecting_range: With `other-aspect`: lengths of the fixed leg between which a path exists, found
            from the census; null if none was found.
        cusp: The number of the cusp, from 1.
        closed: Whether the leg lengths at the end are those at the start.
        sign: The sign of J along the path.
        winding: The number of counter-clockwise turns of the path round the cusp, in the plane of the other
            two legs.
        twins: The numbers of the other cusps with the same joint vector, round which the loop goes as often,
            as for congruent triangles; missing if there are none.
        others: What happens to the other poses of the joint vector; null unless requested.
        duration: The time of the last sample.
        timing: The time profile; `motion` if it follows from limits.
        motion: The limits of motion that all legs keep; missing unless requested.
        sampling: By what the samples were chosen; missing if by number.
        deviation: Proved bounds, rounded up, of what legs that move linearly from sample to sample deviate
            from the path: with `motion` at the same time, else from a point of the path between the two
            samples. Missing unless `motion` or `sampling` was requested.
        certificate: How the path runs, and what is proved of it.
    """

    l1: str | None = optional()
    l2: str | None = optional()
    l3: str | None = optional()
    connected: bool | None
    obstacle: str | None = optional()
    limits: KeptLimits | None = None
    resolution: PathResolution | None = None
    near_pose: NearbyPose | None = optional()
    clearance: PathClearance | None = optional()
    condition: PathCondition | None = optional()
    between: ClosedRange | None = None
    connecting_range: ClosedRange | None = None
    cusp: int | None = None
    closed: bool | None = optional()
    sign: int | None = optional()
    winding: int | None = None
    twins: list[int] | None = optional()
    start: PoseOnPath = Field(alias="from")
    stop: PoseOnPath = Field(alias="to")
    others: list[OtherPose] | None = None
    duration: str | None = optional()
    timing: str | None = optional()
    motion: PathMotion | None = optional()
    sampling: PathSampling | None = optional()
    deviation: LegDecimals | None = optional()
    samples: list[PathSample]
    certificate: PathCertificate | None = optional()
