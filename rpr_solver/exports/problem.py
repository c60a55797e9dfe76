"""What a script is to compute, and the answer that it is to find: the same for every system.

A free leg has a base point a and a platform point m, both seen from the fixed leg, and the squared length
|L e(θ) + R(α) m − a|². Of m, x is rational and y is 0 or ±h, where h² is rational.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import atan2, cos, floor, isqrt, radians
from typing import Any

from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.joint_points import coordinate_names, free_legs
from rpr_solver.model.manipulator import CW, Manipulator

_TURNS = (("1", "0"), ("3/5", "4/5"), ("5/13", "12/13"), ("7/25", "24/25"))
"""Cosine and sine of the angles from which half tangents may be taken."""
_NEAR_INFINITY = 1e-6
SWALLOWTAIL, CRITICAL = "swallowtail", "critical"
_SYSTEMS = {
    PoseKind.SWALLOWTAIL.value: SWALLOWTAIL,
    PoseKind.LIPS.value: CRITICAL,
    PoseKind.BEAK_TO_BEAK.value: CRITICAL,
}


def ratio(x: Fraction) -> str:
    """A rational as every system reads it exactly: a decimal would be a float there."""
    return str(x.numerator) if x.denominator == 1 else f"{x.numerator}/{x.denominator}"


Numbers = tuple[str, ...]
"""α and θ in degrees, and the lengths of the free legs, as a document prints them."""


@dataclass(frozen=True)
class Leg:
    """A free leg: its base point, and its platform point (x, y·h), seen from the fixed leg."""

    ax: str
    ay: str
    x: str
    y: int


@dataclass(frozen=True)
class SliceTask:
    """A slice: its length, its number of cusps, and the cusps; None if only their number is expected."""

    length: str
    count: int
    cusps: tuple[Numbers, ...] | None = None

    @property
    def exact(self) -> str:
        """The length as every system reads it exactly."""
        return ratio(Fraction(self.length))


@dataclass(frozen=True)
class EventTask:
    """A degenerate pose of a transition: its length, its system of equations, and its numbers."""

    length: str
    system: str
    numbers: Numbers


@dataclass(frozen=True)
class Problem:
    """The slices and events of one manipulator.

    Attributes:
        about: what it is, in lines without an end.
        fixed_leg: the leg of fixed length.
        names: of the coordinates, as a document has them.
        legs: the two free legs.
        square: h², exact.
        height: h if it is rational, else None; its sign is ``sign``.
        sign: of h.
        turns: cosine and sine of the α and the θ from which half tangents are taken: no expected pose is
            opposite to them.
        digits: the significant digits of the expected numbers.
    """

    about: tuple[str, ...]
    fixed_leg: int
    names: tuple[str, ...]
    legs: tuple[Leg, Leg]
    square: str
    height: str | None
    sign: int
    turns: tuple[tuple[str, str], tuple[str, str]]
    digits: int
    slices: tuple[SliceTask, ...]
    events: tuple[EventTask, ...]

    @property
    def precision(self) -> int:
        """The decimal digits with which a script should work."""
        return max(120, 3 * self.digits + 30)

    @property
    def size(self) -> int:
        """More than the sum of the coordinates of both legs."""
        return int(sum(abs(Fraction(x)) for leg in self.legs for x in (leg.ax, leg.ay, leg.x))) + 1


def problem_of(document: Mapping[str, Any]) -> Problem:
    """The problem whose answer is a cusp table or a census.

    Raises:
        InputError: it is another document, has slices without an answer, or a curve of degenerate poses.
    """
    try:
        m, leg = Manipulator.from_json(document["geometry"], max_digits=1 << 20), document["fixed_leg"]
        slices = tuple(_slices(document, leg))
        events = tuple(_events(document, leg))
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError.of("document", "is no cusp table and no census; give one as JSON") from None
    p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    square = m.d3**2 - p**2
    sign = -1 if m.orientation == CW else 1
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    numbers = [cusp for part in slices for cusp in part.cusps or ()] + [event.numbers for event in events]
    lengths = "  ".join(f"{name} = {value}" for name, value in m.to_json().items())
    return Problem(
        (f"3-RPR manipulator: {lengths}", f"leg {leg} fixed; solver version {document['solver_version']}"),
        leg,
        coordinate_names(leg),
        _legs(m, leg, p),
        ratio(square),
        ratio(sign * root) if root**2 == square else None,
        sign,
        (_turn([x[0] for x in numbers]), _turn([x[1] for x in numbers])),
        document["digits"],
        slices,
        events,
    )


def _legs(m: Manipulator, fixed_leg: int, p: Fraction) -> tuple[Leg, Leg]:
    base = {1: (Fraction(0), Fraction(0)), 2: (m.a2x, Fraction(0)), 3: (m.a3x, m.a3y)}
    platform = {1: (Fraction(0), 0), 2: (m.d1, 0), 3: (p, 1)}
    (ax, ay), (mx, my) = base[fixed_leg], platform[fixed_leg]
    first, second = (
        Leg(ratio(bx - ax), ratio(by - ay), ratio(x - mx), y - my)
        for (bx, by), (x, y) in ((base[k], platform[k]) for k in free_legs(fixed_leg))
    )
    return first, second


def _turn(angles: Sequence[str]) -> tuple[str, str]:
    """The first turn to which none of the angles is opposite."""

    def apart(turn: tuple[str, str]) -> bool:
        at = atan2(float(Fraction(turn[1])), float(Fraction(turn[0])))
        return all(cos(radians(float(x)) - at) > _NEAR_INFINITY - 1 for x in angles)

    return next(filter(apart, _TURNS), _TURNS[0])


def _slices(document: Mapping[str, Any], leg: int) -> Iterator[SliceTask]:
    name, names = f"l{leg}", coordinate_names(leg)
    if any(part["kind"] == PoseKind.CURVE for part in document.get("degenerate", ())):
        raise InputError.of(
            "document", "has a curve of degenerate poses: no system of equations stands for it"
        )
    for number, part in enumerate(document.get("slices", ())):
        if "error" in part:
            raise InputError.of(f"document.slices[{number}]", "has no answer")
        if any(point["kind"] == PoseKind.CURVE for point in part["degenerate_points"]):
            raise InputError.of(f"document.slices[{number}]", "has a whole curve of degenerate poses")
        cusps = tuple(tuple(cusp[x] for x in names) for cusp in part["cusps"])
        if len(cusps) != part["count"]:
            words = f"is {part['count']}, but {len(cusps)} cusps are listed"
            raise InputError.of(f"document.slices[{number}].count", words)
        yield SliceTask(part[name], part["count"], cusps)
    if "slices" not in document:
        for part in document["intervals"]:
            yield SliceTask(_between(part["from"], part["to"]), part["count"])


def _events(document: Mapping[str, Any], leg: int) -> Iterator[EventTask]:
    for transition in document.get("transitions", ()):
        for event in transition["events"]:
            if event["kind"] in _SYSTEMS:
                numbers = tuple(event[x] for x in coordinate_names(leg))
                yield EventTask(transition[f"l{leg}"], _SYSTEMS[event["kind"]], numbers)


def _between(start: str, stop: str | None) -> str:
    """A short decimal between two lengths."""
    low, high = Fraction(start), 3 * Fraction(start) + 1 if stop is None else Fraction(stop)
    step = Fraction(1)
    while step > (high - low) / 4:
        step /= 10
    return exact_str(floor((low + high) / 2 / step) * step)
