"""What is asked of a path: its ends, and what it must keep.

A pose is asked for as ``{"l1": 27, "l2": 20, "l3": 20, "pose": 2}``, the second one of
:func:`~rpr_solver.model.pose_table.poses`, or as ``{"alpha_deg": "12.5", "theta1_deg": -30, "l1": 27}``,
where all numbers are exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from typing import Any, TypeAlias, TypedDict, Unpack

from flint import arb, ctx

from rpr_solver.contract import PATH_DIGITS, check_digits, check_integer, check_leg
from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.decimals import angle_text, digit_bits, round_all, round_fraction
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_exact, parse_positive
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds, ExactLimits, MotionQuestion, Sampling, read_limits
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import PoseTable, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.conditioning import AskedCondition
from rpr_solver.paths.joint_paths import sign_of
from rpr_solver.paths.path_poses import PathPose, isolated, of_table
from rpr_solver.paths.proofs import BEST, PROOF_BITS, PathLimits, outside
from rpr_solver.paths.routes import EndPose, GivenPose, by_leg, local_map
from rpr_solver.paths.sampling import SamplingPlan

_SPARE_BITS = 64


def read_clearance(asked: Exact | None) -> Fraction | None:
    """The clearance that is required, in degrees; 0 for the greatest one, None if none is asked for.

    Raises:
        InputError: naming ``clearance``.
    """
    if asked is None:
        return None
    if asked == BEST:
        return Fraction(0)
    return parse_positive(asked, "clearance", f"give {BEST!r} or a number of degrees > 0")


class SamplingOptions(TypedDict, total=False):
    """The options of :class:`PathOptions` that say how a path is sampled."""

    samples: int
    timing: str
    duration: Exact
    motion: MotionQuestion | None
    sampling: Sampling | None


class PathOptions(SamplingOptions, total=False):
    """What may be asked of a path beside its ends.

    Attributes:
        limits: joint limits that the path keeps: the least and the greatest length of legs, exact, None for
            an open end: ``{"l2": (5, "20.5"), "l3": (None, 30)}``, or with the legs' numbers as keys.
        fixed_leg: the leg of fixed length, 1, 2 or 3; 1 unless given.
        digits: significant digits of every printed number, 15 to 10000; all are proved. 15 unless given.
        samples: the number of samples, 2 to 10001 (see :meth:`Path.resampled`); 101 unless given.
        timing: the law of time: ``"cosine"`` unless given, ``"trapezoid"`` or ``"constant"``.
        duration: the time of the last sample, exact, > 0; 1 unless given.
        motion: limits of speed, acceleration and perhaps jerk of the legs, from which the times follow
            (see :meth:`Path.resampled`).
        sampling: instead of ``samples``: ``{"step": …}`` or ``{"chord": …}``.
        clearance: ``"best"`` for the path that keeps as far from singular poses as possible, or how far it
            must keep from them, exact, in degrees (:class:`Clearance`). Any path unless given.
        condition: whether condition numbers are wanted (:mod:`rpr_solver.model.conditioning`).
        length_scale: λ, by which they measure rotations, exact, > 0, in the user's unit; the radius of
            gyration of the platform's joints unless given.
        max_condition: the greatest condition number that a pose of the path may have, exact, at least 1.
    """

    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    clearance: Exact | None
    condition: bool
    length_scale: Exact | None
    max_condition: Exact | None


@dataclass(frozen=True)
class PathTerms:
    """The options of a path, checked: the fixed leg, the digits, how it is sampled, and its joint limits.

    ``clearance`` is in degrees, 0 for the greatest one, and None for any path; ``condition`` is None without
    condition numbers.
    """

    leg: int
    digits: int
    plan: SamplingPlan
    bounds: Mapping[int, Bounds]
    clearance: Fraction | None
    condition: AskedCondition | None = None

    @classmethod
    def of(
        cls,
        *,
        limits: ExactLimits | None = None,
        fixed_leg: int = 1,
        digits: int = PATH_DIGITS,
        clearance: Exact | None = None,
        condition: bool = False,
        length_scale: Exact | None = None,
        max_condition: Exact | None = None,
        **sampled: Unpack[SamplingOptions],
    ) -> PathTerms:
        """The terms of :class:`PathOptions`.

        Raises:
            InputError: naming the option at fault.
        """
        digits, leg = check_digits(digits), check_leg(fixed_leg)
        plan = SamplingPlan.of(**sampled)
        bounds = read_limits({} if limits is None else limits, "limits", held=leg)
        asked = AskedCondition.of(condition=condition, length_scale=length_scale, max_condition=max_condition)
        return cls(leg, digits, plan, bounds, read_clearance(clearance), asked)


def span_json(ends: tuple[Fraction, Fraction] | None) -> dict[str, str] | None:
    """A closed range of lengths, exact."""
    return ends and {"from": exact_str(ends[0]), "to": exact_str(ends[1])}


def document_lengths(lengths: Sequence[Fraction] | None) -> dict[str, str]:
    """The leg lengths at both ends by name, exact; none if each end has its own."""
    return {f"l{leg}": exact_str(length) for leg, length in enumerate(lengths or (), 1)}


PoseQuestion: TypeAlias = Mapping[str, Exact]
"""A pose that is asked for, as the top of this module says."""
Lengths: TypeAlias = tuple[Fraction, Fraction, Fraction]
_LEGS = ("l1", "l2", "l3")


@dataclass(frozen=True)
class End:
    """A pose at an end of a path.

    Attributes:
        pose: as the path needs it.
        named: as the document has it.
        lengths: L1, L2 and L3 in the user's unit; None if the pose is given by its angles.
        sign: of J at the pose.
    """

    pose: EndPose
    named: PathPose
    lengths: Lengths | None
    sign: int

    @property
    def length(self) -> Fraction:
        """The length of the fixed leg, in the user's unit."""
        return self.pose.legs[0] / self.pose.slice_map.scale

    def is_same(self, other: End) -> bool:
        """Whether both are asked for as the same pose."""
        if isinstance(self.pose, GivenPose):
            return self.pose == other.pose
        return (self.lengths, self.named.number) == (other.lengths, other.named.number)

    def is_outside(self, bounds: Mapping[int, Bounds]) -> bool:
        """Whether the pose is proved to exceed limits of the legs."""
        if self.lengths is not None:
            return bool(outside(bounds, self.lengths))
        own = self.pose.slice_map
        if outside({leg: x for leg, x in bounds.items() if leg == own.fixed_leg}, [self.length] * 3):
            return True
        with ctx.workprec(PROOF_BITS):
            return PathLimits.of(own, bounds).exclude([square / 2 for square in _squares(self.pose)])


@dataclass(frozen=True)
class Ends:
    """The reader of the poses that a question names.

    Attributes:
        manipulator: the geometry.
        slice_map: its integer model.
        digits: significant digits of the poses.
    """

    manipulator: Manipulator
    slice_map: SliceMap
    digits: int

    def of_joint_vector(self, lengths: Lengths, numbers: Mapping[str, Any]) -> list[End]:
        """Poses of one joint vector, whose numbers are given by the names of their fields.

        Raises:
            InputError: naming a field: there is no such pose, or it is singular.
            Unproved: a pose is too near a singularity.
        """
        table = poses(self.manipulator, *lengths, digits=self.digits)
        return [self.end_of(table, lengths, _number(table, n, field)) for field, n in numbers.items()]

    def end_of(self, table: PoseTable, lengths: Lengths, number: int) -> End:
        """A regular pose of a table.

        Raises:
            Unproved: it is too near a singularity.
        """
        own = self.slice_map
        fixed, *free = (lengths[leg - 1] * own.scale for leg in (own.fixed_leg, *free_legs(own.fixed_leg)))
        with ctx.workprec(PROOF_BITS):
            pose = isolated(own, (fixed, free[0], free[1]), table, number)
        return End(pose, of_table(table, number, own.fixed_leg), lengths, sign_of(pose))

    def read(self, asked: PoseQuestion, field: str) -> End:
        """A pose that is asked for.

        Raises:
            InputError: naming the part of the field at fault.
            Unproved: the pose is too near a singularity.
        """
        leg = self.slice_map.fixed_leg
        angles = "alpha_deg", f"theta{leg}_deg", f"l{leg}"
        if not isinstance(asked, Mapping) or set(asked) not in ({*_LEGS, "pose"}, {*angles}):
            expected = f"give {', '.join(_LEGS)} and pose, or {', '.join(angles)}"
            raise InputError.of(field, f"is {shown(asked)}; {expected}")
        try:
            if "pose" in asked:
                l1, l2, l3 = parse_all({name: asked[name] for name in _LEGS}, parse_positive).values()
                [end] = self.of_joint_vector((l1, l2, l3), {"pose": asked["pose"]})
                return end
            alpha, theta = parse_all({name: asked[name] for name in angles[:2]}, parse_exact).values()
            return self._given(alpha, theta, parse_positive(asked[angles[2]], angles[2]))
        except InputError as error:
            problems = [FieldProblem(f"{field}.{p.field}".rstrip("."), p.message) for p in error.problems]
            raise InputError(problems) from None

    def _given(self, alpha: Fraction, theta: Fraction, length: Fraction) -> End:
        """A pose given by its angles in degrees and the length of the fixed leg, in the user's unit.

        Raises:
            InputError: it is singular, or a leg has no length.
        """
        own = self.slice_map
        pose = GivenPose(own, (length * own.scale, None, None), (_wrapped(alpha), _wrapped(theta)))
        sign = sign_of(pose)
        if not sign:
            raise InputError.of("", "is a singular pose, or too near one; give a regular pose")
        return End(pose, self._named(pose, length), None, sign)

    def _named(self, pose: GivenPose, length: Fraction) -> PathPose:
        alpha, theta = (angle_text(round_fraction(angle, self.digits)) for angle in pose.degrees)
        with ctx.workprec(digit_bits(self.digits) + _SPARE_BITS):
            scale = self.slice_map.scale_ball()
            free = round_all((square.sqrt() / scale for square in _squares(pose)), self.digits)
        if free is None:
            raise InputError.of("", "is too near a pose with a leg of length 0; give another pose")
        texts = by_leg(self.slice_map.fixed_leg, (exact_str(length), *free))
        return PathPose(None, alpha, theta, texts)


def common(ends: tuple[End, End]) -> tuple[tuple[PathPose, PathPose], Lengths | None]:
    """Both poses as documents have them, and their leg lengths: common ones, or each pose with its own."""
    first, last = ends
    if first.lengths is not None and first.lengths == last.lengths:
        return (first.named, last.named), first.lengths
    return (_with_lengths(first), _with_lengths(last)), None


def _with_lengths(end: End) -> PathPose:
    if end.lengths is None:
        return end.named
    l1, l2, l3 = map(exact_str, end.lengths)
    return replace(end.named, lengths=(l1, l2, l3))


def _number(table: PoseTable, number: int, field: str) -> int:
    count = table.count
    if not count:
        raise InputError.of(field, "is a pose of a joint vector that has none")
    number = check_integer(number, field, f"the number of a pose, 1 to {count}", 1, count)
    if table.poses[number - 1].multiplicity > 1:
        raise InputError.of(field, f"is {number}, a singular pose; give a regular one")
    return number


def _wrapped(degrees: Fraction) -> Fraction:
    """An angle in (−180, 180]."""
    return degrees - 360 * ceil((degrees - 180) / 360)


def _squares(pose: EndPose) -> tuple[arb, arb]:
    """The squares of the free legs, scaled."""
    return local_map(pose.slice_map, ball_of(pose.legs[0]), pose.angles, 0).squared_lengths()
