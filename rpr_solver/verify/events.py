"""Events: the degenerate pose of a transition, its length and its kind, digit by digit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rpr_solver.verify.angles import degrees
from rpr_solver.verify.boxes import Directions, around
from rpr_solver.verify.claims import ClaimStatus
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Graded, Surface, value

_SPARE_BITS = 40
GENERIC = ("swallowtail", "lips", "beak-to-beak")
_KINDS = (*GENERIC, "isolated-point", "node", "quadruple", "higher")
Finding = tuple[ClaimStatus, str]


def event_finding(
    surface: Surface, digits: int, printed: Printed, event: Mapping[str, Any], at: str
) -> Finding:
    """What is found about an event, its length and its digits.

    Raises:
        InputError: naming a coordinate that is missing or no decimal.
    """
    kind = str(event.get("kind"))
    if kind not in _KINDS:
        return ClaimStatus.REFUSED, "there is no such kind"
    names = ("alpha_deg", f"theta{surface.fixed}_deg", *(f"l{leg.number}" for leg in surface.legs))
    numbers = [Printed.of(event.get(name), f"{at}/{name}") for name in names]
    least = min(x.half for x in (*numbers, printed) if not x.is_zero)
    bits = (least.denominator // least.numerator).bit_length() + _SPARE_BITS
    for name, triple in surface.systems(kind):
        alpha, theta = numbers[0].value, numbers[1].value
        zero = triple.zero_near(alpha, theta, printed.value * surface.unit, bits)
        if zero is None:
            continue
        here = Directions.of(zero[0], zero[1], surface.ring.radicand)
        if any(value(here, p, zero[2]).sign for p in _conditions(surface)):
            return ClaimStatus.REFUSED, f"J = E = 0 does not hold at the solution of {name}"
        unit = Interval.of(surface.unit, zero[0].bits)
        lengths = (value(here, leg.squared, zero[2]).root().over(unit) for leg in surface.legs)
        values = [degrees(zero[0]), degrees(zero[1]), *lengths, zero[2].over(unit)]
        turns = (360, 360, 0, 0, 0)
        for text, x, number, turn in zip(
            (*names, f"l{surface.fixed}"), values, (*numbers, printed), turns, strict=True
        ):
            if not (x.contains(0) if number.is_zero else number.rounds(x, turn)):
                return ClaimStatus.REFUSED, f"a digit of {text} is wrong"
            if not number.is_zero and number.digits != digits:
                return ClaimStatus.REFUSED, f"{text} has more or fewer digits"
        return kind_finding(surface, kind, name, zero, ", each printed digit is right")
    others = (other for other in ("swallowtail", "lips") if kind in GENERIC and other != kind)
    for other in others:
        for name, triple in surface.systems(other):
            if triple.zero_near(numbers[0].value, numbers[1].value, printed.value * surface.unit, bits):
                return ClaimStatus.REFUSED, f"it is another kind of pose: a regular zero of {name}"
    if kind in ("lips", "beak-to-beak"):  # regular zeros by their definition
        return ClaimStatus.REFUSED, "no zero of J = 0, grad J = 0 is proved near the pose"
    work = 2 * bits + surface.coefficient_bits
    box = around(numbers[0], numbers[1], work, surface.ring.radicand)
    length = Interval.of(printed.value * surface.unit, work, printed.half * surface.unit)
    if any(value(box.directions, p, length).sign for p in _conditions(surface)):
        reason = "J = E = 0 does not hold for any numbers that round to the printed ones"
        return ClaimStatus.REFUSED, reason
    unit = Interval.of(surface.unit, work)
    for text, number, leg in zip(names[2:], numbers[2:], surface.legs, strict=True):
        x = value(box.directions, leg.squared, length).root().over(unit)
        if (x.contains(0) if number.is_zero else number.rounds(x)) is False:
            return ClaimStatus.REFUSED, f"{text} is not the length at the printed angles"
    return ClaimStatus.CHECKED, (
        "no regular system of equations is known for this event; J = E = 0 and its lengths are possible for "
        "numbers that round to the printed ones"
    )


def _conditions(surface: Surface) -> list[Graded]:
    """J and E along either leg."""
    return [surface.singular, *(leg.kernel for leg in surface.legs)]


def kind_finding(surface: Surface, kind: str, name: str, box: list[Interval], more: str = "") -> Finding:
    """Whether the zero of a system is an event of a kind.

    Args:
        surface: the equations.
        kind: the kind of pose.
        name: the system.
        box: a small box of α, θ and the scaled length that holds the zero.
        more: what else is proved of it.
    """
    proof = f"a proved box holds one zero of {name}{more}"
    if kind in ("lips", "beak-to-beak"):
        bent = surface.hessian(Directions.of(box[0], box[1], surface.ring.radicand), box[2])
        if bent.sign != (1 if kind == "lips" else -1):
            return ClaimStatus.REFUSED, f"the Hessian of J is not that of {kind}"
    if kind in GENERIC:
        return ClaimStatus.PROVED, proof
    return ClaimStatus.CHECKED, f"{proof}; J = E = 0 beyond the digits"
