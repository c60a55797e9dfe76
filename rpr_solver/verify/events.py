"""Events: the degenerate pose of a transition, proved near printed numbers or in a box, and its kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil

from rpr_solver.verify.claims import ClaimStatus
from rpr_solver.verify.core.angles import degrees, pi
from rpr_solver.verify.core.boxes import Directions, around, precisions
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import contracted, proved_zero
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.surface import Graded, Surface, value

_SPARE_BITS = 40
GENERIC = ("swallowtail", "lips", "beak-to-beak")
"""Kinds that are regular zeros of three equations; at one, two cusps are born or die."""
_ROOM = Fraction(1, 1000)
Finding = tuple[ClaimStatus, str]
Side = tuple[Fraction, Fraction]
"""The centre and the radius of a side of a box."""


@dataclass(frozen=True)
class ProvedEvent:
    """α, θ and the scaled length of a zero of a system, in small intervals, and the name of the system."""

    system: str
    zero: tuple[Interval, Interval, Interval]

    def here(self, surface: Surface) -> Directions:
        """Its directions."""
        return Directions.of(self.zero[0], self.zero[1], surface.ring.radicand)

    def tangent(self, surface: Surface) -> Interval | None:
        """tan θ; None if θ may be ±90°."""
        cos, sin = self.here(surface).theta
        return None if not cos.sign else sin.over(cos)

    def length(self, surface: Surface) -> Interval:
        """The length in the user's unit."""
        return self.zero[2].over(Interval.of(surface.unit, self.zero[2].bits))

    def rounds_to(self, surface: Surface, length: Printed, event: Record) -> str | None:
        """The first printed number of an event that is wrong for this zero; None if all are right."""
        here, unit = self.here(surface), Interval.of(surface.unit, self.zero[2].bits)
        values = {
            f"l{surface.fixed}": (self.length(surface), length, 0),
            "alpha_deg": (degrees(self.zero[0]), event["alpha_deg"], 360),
            f"theta{surface.fixed}_deg": (degrees(self.zero[1]), event[f"theta{surface.fixed}_deg"], 360),
        }
        for leg in surface.legs:
            name = f"l{leg.number}"
            values[name] = value(here, leg.squared, self.zero[2]).root().over(unit), event[name], 0
        for name, (x, number, turn) in values.items():
            if not (x.contains(0) if number.is_zero else number.rounds(x, turn)):
                return name
        return None


def event_finding(surface: Surface, length: Printed, event: Record) -> Finding:
    """What is found about an event, its length, its digits and its kind."""
    kind, theta = event["kind"], f"theta{surface.fixed}_deg"
    numbers = [event["alpha_deg"], event[theta], *(event[f"l{leg.number}"] for leg in surface.legs)]
    least = min(x.half for x in (*numbers, length) if not x.is_zero)
    bits = (least.denominator // least.numerator).bit_length() + _SPARE_BITS
    for name, triple in surface.systems(kind):
        zero = triple.zero_near(numbers[0].value, numbers[1].value, length.value * surface.unit, bits)
        if zero is None:
            continue
        proof = ProvedEvent(name, (zero[0], zero[1], zero[2]))
        if (wrong := proof.rounds_to(surface, length, event)) is not None:
            return ClaimStatus.REFUSED, f"a digit of {wrong} is wrong"
        status, reason = kind_finding(surface, kind, proof)
        if status is ClaimStatus.PROVED and any(x.is_zero for x in numbers):
            return ClaimStatus.CHECKED, f"{reason}; that an angle is exactly 0, beyond the digits"
        more = ", each printed digit is right" if status is not ClaimStatus.REFUSED else ""
        return status, reason + more
    if kind in GENERIC:
        return ClaimStatus.REFUSED, f"no regular zero of the equations of {kind} is proved near the pose"
    for other in GENERIC:
        if event_finding(surface, length, {**event, "kind": other})[0] is ClaimStatus.PROVED:
            return ClaimStatus.REFUSED, f"it is a {other}"
    work = 2 * bits + surface.coefficient_bits
    box = around(numbers[0], numbers[1], work, surface.ring.radicand)
    scaled = Interval.of(length.value * surface.unit, work, length.half * surface.unit)
    if not _may_be(surface, kind, box.directions, scaled):
        return ClaimStatus.REFUSED, f"it is no {kind} for any numbers that round to the printed ones"
    unit = Interval.of(surface.unit, work)
    for number, leg in zip(numbers[2:], surface.legs, strict=True):
        x = value(box.directions, leg.squared, scaled).root().over(unit)
        if number.rounds(x) is False:
            return ClaimStatus.REFUSED, f"l{leg.number} is not the length at the printed angles"
    return ClaimStatus.NOT_CHECKED, "no regular system of equations is known for this event"


def _may_be(surface: Surface, kind: str, here: Directions, length: Interval) -> bool:
    """Whether what is 0 at an event of no generic kind may be 0 in a box."""

    def may_vanish(*functions: Graded) -> bool:
        return not any(value(here, p, length).sign for p in functions)

    if not may_vanish(surface.singular, *(leg.kernel for leg in surface.legs)):
        return False
    slopes = may_vanish(*surface.slopes)
    tangent = may_vanish(*(leg.kernel2 for leg in surface.legs))
    rank_0 = may_vanish(*(p for leg in surface.legs for p in (leg.alpha, leg.theta)))
    return {"quadruple": rank_0, "higher": slopes or tangent}.get(kind, slopes)


def kind_finding(surface: Surface, kind: str, proof: ProvedEvent) -> Finding:
    """Whether the zero of a system of a kind is an event of this kind."""
    here, length = proof.here(surface), proof.zero[2]
    reason = f"a proved box holds one zero of {proof.system}"
    if kind not in GENERIC:
        if not _may_be(surface, kind, here, length):
            return ClaimStatus.REFUSED, f"{reason}, which is no {kind}"
        return ClaimStatus.CHECKED, f"{reason}; the other equations of {kind} beyond the digits"
    if kind != "swallowtail" and surface.hessian(here, length).sign != (1 if kind == "lips" else -1):
        return ClaimStatus.REFUSED, f"the Hessian of J is not that of {kind}"
    regular = [
        leg for leg in surface.legs if any(value(here, p, length).sign for p in (leg.alpha, leg.theta))
    ]
    if not regular:
        return ClaimStatus.REFUSED, f"the gradients of both legs may be 0, which is no {kind}"
    if kind == "beak-to-beak" and not value(here, regular[0].kernel2, length).sign:
        return ClaimStatus.REFUSED, "v·∇E may be 0, which is no beak-to-beak"
    return ClaimStatus.PROVED, reason


@dataclass(frozen=True)
class EventBox:
    """A box of the length and both angles, in the user's unit and in degrees, with the kind of its pose."""

    kind: str
    length: Side
    alpha: Side
    theta: Side

    @classmethod
    def of(cls, entry: Record, fixed: int) -> EventBox:
        """The box of a document."""
        sides = (
            (entry[name]["centre"], entry[name]["radius"])
            for name in (f"l{fixed}", "alpha_deg", f"theta{fixed}_deg")
        )
        return cls(entry["kind"], *sides)

    @property
    def fault(self) -> str:
        """Why it is no box that can stand for one event; empty if it can.

        A zero with the length L at θ is one with −L at θ + 180°, and the same a turn further: only in a small
        box of lengths > 0 and of angles of one turn is each event once.
        """
        centre, radius = self.length
        if radius * 1000 > centre:
            return "its lengths are not all > 0, or it is wide"
        if any(abs(c) > 180 or r > _ROOM for c, r in (self.alpha, self.theta)):
            return "its angles are not within one turn, or it is wide"
        return ""

    def intervals(self, surface: Surface, bits: int, shift: int) -> list[Interval]:
        """α and θ in radians and the scaled length in units of 2^shift."""
        turn = pi(bits)
        angles = [turn * Interval.of(c / 180, bits, r / 180) for c, r in (self.alpha, self.theta)]
        unit = Fraction(surface.unit, 1 << shift)
        return [*angles, Interval.of(self.length[0] * unit, bits, self.length[1] * unit)]


def proved_event(surface: Surface, box: EventBox) -> ProvedEvent | None:
    """The proof that a box holds exactly one zero of the equations of its kind; None if there is none."""
    if box.fault:
        return None
    radius = min(side[1] for side in (box.length, box.alpha, box.theta))
    bits = (radius.denominator // radius.numerator).bit_length() + _SPARE_BITS
    shift = ceil(box.length[0] * surface.unit).bit_length()
    for name, triple in surface.systems(box.kind):
        near_one = triple.in_units_of(shift)
        for work in precisions(bits + shift + near_one.coefficient_bits):
            wide = box.intervals(surface, work, shift)
            if contracted(near_one, wide) is None:
                continue
            zero = proved_zero(near_one, wide, bits + shift)
            # the zero of the box is the only one, so a zero within it is this one
            if zero is not None and all(
                x.lower < y.lower <= y.upper < x.upper for x, y in zip(wide, zero, strict=True)
            ):
                return ProvedEvent(name, (zero[0], zero[1], zero[2].scaled(1 << shift)))
    return None


def matched(
    surface: Surface, length: Printed, events: Sequence[Record], proofs: Sequence[tuple[str, ProvedEvent]]
) -> Iterator[int | None]:
    """For each printed event of a length the place of a proof of its kind with its digits, each once."""
    used: set[int] = set()
    for event in events:
        fits = (
            n
            for n, (kind, proof) in enumerate(proofs)
            if n not in used and kind == event["kind"] and proof.rounds_to(surface, length, event) is None
        )
        found = next(fits, None)
        used |= set() if found is None else {found}
        yield found
