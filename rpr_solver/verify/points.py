"""Points of a slice: the proof that a printed pose is a cusp, or the check that it is degenerate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from rpr_solver.errors import InputError
from rpr_solver.verify.angles import degrees
from rpr_solver.verify.boxes import Box, Equations, around, zero_near
from rpr_solver.verify.claims import ClaimStatus
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.system import Leg, System, Trig, derivative

_SPARE_BITS = 40
Finding = tuple[ClaimStatus, str]

CONDITIONS = {
    "cusp": "J = E = 0",
    "swallowtail": "J = v·∇E = 0",
    "lips": "∇J = 0",
    "beak-to-beak": "∇J = 0",
    "isolated-point": "∇J = 0",
    "node": "∇J = 0",
    "quadruple": "∇f = ∇g = 0",
}
"""Kind → the equations that find the pose."""

DEFINITE = {"lips": 1, "isolated-point": 1, "beak-to-beak": -1, "node": -1}
"""Kind → the sign of the determinant of the Hessian of J."""


@dataclass(frozen=True)
class Point:
    """A printed point of a slice: α and θ in degrees, the lengths of the free legs."""

    alpha: Printed
    theta: Printed
    lengths: tuple[Printed, Printed]

    @classmethod
    def of(cls, point: Mapping[str, Any], system: System, field: str) -> Point:
        """Reads a point.

        Raises:
            InputError: naming the coordinate that is missing or no decimal.
        """
        names = ("alpha_deg", f"theta{system.fixed}_deg", *(f"l{leg.number}" for leg in system.legs))
        alpha, theta, first, second = (Printed.of(point.get(name), f"{field}/{name}") for name in names)
        return cls(alpha, theta, (first, second))

    @property
    def numbers(self) -> tuple[Printed, ...]:
        """All four numbers."""
        return self.alpha, self.theta, *self.lengths

    @property
    def bits(self) -> int:
        """Bits well below the last printed digit of the angles and the lengths."""
        least = min((x.half for x in self.numbers if not x.is_zero), default=Fraction(1))
        return (least.denominator // least.numerator).bit_length() + _SPARE_BITS


class Points:
    """The equations of a slice, differentiated once for all of its points."""

    def __init__(self, system: System) -> None:
        self.system = system

    @cached_property
    def _kernel(self) -> tuple[Equations, Equations]:
        first, second = self.system.legs
        return self._pair(self.system.singular, first.kernel), self._pair(self.system.singular, second.kernel)

    @property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient of J and E."""
        return max(pair.coefficient_bits for pair in self._kernel)

    def _pair(self, first: Trig, second: Trig) -> Equations:
        return Equations.of(first, second, self.system.ring.radicand)

    def cusp(self, point: Point, bits: int = 0) -> tuple[Box | None, Finding]:
        """The proved box of a cusp, of some 2^−``bits`` at most, and what is found about its digits."""
        box = self.cusp_near(point.alpha.value, point.theta.value, max(point.bits, bits))
        if box is None:
            reason = "no zero of J = E = 0 with a regular derivative is proved near the pose"
            return None, (ClaimStatus.REFUSED, reason)
        return box, self.printed_right(point, box)

    def cusp_near(self, alpha: Fraction, theta: Fraction, bits: int, apart: int = 0) -> Box | None:
        """The proved box of the cusp near two angles in degrees, others being 2^−``apart`` away; or None."""
        for leg, equations in zip(self.system.legs, self._kernel, strict=True):
            box = zero_near(equations, alpha, theta, bits, apart)
            if box and any(box.directions.value(slope).sign for slope in (leg.alpha, leg.theta)):
                return box
        return None

    def printed_right(self, point: Point, box: Box) -> Finding:
        """What is found about the digits of a cusp with a proved box."""
        status, reason = self.digits(point, box)
        if status is not ClaimStatus.REFUSED:
            reason = f"a proved box holds one zero of (J, E), with a regular derivative; {reason}"
        return status, reason

    def degenerate(self, kind: str, point: Point) -> tuple[Box, Finding]:
        """The box of a degenerate pose, and what is found about its digits and conditions."""
        for name, equations in self._systems(kind):
            box = zero_near(equations, point.alpha.value, point.theta.value, point.bits)
            if box is None:
                continue
            if any(box.directions.value(p).sign for p in self._conditions):
                return box, (ClaimStatus.REFUSED, f"J = E = 0 does not hold at the solution of {name}")
            if kind in DEFINITE and self._curvature(box) != DEFINITE[kind]:
                return box, (ClaimStatus.REFUSED, f"the Hessian of J is not that of {kind}")
            status, reason = self.digits(point, box)
            if status is ClaimStatus.PROVED:
                status, reason = (
                    ClaimStatus.CHECKED,
                    f"one zero of {name}, J = E = 0 beyond the digits; {reason}",
                )
            return box, (status, reason)
        bits = point.bits + self.coefficient_bits
        box = around(point.alpha, point.theta, bits, self.system.ring.radicand)
        if any(box.directions.value(p).sign for p in self._conditions):
            return box, (
                ClaimStatus.REFUSED,
                "J = E = 0 does not hold for any angles that round to the printed ones",
            )
        if any(p.rounds(self.length(leg, box)) is False for p, leg in self._with_legs(point)):
            return box, (ClaimStatus.REFUSED, "a length is wrong")
        return box, (ClaimStatus.CHECKED, "J = E = 0 is possible for angles that round to the printed ones")

    def _curvature(self, box: Box) -> int:
        """The sign of the determinant of the Hessian of J, 0 if it is open."""
        slopes = (derivative(self.system.singular, theta=side) for side in (False, True))
        hessian = [[derivative(p, theta=side) for side in (False, True)] for p in slopes]
        (a, b), (c, d) = ([box.directions.value(p) for p in row] for row in hessian)
        return (a * d - b * c).sign

    @property
    def _conditions(self) -> list[Trig]:
        return [self.system.singular, *(leg.kernel for leg in self.system.legs)]

    def _with_legs(self, point: Point) -> Iterator[tuple[Printed, Leg]]:
        return zip(point.lengths, self.system.legs, strict=True)

    def _systems(self, kind: str) -> Iterator[tuple[str, Equations]]:
        j = self.system.singular
        slopes = derivative(j, theta=False), derivative(j, theta=True)
        if CONDITIONS.get(kind) in ("∇J = 0", None):
            yield "∇J = 0", self._pair(*slopes)
        if CONDITIONS.get(kind) in ("J = v·∇E = 0", None):
            yield from (("J = v·∇E = 0", self._pair(j, leg.kernel2)) for leg in self.system.legs)
        if CONDITIONS.get(kind) in ("∇f = ∇g = 0", None):
            yield from (("∇f = 0", self._pair(leg.alpha, leg.theta)) for leg in self.system.legs)

    def digits(self, point: Point, box: Box) -> Finding:
        """Whether each printed digit is right at the zero in a box."""
        system = self.system
        values = [degrees(box.alpha), degrees(box.theta), *(self.length(leg, box) for leg in system.legs)]
        names = ("alpha_deg", f"theta{system.fixed}_deg", *(f"l{leg.number}" for leg in system.legs))
        for name, printed, value, turn in zip(names, point.numbers, values, (360, 360, 0, 0), strict=True):
            if printed.is_zero:
                if not value.contains(0):
                    return ClaimStatus.REFUSED, f"{name} is not 0"
                continue
            right = printed.rounds(value, turn)
            if not right:
                return (
                    ClaimStatus.REFUSED,
                    f"a digit of {name} is wrong" if right is False else f"{name} is undecided",
                )
        return ClaimStatus.PROVED, "each printed digit is right"

    def length(self, leg: Leg, box: Box) -> Interval:
        """The length of a free leg in the user's unit."""
        scaled = box.directions.value(leg.squared).root()
        return scaled.over(Interval.of(self.system.unit, scaled.bits))


def read(points: Any, system: System, field: str) -> list[Point]:
    """Reads a list of points.

    Raises:
        InputError: naming what is no point.
    """
    if not isinstance(points, list) or not all(isinstance(point, Mapping) for point in points):
        raise InputError.of(field, "is not a list of points")
    return [Point.of(point, system, f"{field}/{n}") for n, point in enumerate(points)]
