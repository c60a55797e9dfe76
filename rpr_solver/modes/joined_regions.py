"""Which poses are in one aspect of a slice or of a range; the parts of the allowed region."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, log10
from typing import Any, TypeAlias

from flint import ctx

from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import PoseTable, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import counted, shortened
from rpr_solver.paths import DecimalPose, EndPose, by_leg
from rpr_solver.paths.between_poses import Obstacle
from rpr_solver.paths.boxes import Boxes, Resolution, decimal_pose
from rpr_solver.paths.cells import Cells
from rpr_solver.paths.components import AllowedRegion, Group
from rpr_solver.paths.joint_paths import Range, sign_of
from rpr_solver.paths.path_poses import isolated
from rpr_solver.paths.proofs import NO_BOUNDS, PROOF_BITS, PathLimits
from rpr_solver.paths.question import End
from rpr_solver.paths.search import spot_of
from rpr_solver.singular import singular_curves

Lengths: TypeAlias = tuple[Fraction, Fraction, Fraction]
Span: TypeAlias = tuple[Fraction, Fraction]
"""The least and the greatest length of the fixed leg, in the user's unit; equal for a slice."""
OpenSpan: TypeAlias = tuple[Fraction, Fraction | None]
"""The same; None is no upper end."""

DIGITS = 15
"""The digits of the tables of poses to whose numbers the answer refers."""
_TOLERANCE = Fraction(1, 1000)


@dataclass(frozen=True)
class JoinedRegion:
    """A region of the plane of the free legs, and which of its poses are in one aspect.

    Attributes:
        lengths: L1, L2 and L3 of a joint vector in the region, exact.
        poses: the number of its poses.
        joined: their numbers, from 1, in groups: poses of one group are joined by a path without a
            singularity, poses of different groups are not. None if the point is too near a singularity.

    >>> JoinedRegion((Fraction(27), Fraction(20), Fraction(20)), 4, ((1, 2), (3, 4)))
    <JoinedRegion of 4 poses at (27, 20, 20): 1-2, 3-4>
    """

    lengths: Lengths
    poses: int
    joined: tuple[tuple[int, ...], ...] | None

    def __repr__(self) -> str:
        place = ", ".join(shortened(exact_str(x)) for x in self.lengths)
        groups = (
            "not told apart" if self.joined is None else ", ".join("-".join(map(str, g)) for g in self.joined)
        )
        return f"<JoinedRegion of {counted(self.poses, 'pose')} at ({place}): {groups or 'none'}>"

    def to_json(self) -> dict[str, Any]:
        """The document's object."""
        return {
            "point": {f"l{leg}": exact_str(length) for leg, length in enumerate(self.lengths, 1)},
            "poses": self.poses,
            "joined": None if self.joined is None else [list(group) for group in self.joined],
        }


@dataclass(frozen=True)
class Aspects:
    """The aspects of a slice or of a range: poses with one name are in one aspect."""

    slice_map: SliceMap
    ends: tuple[Cells, ...]
    ranges: tuple[Range, ...] = ()

    @classmethod
    def of(cls, slice_map: SliceMap, span: Span) -> Aspects:
        """Those of the lengths of the fixed leg from the first to the last one.

        Raises:
            SolverError: the singular curves are not supported, or could not be compared.
        """
        low, high = (end * slice_map.scale for end in span)
        if low == high:
            return cls(slice_map, (Cells.of(slice_map, low),))
        return cls(slice_map, (), tuple(Range.of(slice_map, (low, high), sign) for sign in (1, -1)))

    def name(self, pose: EndPose) -> Hashable:
        """The name of the aspect of a pose.

        Raises:
            Unproved: the pose is too near a singularity.
        """
        sign = sign_of(pose)
        if not sign:
            raise Unproved("a pose is too near a singularity")
        if self.ends:
            [cells] = self.ends
            return sign, cells.aspects[cells.cell_of(pose.angles)]
        [own] = [part for part in self.ranges if part.sign == sign]
        return sign, own.component(pose)

    def groups(self, table: PoseTable, lengths: Lengths) -> tuple[tuple[int, ...], ...] | None:
        """The numbers of the poses of a table, those of one aspect together; None if they are too near a
        singularity."""
        leg = self.slice_map.fixed_leg
        fixed, first, second = (lengths[k - 1] * self.slice_map.scale for k in (leg, *free_legs(leg)))
        found: dict[Hashable, list[int]] = {}
        try:
            for number in range(1, table.count + 1):
                with ctx.workprec(PROOF_BITS):
                    pose = isolated(self.slice_map, (fixed, first, second), table, number)
                found.setdefault(self.name(pose), []).append(number)
        except Unproved:
            return None
        return tuple(map(tuple, found.values()))


@dataclass(frozen=True)
class AspectName:
    """An aspect: its name in the whole range or slice; or in one slice of a range, with its length."""

    name: Hashable
    length: Fraction | None

    def are_apart(self, other: AspectName) -> bool:
        """Whether two aspects are different ones of the whole, so that no path joins them."""
        return self.length is None and self != other


def aspects_of(slice_map: SliceMap, span: Span | None, ends: Mapping[int, End]) -> dict[int, AspectName]:
    """The aspects of poses, in a range of the fixed leg or in their slices; without those that are too near a
    singularity.

    If the range is not supported, the aspects of the slices tell which poses are joined, not which are apart.

    Raises:
        SolverError: the singular curves of a slice are not supported.
    """
    lengths = {end.length for end in ends.values()}
    is_whole, own = True, {}
    if span is not None:
        try:
            own = dict.fromkeys(lengths, Aspects.of(slice_map, span))
        except SolverError:
            is_whole = False
    if not own:
        own = {length: Aspects.of(slice_map, (length, length)) for length in lengths}
    names = {}
    for k, end in ends.items():
        with suppress(Unproved):
            names[k] = AspectName(own[end.length].name(end.pose), None if is_whole else end.length)
    return names


def joined_regions(manipulator: Manipulator, aspects: Aspects, length: Fraction) -> Iterator[JoinedRegion]:
    """The regions of a slice with the groups of their poses.

    Raises:
        SolverError: the singular curves are not supported, or their regions could not be told apart.
    """
    leg = aspects.slice_map.fixed_leg
    for region in singular_curves(manipulator, length, fixed_leg=leg, tolerance=_TOLERANCE).regions:
        lengths = by_leg(leg, (length, *region.point))
        table = poses(manipulator, *lengths, digits=DIGITS)
        yield JoinedRegion(lengths, table.count, aspects.groups(table, lengths))


Matrix: TypeAlias = tuple[tuple[Obstacle | None, ...], ...]
"""For each pair of poses why no path joins them; None if one does."""


@dataclass(frozen=True)
class AllowedPart:
    """A part of the allowed region; or several that could not be told apart.

    Attributes:
        sign: that of J.
        is_one: whether it is proved to be one part, so that all its poses are joined within it.
        pose: one of them: α and the fixed leg's angle in degrees, and the length of the fixed leg, exact;
            None if it is not known to have one.
        near: if it is not proved to be one part, a pose near which it is not.
        places: those of the poses that are in it, from 1.

    >>> pose = Fraction(10), Fraction(-20), Fraction(27)
    >>> AllowedPart(1, True, pose, None, (2, 3)).to_json(1)["pose"]
    {'alpha_deg': '10', 'theta1_deg': '-20', 'l1': '27'}
    """

    sign: int
    is_one: bool
    pose: tuple[Fraction, Fraction, Fraction] | None
    near: DecimalPose | None
    places: tuple[int, ...]

    @classmethod
    def of(cls, boxes: Boxes, group: Group, places: Sequence[int]) -> AllowedPart:
        """The part that a group of boxes holds."""
        scale, pose = boxes.slice_map.scale, None
        near = None if group.is_one else decimal_pose(spot_of(boxes.middle(group.stuck)), scale)
        if group.inside:
            widest = min(group.inside, key=lambda box: box[0])
            (alpha, theta, length), (turn, _, size) = boxes.middle(widest), boxes.sizes(widest)
            a, t = (_decimal(360 * (x - round(x)), 360 * turn) for x in (alpha, theta))
            pose = a, t, _decimal(length / scale, size / scale) if size else length / scale
        return cls(boxes.sign, group.is_one, pose, near, tuple(places))

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        return {
            "sign": self.sign,
            "is_one": self.is_one,
            "poses": list(self.places),
            "pose": self.pose and DecimalPose(*self.pose).to_json(fixed_leg),
            **({} if self.near is None else {"near": self.near.to_json(fixed_leg)}),
        }


def _decimal(middle: Fraction, width: Fraction) -> Fraction:
    """A short decimal in the middle half of an interval of this width."""
    digits = 2 - ceil(log10(width.numerator) - log10(width.denominator))
    return Fraction(round(middle * Fraction(10) ** digits)) / Fraction(10) ** digits


@dataclass(frozen=True)
class AllowedParts:
    """All parts of the allowed region: of the poses at which J is not zero and the legs keep their limits.

    Attributes:
        parts: those with J > 0 first, and of them those with the most room first.
        resolution: the size of the narrowest boxes of poses that were examined.

    >>> from rpr_solver import EXAMPLES, pose_connections
    >>> found = pose_connections(EXAMPLES["innocenti"], 27, 20, 20, parts=True, limits={"l2": (None, 22)})
    >>> found.allowed.count, [part.places for part in found.allowed.parts if part.places]
    (4, [(3, 4), (1,), (2,)])
    """

    parts: tuple[AllowedPart, ...]
    resolution: Resolution

    @classmethod
    def of(
        cls, slice_map: SliceMap, bounds: Mapping[int, Bounds], span: Span, ends: Mapping[int, End]
    ) -> AllowedParts:
        """The parts within joint limits.

        Args:
            slice_map: of the manipulator and its fixed leg.
            bounds: the joint limits, by legs.
            span: the least and the greatest length of the fixed leg, within its limits; in the user's unit.
            ends: allowed poses by their places.
        """
        low, high = bounds.get(slice_map.fixed_leg, NO_BOUNDS)
        is_outside = (low is not None and span[1] < low) or (high is not None and high < span[0])
        limits, lengths = PathLimits.of(slice_map, bounds), [end * slice_map.scale for end in span]
        parts, resolution = [], Resolution(Fraction(360))
        for sign in () if is_outside else (1, -1):
            boxes = Boxes(slice_map, sign, limits, lengths[0], lengths[1])
            region = AllowedRegion(boxes)
            held: dict[int | None, list[int]] = {}
            for place, end in ends.items():
                if end.sign == sign:
                    point = *end.pose.angles, end.pose.legs[0]
                    held.setdefault(region.group_of(point), []).append(place)
            parts += [AllowedPart.of(boxes, group, held.get(k, ())) for k, group in enumerate(region.groups)]
            resolution = min(resolution, region.resolution, key=lambda size: size.angle_deg)
        return cls(tuple(parts), resolution)

    @property
    def count(self) -> int | None:
        """The number of parts; None if it is not proved."""
        return len(self.parts) if all(part.is_one for part in self.parts) else None

    def decided(self, matrix: Matrix) -> Matrix:
        """A matrix with pairs decided by the parts in which they are, where it is undecided."""
        part_of = {place: part for part in self.parts for place in part.places}

        def entry(word: Obstacle | None, i: int, k: int) -> Obstacle | None:
            first, second = part_of.get(i), part_of.get(k)
            if word is not Obstacle.UNDECIDED or first is None or second is None:
                return word
            if first is not second:
                return Obstacle.SEPARATED_BY_LIMITS
            return None if first.is_one else word

        rows = enumerate(matrix, 1)
        return tuple(tuple(entry(word, i, k) for k, word in enumerate(row, 1)) for i, row in rows)

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        parts = [part.to_json(fixed_leg) for part in self.parts]
        return {"count": self.count, "parts": parts, "resolution": self.resolution.to_json()}
