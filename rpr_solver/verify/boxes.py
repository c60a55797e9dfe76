"""Poses in boxes: trigonometric polynomials in intervals, and Krawczyk's proof that a box holds one zero.

If K(X) = x₀ − Y F(x₀) + (1 − Y F′(X)) (X − x₀) lies in the interior of X, then X holds exactly one zero of
F, it is in K(X), and F′ is invertible there (Krawczyk 1969, Moore 1977).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.angles import cos_sin, pi, radians
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surds import ZERO, Surd
from rpr_solver.verify.system import Trig, derivative

_STEPS = 12
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

    @cached_property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient."""
        return max((_bits(x) for p in self.functions for x in p.values()), default=0)


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

    def meets(self, other: Box) -> bool:
        """Whether two boxes may share a pose."""
        here, there = self.directions, other.directions
        both = zip((*here.alpha, *here.theta), (*there.alpha, *there.theta), strict=True)
        return all(x.meets(y) for x, y in both)


def around(alpha: Printed, theta: Printed, bits: int, radicand: int) -> Box:
    """All poses whose angles round to two printed ones."""
    turn = pi(bits)
    first, second = (turn * Interval.of(x.value / 180, bits, x.half / 180) for x in (alpha, theta))
    return Box(first, second, radicand)


def zero_near(equations: Equations, alpha: Fraction, theta: Fraction, bits: int) -> Box | None:
    """The zero near two angles in degrees, in a box of some 2^−``bits``; None if none is proved."""
    for work in _precisions(bits + 48 + equations.coefficient_bits):
        box = _proved(equations, radians(alpha, work), radians(theta, work), bits)
        if box is not None:
            return box
    return None


def _precisions(bits: int) -> Iterator[int]:
    yield bits
    yield 2 * bits + 128


def _proved(equations: Equations, alpha: Interval, theta: Interval, bits: int) -> Box | None:
    work = alpha.bits
    x = [alpha.lower, theta.lower]
    aim = 1 << (work - bits)
    for _ in range(_STEPS):
        step = _newton(equations, x, work)
        if step is None or max(abs(s) for s in step) > 1 << (work - 3):
            return None
        x = [value - s for value, s in zip(x, step, strict=True)]
        size = max(abs(s) for s in step)
        if size < aim:
            radius = 4 * size + (aim >> 2)
            return _krawczyk(equations, x, radius, work)
    return None


def _newton(equations: Equations, x: list[int], work: int) -> tuple[int, int] | None:
    here = Directions.of(Interval(x[0], x[0], work), Interval(x[1], x[1], work), equations.radicand)
    inverse = _inverse(_jacobian(equations, here))
    if inverse is None:
        return None
    f, g = (here.value(p) for p in equations.functions)
    first, second = (row[0] * f + row[1] * g for row in inverse)
    return (first.lower + first.upper) // 2, (second.lower + second.upper) // 2


def _krawczyk(equations: Equations, x: list[int], radius: int, work: int) -> Box | None:
    points = [Interval(v, v, work) for v in x]
    centre = Directions.of(points[0], points[1], equations.radicand)
    inverse = _inverse(_jacobian(equations, centre))
    if inverse is None:
        return None
    wide = [Interval(v - radius, v + radius, work) for v in x]
    slopes = _jacobian(equations, Directions.of(wide[0], wide[1], equations.radicand))
    f, g = (centre.value(p) for p in equations.functions)
    around, result = Interval(-radius, radius, work), []
    for i, row in enumerate(inverse):
        image = points[i] - (row[0] * f + row[1] * g)
        for k in range(2):
            product = row[0] * slopes[0][k] + row[1] * slopes[1][k]
            image += (Interval.of(int(i == k), work) - product) * around
        if not wide[i].lower < image.lower <= image.upper < wide[i].upper:
            return None
        result.append(image)
    return Box(result[0], result[1], equations.radicand)


def _jacobian(equations: Equations, at: Directions) -> list[list[Interval]]:
    return [[at.value(p) for p in row] for row in equations.derivatives]


def _inverse(matrix: list[list[Interval]]) -> list[list[Interval]] | None:
    """An approximate inverse of the midpoints, as exact numbers; None if they are nearly dependent."""
    work = matrix[0][0].bits
    (a, b), (c, d) = ([x.middle for x in row] for row in matrix)
    determinant = a * d - b * c
    if determinant == 0:
        return None
    rows = ((d, -b), (-c, a))
    result = []
    for row in rows:
        points = [int(x / determinant * (1 << work)) for x in row]
        result.append([Interval(v, v, work) for v in points])
    return result


def _bits(x: Surd) -> int:
    return max(part.bit_length() for part in x) if x != ZERO else 0
