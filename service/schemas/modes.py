"""Assembly modes: the questions whether they can change and which poses are joined, and the answers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, ValidationInfo, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import PATH_DIGITS
from rpr_solver.exact.rationals import parse_positive
from rpr_solver.model.lengths import LengthRange
from service.schemas.answers import (
    JSON,
    JSON_FORM,
    PICTURE_FORM,
    SVG,
    ClosedRange,
    Decimal,
    DocumentHead,
    Forms,
    optional,
)
from service.schemas.document import Document, Source, given
from service.schemas.lengths import (
    OF_THE_FIXED_LEG,
    Changes,
    JointLimits,
    KeptLimits,
    OneSlice,
    SlicesOfOneLeg,
    Tolerance,
    changes_json,
    limits_member,
)
from service.schemas.limits import Detail, Model
from service.schemas.motions import Legs, NearbyPose, Path, PathResolution, PoseOnPath
from service.schemas.numbers import Digits, FixedLeg, Flag, Length, Positive, digits_field, fixed_leg_field
from service.schemas.paths import AskedJoints, Between
from service.schemas.questions import Question, check_one
from worker.answers.paths import CONNECTIONS, MODES


class ModeWitness(Detail, Legs):
    """Two poses of one joint vector, and the path that joins them."""

    start: int = Field(alias="from", description="The number of the first pose in the answer of /v1/poses.")
    stop: int = Field(alias="to", description="The number of the second pose.")
    path: Path = Field(description="The path, as /v1/paths gives it.")


class RegionPoint(Detail, Legs):
    """A joint vector, exact."""


class JoinedRegion(Detail):
    """A region of the plane of the free legs, with those of its poses that are in one aspect.

    Attributes:
        point: A joint vector in the region.
        poses: The number of its poses.
        joined: The numbers of its poses in /v1/poses, in groups: a path without a singularity joins the poses
            of one group, and none joins poses of different groups. null if the region is too narrow to
            decide.
    """

    point: RegionPoint
    poses: int
    joined: list[list[int]] | None


class ModeCertificate(Detail):
    """How the answer is proved.

    Attributes:
        method: `witness`: by the path. `regions`: the poses that keep the `clearance` are in regions, none
            of which holds two poses of one joint vector, by pairs of boxes. `folds`: by pairs of boxes of
            poses, none of which can hold folds of one joint vector. `similar`: base and platform are similar
            triangles of one sense, all aspects of which map one to one. `shared-joints`: so do those of
            machines whose legs share a joint. null if it is not proved.
        pairs: The number of pairs of boxes that were examined; null if there was no need.
    """

    method: Literal["witness", "folds", "regions", "similar", "shared-joints"] | None
    pairs: int | None


_BEST = (
    "If a clearance or a tolerance leaves it undecided: the greatest clearance of a path that was found to "
    "change the mode, in degrees."
)
_BOUND = "If a clearance leaves it undecided: one that no path keeps, by proof, in degrees, if one was found."


class ModeChange(Detail):
    """Whether the assembly mode can change without a singularity, as /v1/assembly-modes says."""

    change: Literal["possible", "impossible", "undecided"]
    witness: ModeWitness | None = Field(description="null unless it is possible.")
    reason: str | None = Field(description="Why it is undecided; null if it is not.")
    best_clearance: Decimal | None = optional(_BEST)
    clearance_bound: Decimal | None = optional(_BOUND)
    certificate: ModeCertificate


class AssemblyModes(DocumentHead):
    """Whether the assembly mode can change without a singularity.

    Attributes:
        asked: The slice (`l1`, `l2` or `l3`) or the `range`, the `limits`, and the `clearance` and the
            `tolerance` if they are asked for.
        change: Whether two poses of one joint vector are joined by a path without a singularity, in the
            slice, or while the fixed leg keeps the range, within the limits. `possible` and `impossible` are
            proved.
        witness: null unless a change is possible. Its path has its `clearance`.
        regions: The regions of the slice, or those of the slices at both ends of the range, with the poses
            that are joined in the slice or in the range. null with limits, if the range has no upper end, or
            if the singular curves are not supported.
        reason: Why it is undecided; null if it is not.
    """

    asked: dict[str, Any]
    change: Literal["possible", "impossible", "undecided"]
    witness: ModeWitness | None
    regions: list[JoinedRegion] | None
    reason: str | None
    best_clearance: Decimal | None = optional(_BEST)
    clearance_bound: Decimal | None = optional(_BOUND)
    certificate: ModeCertificate


class ModeRange(Document):
    """The lengths between which the fixed leg may vary, perhaps without an upper end.

    Attributes:
        start: The lower end.
        stop: The upper end; unbounded if missing or null.
    """

    expected: ClassVar[str] = 'give an object with "from" and "to"'

    start: Length = Field(alias="from")
    stop: Length | None = Field(default=None, alias="to")


class AssemblyModesRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator, a slice or a range of the fixed leg, and joint limits of the other legs.

    For a slice, or a range of lengths of the fixed leg, and joint limits of the others: whether some joint
    vector has two poses that a path without a singularity joins. If so, the answer has such a path, for
    example round a cusp. If not, it is proved that every aspect maps one to one; that there is no cusp does
    not prove it. The regions of the joint plane say which of their poses are joined.

    With `clearance` a path must keep that far from singular poses, and with `tolerance` every geometry
    within it must be able to follow one; or it is proved that none can. Else it is `undecided`, with the
    greatest clearance that was found.

    A worker takes a fraction of a second for a slice, and some seconds for a range.
    """

    model_config = ConfigDict(json_schema_extra=OF_THE_FIXED_LEG)

    expected = "send an object with geometry and one of l1 and range"
    kinds = (MODES,)
    path = "/v1/assembly-modes"
    tag = "assembly modes"
    summary = "Whether the assembly mode can change without a singularity"
    answer = AssemblyModes
    needs_slices = False

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length | None = given("The length of leg 1 in a slice. With `fixed_leg` 2 or 3 use `l2` or `l3`.")
    l2: Length | None = given("The length, with `fixed_leg` 2.")
    l3: Length | None = given("The length, with `fixed_leg` 3.")
    range: ModeRange | None = given("The lengths between which the fixed leg may vary, instead of a slice.")
    limits: JointLimits | None = given("Joint limits of the other legs, an end of which may be missing.")
    clearance: Positive | None = given(
        "How far all poses of a change must keep from singular poses, in degrees of α and the fixed leg's "
        "angle."
    )
    tolerance: Tolerance | None = given(
        "A change of all lengths of the geometry, or those of single lengths, the others being exact: the "
        "answer must hold for every geometry within it."
    )

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered, but not for neighbouring geometries."""
        return self.tolerance is None

    @model_validator(mode="after")
    def _is_one_question(self, info: ValidationInfo) -> Self:
        check_one({f"l{self.fixed_leg}": self.length, "range": self.range}, Source.of(info))
        if self.range is not None:
            LengthRange.of(self.range.start, self.range.stop, ("range.from", "range.to"))
        limits_member(self.limits, fixed_leg=self.fixed_leg)
        _check_clearance(self.clearance)
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        free = {} if self.range is None else {"range": self.range.model_dump()}
        limits = limits_member(self.limits, fixed_leg=self.fixed_leg)
        thresholds = _thresholds(self.clearance, self.tolerance)
        return {**self._of_slice(), **free, **limits, **thresholds, "digits": PATH_DIGITS}


class ConnectedPose(PoseOnPath):
    """A pose of one of the joint vectors; with its own lengths, if there are two.

    Attributes:
        sign: The sign of J; 0 for a singular pose, null for one too near a singularity.
    """

    sign: Literal[1, 0, -1] | None


class PartPose(NearbyPose):
    """A pose of a part, exact: α, the fixed leg's angle, and its length."""


class AllowedPart(Model):
    """A part of the allowed region; or several, if `is_one` is false.

    Attributes:
        sign: The sign of J.
        is_one: Whether it is proved to be one part, so that paths within it join all its poses.
        poses: The places in `poses`, from 1, of the poses in it.
        pose: A pose in it; null if it is not known to have one.
        near: If `is_one` is false: a pose near which it stays undecided.
    """

    sign: Literal[1, -1]
    is_one: bool
    poses: list[int]
    pose: PartPose | None
    near: NearbyPose | None = optional()


class AllowedRegion(Detail):
    """The poses with J ≠ 0, in the slice or in the range, that keep the joint limits: their parts.

    Attributes:
        count: The number of parts, proved; null if it is not.
        parts: Those with J > 0 first, then by falling size. No path within the limits and without a
            singularity leads from one to another.
        resolution: The size of the narrowest boxes that were examined.
    """

    count: int | None
    parts: list[AllowedPart]
    resolution: PathResolution


class UndecidedPair(Detail):
    """Two poses for which it stays undecided, and where."""

    poses: list[int] = Field(description="Their places in `poses`, from 1.")
    near: NearbyPose


class PathFound(Detail):
    """The widest path that was found between two poses."""

    poses: list[int] = Field(description="Their places in `poses`, from 1.")
    clearance: Decimal = Field(description="How far it keeps from singular poses, in degrees, proved.")


class PoseConnections(DocumentHead):
    """Which poses are joined by paths without a singularity.

    Attributes:
        l1: Length of leg 1, exact; missing if there are two joint vectors.
        l2: Length of leg 2.
        l3: Length of leg 3.
        between: The lengths between which the fixed leg was free; null if it stayed fixed.
        limits: The joint limits that the paths keep; null if none.
        poses: All poses of the joint vector in the order of /v1/poses, then those of `to`.
        groups: The places in `poses`, from 1, of poses that are joined with each other, proved. Poses of
            different groups are not joined, or it is undecided. Singular poses and those outside the limits
            are in none.
        matrix: For each pose a row, and in it for each pose whether a path joins the two, or why none does.
            The words are those of `obstacle` in /v1/paths; all but `undecided` are proved. `singular-pose`:
            one of both poses is singular.
        resolution: If joint limits separate poses, or leave them undecided: the size of the smallest boxes of
            poses that were examined.
        undecided: Pairs that joint limits leave undecided, with a pose near which they do; missing if there
            are none. Pairs that follow from others may be left out.
        allowed: The parts of the allowed region; missing unless requested.
        clearance: How far the paths keep from singular poses, in degrees; missing unless requested.
        tolerance: How much each length may be off; missing unless requested.
        paths: With a clearance or a tolerance: the clearances of the widest paths that were found.
    """

    l1: str | None = optional()
    l2: str | None = optional()
    l3: str | None = optional()
    between: ClosedRange | None
    limits: KeptLimits | None
    poses: list[ConnectedPose]
    groups: list[list[int]]
    matrix: list[
        list[
            Literal[
                "joined",
                "singular-pose",
                "outside-limits",
                "opposite-signs",
                "other-aspect",
                "separated-by-limits",
                "too-narrow",
                "undecided",
            ]
        ]
    ]
    resolution: PathResolution | None
    undecided: list[UndecidedPair] | None = optional()
    allowed: AllowedRegion | None = optional()
    clearance: str | None = optional()
    tolerance: dict[str, str] | None = optional()
    paths: list[PathFound] | None = optional()


class PoseConnectionsRequest(Question):
    """A manipulator, one joint vector or two, and what paths between their poses must keep.

    All pairs of poses at once: for each, whether a path without a singularity joins them, or the proved
    reason why none does, as `/v1/paths` gives it for one pair. The fixed leg keeps its length, or may vary in
    `between`; with two joint vectors it may vary between its lengths at both. With `limits` the paths keep
    joint limits. `groups` has the poses that are joined with each other. With `Accept: image/svg+xml` the
    matrix is drawn. With `clearance` poses are joined only by paths that keep this far from singular poses,
    and with `tolerance` only if this is so for every geometry within it.

    A worker takes a fraction of a second without limits, and some seconds with limits in a range.

    Attributes:
        l1: Length of leg 1; > 0.
        l2: Length of leg 2; > 0.
        l3: Length of leg 3; > 0.
        to: A second joint vector, whose poses are included.
        between: Lengths between which the fixed leg may vary; without them it stays fixed, or varies
            between its lengths at both joint vectors.
        limits: Joint limits that the paths keep, of any legs: `min` and `max`, either of which may be
            missing.
        parts: Whether the parts of the allowed region are counted, too, with the poses in each: of all poses
            with J ≠ 0, in the slice or in the range, that keep the limits.
        clearance: How far the paths must keep from singular poses, in degrees of α and the fixed leg's angle.
        tolerance: A change of all lengths of the geometry, or those of single lengths, the others being
            exact: the paths must exist for every geometry within it.
    """

    expected = "send an object with geometry, l1, l2 and l3"
    kinds = (CONNECTIONS,)
    path = "/v1/pose-connections"
    tag = "pose connections"
    summary = "Which poses of a joint vector, or of two, are joined by paths without a singularity"
    answer = PoseConnections
    forms: ClassVar[Forms] = {JSON: JSON_FORM, SVG: PICTURE_FORM}

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length
    l2: Length
    l3: Length
    to: AskedJoints = given()
    between: Between = given()
    limits: JointLimits = given()
    parts: Flag = False
    clearance: Positive | None = given()
    tolerance: Tolerance | None = given()
    digits: Digits = digits_field(PATH_DIGITS)

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        limits_member(self.limits, held=self.fixed_leg)
        _check_clearance(self.clearance)
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        content = self.model_dump(exclude={"limits", "clearance", "tolerance"}, exclude_none=True)
        if not self.parts:
            del content["parts"]
        thresholds = _thresholds(self.clearance, self.tolerance)
        return {**content, **limits_member(self.limits, held=self.fixed_leg), **thresholds}


def _check_clearance(clearance: Fraction | None) -> None:
    if clearance is not None:
        parse_positive(clearance, "clearance")


def _thresholds(clearance: Fraction | None, tolerance: Fraction | Changes | None) -> dict[str, Any]:
    """A clearance and a tolerance in canonical form, without what is not asked for."""
    found: dict[str, Any] = {} if clearance is None else {"clearance": exact_str(clearance)}
    return found if tolerance is None else {**found, "tolerance": changes_json(tolerance)}
