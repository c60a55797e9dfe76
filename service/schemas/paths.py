"""Paths without a singularity: the question, with the members that it is asked by.

The answer is in motions.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import ConfigDict, Field, PlainValidator, TypeAdapter, ValidationInfo, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import FIXED_LEGS, LEAST_SAMPLES, LEGS, MOST_POSES, MOST_SAMPLES, PATH_DIGITS
from rpr_solver.errors import FieldProblem, InputError, clipped
from service.schemas.answers import CSV, JSON, JSON_FORM, NDJSON, Forms, csv_form
from service.schemas.conditions import LengthScale, MostCondition, condition_member, scale_field
from service.schemas.document import Document, Source, given, json_kind, named, part
from service.schemas.geometry import points_member
from service.schemas.lengths import NEEDED, JointLimits, OneSlice, SlicesOfOneLeg, limits_member
from service.schemas.limits import DEFERRED
from service.schemas.motions import SAMPLES_FORM, AskedMotion, AskedSampling, Path, problems_of_sampling
from service.schemas.numbers import (
    CuspNumber,
    Digits,
    Exact,
    FixedLeg,
    Flag,
    Length,
    PoseNumber,
    cusp_field,
    digits_field,
    exact_number,
    fixed_leg_field,
    positive,
    whole_from,
)
from worker.answers.paths import PATH, USUAL

BEST = "best"


class Between(Document):
    """The lengths between which the fixed leg may vary."""

    expected: ClassVar[str] = 'give an object with "from" and "to"'

    start: Length = Field(alias="from", description="The lower end.")
    stop: Length = Field(alias="to", description="The upper end.")


Duration = Annotated[Fraction, positive("a duration must be > 0", Length)]
"""The time of a motion."""


def _clearance(value: object, info: ValidationInfo) -> str | None:
    if value is None or value == BEST:
        return None if value is None else BEST
    expected = f"give {BEST!r} or a number of degrees > 0"
    if isinstance(value, str) and value.strip().isalpha():
        raise InputError.of("", f"is {clipped(value)!r}; {expected}")
    clearance = exact_number(value, info)
    if clearance <= 0:
        raise InputError.of("", f"is {exact_str(clearance)}; {expected}")
    return exact_str(clearance)


AskedClearance = Annotated[
    str | None, PlainValidator(_clearance, json_schema_input_type=Literal["best"] | Length)
]
"""How far a path must keep from singular poses, in canonical form."""


class AskedJoints(Document):
    """A joint vector."""

    expected: ClassVar[str] = "give an object with l1, l2 and l3"

    l1: Length = Field(description="The length of leg 1.")
    l2: Length = Field(description="The length of leg 2.")
    l3: Length = Field(description="The length of leg 3.")


class NumberedPose(AskedJoints):
    """A pose of a joint vector."""

    expected: ClassVar[str] = "give an object with l1, l2, l3 and pose"

    pose: PoseNumber = Field(description="Its number, from 1, in the answer of /v1/poses.")


class AngledPose(Document):
    """A pose given by the orientation of the platform, the angle of the fixed leg and its length; exact."""

    expected: ClassVar[str] = "give an object with alpha_deg, theta1_deg and l1"

    alpha_deg: Exact = Field(description="The orientation of the platform, in degrees.")
    theta1_deg: Exact = given("The angle of leg 1, in degrees. With `fixed_leg` 2 or 3 use its own.")
    theta2_deg: Exact = given("The angle of leg 2, with `fixed_leg` 2.")
    theta3_deg: Exact = given("The angle of leg 3, with `fixed_leg` 3.")
    l1: Length = given("The length of leg 1.")
    l2: Length = given("The length of leg 2, with `fixed_leg` 2.")
    l3: Length = given("The length of leg 3, with `fixed_leg` 3.")

    def check(self, leg: int) -> None:
        """Checks that the angle and the length are those of the fixed leg, and not of others.

        Raises:
            InputError: naming the member at fault.
        """
        for number in FIXED_LEGS:
            for name in (f"theta{number}_deg", f"l{number}"):
                has = getattr(self, name) is not None
                if number == leg and not has:
                    raise InputError.of(name, f"is missing; {leg} is the fixed leg")
                if number != leg and has:
                    raise InputError.of(name, f"is given, but the fixed leg is {leg}")


AskedPose: TypeAlias = NumberedPose | AngledPose
_POSE: TypeAdapter[int] = TypeAdapter(PoseNumber, config=DEFERRED)
_FORMS = "the number of a pose, an object with l1, l2, l3 and pose, or one with alpha_deg, theta1_deg and l1"


def _end(value: object, info: ValidationInfo) -> int | AskedPose:
    """Reads a pose: its number among those of the joint vector of the question, or an object."""
    if isinstance(value, NumberedPose | AngledPose):
        return value
    if isinstance(value, Mapping) and set(value) == {"pose"}:
        value = value["pose"]
    if isinstance(value, Mapping):
        is_angled = any(name.startswith(("alpha", "theta")) for name in value)
        if is_angled:
            return part(AngledPose.model_validate, value, Source.of(info))
        return part(NumberedPose.model_validate, value, Source.of(info))
    if not isinstance(value, int | str):
        raise InputError.of("", f"is {json_kind(value)}; give {_FORMS}")
    return part(_POSE.validate_python, value, Source.of(info))


EndOfPath = Annotated[
    int | AskedPose,
    PlainValidator(
        _end, json_schema_input_type=Annotated[int, Field(ge=1, le=MOST_POSES)] | NumberedPose | AngledPose
    ),
]
"""A pose at an end of a path."""

POSES = ("from", "to")
"""The members that give the ends of a path."""

_BY_NUMBER: dict[str, Any] = {
    "if": {"anyOf": [{"type": "object", "properties": {name: {"type": "integer"}}} for name in POSES]},
    "then": {"required": [*LEGS]},
    "else": {"properties": dict.fromkeys(LEGS, False)},
}
LOOP_OR_POSES: dict[str, Any] = {
    "if": {"anyOf": [{"type": "object", "required": [name]} for name in POSES]},
    "then": {"required": [*POSES], "properties": {"cusp": False}, **_BY_NUMBER},
    "else": {**NEEDED, "properties": {"between": False}},
}
"""Of a schema: a loop, or a path from pose to pose."""


def is_of_poses(value: Mapping[str, Any]) -> bool:
    """Whether an object asks for a path from pose to pose."""
    return any(name in value for name in POSES)


def is_numbered(end: object) -> bool:
    """Whether a pose is given as one of the joint vector of the question."""
    return set(end) == {"pose"} if isinstance(end, Mapping) else not isinstance(end, AskedJoints | AngledPose)


def problems_of_poses(value: Mapping[str, Any]) -> Iterator[FieldProblem]:
    """What a path from pose to pose lacks: lengths, if a pose is given by its number, and none otherwise."""
    numbered = any(is_numbered(value[name]) for name in POSES if name in value)
    missing = [name for name in (*(LEGS if numbered else ()), *POSES) if name not in value]
    yield from (FieldProblem(name, "is missing; give a number") for name in missing)
    spare = [] if numbered else [name for name in LEGS if name in value]
    yield from (FieldProblem(name, "is for poses by number; leave it out") for name in spare)


class PathRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator, and the loop or the path that is requested. For a loop round a cusp give the slice and
    the `cusp`. The slice is the length of the fixed leg: `l1`, or `l2` with `fixed_leg` 2, or `l3` with
    `fixed_leg` 3, and neither of the other two. For a path from one pose to another of the same joint vector
    give `l1`, `l2` and `l3`, and the numbers of the poses as `from` and `to`. Either may also be a pose of
    another joint vector, or be given by its angles.

    A loop begins and ends at one joint vector, where the manipulator has two poses of one sign of J. The
    platform follows the legs continuously, is never singular, and arrives at the other pose. It is proved for
    the whole path, not only for its samples, that J keeps its sign, and that the loop turns once round the
    cusp, counter-clockwise, and round no other cusp of the slice. This is one way to change the assembly
    mode, not the only one.

    From pose to pose, the answer is a path in the slice or, with `between`, a path on which the fixed leg may
    vary; without it this leg stays fixed, or varies between its lengths at both poses. Or the answer is the
    reason why there is none: J has different signs at the two poses, or they belong to different aspects of
    the slice or of the range. In the latter case the answer has a range of the fixed leg within which they
    are joined.

    With `clearance`, the path is as far from singular poses as possible, or at least as far as requested, and
    this is proved.

    With `condition`, samples have the condition number of the Jacobian, and the answer bounds it, with proof,
    along the path; with `max_condition` it is proved to be nowhere greater.

    With `limits`, the path or the loop is proved to keep the joint limits. If there is no such path, this is
    proved by subdivision, or undecided at the reported `resolution`.

    Samples are points of the path at equal intervals of time, or in chords of a bounded deviation
    (`sampling`), with the legs, the pose, the determinant and the clearance. With `motion` the times keep
    limits of the speed, acceleration and jerk of each leg, which is proved for the whole path.

    A worker finds a path in a fraction of a second.

    Attributes:
        l1: The length of leg 1. For a loop with `fixed_leg` 2 or 3 use `l2` or `l3`.
        l2: The length of leg 2: for a loop, with `fixed_leg` 2.
        l3: The length of leg 3: for a loop, with `fixed_leg` 3.
        start: The pose at the start: its number, from 1, in the answer of /v1/poses for `l1`, `l2` and `l3`;
            or a pose of other leg lengths; or its angles and the length of the fixed leg.
        stop: The pose at the end, likewise.
        between: Lengths between which the fixed leg may vary; without them it stays fixed.
        limits: Joint limits that the path keeps, of any legs: `min` and `max`, either of which may be
            missing.
        clearance: How far the path must keep from singular poses, in degrees of α and the fixed leg's angle;
            or `best`, for as far as possible. Where the fixed leg varies, those of its length at each pose
            count.
        condition: Whether condition numbers are wanted: of each sample, and bounds of them along the path.
        max_condition: The greatest condition number that a pose of the path may have; at least 1.
        samples: The number of samples, the ends included.
        timing: The time profile of the arc length in joint space. The speed follows half a sine wave
            (`cosine`), rises, stays and falls for a third of the time each (`trapezoid`), or is constant.
        others: Whether the other poses of the joint vector are followed, too, until the fold at which they
            vanish.
        duration: The time of the last sample; > 0.
        motion: Limits of the speed and the acceleration of the legs, and perhaps of their jerk, from which
            the times follow, instead of `timing` and `duration`. The legs rest where the path has corners.
        sampling: Samples by number, by steps of time, or by chords, instead of `samples`.
    """

    model_config = ConfigDict(json_schema_extra=LOOP_OR_POSES)

    expected = "send an object with geometry and l1"
    kinds = (PATH,)
    path = "/v1/paths"
    tag = "paths"
    summary = "A motion from one pose to another, without a singularity"
    answer = Path
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("path_csv", "sample"), NDJSON: SAMPLES_FORM}
    needs_slices = True
    hint_of_slices = "give a number"

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = given()
    l2: Length = given()
    l3: Length = given()
    start: EndOfPath = given(alias="from")
    stop: EndOfPath = given(alias="to")
    between: Between = given()
    limits: JointLimits = given()
    clearance: AskedClearance = given()
    condition: Flag = False
    length_scale: LengthScale = scale_field()
    max_condition: MostCondition = given()
    cusp: CuspNumber = cusp_field()
    samples: Annotated[int, whole_from(LEAST_SAMPLES, MOST_SAMPLES)] = USUAL["samples"]
    timing: Literal["cosine", "trapezoid", "constant"] = USUAL["timing"]
    others: Flag = USUAL["others"]
    duration: Duration = Fraction(USUAL["duration"])
    motion: AskedMotion = given()
    sampling: AskedSampling = given()
    digits: Digits = digits_field(PATH_DIGITS)

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        return cls._names() if is_of_poses(value) else super()._members(value)

    @classmethod
    def _hint(cls, name: str, known: Sequence[str]) -> str:
        also = "; for a path from pose to pose give from and to" if name in LEGS else ""
        return super()._hint(name, known) + also

    @classmethod
    def _problems_of_members(cls, value: Mapping[str, Any], known: Sequence[str]) -> Iterator[FieldProblem]:
        yield from problems_of_sampling(value)
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
        limits_member(self.limits, held=self.fixed_leg)
        condition_member(self)
        for name, end in zip(POSES, (self.start, self.stop), strict=True):
            if isinstance(end, AngledPose):
                with named(name):
                    end.check(self.fixed_leg)
        if self.others and self.start is not None and LEGS[0] not in self._ends():
            raise InputError.of("others", "are followed on paths that come back to their leg lengths")
        return self

    def _ends(self) -> dict[str, Any]:
        """The canonical form of both poses: by their numbers, if they have one joint vector."""
        own = self.model_dump(include={*LEGS}, exclude_none=True)
        first, last = (
            {**own, "pose": end} if isinstance(end, int) else end.model_dump(exclude_none=True)
            for end in (self.start, self.stop)
        )
        if "pose" in first and "pose" in last and all(first[leg] == last[leg] for leg in LEGS):
            return {**{leg: first[leg] for leg in LEGS}, "from": first["pose"], "to": last["pose"]}
        return {"from": first, "to": last}

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        if self.start is None:
            own = {**self._of_slice(), "cusp": self.cusp}
        else:
            between = self.between and self.between.model_dump()
            head = {"geometry": self.geometry.to_json(), "fixed_leg": self.fixed_leg}
            own = {**head, **self._ends(), "between": between}
        return {
            **own,
            **limits_member(self.limits, held=self.fixed_leg),
            **({} if self.clearance is None else {"clearance": self.clearance}),
            **condition_member(self),
            **({"samples": self.samples} if self.sampling is None else self.sampling.content()),
            **self._times(),
            "others": self.others,
            "digits": self.digits,
            **points_member(self.geometry),
        }

    def _times(self) -> dict[str, Any]:
        """The canonical form of the law of time."""
        if self.motion is not None:
            return {"motion": self.motion.limits().to_json()}
        return {"timing": self.timing, "duration": exact_str(self.duration)}
