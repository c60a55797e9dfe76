"""The full certificate of a census: what an independent checker needs to check it without solving it.

    {"systems": [{"name": "swallowtails", "polynomial": {"variable": "v = tan(theta1)", …},
                  "squarefree": {"prime": "…", "omega": "…"},
                  "real_roots": [{"lower": "…", "upper": "…", "multiplicity": 1}, …]}, …],
     "events": [{"kind": "swallowtail", "l1": {"centre": "…", "radius": "…"}, "alpha_deg": …}, …],
     "samples": ["…", …]}

The systems are those of event_systems.py, each with its eliminant P(v), exact, and isolating intervals of all
its real roots (mathematics.md#the-eliminants-of-the-census). ``squarefree`` is null if a root is multiple or
infinite. ``events`` has a box in all unknowns for each degenerate pose, of all lengths, in or out of the
range; tan θ of it lies in the interval of its root. ``samples`` has for each interval the length of the slice
in which its cusps were counted.

Where events are not isolated (method ``"components"``), there are no systems, and the events are those of the
transitions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import floor
from typing import Any

from flint import arb, ctx

from rpr_solver.exact import GREATEST_BITS, decided
from rpr_solver.exact.factors import Certified
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import RealRoot, ball_of, fraction_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.components import once
from rpr_solver.transitions.event_systems import Event, EventSystems, System
from rpr_solver.transitions.isolated_events import BallEvent
from rpr_solver.transitions.survey import Survey, grouped

_FIRST_BITS = 128
_BITS_OF_AN_END, _BITS_OF_A_PLACE = 8, 4
"""Bits of precision for each decimal place of an isolating interval, and of a box, which is to be smaller."""
End = tuple[Fraction, Fraction]


def full_certificate(result: Survey, transitions: Sequence[int]) -> dict[str, Any]:
    """The member ``full`` of a census's certificate.

    Args:
        result: the survey of the range.
        transitions: the numbers of its groups that are transitions.

    Raises:
        SolverError: an event could not be enclosed.
    """
    slice_map = result.eliminant.slice_map
    isolated = [_Isolated.of(name, system) for name, system in _systems(result.systems)]
    groups = map(once, grouped(result.events)) if isolated else (result.groups[k] for k in transitions)
    events = [event for group in groups for event in group]
    samples = [result.slices[0], *(result.slices[k + 1] for k in transitions)]
    return {
        "systems": [system.to_json() for system in isolated],
        "events": [_event_json(slice_map, event, isolated) for event in _ascending(events)],
        "samples": [exact_str(part.length) for part in samples],
    }


def _systems(systems: EventSystems | None) -> Iterator[tuple[str, System]]:
    if systems is not None:
        yield "swallowtails", systems.swallowtails
        yield "critical poses", systems.critical
        for system in systems.near_shared_angles:
            yield "beside shared angles", system


def _ascending(events: Sequence[Event]) -> list[Event]:
    """Those with a pose, by middles of their lengths."""
    return sorted((e for e in events if e.pose), key=lambda e: fraction_of(e.scaled_length(_FIRST_BITS)))


@dataclass(frozen=True)
class _Isolated:
    """A system with isolating intervals of the roots of its eliminant, ascending, with multiplicities."""

    name: str
    system: System
    eliminant: Certified
    intervals: tuple[tuple[Fraction, Fraction, int], ...]

    @classmethod
    def of(cls, name: str, system: System) -> _Isolated:
        eliminant = Certified.of(system.eliminant)

        def disjoint(bits: int) -> list[tuple[Fraction, Fraction, int]] | None:
            ends = [(_ends(root, bits), multiplicity) for root, multiplicity in eliminant.roots]
            found = sorted((*end, multiplicity) for end, multiplicity in ends if end is not None)
            apart = all(x[1] < y[0] for x, y in pairwise(found))
            return found if apart and len(found) == len(ends) else None

        message = "the roots of the eliminant of transitions could not be isolated"
        return cls(name, system, eliminant, tuple(decided(disjoint, _FIRST_BITS, GREATEST_BITS, message)))

    def isolates(self, v: arb) -> bool:
        """Whether one of the intervals holds a ball."""
        return any(ball_of(low) < v < ball_of(high) for low, high, _ in self.intervals)

    def to_json(self) -> dict[str, Any]:
        leg = self.system.slice_map.fixed_leg
        return {"name": self.name, **self.eliminant.to_json(f"v = tan(theta{leg})", self.intervals)}


def _ends(root: RealRoot, bits: int) -> End | None:
    """Two short decimals on either side of a root; None if its ball is too wide for these."""
    ball, unit = root.refined(bits), Fraction(1, 10 ** (bits // _BITS_OF_AN_END))
    with ctx.workprec(2 * bits):
        below = floor(fraction_of(ball) / unit) - 1
        low, high = below * unit, (below + 3) * unit
        return (low, high) if ball_of(low) < ball < ball_of(high) else None


def _event_json(slice_map: SliceMap, event: Event, systems: Sequence[_Isolated]) -> dict[str, Any]:
    """The kind, and a box of the length and both angles."""
    assert event.pose is not None
    pose, leg = event.pose, slice_map.fixed_leg
    mine = [part for part in systems if isinstance(event, BallEvent) and part.system is event.system]

    def box(bits: int) -> list[_Side] | None:
        alpha, theta, *_ = pose.coordinates(2 * bits)
        length = event.scaled_length(2 * bits)
        with ctx.workprec(2 * bits):
            balls = (length / slice_map.scale_ball(), alpha, theta)
            sides = [_Side.of(x, bits // _BITS_OF_A_PLACE) for x in balls]
            if not all(side.holds(x) for side, x in zip(sides, balls, strict=True)):
                return None
            v = (sides[2].ball() * arb.pi() / 180).tan()
            return sides if all(part.isolates(v) for part in mine) else None

    sides = decided(box, _FIRST_BITS, GREATEST_BITS, "a transition could not be enclosed in a short box")
    names = (f"l{leg}", "alpha_deg", f"theta{leg}_deg")
    boxes = {name: side.to_json() for name, side in zip(names, sides, strict=True)}
    return {"kind": pose.kind.value, **boxes}


@dataclass(frozen=True)
class _Side:
    """A side of a box: a decimal centre, and two units of its last place as the radius."""

    centre: Fraction
    places: int

    @classmethod
    def of(cls, x: arb, places: int) -> _Side:
        """Round the middle of a ball; a number far below 1 gets more places."""
        middle = fraction_of(x)
        if middle:
            places += max(0, len(str(middle.denominator)) - len(str(abs(middle.numerator))))
        return cls(Fraction(round(middle * 10**places), 10**places), places)

    def ball(self) -> arb:
        """All its numbers."""
        return ball_of(self.centre) + arb(0, 1) * self._radius

    def holds(self, x: arb) -> bool:
        """Whether a ball lies within."""
        return bool(abs(x - ball_of(self.centre)) < self._radius)

    @property
    def _radius(self) -> arb:
        return arb(2) / arb(10) ** self.places

    def to_json(self) -> dict[str, str]:
        return {"centre": exact_str(self.centre), "radius": f"2e-{self.places}"}
