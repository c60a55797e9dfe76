"""Boxes of events in full certificates: each holds one zero of the equations of its kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import ceil
from typing import Any

from rpr_solver.verify.angles import pi
from rpr_solver.verify.boxes import Directions, precisions
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.krawczyk import contracted, proved_zero
from rpr_solver.verify.manipulator import exact
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Surface

_SPARE_BITS = 40
Side = tuple[Fraction, Fraction]
"""The centre and the radius of a side of a box."""


@dataclass(frozen=True)
class EventBox:
    """A box of the length and both angles, in the user's unit and in degrees, with the kind of its pose."""

    kind: str
    length: Side
    alpha: Side
    theta: Side

    @classmethod
    def of(cls, entry: Mapping[str, Any], fixed: int, at: str) -> EventBox:
        """Reads a box.

        Raises:
            InputError: naming what is no number.
        """

        def side(name: str) -> Side:
            numbers = (exact(entry[name][part], f"{at}/{name}/{part}") for part in ("centre", "radius"))
            centre, radius = numbers
            return centre, radius

        return cls(str(entry["kind"]), side(f"l{fixed}"), side("alpha_deg"), side(f"theta{fixed}_deg"))

    @property
    def ends(self) -> tuple[Fraction, Fraction]:
        """The least and the greatest length."""
        centre, radius = self.length
        return centre - radius, centre + radius

    def may_be(self, kind: object, length: Printed, alpha: Printed, theta: Printed) -> bool:
        """Whether a printed event may be the one in this box."""
        sides = ((self.length, length, 0), (self.alpha, alpha, 360), (self.theta, theta, 360))
        return kind == self.kind and all(_near(side, printed, turn) for side, printed, turn in sides)

    def intervals(self, surface: Surface, bits: int, shift: int) -> list[Interval]:
        """α and θ in radians and the scaled length in units of 2^shift."""
        turn = pi(bits)
        angles = [turn * Interval.of(c / 180, bits, r / 180) for c, r in (self.alpha, self.theta)]
        unit = Fraction(surface.unit, 1 << shift)
        return [*angles, Interval.of(self.length[0] * unit, bits, self.length[1] * unit)]


@dataclass(frozen=True)
class ProvedEvent:
    """The zero in a box, in intervals far smaller than it, and the name of the system that it solves."""

    system: str
    zero: list[Interval]

    def tangent(self, surface: Surface) -> Interval | None:
        """tan θ; None if θ may be ±90°."""
        cos, sin = Directions.of(self.zero[0], self.zero[1], surface.ring.radicand).theta
        return None if not cos.sign else sin.over(cos)


def proved_event(surface: Surface, box: EventBox) -> ProvedEvent | None:
    """The proof that a box holds exactly one zero of the equations of its kind; None if there is none."""
    radius = min(side[1] for side in (box.length, box.alpha, box.theta))
    if radius <= 0:
        return None
    bits = (radius.denominator // radius.numerator).bit_length() + _SPARE_BITS
    shift = ceil(abs(box.length[0]) * surface.unit).bit_length()
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
                return ProvedEvent(name, [*zero[:2], zero[2].scaled(1 << shift)])
    return None


def _near(side: Side, printed: Printed, turn: int) -> bool:
    (centre, radius), shift = side, 0
    if turn:
        shift = round((centre - printed.value) / turn) * turn
    return abs(centre - shift - printed.value) <= radius + printed.half
