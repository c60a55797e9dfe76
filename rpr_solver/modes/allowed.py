"""The parts of the allowed region, and which poses are in which."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, log10
from typing import Any, TypeAlias

from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.joined import Span
from rpr_solver.paths.between_poses import Obstacle
from rpr_solver.paths.boxes import Boxes, Nearby, Resolution
from rpr_solver.paths.ends import End
from rpr_solver.paths.parts import AllowedRegion, Group
from rpr_solver.paths.proofs import NO_BOUNDS, PathLimits
from rpr_solver.paths.ways import spot_of

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
    near: Nearby | None
    places: tuple[int, ...]

    @classmethod
    def of(cls, boxes: Boxes, group: Group, places: Sequence[int]) -> AllowedPart:
        """The part that a group of boxes holds."""
        scale, pose = boxes.slice_map.scale, None
        near = None if group.is_one else Nearby.of(spot_of(boxes.middle(group.stuck)), scale)
        if group.inside:
            widest = min(group.inside, key=lambda box: box[0])
            (alpha, theta, length), (turn, _, size) = boxes.middle(widest), boxes.sizes(widest)
            a, t = (_decimal(360 * (x - round(x)), 360 * turn) for x in (alpha, theta))
            pose = a, t, _decimal(length / scale, size / scale) if size else length / scale
        return cls(boxes.sign, group.is_one, pose, near, tuple(places))

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        names = "alpha_deg", f"theta{fixed_leg}_deg", f"l{fixed_leg}"
        return {
            "sign": self.sign,
            "is_one": self.is_one,
            "poses": list(self.places),
            "pose": self.pose and dict(zip(names, map(exact_str, self.pose), strict=True)),
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
