"""Limits of a motion as they are asked for: the greatest speed, acceleration and jerk of each leg."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from rpr_solver.errors import InputError, shown
from rpr_solver.exact.rationals import Exact, exact_str, parse_positive
from rpr_solver.model.lengths import leg_of

MotionQuestion: TypeAlias = Mapping[str, Exact | Mapping[str, Exact]]
"""``{"speed": 10, "acceleration": {"l2": 30, "l3": "20.5"}, "jerk": 100}``."""
Sampling: TypeAlias = Mapping[str, Exact]
"""``{"number": 101}``, ``{"step": "0.01"}`` or ``{"chord": "0.001"}``."""

_KINDS = ("speed", "acceleration", "jerk")
_NEEDED = _KINDS[:2]
ROWS = ("number", "step", "chord")
"""By what the samples of a path are chosen."""
OF_LIMITS = "motion"
"""The law of time that follows from limits."""


@dataclass(frozen=True)
class MotionLimits:
    """The greatest speed, acceleration and perhaps jerk of legs, by their numbers, in the user's units.

    >>> MotionLimits.of({"speed": 5, "acceleration": {"l2": "0.5"}}).to_json()["acceleration"]
    {'l2': '0.5'}
    """

    speed: Mapping[int, Fraction]
    acceleration: Mapping[int, Fraction]
    jerk: Mapping[int, Fraction] | None = None

    @classmethod
    def of(cls, motion: MotionQuestion) -> MotionLimits:
        """The limits; a number is that of all legs.

        Raises:
            InputError: naming ``motion`` or its part at fault.
        """
        expected = "give speed and acceleration, and perhaps jerk"
        if not isinstance(motion, Mapping) or not set(_NEEDED) <= set(motion) <= set(_KINDS):
            raise InputError.of("motion", f"is {shown(motion)}; {expected}")
        return cls(**{kind: _by_leg(limit, f"motion.{kind}") for kind, limit in motion.items()})

    def to_json(self) -> dict[str, dict[str, str]]:
        """The contract's object, with numbers in canonical text."""
        kinds = ((kind, getattr(self, kind)) for kind in _KINDS)
        return {
            kind: {f"l{leg}": exact_str(x) for leg, x in sorted(limits.items())}
            for kind, limits in kinds
            if limits is not None
        }

    def check(self, moving: Sequence[int]) -> None:
        """Checks that all legs that move have limits.

        Raises:
            InputError: naming the limit that is missing.
        """
        for kind in _KINDS:
            limits = getattr(self, kind)
            for leg in moving:
                if limits is not None and leg not in limits:
                    raise InputError.of(f"motion.{kind}.l{leg}", "is missing; this leg moves, too")


def _by_leg(limit: Exact | Mapping[str, Exact], field: str) -> dict[int, Fraction]:
    if not isinstance(limit, Mapping):
        return dict.fromkeys((1, 2, 3), parse_positive(limit, field, "a limit must be > 0"))
    if not limit:
        raise InputError.of(field, "has no limits; give them by leg, such as l2")
    return {
        leg_of(leg, field): parse_positive(x, f"{field}.{leg}", "a limit must be > 0")
        for leg, x in limit.items()
    }
