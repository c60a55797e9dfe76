"""Events: lengths of the fixed leg at which the number of cusps may change, with their degenerate poses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from flint import arb

from rpr_solver.exact.number_field import Algebraic
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.exact_pose import ExactPose

Coordinates = tuple[arb, arb, arb, arb]
"""α and θ in degrees, and the free legs in the user's unit."""


@dataclass(frozen=True)
class BallPose:
    """The degenerate pose of an event: its kind, and its coordinates as balls at a precision in bits."""

    kind: PoseKind
    coordinates: Callable[[int], Coordinates]
    exact: Callable[[], ExactPose]
    """The same pose in a number field."""


class Event(Protocol):
    """A length L at which the number of cusps may change (scaled units)."""

    @property
    def pose(self) -> ExactPose | BallPose | None:
        """The degenerate pose; None if only the length is known."""

    @property
    def exact_length(self) -> Algebraic | None:
        """L (scaled) as an algebraic number, or None if it is only known by balls."""

    @property
    def lasting(self) -> bool:
        """Whether neighbouring slices have a degenerate pose of the same kind beside this one."""

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""


@dataclass(frozen=True)
class Landmark:
    """A length, exact, at which the number of cusps may change, with its degenerate pose if one is known."""

    exact_length: Algebraic
    pose: ExactPose | None = None
    lasting: bool = False

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self.exact_length.ball(bits)
