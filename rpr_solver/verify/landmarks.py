"""Lengths at which something happens to the cusps of a slice, with the degenerate pose where it is known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.claims import ClaimStatus, Finding
from rpr_solver.verify.core.intervals import Interval, cos_sin, degrees
from rpr_solver.verify.core.krawczyk import Directions, Pair, value
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import angle_of

_SPARE_BITS = 40


@dataclass(frozen=True)
class Landmark:
    """A length at which a cusp may degenerate, or be at a limit: scaled, in a small interval.

    ``square`` is a name of the exact length, if it is known: equal ones are of one length.
    """

    scaled: Interval
    square: object = None

    def length(self, surface: Surface) -> Interval:
        """The length in the user's unit."""
        return self.scaled.over(Interval.of(surface.unit, self.scaled.bits))


@dataclass(frozen=True, kw_only=True)
class Event(Landmark):
    """A proved event: its kind, and a box of its pose, with α and θ in radians and as directions.

    ``zeros`` are the angles and lengths that are proved to be exactly 0, as documents name them.
    """

    kind: str
    pose: tuple[Interval, Interval]
    directions: Directions
    zeros: frozenset[str] = frozenset()

    @classmethod
    def at(cls, kind: str, here: Directions, length: Landmark, zeros: Iterable[str]) -> Event:
        """An event of known directions and length."""
        pose = enclosed(here.alpha), enclosed(here.theta)
        return cls(
            length.scaled, length.square, kind=kind, pose=pose, directions=here, zeros=frozenset(zeros)
        )

    def wrong(self, surface: Surface, length: Printed, event: Record) -> str | None:
        """The first printed number that is wrong for this event; None if all are right."""
        if not length.rounds(self.length(surface)):
            return f"l{surface.fixed}"
        return self.unlike(surface, event)

    def unlike(self, surface: Surface, event: Record) -> str | None:
        """The first printed number but the fixed length that is wrong; None if all are right."""
        unit, theta = Interval.of(surface.unit, self.scaled.bits), f"theta{surface.fixed}_deg"
        values = [
            ("alpha_deg", degrees(self.pose[0]), event["alpha_deg"], 360),
            (theta, degrees(self.pose[1]), event[theta], 360),
        ]
        for leg in surface.legs:
            squared = value(self.directions, leg.squared, self.scaled)
            values.append((f"l{leg.number}", squared.root().over(unit), event[f"l{leg.number}"], 0))
        for name, x, number, turn in values:
            if not (x.contains(0) if number.is_zero else number.rounds(x, turn)):
                return name
        return None

    def exactly(self, surface: Surface, event: Record, reason: str) -> Finding:
        """Proved, if each number that is printed as an exact 0 is one."""
        names = ("alpha_deg", f"theta{surface.fixed}_deg", *(f"l{leg}" for leg in surface.free))
        if any(event[name].is_zero and name not in self.zeros for name in names):
            return ClaimStatus.CHECKED, f"{reason}; that a number is exactly 0, beyond the digits"
        return ClaimStatus.PROVED, reason


def enclosed(pair: Pair) -> Interval:
    """All angles in radians with this cosine and sine, a small box, but for whole turns.

    Raises:
        ArithmeticError: it is no small box.
    """
    near = angle_of(pair)
    (cos, sin), (at_cos, at_sin) = pair, cos_sin(near)
    off = sin * at_cos - cos * at_sin
    if (cos * at_cos + sin * at_sin).sign <= 0:
        raise ArithmeticError("a direction is not known well enough")
    # |δ| ≤ 2 |sin δ| for |δ| < π/2
    return Interval.of(near.middle, near.bits, 2 * off.greatest)


def distinct(landmarks: Sequence[Landmark]) -> list[Landmark]:
    """Without those whose lengths are exactly those of others."""
    known: dict[object, Landmark] = {}
    for n, landmark in enumerate(landmarks):
        known.setdefault(n if landmark.square is None else landmark.square, landmark)
    return list(known.values())


def event_numbers(surface: Surface, event: Record) -> list[Printed]:
    """The printed angles and lengths of an event."""
    legs = (event[f"l{number}"] for number in surface.free)
    return [event["alpha_deg"], event[f"theta{surface.fixed}_deg"], *legs]


def bits_of(numbers: Sequence[Printed]) -> int:
    """Bits well below the last digits of printed numbers."""
    least = min((x.half for x in numbers if not x.is_zero), default=Fraction(1))
    return (least.denominator // least.numerator).bit_length() + _SPARE_BITS
