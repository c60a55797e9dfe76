"""All slices of one fixed leg at once: the same equations with its length as a third unknown.

Events are found as zeros of three equations: J = ∂J/∂α = ∂J/∂θ = 0 for lips and beaks, J = E = v·∇E = 0 for
swallowtails. A box of Krawczyk's test has the length besides both angles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.core.angles import radians
from rpr_solver.verify.core.boxes import Directions, precisions
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Matrix, proved_zero
from rpr_solver.verify.core.manipulator import Geometry
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.core.system import Trig, derivative, derive, graded, variables
from rpr_solver.verify.core.work import spend

CRITICAL, SWALLOWTAIL = "J = 0, grad J = 0", "J = E = v·grad E = 0"
"""The equations of lips and beaks, and of swallowtails."""

Graded = tuple[Trig, ...]
"""A trigonometric polynomial in α and θ by the powers of the scaled length."""


@dataclass(frozen=True)
class SurfaceLeg:
    """As :class:`~rpr_solver.verify.core.system.Leg`, for every length."""

    number: int
    squared: Graded
    alpha: Graded
    theta: Graded
    kernel: Graded
    kernel2: Graded


@dataclass(frozen=True)
class Surface:
    """A manipulator and its fixed leg; ``singular`` is J / L."""

    geometry: Geometry
    fixed: int
    unit: int
    ring: Ring
    legs: tuple[SurfaceLeg, SurfaceLeg]
    singular: Graded

    @classmethod
    def of(cls, geometry: Geometry, fixed: int) -> Surface:
        """Derives the equations."""
        spend(50_000, 8 * geometry.bits)
        symbols = variables(geometry, ())
        parts = derive(symbols, geometry, fixed, symbols.length)
        first, second = (
            SurfaceLeg(number, *(graded(symbols, part) for part in leg))
            for number, leg in zip(geometry.free_legs(fixed), parts.legs, strict=True)
        )
        singular = graded(symbols, parts.singular)
        return cls(geometry, fixed, symbols.unit, Ring(symbols.radicand), (first, second), singular)

    @property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient of J and E."""
        graded = (self.singular, *(leg.kernel for leg in self.legs))
        return max(part.bit_length() for p in graded for row in p for x in row.values() for part in x)

    @cached_property
    def slopes(self) -> tuple[Graded, Graded]:
        """The derivatives of J in α and θ."""
        return _slope(self.singular, theta=False), _slope(self.singular, theta=True)

    def hessian(self, here: Directions, length: Interval) -> Interval:
        """The determinant of the second derivatives of J in α and θ."""
        rows = [[value(here, _slope(p, theta=side), length) for side in (False, True)] for p in self.slopes]
        (a, b), (c, d) = rows
        return a * d - b * c

    def systems(self, kind: str) -> Iterator[tuple[str, Triple]]:
        """The systems of three equations of a kind, any of which finds the event, each with its name."""
        f, g = self.legs
        j, slopes = self.singular, self.slopes
        triples: list[tuple[str, Graded, Graded, Graded]] = []
        if kind in ("lips", "beak-to-beak"):
            triples = [(CRITICAL, j, *slopes)]
        elif kind == "swallowtail":
            triples = [(SWALLOWTAIL, j, leg.kernel, leg.kernel2) for leg in self.legs]
        if kind in ("isolated-point", "node", "higher"):
            # a node of every slice: where dJ/dL is 0 too, or v gets the direction of a branch of J = 0
            triples += [("grad J = 0, dJ/dL = 0", *slopes, (j[1],))] if len(j) > 1 else []
            triples += [("grad J = 0, v·grad E = 0", *slopes, leg.kernel2) for leg in self.legs]
            triples += [("grad J = 0, df/dtheta = 0", *slopes, leg.theta) for leg in self.legs]
        if kind in ("quadruple", "higher"):
            for leg, other in ((f, g), (g, f)):
                for third in (other.alpha, other.theta):
                    triples.append(("grad f = 0, grad g = 0", leg.alpha, leg.theta, third))
        for name, *functions in triples:
            yield name, Triple((functions[0], functions[1], functions[2]), self.ring.radicand)


@dataclass(frozen=True)
class Triple:
    """Three equations in α, θ and the scaled length."""

    functions: tuple[Graded, Graded, Graded]
    radicand: int

    @cached_property
    def _derivatives(self) -> list[tuple[Graded, Graded]]:
        return [(_slope(p, theta=False), _slope(p, theta=True)) for p in self.functions]

    @property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient."""
        return max(part.bit_length() for p in self.functions for row in p for x in row.values() for part in x)

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        """The values of the equations."""
        here = Directions.of(box[0], box[1], self.radicand)
        return [value(here, p, box[2]) for p in self.functions]

    def jacobian(self, box: Sequence[Interval]) -> Matrix:
        """Their derivatives in α, θ and the length."""
        here = Directions.of(box[0], box[1], self.radicand)
        rows = []
        for p, slopes in zip(self.functions, self._derivatives, strict=True):
            in_length = tuple(_multiple(row, k) for k, row in enumerate(p) if k) or ({},)
            rows.append([value(here, q, box[2]) for q in (*slopes, in_length)])
        return rows

    def zero_near(
        self, alpha: Fraction, theta: Fraction, length: Fraction, bits: int
    ) -> list[Interval] | None:
        """A proved box near angles in degrees and a scaled length."""
        shift = (abs(length.numerator) // length.denominator).bit_length()
        near_one = self.in_units_of(shift)
        for work in precisions(bits + shift + near_one.coefficient_bits):
            start = radians(alpha, work), radians(theta, work), Interval.of(length / (1 << shift), work)
            zero = proved_zero(near_one, start, bits + shift)
            if zero is not None:
                return [*zero[:2], zero[2].scaled(1 << shift)]
        return None

    def in_units_of(self, shift: int) -> Triple:
        """The same equations, the length being a multiple of 2^shift: of the size of the angles."""
        first, second, third = (
            tuple(_multiple(row, 1 << (shift * k)) for k, row in enumerate(p)) for p in self.functions
        )
        return Triple((first, second, third), self.radicand)


def value(here: Directions, p: Graded, length: Interval) -> Interval:
    """The values of a polynomial in a box, by Horner's scheme in the length."""
    total = Interval(0, 0, length.bits)
    for row in reversed(p):
        total = total * length + here.value(row)
    return total


def _slope(p: Graded, *, theta: bool) -> Graded:
    return tuple(derivative(row, theta=theta) for row in p)


def _multiple(p: Trig, factor: int) -> Trig:
    return {key: (a * factor, b * factor) for key, (a, b) in p.items()}
