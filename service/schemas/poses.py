"""Poses, singular curves and aspects: the questions, and the answers."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    RootModel,
    TypeAdapter,
    ValidationInfo,
    model_validator,
)

from rpr_solver import MIN_DIGITS, exact_str
from rpr_solver.contract import COARSEST_TOLERANCE, DEFAULT_TOLERANCE, FINEST_TOLERANCE, LEGS
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.sensed.angles import ANGLES, LEAST, read_tolerance
from service.schemas.answers import (
    CSV,
    JSON,
    JSON_FORM,
    NEAR,
    CanonicalGeometry,
    ClosedRange,
    Decimal,
    DocumentHead,
    FixedLength,
    Forms,
    NearShape,
    Point,
    csv_form,
    optional,
)
from service.schemas.conditions import ConditionScale, LengthScale, condition_member, scale_field
from service.schemas.document import Expected, Source, given, part
from service.schemas.geometry import points_member
from service.schemas.lengths import NEEDED, OneSlice, OpenRange, Range, SlicesOfOneLeg, range_field
from service.schemas.limits import DEFERRED, Detail, Model
from service.schemas.numbers import (
    Digits,
    FixedLeg,
    Flag,
    Length,
    Positive,
    digits_field,
    fixed_leg_field,
    number_where,
)
from service.schemas.questions import Question
from service.schemas.workspaces import Phi
from worker.answers.documents import ASPECTS, POSES, SINGULAR_CURVES


class _PlatformPose(Model):
    """A pose of the platform. Angles are degrees in (−180, 180].

    Attributes:
        alpha_deg: Orientation of the platform.
        theta1_deg: Angle of leg 1.
        theta2_deg: Angle of leg 2.
        theta3_deg: Angle of leg 3.
        b1_x: x of the platform's point B1.
        b1_y: y of the platform's point B1.
        multiplicity: Number of poses that coalesce here: 1 regular, 2 on a singular curve, 3 at a cusp.
        x: Where base or platform are given by points: x of the origin of the platform's frame in the frame of
            the base.
        y: y of this origin.
        phi_deg: The angle of the platform's frame in the frame of the base, degrees in (−180, 180].
    """

    alpha_deg: Decimal
    theta1_deg: Decimal
    theta2_deg: Decimal
    theta3_deg: Decimal
    b1_x: Decimal
    b1_y: Decimal
    multiplicity: int
    x: Decimal | None = optional()
    y: Decimal | None = optional()
    phi_deg: Decimal | None = optional()


class Pose(_PlatformPose):
    """A pose of the platform. Angles are degrees in (−180, 180].

    Attributes:
        condition: The condition number of the Jacobian, if it was asked for; null if it is infinite, at a
            singular pose.
        clearance_deg: A proved lower bound, of 6 digits, of the distance to the nearest singular pose with
            the same length of leg 1: α and the angle of leg 1 may change together (in the Euclidean norm) by
            less than this, in degrees. Missing unless condition numbers were asked for.
    """

    condition: Decimal | None = None
    clearance_deg: Decimal | None = optional()


class PoseCurve(Detail):
    """A whole curve of poses: congruent triangles with equal legs have one, and so has a platform that can
    turn about a joint that legs share; its `alpha_deg` is `any`."""

    kind: str
    alpha_deg: str
    description: str


class PosePolynomial(Detail):
    """The polynomial of direct kinematics, exact: Σ (coefficients[i] + omega · omega_coefficients[i]) tⁱ.

    Attributes:
        omega: The square root; missing if it is rational.
        omega_coefficients: The coefficients of the square root; missing if it is rational.
    """

    variable: str
    degree: int
    coefficients: list[str]
    omega: str | None = optional()
    omega_coefficients: list[str] | None = optional()


class PoseCertificate(Detail):
    """What the count rests on."""

    model_config = ConfigDict(extra="allow")

    method: str
    factors: list[dict[str, Any]]


class PoseTable(Model):
    """All real poses of one joint vector, sorted by α, then θ1."""

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    digits: int
    solver_version: str
    l1: str
    l2: str
    l3: str
    count: int = Field(description="Number of distinct isolated poses.")
    count_with_multiplicity: int
    condition: ConditionScale | None = optional("By what condition numbers measure rotations.")
    poses: list[Pose]
    curves: list[PoseCurve]
    polynomial: PosePolynomial
    certificate: PoseCertificate


class LegPose(_PlatformPose):
    """A pose at a length inside an interval.

    Attributes:
        sign: The sign of J throughout the interval; null if it could not be decided.
        aspect: The aspect in which the pose stays throughout the interval, by its number in this document: in
            the slice of the first fixed leg, a path without a singularity joins two poses if and only if
            their numbers are equal. Null if it could not be decided.
    """

    sign: int | None
    aspect: int | None


class LegInterval(Detail):
    """Lengths of the moving leg between which no pose is singular.

    Attributes:
        start: The lower end: exact if it is that of the range, else correctly rounded.
        stop: The upper end, likewise; null: no end.
        count: The number of poses at each length inside.
        at: A length inside, exact.
        poses: The poses there.
    """

    start: str = Field(alias="from")
    stop: str | None = Field(alias="to")
    count: int
    at: str
    poses: list[LegPose]


class SingularPose(Model):
    """A singular pose. Angles are degrees in (−180, 180].

    Attributes:
        alpha_deg: Orientation of the platform.
        theta1_deg: Angle of leg 1; missing if its length is 0. Likewise `theta2_deg` and `theta3_deg`.
        b1_x: x of the platform's point B1.
        b1_y: y of the platform's point B1.
        x: Where base or platform are given by points: as of other poses, like `y` and `phi_deg`.
    """

    alpha_deg: Decimal
    theta1_deg: Decimal | None = optional()
    theta2_deg: Decimal | None = optional()
    theta3_deg: Decimal | None = optional()
    b1_x: Decimal
    b1_y: Decimal
    x: Decimal | None = optional()
    y: Decimal | None = optional()
    phi_deg: Decimal | None = optional()


class LegEnd(Detail):
    """A length of the moving leg, which is named, at which poses are singular.

    Attributes:
        kind: `fold`, where two poses merge in one; `closed-leg`, where the moving leg has length 0; or
            `degenerate`: several singular poses, or one of a higher kind.
        poses: The singular poses, by α. Of a whole circle of poses, as congruent triangles have one, none is
            listed.
    """

    l1: Decimal | None = optional()
    l2: Decimal | None = optional()
    l3: Decimal | None = optional()
    kind: str
    poses: list[SingularPose]


class LegPoses(Model):
    """The poses along a leg: all lengths in its range with singular poses, and what is between them.

    Attributes:
        moving_leg: The leg whose length varies.
        l1: The length of leg 1, exact, or its range; likewise `l2` and `l3`.
        ends: All lengths in the range at which a pose is singular, ascending; proved complete.
        intervals: What is between them, ascending.
    """

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    digits: int
    solver_version: str
    moving_leg: int
    l1: str | ClosedRange
    l2: str | ClosedRange
    l3: str | ClosedRange
    ends: list[LegEnd]
    intervals: list[LegInterval]


class SensedPose(Model):
    """A pose with given lengths and angles of legs. Angles are degrees in (−180, 180].

    Attributes:
        alpha_deg: Orientation of the platform.
        theta1_deg: Angle of leg 1 in the frame of the article; missing if its length is 0. Likewise
            `theta2_deg` and `theta3_deg`.
        b1_x: x of the platform's point B1.
        b1_y: y of the platform's point B1.
        l1: Length of leg 1; likewise `l2` and `l3`.
        x: Where base or platform are given by points: as of other poses, like `y` and `phi_deg`.
        off_deg: Of each angle beyond the data from which the pose was found: by how many degrees that of the
            pose differs from it.
    """

    alpha_deg: Decimal
    theta1_deg: Decimal | None = optional()
    theta2_deg: Decimal | None = optional()
    theta3_deg: Decimal | None = optional()
    b1_x: Decimal
    b1_y: Decimal
    l1: Decimal
    l2: Decimal
    l3: Decimal
    x: Decimal | None = optional()
    y: Decimal | None = optional()
    phi_deg: Decimal | None = optional()
    off_deg: dict[str, Decimal]


class SensedPoses(Model):
    """All poses with given lengths and angles of legs.

    Attributes:
        sensed: The lengths, and the angles in degrees, exact, by name.
        angle_tolerance_deg: How far angles beyond three data may be off; null if not given.
        solved_from: The three data from which the poses were found.
        count: Number of poses that agree with all data; proved complete.
        poses: These poses, by α.
        others: Poses that fulfil the three data, but disagree with another angle.
        disagree: The angles with which no pose agrees.
        is_curve: Whether a whole curve of poses fulfils the data; none is listed then.
    """

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    digits: int
    solver_version: str
    sensed: dict[str, str]
    angle_tolerance_deg: str | None
    solved_from: list[str]
    count: int
    poses: list[SensedPose]
    others: list[SensedPose]
    disagree: list[str]
    is_curve: bool


class Poses(RootModel[PoseTable | LegPoses | SensedPoses]):
    """The poses of one joint vector; with a range for one leg, those along this leg; or, with angles of legs,
    those with these lengths and angles."""


_LENGTH: TypeAdapter[Fraction] = TypeAdapter(Length, config=DEFERRED)


def _length_or_range(value: object, info: ValidationInfo) -> Fraction | OpenRange:
    source = Source.of(info)
    if isinstance(value, Mapping | OpenRange):
        return part(OpenRange.model_validate, value, source)
    return part(_LENGTH.validate_python, value, source)


LengthOrRange = Annotated[
    Fraction | OpenRange,
    PlainValidator(_length_or_range, json_schema_input_type=Length | OpenRange),
    PlainSerializer(lambda value: exact_str(value) if isinstance(value, Fraction) else value.model_dump()),
    Expected("give a number > 0"),
]
"""The length of a leg, or the range of the one that moves."""


_ENOUGH: dict[str, Any] = {
    "anyOf": [{"required": [*LEGS]}, *({"required": [name]} for name in ANGLES)],
    "dependentSchemas": {"angle_tolerance_deg": {"anyOf": [{"required": [name]} for name in ANGLES]}},
}
_TOLERANCE = number_where(
    f"give {exact_str(FINEST_TOLERANCE)} to {exact_str(COARSEST_TOLERANCE)}",
    lambda tolerance: FINEST_TOLERANCE <= tolerance <= COARSEST_TOLERANCE,
    Length,
)


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
    """A special point of the singular curves, with proved digits.

    Attributes:
        index: The number of its sample in the strand, from 0.
        kind: `cusp`; `turning`, an extremum of the fixed leg's angle along the curve; `closed-leg`, a free
            leg of length 0; or the kind of a degenerate pose, such as `node` or `isolated-point`.
        cusp: The number of a cusp, from 1, in the cusp table of the slice.
    """

    index: int
    kind: str
    cusp: int | None = optional()


class Strand(Samples):
    """A closed curve, or a piece of one from node to node. J > 0 lies on its left in the plane of α and θ.

    Its angles are continuous and may exceed ±180 degrees. The last sample of a closed strand repeats the
    first, plus `turns` full turns.
    """

    closed: bool
    turns: Turns
    vertices: list[Vertex]


class SingularComponent(Detail):
    """A connected component of the singular curves: one closed strand, or several that meet in nodes."""

    strands: list[Strand]


class RegionPoint(Detail):
    """A joint vector: the exact lengths of the free legs, decimals or quotients p/q."""

    l1: str | None = optional("Length of leg 1, if it is free.")
    l2: str | None = optional("Length of leg 2, if it is free.")
    l3: str | None = optional("Length of leg 3, if it is free.")


class Region(Detail):
    """A region of the plane of the free legs, in which the number of poses is constant.

    Attributes:
        poses: The number of real poses at each of its points, half of them with J > 0.
        point: A point of the region, at which the number is proved.
        rings: Closed polylines of the free legs' lengths: its outer boundary first, then its holes; the
            unbounded region has only holes.
    """

    poses: int
    bounded: bool
    point: RegionPoint
    rings: list[Samples]


class Aspect(Detail):
    """A connected region of the torus of α and θ on which J has one sign.

    Attributes:
        share: The approximate share of the torus that it covers.
        polygons: Polygons of α and θ in degrees, from −180 to 180, that together cover the aspect.
    """

    sign: int
    share: float
    polygons: list[Samples]


class SingularCurves(DocumentHead, FixedLength):
    """The singular curves of a slice: components, regions and aspects.

    Attributes:
        tolerance: Exact, as asked.
        regions: By decreasing number of poses, then by decreasing area.
        thin_regions: The number of further regions, narrower than the tolerance: with a point at which the
            number of poses is proved, or too small to be drawn.
        aspects: Those with J > 0 first, then by decreasing size. Their number is proved.
    """

    tolerance: str
    components: list[SingularComponent]
    regions: list[Region]
    thin_regions: int
    aspects: list[Aspect]


class RangeAspect(Detail):
    """A connected set of poses without a singularity, while the length of the leg varies within the range.

    Attributes:
        sign: The sign of J.
        at_start: The number of aspects of the slice at the lower end that belong to it; at an open end, of
            the limit of slices there.
        at_stop: The number of aspects of the slice at the upper end, likewise.
    """

    sign: int
    at_start: int
    at_stop: int


class Aspects(DocumentHead):
    """The aspects of a range of lengths.

    Attributes:
        aspects: Those with J > 0 first. Within the range, a path without a singularity joins any two poses of
            one aspect, and none joins poses of different aspects. Their number is exact.
    """

    range: ClosedRange
    aspects: list[RangeAspect]


class PosesRequest(Question):
    """A manipulator and the lengths of its legs, of which one may be a range: `{"from": 0, "to": 12}`.

    Direct kinematics: every real pose of the joint vector (L1, L2, L3), proved complete, each with its
    multiplicity: 1 regular, 2 on a singular curve, 3 at a cusp. Where base or platform are given by points,
    poses also have x, y and phi_deg in the frame of these points.

    With a range for one leg, the poses along this leg: all lengths in the range at which poses merge, and
    between them the number of poses, with the sign of J and the aspect of each.

    With `condition`, each pose has the condition number of its Jacobian, for the rates of the legs by the
    velocity of the platform's centroid and its angular velocity times `length_scale`, and how far it is from
    singular poses.

    With angles of legs, in place of lengths or beside them: the poses with at least three such data. The
    angle of a leg is that of the vector from A to B in the frame of the base's points, or in the article's.
    Angles beyond three data must agree within `angle_tolerance_deg`.

    A worker computes the poses in milliseconds.

    Attributes:
        l1: Length of leg 1; > 0. Or its range, if it is the one that moves.
        l2: Length of leg 2, likewise.
        l3: Length of leg 3, likewise.
        angle1: Angle of leg 1 in degrees, if it is known.
        angle2: Angle of leg 2, likewise.
        angle3: Angle of leg 3, likewise.
        angle_tolerance_deg: How far angles beyond three data may be off, in degrees; > 0.
    """

    model_config = ConfigDict(json_schema_extra=_ENOUGH)

    expected = "send an object with geometry, l1, l2 and l3"
    kinds = (POSES,)
    path = "/v1/poses"
    tag = "poses"
    summary = "All poses of a manipulator with given leg lengths"
    answer = Poses
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("poses_csv", "pose or interval")}

    l1: LengthOrRange = given()
    l2: LengthOrRange = given()
    l3: LengthOrRange = given()
    angle1: Phi = given()
    angle2: Phi = given()
    angle3: Phi = given()
    angle_tolerance_deg: Positive = given()
    condition: Flag = Field(
        default=False, description="Whether each pose has its condition number, and its clearance."
    )
    length_scale: LengthScale = scale_field()
    digits: Digits = digits_field()

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered."""
        return True

    @model_validator(mode="after")
    def _one_moves(self) -> Self:
        moving = [leg for leg in LEGS if isinstance(getattr(self, leg), OpenRange)]
        if len(moving) > 1:
            raise InputError.of(moving[1], "is a second range; two legs need a length")
        if condition_member(self) and moving:
            name = "condition" if self.condition else "length_scale"
            raise InputError.of(
                name, f"is for poses of three lengths, and {moving[0]} is a range; leave it out"
            )
        return self

    @model_validator(mode="after")
    def _has_enough(self) -> Self:
        known = self.given()
        angles = {name: known[name] for name in ANGLES if name in known}
        lengths = {leg: known[leg] for leg in LEGS if leg in known}
        if angles:
            self._check_sensed(lengths, angles)
        elif missing := [leg for leg in LEGS if leg not in lengths]:
            message = "is missing; give a number > 0, or the angle of a leg in its place"
            raise InputError([FieldProblem(leg, message) for leg in missing])
        elif self.angle_tolerance_deg is not None:
            raise InputError.of("angle_tolerance_deg", "says nothing without angles of legs; leave it out")
        return self

    def _check_sensed(self, lengths: Mapping[str, Any], angles: Mapping[str, Any]) -> None:
        moving = [leg for leg, length in lengths.items() if isinstance(length, OpenRange)]
        if moving:
            raise InputError.of(moving[0], "is a range; beside angles of legs give a length, or leave it out")
        if condition_member(self):
            name = "condition" if self.condition else "length_scale"
            raise InputError.of(name, "is for poses of three lengths, without angles of legs; leave it out")
        if len(lengths) + len(angles) < LEAST:
            free = next(name for name in (*LEGS, *ANGLES) if name not in (*lengths, *angles))
            count = len(lengths) + len(angles)
            message = f"is missing; lengths and angles are {count}, and a pose needs {LEAST}"
            raise InputError.of(free, message)
        read_tolerance(self.angle_tolerance_deg, is_needed=len(lengths) + len(angles) > LEAST)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question, with the points in whose frame poses are told."""
        missing = {*LEGS, *ANGLES, "angle_tolerance_deg"} - self.model_fields_set
        plain = self.model_dump(exclude={"condition", "length_scale", *missing})
        return {**plain, **condition_member(self), **points_member(self.geometry)}


class SingularCurvesRequest(SlicesOfOneLeg, OneSlice):
    """A manipulator and a slice. The slice is the length of the fixed leg: give `l1`, or `l2` with
    `fixed_leg` 2, or `l3` with `fixed_leg` 3, and neither of the other two.

    All components of the curve J = 0, in the plane of α and the fixed leg's angle and in the plane of the
    free legs. The topology is proved, and special points (cusps, turning points, nodes, …) have proved
    digits. Samples between them are for drawing; they are within `tolerance` of the true curve.

    `regions` are the parts into which the curves divide the plane of the free legs. The number of poses of
    each is proved at one of its points. `aspects` are the connected sets of poses in which J has one sign.

    A worker draws a slice in a fraction of a second.

    Attributes:
        l1: The length of leg 1. With `fixed_leg` 2 or 3 use `l2` or `l3`.
        l2: The length, with `fixed_leg` 2.
        l3: The length, with `fixed_leg` 3.
        tolerance: The largest distance of a drawn curve from the true one, relative to the size of the
            picture, in the plane of the angles and in the plane of the free legs; 0.000001 to 0.1.
    """

    model_config = ConfigDict(json_schema_extra=NEEDED)

    expected = "send an object with geometry and l1"
    kinds = (SINGULAR_CURVES,)
    path = "/v1/singular-curves"
    tag = "singular curves"
    summary = "The singular curves of a slice, the number of poses in each region, and the aspects"
    answer = SingularCurves
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: csv_form("singular_csv", "sample")}
    needs_slices = True
    hint_of_slices = "give a number"

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length = given()
    l2: Length = given()
    l3: Length = given()
    tolerance: Annotated[Fraction, _TOLERANCE] = DEFAULT_TOLERANCE
    digits: Digits = digits_field(MIN_DIGITS)

    @property
    def takes_shared_joints(self) -> bool:
        """It is answered for some legs."""
        return True

    @model_validator(mode="after")
    def _has_drawn_curves(self) -> Self:
        self.geometry.geometry.with_drawn_curves(self.fixed_leg)
        return self

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return {**self._of_slice(), "tolerance": exact_str(self.tolerance), "digits": self.digits}


class AspectsRequest(Question):
    """A manipulator, and the range within which the length of one leg may vary.

    Aspects of different slices join if the fixed leg may vary, too. The answer has those of a range of
    lengths, each with its sign of J and the number of aspects of the slices at both ends that belong to it.
    An open end is the limit of slices as the length approaches 0 or infinity.

    Their number is exact, so no path without a singularity within the range joins two poses of different
    aspects. A worker takes a fraction of a second.
    """

    kinds = (ASPECTS,)
    path = "/v1/aspects"
    name = "post_aspects"
    tag = "aspects"
    summary = "The aspects of a manipulator while the length of one leg varies within a range"
    answer = Aspects

    fixed_leg: FixedLeg = Field(default=1, description="The leg whose length varies over the range.")
    range: Range = range_field()
    digits: Digits = digits_field(MIN_DIGITS)
