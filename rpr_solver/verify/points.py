"""Points of a slice: the proof that a printed pose is a cusp, or what is found of one that is degenerate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations

from rpr_solver.verify.claims import ClaimStatus
from rpr_solver.verify.core.angles import degrees
from rpr_solver.verify.core.boxes import Box, Equations, around, common_on_axis, zero_near
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.system import Leg, System, Trig, derivative
from rpr_solver.verify.surface import Surface

_SPARE_BITS = 40
Finding = tuple[ClaimStatus, str]

DEFINITE = {"lips": 1, "isolated-point": 1, "beak-to-beak": -1, "node": -1}
"""Kind with ∇J = 0 → the sign of the determinant of the Hessian of J."""


@dataclass(frozen=True)
class Point:
    """A printed point of a slice: α and θ in degrees, the lengths of the free legs."""

    alpha: Printed
    theta: Printed
    lengths: tuple[Printed, Printed]

    @classmethod
    def of(cls, point: Record, system: System) -> Point:
        """The point of a document."""
        first, second = (point[f"l{leg.number}"] for leg in system.legs)
        return cls(point["alpha_deg"], point[f"theta{system.fixed}_deg"], (first, second))

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

    def alone(self, box: Box) -> Interval | None:
        """All α of a wide box about that of a cusp, which holds no other zero of J = E = 0; or None."""
        found = (equations.alone(box) for equations in self._kernel)
        return next((wide.alpha for wide in found if wide is not None), None)

    def printed_right(self, point: Point, box: Box) -> Finding:
        """What is found about the digits of a cusp with a proved box."""
        status, reason = self.digits(point, box, self._kernel)
        if status is not ClaimStatus.REFUSED:
            reason = f"a proved box holds one zero of (J, E), with a regular derivative; {reason}"
        return status, reason

    def degenerate(self, kind: str, point: Point) -> tuple[Box, Finding]:
        """The box of a degenerate pose, and what is found about its digits, its kind and its conditions.

        The equations of a kind are more than its unknowns; a regular zero of two of them is proved, that the
        others hold is checked beyond the digits.
        """
        cusp, found = self.cusp(point)
        if cusp is not None and found[0] is ClaimStatus.PROVED:
            return cusp, (ClaimStatus.REFUSED, "it is a cusp: a proved box holds one regular zero of (J, E)")
        for name, equations, conditions in self._systems(kind):
            box = zero_near(equations, point.alpha.value, point.theta.value, point.bits)
            if box is None:
                continue
            if any(box.directions.value(p).sign for p in conditions):
                return box, (ClaimStatus.REFUSED, f"J = E = 0 does not hold at the solution of {name}")
            if not self._may_be(kind, box):
                return box, (ClaimStatus.REFUSED, f"the derivatives are not those of {kind}")
            status, reason = self.digits(point, box, (equations,))
            if status is not ClaimStatus.REFUSED:
                status = ClaimStatus.CHECKED
                reason = f"one zero of {name}, J = E = 0 and the kind beyond the digits; {reason}"
            return box, (status, reason)
        bits = point.bits + self.coefficient_bits
        box = around(point.alpha, point.theta, bits, self.system.ring.radicand)
        if kind not in ("higher", "quadruple"):
            return box, (ClaimStatus.REFUSED, f"no zero of the equations of {kind} is proved near the pose")
        if any(box.directions.value(p).sign for p in self._conditions):
            reason = "J = E = 0 does not hold for any angles that round to the printed ones"
            return box, (ClaimStatus.REFUSED, reason)
        if any(p.rounds(self.length(leg, box)) is False for p, leg in self._with_legs(point)):
            return box, (ClaimStatus.REFUSED, "a length is wrong")
        return box, (ClaimStatus.NOT_CHECKED, "no equations are known that prove its digits")

    def _may_be(self, kind: str, box: Box) -> bool:
        """Whether derivatives that are not 0 in a box leave a kind possible."""
        here, (first, second) = box.directions, self.system.legs
        if kind in DEFINITE:
            if self._curvature(box) != DEFINITE[kind]:
                return False
            regular = [
                leg for leg in (first, second) if any(here.value(p).sign for p in (leg.alpha, leg.theta))
            ]
            lasting = not here.value(self._in_length).sign  # as L changes the pose stays singular
            if not regular:
                return False
            tangent = not here.value(regular[0].kernel2).sign
            return {
                "lips": not lasting and not tangent,
                "isolated-point": lasting or tangent,
                "beak-to-beak": not lasting and not tangent,
                "node": lasting or tangent,
            }[kind]
        return True

    @cached_property
    def _in_length(self) -> Trig:
        """∂J/∂L at a pose with J = 0, but for a constant factor."""
        graded = Surface.of(self.system.geometry, self.system.fixed).singular
        return graded[1] if len(graded) > 1 else {}

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

    def _systems(self, kind: str) -> Iterator[tuple[str, Equations, list[Trig]]]:
        """Two equations of a kind, and all others: with their name."""
        j, legs = self.system.singular, self.system.legs
        if kind in DEFINITE:
            slopes = derivative(j, theta=False), derivative(j, theta=True)
            yield "∇J = 0", self._pair(*slopes), self._conditions
        elif kind == "swallowtail":
            for leg in legs:
                others = [*self._conditions, *(other.kernel2 for other in legs)]
                yield "J = v·∇E = 0", self._pair(j, leg.kernel2), others
        elif kind == "quadruple":
            gradients = [p for leg in legs for p in (leg.alpha, leg.theta)]
            for first, second in combinations(gradients, 2):
                yield "∇f = ∇g = 0", self._pair(first, second), gradients

    def digits(self, point: Point, box: Box, systems: Sequence[Equations]) -> Finding:
        """Whether each printed digit is right at the zero in a box, the only one of each of some systems."""
        system = self.system
        values = [degrees(box.alpha), degrees(box.theta), *(self.length(leg, box) for leg in system.legs)]
        names = ("alpha_deg", f"theta{system.fixed}_deg", *(f"l{leg.number}" for leg in system.legs))
        for name, printed, value, turn in zip(names, point.numbers, values, (360, 360, 0, 0), strict=True):
            if printed.is_zero:
                if not value.contains(0):
                    return ClaimStatus.REFUSED, f"{name} is not 0"
                if turn and not any(common_on_axis(pair, box, theta=name != "alpha_deg") for pair in systems):
                    return ClaimStatus.REFUSED, f"{name} is not exactly 0"
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
