"""The tests that decide: which directions, boxes of poses and boxes of events hold exactly one zero.

If K(X) = x₀ − Y F(x₀) + (1 − Y F′(X)) (X − x₀) lies in the interior of X, then X holds exactly one zero of
F, it is in K(X), and F′ is invertible there (Krawczyk 1969, Moore 1977).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2
from typing import Protocol

from rpr_solver.verify.core.intervals import Interval, cos_sin, halved
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, real_roots, refined
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, primitive, radical
from rpr_solver.verify.core.system import Graded, Trig, gradient, in_half_tangent

_STEPS, _SPARE, _SLOPE_BITS = 24, 48, 192
_ULPS = 1 << 8
_ROOMS = (5, 8, 12, 16, 24, 40, 64, 100)
Matrix = list[list[Interval]]
Pair = tuple[Interval, Interval]
"""Cosine and sine of a direction."""


class Problem(Protocol):
    """Equations, by their values and derivatives in a box."""

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        """The values of the equations."""

    def jacobian(self, box: Sequence[Interval]) -> Matrix:
        """A row of derivatives for each equation."""


def proved_zero(
    problem: Problem, start: Sequence[Interval], bits: int, least: int = _SLOPE_BITS
) -> list[Interval] | None:
    """The zero near ``start``, in a box of some 2^−``bits``; None if none is proved at this precision.

    Newton's steps have as many bits as they may add, slopes as are known, or ``least``; if that fails, all.
    """
    tries = [least, start[0].bits] if least < start[0].bits else [least]
    return next((zero for n in tries if (zero := _steps(problem, start, bits, n)) is not None), None)


def _steps(problem: Problem, start: Sequence[Interval], bits: int, least: int) -> list[Interval] | None:
    work = start[0].bits
    x, known = [_middle(interval) for interval in start], 0
    aim = 1 << (work - bits)
    for _ in range(_STEPS):
        low, high = (min(work, max(least, n)) for n in (known, 2 * known))
        inverse = _inverse(problem.jacobian(_points(x, work, low)), high)
        if inverse is None:
            return None
        points = _points(x, work, high)
        steps = [_middle(step) for step in _times(inverse, problem.values(points))]
        size = max(abs(step) for step in steps)
        if size > 1 << (high - 3):
            return None
        x = [(point.lower - step) << (work - high) for point, step in zip(points, steps, strict=True)]
        if high == work and size < aim:
            radius = 4 * size + (aim >> 2)
            return contracted(problem, [Interval(v - radius, v + radius, work) for v in x])
        known = max(2 * (high - size.bit_length()) - _SPARE, 0)
    return None


def contracted(problem: Problem, wide: Sequence[Interval]) -> list[Interval] | None:
    """K(X) of a given box X if it lies in its interior, so that X holds exactly one zero; else None.

    Y may be any matrix, and slopes are rounded outwards: they have few bits where Y is small.
    """
    work = wide[0].bits
    middle = [_middle(x) for x in wide]
    for low in (min(work, _SLOPE_BITS), work):
        inverse = _inverse(problem.jacobian(_points(middle, work, low)), work)
        if inverse and all(abs(entry.lower) >> (work + low // 2) == 0 for row in inverse for entry in row):
            break
    if inverse is None:
        return None
    points = _points(middle, work, work)
    slopes = [[slope.at(work) for slope in row] for row in problem.jacobian([x.at(low) for x in wide])]
    shifts = _times(inverse, problem.values(points))
    around, result = [x - point for x, point in zip(wide, points, strict=True)], []
    spend(len(wide) ** 3, work)
    columns = [_times(inverse, column) for column in zip(*slopes, strict=True)]
    for i in range(len(wide)):
        image = points[i] - shifts[i]
        for k, column in enumerate(columns):
            image += (Interval.of(int(i == k), work) - column[i]) * around[k]
        if not wide[i].lower < image.lower <= image.upper < wide[i].upper:
            return None
        result.append(image)
    return result


def _points(x: Sequence[int], work: int, bits: int) -> list[Interval]:
    """Numbers in units of 2^−``work``, cut to ``bits``."""
    return [Interval(v >> (work - bits), v >> (work - bits), bits) for v in x]


def _times(matrix: Matrix, vector: Sequence[Interval]) -> list[Interval]:
    zero = Interval(0, 0, matrix[0][0].bits)
    return [sum((x * y for x, y in zip(row, vector, strict=True)), zero) for row in matrix]


def _middle(x: Interval) -> int:
    return (x.lower + x.upper) // 2


def _inverse(matrix: Matrix, bits: int) -> Matrix | None:
    """The inverse of the midpoints by cofactors, rounded to ``bits``; None if they are dependent."""
    size, shift = range(len(matrix)), matrix[0][0].bits + bits
    spend(12 * len(matrix) ** 2, shift)
    rows = [[_middle(x) for x in row] for row in matrix]
    determinant = _determinant(rows)
    if not determinant:
        return None

    def entry(i: int, k: int) -> Interval:
        cofactor = _determinant([row[:i] + row[i + 1 :] for n, row in enumerate(rows) if n != k])
        v = ((-cofactor if (i + k) % 2 else cofactor) << shift) // determinant
        return Interval(v, v, bits)

    return [[entry(i, k) for k in size] for i in size]


def _determinant(rows: Sequence[list[int]]) -> int:
    """Of a matrix of integers, by its first row."""
    if not rows:
        return 1
    minors = ([row[:k] + row[k + 1 :] for row in rows[1:]] for k in range(len(rows)))
    return sum(
        (-x if k % 2 else x) * _determinant(minor)
        for k, (x, minor) in enumerate(zip(rows[0], minors, strict=True))
    )


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
        spend(8 * len(p), self.bits)
        monomials = [self._monomial(key) for key in p]
        rational, irrational = (_sum([x[n] for x in p.values()], monomials, self.bits) for n in (0, 1))
        return rational + irrational * self._omega if irrational.lower or irrational.upper else rational


def _sum(factors: Sequence[int], terms: Sequence[Interval], bits: int) -> Interval:
    """Σ factor · term."""
    low = high = 0
    for factor, x in zip(factors, terms, strict=True):
        if factor > 0:
            low, high = low + factor * x.lower, high + factor * x.upper
        elif factor:
            low, high = low + factor * x.upper, high + factor * x.lower
    return Interval(low, high, bits)


@dataclass(frozen=True)
class Equations:
    """Two equations in α and θ, or three in these and the scaled length, with their derivatives.

    Each is divided by a power of 2 of its size.
    """

    functions: tuple[Graded, ...]
    radicand: int

    @classmethod
    def of(cls, first: Trig, second: Trig, radicand: int) -> Equations:
        """The equations first = second = 0 of a slice."""
        return cls(((first,), (second,)), radicand)

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        """The values of the functions."""
        return [x for [x] in self._on(box, [(p,) for p in self.functions])]

    def jacobian(self, box: Sequence[Interval]) -> Matrix:
        """Their derivatives in all unknowns."""
        return self._on(box, [row[: len(box)] for row in self._gradients])

    def _on(self, box: Sequence[Interval], rows: Sequence[Sequence[Graded]]) -> Matrix:
        here = Directions.of(box[0], box[1], self.radicand)
        pairs = zip(rows, self._sizes, strict=True)
        return [[halved(value(here, p, box[-1]), size) for p in row] for row, size in pairs]

    @cached_property
    def _gradients(self) -> list[tuple[Graded, ...]]:
        return [gradient(p) for p in self.functions]

    @cached_property
    def _sizes(self) -> list[int]:
        return [_size([x for row in p for x in row.values()], self.radicand) for p in self.functions]

    @property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient."""
        return max(self._sizes)

    def zero_near(self, start: Sequence[Interval], bits: int, spare: int = 0) -> list[Interval] | None:
        """A proved box of some 2^−``bits`` near a start, in ever more bits; or None.

        Where another zero is 2^−``spare`` away, the inverse of the derivative is as great as 2^``spare``.
        """
        size = self.coefficient_bits
        # for zeros that are well conditioned, and others
        tries = bits + spare + _SPARE, bits + spare + size + _SPARE, 2 * (bits + spare + size) + 4 * _SPARE
        least = _SLOPE_BITS + 4 * spare
        found = (proved_zero(self, [x.at(work) for x in start], bits, least) for work in tries)
        return next((zero for zero in found if zero is not None), None)

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
        return meet(here.alpha, there.alpha) and meet(here.theta, there.theta)


def angle_of(pair: Pair) -> Interval:
    """The angle in radians with about this cosine and sine.

    Each step leaves a sixth of the cube of the error: x + sin(a − x) is x + (a − x) to third order.
    """
    cos, sin = pair
    x = Interval.of(Fraction(atan2(float(sin.middle), float(cos.middle))), cos.bits).lower
    while True:
        at_cos, at_sin = cos_sin(Interval(x, x, cos.bits))
        error = sin * at_cos - cos * at_sin
        step = (error.lower + error.upper) // 2
        x += step
        if abs(step) < _ULPS:
            return Interval(x, x, cos.bits)


def enclosed(vector: Pair, most: int = 1 << 20) -> Interval:
    """All angles in radians of the vectors of a small box, but for whole turns, to so many bits at most.

    Raises:
        ArithmeticError: it is no small box, or it may hold 0.
    """
    x, y = vector
    norm = (x * x + y * y).root()
    cos, sin = (part.over(norm).at(min(most, norm.bits)) for part in vector)
    near = angle_of((cos, sin))
    at_cos, at_sin = cos_sin(near)
    off = sin * at_cos - cos * at_sin
    if (cos * at_cos + sin * at_sin).sign <= 0:
        raise ArithmeticError("a direction is not known well enough")
    # |δ| ≤ 2 |sin δ| for |δ| < π/2
    return Interval.of(near.middle, near.bits, 2 * off.greatest)


def meet(first: Pair, second: Pair) -> bool:
    """Whether two directions may be the same."""
    return all(x.meets(y) for x, y in zip(first, second, strict=True))


def common_on_axis(equations: Equations, box: Box, *, theta: bool) -> bool:
    """Whether the one zero of two equations in a box has θ = 0, or α = 0, exactly.

    There both equations are polynomials in the half tangent of the other angle. A common root of theirs is a
    zero; it is the one of the box if a wide box about this holds no other.
    """
    ring = Ring(equations.radicand)
    forms = [form_on_axis(p, theta=theta) for [p] in equations.functions]
    common = ring.gcd(*map(primitive, forms))
    if equations.alone(box) is None:
        return False
    bits = 2 * box.alpha.bits
    once = radical(ring, common)
    zero, other = (box.theta, box.alpha) if theta else (box.alpha, box.theta)
    there = cos_sin(other)
    near = [direction(ring, once, root, bits) for root in real_roots(ring, once)]
    if all(form[-1] == ZERO for form in forms):
        near.append((Interval.of(-1, bits), Interval.of(0, bits)))
    return zero.contains(0) and any(meet(there, d) for d in near)


def form_on_axis(p: Trig, *, theta: bool, cos: int = 1) -> Poly:
    """p where θ, or α, has the cosine ±1, by powers of the half tangent of the other, of formal degree."""
    turned = p if theta else {(k, m, i, j): x for (i, j, k, m), x in p.items()}
    degree = max((i + j for i, j, _, _ in turned), default=0)
    return in_half_tangent(turned, degree, lambda power, sin: 0 if sin else cos**power)


def direction(ring: Ring, form: Poly, root: Root, bits: int) -> Pair:
    """Cosine and sine of θ on a line, the root u = tan(θ/2) being isolated."""
    narrow = refined(ring, form, root, Fraction(1, 1 << bits))
    middle, radius = (narrow.lower + narrow.upper) / 2, narrow.width / 2
    x, one = Interval.of(middle, bits, radius), Interval.of(1, bits)
    square = x * x
    norm = one + square
    cos, sin = (one - square).over(norm), x.scaled(2).over(norm)
    return (cos.scaled(-1) if narrow.inverted else cos), sin


def zero_near(
    equations: Equations, alpha: Interval, theta: Interval, bits: int, spare: int = 0
) -> Box | None:
    """The zero near two angles in radians, in a box of some 2^−``bits``; None if none is proved."""
    zero = equations.zero_near((alpha, theta), bits, spare)
    return None if zero is None else Box(zero[0], zero[1], equations.radicand)


def _size(numbers: Iterable[Surd], radicand: int) -> int:
    """The bits of the largest a or b ω."""
    omega = radicand.bit_length() // 2
    return max((max(a.bit_length(), b.bit_length() + omega) for a, b in numbers), default=0)


def value(here: Directions, p: Graded, length: Interval) -> Interval:
    """The values of a polynomial in a box, by Horner's scheme in the length."""
    total = here.value(p[-1])
    for row in reversed(p[:-1]):
        total = total * length + here.value(row)
    return total
