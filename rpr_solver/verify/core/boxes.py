"""Poses in boxes: trigonometric polynomials in intervals, and boxes that hold one zero of two of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.core.angles import cos_sin, pi, radians
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import contracted, proved_zero
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.roots import Root, real_roots, refined
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, primitive
from rpr_solver.verify.core.surds import derivative as slope
from rpr_solver.verify.core.system import Trig, derivative, in_half_tangent
from rpr_solver.verify.core.work import spend

_SPARE = 48
_ROOMS = (5, 8, 12, 16, 24, 40, 64, 100)
Pair = tuple[Interval, Interval]


@dataclass(frozen=True)
class Directions:
    """A box of poses by cosines and sines of α and θ."""

    alpha: Pair
    theta: Pair
    radicand: int

    @classmethod
    def of(cls, alpha: Interval, theta: Interval, radicand: int) -> Directions:
        """The box of two angles in radians."""
        return cls(cos_sin(alpha), cos_sin(theta), radicand)

    @property
    def bits(self) -> int:
        """The precision."""
        return self.alpha[0].bits

    @cached_property
    def _omega(self) -> Interval:
        return Interval.of(self.radicand, self.bits).root()

    @cached_property
    def _powers(self) -> tuple[list[Interval], list[Interval]]:
        one = Interval.of(1, self.bits)
        return [one], [one]

    @cached_property
    def _products(self) -> dict[tuple[int, int, int, int], Interval]:
        return {}

    def _monomial(self, key: tuple[int, int, int, int]) -> Interval:
        if key not in self._products:
            i, j, k, m = key
            for powers, (cos, _), n in zip(self._powers, (self.alpha, self.theta), (i, k), strict=True):
                while len(powers) <= n:
                    powers.append(powers[-1] * cos)
            x, y = self._powers[0][i], self._powers[1][k]
            x = x * self.alpha[1] if j else x
            y = y * self.theta[1] if m else y
            self._products[key] = x * y
        return self._products[key]

    def value(self, p: Trig) -> Interval:
        """All values of a trigonometric polynomial in the box."""
        spend(2 * len(p), self.bits)
        rational = irrational = Interval(0, 0, self.bits)
        for key, (a, b) in p.items():
            monomial = self._monomial(key)
            if a:
                rational += monomial.scaled(a)
            if b:
                irrational += monomial.scaled(b)
        return rational + irrational * self._omega if irrational != Interval(0, 0, self.bits) else rational


@dataclass(frozen=True)
class Equations:
    """Two equations in α and θ with their derivatives."""

    functions: tuple[Trig, Trig]
    derivatives: tuple[tuple[Trig, Trig], tuple[Trig, Trig]]
    radicand: int

    @classmethod
    def of(cls, first: Trig, second: Trig, radicand: int) -> Equations:
        """The equations first = second = 0."""
        rows = [(derivative(p, theta=False), derivative(p, theta=True)) for p in (first, second)]
        return cls((first, second), (rows[0], rows[1]), radicand)

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        """The values of both functions."""
        here = Directions.of(box[0], box[1], self.radicand)
        return [here.value(p) for p in self.functions]

    def jacobian(self, box: Sequence[Interval]) -> list[list[Interval]]:
        """The derivatives of both functions."""
        here = Directions.of(box[0], box[1], self.radicand)
        return [[here.value(p) for p in row] for row in self.derivatives]

    @cached_property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient."""
        return max((_bits(x) for p in self.functions for x in p.values()), default=0)

    def alone(self, box: Box) -> Box | None:
        """A wide box about one that holds a zero, in which there is no other; None if none is proved."""
        for room in _ROOMS:
            wide = box.widened(room)
            if contracted(self, (wide.alpha, wide.theta)) is not None:
                return wide
        return None


@dataclass(frozen=True)
class Box:
    """A box of poses; a proved one holds exactly one zero, a regular one. Angles in radians."""

    alpha: Interval
    theta: Interval
    radicand: int

    @cached_property
    def directions(self) -> Directions:
        """Its cosines and sines."""
        return Directions.of(self.alpha, self.theta, self.radicand)

    def widened(self, room: int) -> Box:
        """A box of all angles within 2^−``room`` radians of the middles."""
        bits, radius = self.alpha.bits, Fraction(1, 1 << room)
        alpha, theta = (Interval.of(x.middle, bits, radius) for x in (self.alpha, self.theta))
        return Box(alpha, theta, self.radicand)

    def meets(self, other: Box) -> bool:
        """Whether two boxes may share a pose."""
        here, there = self.directions, other.directions
        both = zip((*here.alpha, *here.theta), (*there.alpha, *there.theta), strict=True)
        return all(x.meets(y) for x, y in both)


def common_on_axis(equations: Equations, box: Box, *, theta: bool) -> bool:
    """Whether the one zero of two equations in a box has θ = 0, or α = 0, exactly.

    There both equations are polynomials in the half tangent of the other angle. A common root of theirs is a
    zero; it is the one of the box if a wide box about this holds no other.
    """
    ring = Ring(equations.radicand)
    forms = [_on_axis(p, theta=theta) for p in equations.functions]
    common = ring.gcd(*map(primitive, forms))
    if equations.alone(box) is None:
        return False
    bits = 2 * box.alpha.bits
    once: Poly = ()
    if len(common) > 1:
        once = ring.field_quotient(common, ring.gcd(common, slope(common)))
    zero, other = (box.theta, box.alpha) if theta else (box.alpha, box.theta)
    there = cos_sin(other)
    near = [direction(ring, once, root, bits) for root in real_roots(ring, once)] if once else []
    if all(form[-1] == ZERO for form in forms):
        near.append((Interval.of(-1, bits), Interval.of(0, bits)))
    return zero.contains(0) and any(all(x.meets(y) for x, y in zip(there, d, strict=True)) for d in near)


def _on_axis(p: Trig, *, theta: bool) -> Poly:
    """p at θ = 0, or at α = 0, by powers of the half tangent of the other angle, of formal degree."""
    turned = p if theta else {(k, m, i, j): x for (i, j, k, m), x in p.items()}
    degree = max((i + j for i, j, _, _ in turned), default=0)
    return in_half_tangent(turned, degree, lambda _cos, sin: int(not sin))


def direction(ring: Ring, form: Poly, root: Root, bits: int) -> Pair:
    """Cosine and sine of θ on a line, the root u = tan(θ/2) being isolated."""
    narrow = refined(ring, form, root, Fraction(1, 1 << bits))
    middle, radius = (narrow.lower + narrow.upper) / 2, narrow.width / 2
    x, one = Interval.of(middle, bits, radius), Interval.of(1, bits)
    square = x * x
    norm = one + square
    cos, sin = (one - square).over(norm), x.scaled(2).over(norm)
    return (-cos if narrow.inverted else cos), sin


def around(alpha: Printed, theta: Printed, bits: int, radicand: int) -> Box:
    """All poses whose angles round to two printed ones."""
    turn = pi(bits)
    first, second = (turn * Interval.of(x.value / 180, bits, x.half / 180) for x in (alpha, theta))
    return Box(first, second, radicand)


def zero_near(
    equations: Equations, alpha: Fraction, theta: Fraction, bits: int, spare: int = 0
) -> Box | None:
    """The zero near two angles in degrees, in a box of some 2^−``bits``; None if none is proved.

    Where another zero is 2^−``spare`` away, the inverse of the derivative is as great as 2^``spare``.
    """
    for work in precisions(bits + equations.coefficient_bits + spare):
        zero = proved_zero(equations, (radians(alpha, work), radians(theta, work)), bits)
        if zero is not None:
            return Box(zero[0], zero[1], equations.radicand)
    return None


def precisions(bits: int) -> tuple[int, int]:
    """The working precisions to try, for zeros that are well conditioned and others."""
    return bits + _SPARE, 2 * bits + 4 * _SPARE


def _bits(x: Surd) -> int:
    return max(part.bit_length() for part in x) if x != ZERO else 0
