"""What an event is: a length of the fixed leg to look at on both sides, and its degenerate pose, if any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from flint import arb

from rpr_solver.exact.number_field import Algebraic
from rpr_solver.model.classify import PoseKind

Coordinates = tuple[arb, arb, arb, arb]
"""α and θ in degrees, and the free legs in the user's unit."""


@dataclass(frozen=True)
class EventPose:
    """The degenerate pose of an event: its kind, and its coordinates as balls from a precision in bits."""

    kind: PoseKind
    coordinates: Callable[[int], Coordinates]
    exact: Callable[[], EventPose | None] | None = None
    """The same pose in a number field, where it is given by balls; None where it is in one."""


class Event(Protocol):
    """A place on the axis of L at which the number of cusps may change (scaled units inside)."""

    @property
    def pose(self) -> EventPose | None:
        """The degenerate pose; None where the length alone matters."""
        ...

    @property
    def exact_length(self) -> Algebraic | None:
        """L (scaled) as an algebraic number, where it is known as one."""
        ...

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        ...


@dataclass(frozen=True)
class Landmark:
    """A length to look at on both sides, without a degenerate pose of its own."""

    exact_length: Algebraic
    pose: None = None

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self.exact_length.ball(bits)
