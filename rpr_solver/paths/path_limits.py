"""Joint limits of the free legs along a path, as bounds on half their squared lengths.

Limits are closed: a leg may be as long as its limit. Where the joint vector of the path itself lies on one,
balls cannot show that the path stays within it, but the slope of the length at the end shows that it leaves
the limit inwards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.isolated import Legs

NO_BOUNDS: Bounds = (None, None)


@dataclass(frozen=True)
class Wall:
    """One limit: ``side`` · (half the squared length) is at most ``side`` · ``height``.

    Attributes:
        leg: 0 or 1, the number of the free leg.
        side: 1 for a maximum, −1 for a minimum.
        height: half the square of the scaled limit.
        is_touched: whether the ends of the path lie on it.
    """

    leg: int
    side: int
    height: Fraction
    is_touched: bool

    def room(self, value: arb) -> arb:
        """How far a value is inside; negative beyond the limit."""
        return (ball_of(self.height) - value) * self.side


@dataclass(frozen=True)
class PathLimits:
    """The limits of the two free legs of a path between poses of one joint vector."""

    walls: tuple[Wall, ...] = ()

    @classmethod
    def of(cls, slice_map: SliceMap, bounds: Mapping[int, Bounds], legs: Legs | None = None) -> PathLimits:
        """The limits by the legs' numbers, in the user's unit; ``legs`` are those at the ends, scaled."""
        walls = []
        for number, leg in enumerate(free_legs(slice_map.fixed_leg)):
            length = None if legs is None else legs[1 + number]
            for bound, side in zip(bounds.get(leg, NO_BOUNDS), (-1, 1), strict=True):
                if bound is not None:
                    limit = bound * slice_map.scale
                    walls.append(Wall(number, side, limit * limit / 2, length == limit))
        return cls(tuple(walls))

    def hold(
        self, image: Sequence[arb], slopes: Sequence[arb], *, at_start: bool = False, at_stop: bool = False
    ) -> bool:
        """Whether a piece of a path is proved to keep the limits.

        Args:
            image: half the squared lengths on the piece.
            slopes: their derivatives along it.
            at_start: whether the piece begins where the path begins.
            at_stop: whether it ends where the path ends.
        """
        return all(
            wall.room(image[wall.leg]) >= 0
            or (wall.is_touched and at_start and slopes[wall.leg] * wall.side < 0)
            or (wall.is_touched and at_stop and slopes[wall.leg] * wall.side > 0)
            for wall in self.walls
        )

    def exclude(self, image: Sequence[arb]) -> bool:
        """Whether values of half the squared lengths are all proved to be beyond one of the limits."""
        return any(wall.room(image[wall.leg]) < 0 for wall in self.walls)


NO_LIMITS = PathLimits()
"""Every length is allowed."""


def outside(bounds: Mapping[int, Bounds], lengths: Sequence[Fraction]) -> list[int]:
    """The legs that are shorter or longer than their limits allow; lengths are L1, L2, L3.

    >>> outside({2: (Fraction(5), None)}, [Fraction(3), Fraction(4), Fraction(5)])
    [2]
    """
    found = []
    for leg, (low, high) in sorted(bounds.items()):
        length = lengths[leg - 1]
        if (low is not None and length < low) or (high is not None and length > high):
            found.append(leg)
    return found
