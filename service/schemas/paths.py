"""Paths without a singularity: the question, and the answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import (
    LEAST_SAMPLES,
    MOST_SAMPLES,
    PATH_DIGITS,
)
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.model.lengths import Bounds, limits_json, read_limits
from service.schemas.answers import (
    CSV,
    JSON,
    JSON_FORM,
    ClosedRange,
    Decimal,
    DocumentHead,
    Forms,
    csv_form,
    optional,
)
from service.schemas.document import at, given
from service.schemas.ends import (
    LOOP_OR_POSES,
    POSES,
    AngledPose,
    Between,
    CuspNumber,
    Duration,
    EndOfPath,
    cusp_field,
    is_of_poses,
    problems_of_poses,
)
from service.schemas.lengths import LEGS, JointLimits, KeptLimits, OneSlice, SlicesOfOneLeg
from service.schemas.model import Model
from service.schemas.numbers import (
    Digits,
    FixedLeg,
    Flag,
    Length,
    digits_field,
    fixed_leg_field,
    whole_from,
)
from service.schemas.questions import Examples
from worker.answers.paths import PATH, USUAL


class _Angles(Model):
    alpha_deg: Decimal
    theta1_deg: Decimal | None = None
    theta2_deg: Decimal | None = None
    theta3_deg: Decimal | None = None


class _Legs(Model):
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


class PoseOnPath(_Angles, _Numbered):
    """A pose at an end of the path; with its own lengths, if those of the other end are different."""

    l1: str | None = optional("Length of leg 1, exact, or correctly rounded if the pose was given by angles.")
    l2: str | None = optional("Length of leg 2.")
    l3: str | None = optional("Length of leg 3.")


class PathSample(_Angles, _Legs, _Timed):
    """A point of the path at its time. Angles are continuous along the path: they may leave (−180°, 180°]."""

    determinant: Decimal = Field(
        description="J / (L1 L2 L3), in the unit of the geometry: up to its sign, the determinant of the "
        "partial derivatives of L1, L2, L3 by the translation of the platform and its rotation in radians."
    )
    clearance_deg: Decimal = Field(
        description="A proved lower bound, of 6 digits, of the distance to the nearest singular pose with "
        "the same fixed length: α and the fixed leg's angle may both change by less than this, in degrees."
    )
    place: str = Field(
        description="Where on the arcs of `certificate`, exact: the number of the arc, from 0, plus its "
        "parameter τ."
    )


class FoldPoint(_Angles, _Legs):
    """A fold, where the pose meets another one and both vanish: a point of a singular curve."""


class OtherPose(Model):
    """Another pose of the joint vector, followed along the path."""

    start: PoseOnPath = Field(alias="from")
    stop: PoseOnPath | None = Field(alias="to", description="null if it vanishes before, or is not followed.")
    fold: FoldPoint | None = Field(
        description="Where it vanishes. If this and `to` are null, neither is decided."
    )


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


class PathCertificate(Model):
    """The proof of the path."""

    model_config = ConfigDict(extra="allow")

    arcs: list[list[Any]] = Field(
        description="The control points of the Bézier arcs of the path, exact; `from` and `to` are its ends."
    )
    turns: EndTurns
    pieces: int = Field(description="Number of pieces on each of which balls prove the sign of J.")
    least_determinant: Decimal = Field(description="A lower bound of the absolute value of the determinant.")
    working_bits: int


class PathResolution(Model):
    """The size of a box of poses, exact."""

    angle_deg: str = Field(description="Its width in α and in the fixed leg's angle.")
    length: str | None = Field(description="Its width in the fixed leg's length; null if that is held.")


class Path(DocumentHead):
    """A path without a singularity; or, from pose to pose, the reason why there is none, without samples."""

    l1: str | None = optional(
        "Length of leg 1 at both ends, exact; missing if `from` and `to` have lengths of their own."
    )
    l2: str | None = optional("Length of leg 2.")
    l3: str | None = optional("Length of leg 3.")
    connected: bool | None = Field(
        description="Whether there is a path, proved; null if neither a path nor an obstacle is proved."
    )
    obstacle: str | None = optional(
        "Why there is no path: `opposite-signs` of J at both poses, so that no path exists in any slices; "
        "`other-aspect` of the slice, or of the range between the lengths of `between`; `outside-limits`: "
        "a pose itself exceeds the joint limits; `separated-by-limits`: every path meets a "
        "singularity or exceeds a joint limit; or `undecided`: the singular curves at the ends of that "
        "range are not supported, or the poses within the limits are too narrowly connected for the "
        "`resolution`."
    )
    limits: KeptLimits | None = Field(
        default=None, description="The joint limits that the path keeps, proved; null if none were given."
    )
    resolution: PathResolution | None = Field(
        default=None,
        description="If joint limits separate the poses, or leave the answer undecided: the size of the "
        "smallest boxes of poses that were examined.",
    )
    between: ClosedRange | None = Field(
        default=None, description="The requested lengths between which the fixed leg was free."
    )
    connecting_range: ClosedRange | None = Field(
        default=None,
        description="With `other-aspect`: lengths of the fixed leg between which a path exists, found from "
        "the census; null if none was found.",
    )
    cusp: int | None = Field(default=None, description="The number of the cusp, from 1.")
    closed: bool | None = optional("Whether the leg lengths at the end are those at the start.")
    sign: int | None = optional("The sign of J along the path.")
    winding: int | None = Field(
        default=None,
        description="The number of counter-clockwise turns of the path round the cusp, in the plane of the "
        "other two legs.",
    )
    twins: list[int] | None = optional(
        "The numbers of the other cusps with the same joint vector, round which the loop goes as often, as "
        "for congruent triangles; missing if there are none."
    )
    start: PoseOnPath = Field(alias="from")
    stop: PoseOnPath = Field(alias="to")
    others: list[OtherPose] | None = Field(
        default=None,
        description="What happens to the other poses of the joint vector; null unless requested.",
    )
    duration: str | None = optional("The time of the last sample.")
    timing: str | None = optional("The time profile.")
    samples: list[PathSample]
    certificate: PathCertificate | None = optional("The proof of the path.")


class PathRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator, and the loop or the path that is requested.

    For a loop round a cusp give the slice and the `cusp`. The slice is the length of the fixed leg: `l1`, or
    `l2` with `fixed_leg` 2, or `l3` with `fixed_leg` 3, and neither of the other two. For a path from one
    pose to another of the same joint vector give `l1`, `l2` and `l3`, and the numbers of the poses as `from`
    and `to`. Either may also be a pose of another joint vector, or be given by its angles.
    """

    model_config = ConfigDict(json_schema_extra=LOOP_OR_POSES)

    expected = "send an object with geometry and l1"
    kinds = (PATH,)
    path = "/v1/paths"
    name = "post_path"
    tag = ("paths", "Motions without a singularity.")
    summary = "A motion from one pose to another, without a singularity"
    description = """\
A loop begins and ends at one joint vector, where the manipulator has two poses of one sign of J. The platform
follows the legs continuously, is never singular, and arrives at the other pose. It is proved for the whole
path, not only for its samples, that J keeps its sign, and that the loop turns once round the cusp,
counter-clockwise, and round no other cusp of the slice. This is one way to change the assembly mode, not the
only one.

From pose to pose, the answer is a path in the slice or, with `between`, a path on which the fixed leg may
vary; without it the fixed leg is held, or varies between its lengths at both poses. Or the answer is the
reason why there is none: J has different signs at the two poses, or they belong to different aspects of the
slice or of the range. In the latter case the answer has a range of the fixed leg within which
they are joined.

With `limits`, the path or the loop is proved to keep the joint limits. If there is no such path, this is
proved by subdivision, or undecided at the reported `resolution`.

Samples are points of the path at equal intervals of time, with the legs, the pose, the determinant and the
clearance. A worker finds a path in a fraction of a second, so the response waits for it, up to 10 seconds
unless `Prefer` says otherwise; after that it is 202 with a job.
"""
    answer = Path
    known = "The path."
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("path_csv", "sample")}
    implied_wait = 10
    needs_slices = True
    hint_of_slices = "give a number"
    examples: ClassVar[Examples] = {
        "loop": (
            "The article's first manipulator, round cusp B at L1 = 27",
            {"l1": 27, "cusp": "B", "samples": 5},
        ),
        "poses": (
            "From one pose to another, with leg 1 free between 27 and 30",
            {
                "l1": 27,
                "l2": "25.7",
                "l3": "9.2",
                "from": 2,
                "to": 4,
                "between": {"from": 27, "to": 30},
                "samples": 5,
            },
        ),
        "angles": (
            "From a pose of one joint vector to a pose given by its angles",
            {
                "from": {"l1": 27, "l2": 20, "l3": 20, "pose": 1},
                "to": {"alpha_deg": -40, "theta1_deg": 140, "l1": 28},
                "samples": 5,
            },
        ),
        "limits": (
            "A loop that keeps joint limits",
            {"l1": 27, "cusp": "B", "limits": {"l2": {"min": 8, "max": 20}, "l3": {"max": 18}}, "samples": 5},
        ),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = given("The length of leg 1. For a loop with `fixed_leg` 2 or 3 use `l2` or `l3`.")
    l2: Length = given("The length of leg 2: for a loop, with `fixed_leg` 2.")
    l3: Length = given("The length of leg 3: for a loop, with `fixed_leg` 3.")
    start: EndOfPath = given(
        "The pose at the start: its number, from 1, in the answer of /v1/poses for `l1`, `l2` and `l3`; or a "
        "pose of other leg lengths; or its angles and the length of the fixed leg.",
        alias="from",
    )
    stop: EndOfPath = given("The pose at the end, likewise.", alias="to")
    between: Between = given("Lengths between which the fixed leg may vary; without them it is held.")
    limits: JointLimits = given(
        "Joint limits that the path keeps, of any legs: `min` and `max`, either of which may be missing."
    )
    cusp: CuspNumber = cusp_field()
    samples: Annotated[int, whole_from(LEAST_SAMPLES, MOST_SAMPLES)] = Field(
        default=USUAL["samples"], description="The number of samples, the ends included."
    )
    timing: Literal["cosine", "trapezoid", "constant"] = Field(
        default=USUAL["timing"],
        description="The time profile of the arc length in joint space. The speed follows half a sine wave "
        "(`cosine`), rises, stays and falls for a third of the time each (`trapezoid`), or is constant.",
    )
    others: Flag = Field(
        default=USUAL["others"],
        description="Whether the other poses of the joint vector are followed, too, until the fold at "
        "which they vanish.",
    )
    duration: Duration = Field(
        default=Fraction(USUAL["duration"]), description="The time of the last sample; > 0."
    )
    digits: Digits = digits_field(PATH_DIGITS)

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        return cls._names() if is_of_poses(value) else super()._members(value)

    @classmethod
    def _problems_of_members(cls, value: Mapping[str, Any], known: Sequence[str]) -> Iterator[FieldProblem]:
        of_poses = is_of_poses(value)
        faults = super()._problems_of_members(value, known)
        # which lengths are needed depends on the poses
        yield from (fault for fault in faults if not (of_poses and fault.field in LEGS))
        if of_poses:
            yield from problems_of_poses(value)
            if "cusp" in value:
                yield FieldProblem("cusp", "is for a loop; leave it out, or from and to")
        elif "between" in value:
            yield FieldProblem("between", "is for a path from pose to pose; give from and to as well")

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        self._bounds()
        for name, end in zip(POSES, (self.start, self.stop), strict=True):
            if isinstance(end, AngledPose):
                try:
                    end.check(self.fixed_leg)
                except InputError as error:
                    raise at(error, name) from None
        if self.others and self.start is not None and LEGS[0] not in self._ends():
            raise InputError.of("others", "are followed on paths that come back to their leg lengths")
        return self

    def _ends(self) -> dict[str, Any]:
        """The canonical form of both poses: by their numbers, if they have one joint vector."""
        own = {leg: exact_str(x) for leg in LEGS if (x := getattr(self, leg)) is not None}
        first, last = (
            {**own, "pose": end} if isinstance(end, int) else end.content() for end in (self.start, self.stop)
        )
        if "pose" in first and "pose" in last and all(first[leg] == last[leg] for leg in LEGS):
            return {**{leg: first[leg] for leg in LEGS}, "from": first["pose"], "to": last["pose"]}
        return {"from": first, "to": last}

    def _bounds(self) -> dict[int, Bounds]:
        return {} if self.limits is None else read_limits(self.limits.bounds(), "limits")

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        own: dict[str, Any] = {"cusp": self.cusp}
        if self.start is None:
            own["length"] = exact_str(self.length)
        else:
            between = self.between and self.between.model_dump(by_alias=True)
            own = {**self._ends(), "between": between}
        return {
            "geometry": self.geometry.to_json(),
            "fixed_leg": self.fixed_leg,
            **own,
            **({"limits": limits_json(bounds)} if (bounds := self._bounds()) else {}),
            "samples": self.samples,
            "timing": self.timing,
            "duration": exact_str(self.duration),
            "others": self.others,
            "digits": self.digits,
        }

    def _asked(self) -> dict[str, Any]:
        return {name: value for name, value in super()._asked().items() if value is not None}
