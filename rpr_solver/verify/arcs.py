"""Arcs of a path in (α, θ, L) and pieces of them, with J and the legs on each in intervals.

A piece of a Bézier arc lies in the hull of its control points, and its derivative in that of their
differences. So a function on a piece over [0, 1] is within F(1/2) + F′(piece) [−1/2, 1/2], and halving the
piece makes the second part about two times smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval, cos_sin, halved, pi
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.system import Graded, Surface, gradient, longest

_DEEPEST = 24
Place = tuple[Interval, Interval, Interval]
"""α and θ in degrees, and the scaled length of the fixed leg."""
Controls = tuple[Place, ...]
Point = TypeVar("Point")


class Forms:
    """J / L and the squared free legs of a manipulator, with their derivatives in α, θ and L."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self.functions = (surface.singular, *(leg.squared for leg in surface.legs))

    @cached_property
    def slopes(self) -> list[tuple[Graded, Graded, Graded]]:
        """The derivatives of each function."""
        return [gradient(p) for p in self.functions]

    @cached_property
    def bits(self) -> int:
        """The size of the largest coefficient."""
        return longest(*(row for p in self.functions for row in p))

    def content(self, at: Place) -> int:
        """What f_α g_θ − f_θ g_α = content · L · (J / L) says, at a regular pose.

        Raises:
            OpenError: intervals do not decide it.
        """
        here, length = directions(at, self.surface.ring.radicand), at[2]
        (fa, ft), (ga, gt) = ((value(here, p, length) for p in row[:2]) for row in self.slopes[1:])
        product = value(here, self.functions[0], length) * length
        if not product.sign:
            raise OpenError("J may be 0 at the start")
        quotient = (fa * gt - ft * ga).over(product)
        content = round(quotient.middle)
        if content < 1 or not quotient.inside(content - Fraction(1, 2), content + Fraction(1, 2)):
            raise OpenError("the scale of J is not decided")
        return content


def directions(at: Place, radicand: int) -> Directions:
    """The box of the angles of a place."""
    bits = at[0].bits
    alpha, theta = (cos_sin(in_radians(x)) for x in at[:2])
    spend(8, bits)
    return Directions(alpha, theta, radicand)


def in_radians(x: Interval) -> Interval:
    """Degrees in radians."""
    return (x * pi(x.bits)).over(Interval.of(180, x.bits))


@dataclass(frozen=True)
class Piece:
    """A piece of an arc, over [0, 1]."""

    forms: Forms
    controls: Controls
    depth: int = 0

    @cached_property
    def halves(self) -> tuple[Piece, Piece]:
        """Both halves.

        Raises:
            OpenError: it is too small.
        """
        if self.depth >= _DEEPEST:
            raise OpenError("pieces of the arcs are so small that it is not decided")
        spend(40 + 3 * len(self.controls) ** 2, self.controls[0][0].bits)
        left, right = (tuple(half) for half in halves_of(self.controls, _middle))
        return Piece(self.forms, left, self.depth + 1), Piece(self.forms, right, self.depth + 1)

    @cached_property
    def hull(self) -> Place:
        """A box with all its points."""
        alpha, theta, length = (hull_of(column) for column in zip(*self.controls, strict=True))
        return alpha, theta, length

    @cached_property
    def _speed(self) -> Place:
        """All derivatives along it, angles in radians."""
        degree = len(self.controls) - 1
        rows = [
            [(y - x).scaled(degree) for x, y in zip(p, q, strict=True)] for p, q in pairwise(self.controls)
        ]
        alpha, theta, length = (hull_of(column) for column in zip(*rows, strict=True))
        return in_radians(alpha), in_radians(theta), length

    @cached_property
    def _box(self) -> Directions:
        return directions(self.hull, self.forms.surface.ring.radicand)

    @cached_property
    def _at_middle(self) -> tuple[Directions, Interval]:
        at = self.halves[0].controls[-1]
        return directions(at, self.forms.surface.ring.radicand), at[2]

    @cached_property
    def _known(self) -> dict[int, tuple[Interval, Interval, Interval]]:
        return {}

    def _of(self, n: int) -> tuple[Interval, Interval, Interval]:
        """Function n at the middle, on the piece, and its derivative along it."""
        if n not in self._known:
            length = self.hull[2]
            spend(120, length.bits)
            change = Interval(0, 0, length.bits)
            for p, speed in zip(self.forms.slopes[n], self._speed, strict=True):
                change += value(self._box, p, length) * speed
            middle = value(self._at_middle[0], self.forms.functions[n], self._at_middle[1])
            half = halved(Interval(-1, 1, 0).at(length.bits), 1)
            self._known[n] = middle, middle + change * half, change
        return self._known[n]

    def middle(self, n: int) -> Interval:
        """A function at the middle: 0 for J / L, 1 and 2 for the squared free legs."""
        return self._of(n)[0]

    def value(self, n: int) -> Interval:
        """All its values on the piece."""
        return self._of(n)[1]

    def change(self, n: int) -> Interval:
        """All its derivatives along the piece."""
        return self._of(n)[2]


def halves_of(points: Sequence[Point], middle: Callable[[Point, Point], Point]) -> tuple[list[Point], ...]:
    """The control points of both halves, by de Casteljau's scheme."""
    left, right, row = [], [], list(points)
    while row:
        left.append(row[0])
        right.append(row[-1])
        row = [middle(p, q) for p, q in pairwise(row)]
    return left, right[::-1]


def mean(x: Fraction, y: Fraction) -> Fraction:
    """The number halfway."""
    return (x + y) / 2


def _middle(p: Place, q: Place) -> Place:
    alpha, theta, length = (halved(x + y, 1) for x, y in zip(p, q, strict=True))
    return alpha, theta, length


def hull_of(numbers: Sequence[Interval]) -> Interval:
    """The interval from the least to the greatest number of some."""
    return Interval(min(x.lower for x in numbers), max(x.upper for x in numbers), numbers[0].bits)


def point_at(controls: Controls, tau: Fraction) -> Place:
    """The point of an arc at a parameter."""
    bits = controls[0][0].bits
    spend(6 * len(controls) ** 2, bits)
    first, second = Interval.of(1 - tau, bits), Interval.of(tau, bits)
    points = list(controls)
    while len(points) > 1:
        points = [
            (p[0] * first + q[0] * second, p[1] * first + q[1] * second, p[2] * first + q[2] * second)
            for p, q in pairwise(points)
        ]
    return points[0]


def waves_of(p: Graded, radicand: int, length: Interval) -> dict[tuple[int, int], list[Interval]]:
    """A polynomial of a slice as Σ c(p, q) e^(i (p α + q θ)): the real and the imaginary part of each c."""
    bits, omega = length.bits, Interval.of(radicand, length.bits).root()
    parts: dict[tuple[int, int], list[Interval]] = {}
    power = Interval.of(1, bits)
    for row in p:
        for (i, j, k, m), (a, b) in row.items():
            spend(40, bits)
            size = (Interval.of(a, bits) + omega.scaled(b)) * power
            for n, x in _waves(i, j).items():
                for o, y in _waves(k, m).items():
                    re, im = x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]
                    old = parts.setdefault((n, o), [Interval.of(0, bits)] * 2)
                    parts[n, o] = [
                        old[0] + size * Interval.of(re, bits),
                        old[1] + size * Interval.of(im, bits),
                    ]
        power *= length
    return parts


def steepest(forms: Forms, length: Interval) -> Interval:
    """A bound of the second derivatives of J / L in all directions of unit length, at any angles.

    They are at most Σ |c(p, q)| (p² + q²) by the waves of J.
    """
    total, waves = (
        Interval.of(0, length.bits),
        waves_of(forms.functions[0], forms.surface.ring.radicand, length),
    )
    for (p, q), (real, imaginary) in waves.items():
        spend(10, length.bits)
        total += (squared(real) + squared(imaginary)).root().scaled(p * p + q * q)
    return total


def squared(x: Interval) -> Interval:
    """The numbers from 0 to the greatest square."""
    top = max(abs(x.lower), abs(x.upper))
    return Interval(0, -(-top * top >> x.bits) + 1, x.bits)


def _waves(cos: int, sin: int) -> dict[int, tuple[Fraction, Fraction]]:
    """cosⁿ or cosⁿ sin as Σ c(p) e^(i p x): the real and the imaginary part of c(p)."""
    half = Fraction(1, 2)
    found = {0: (Fraction(1), Fraction(0))}
    factors = [{1: (half, Fraction(0)), -1: (half, Fraction(0))}] * cos
    factors += [{1: (Fraction(0), -half), -1: (Fraction(0), half)}] * sin
    for factor in factors:
        grown: dict[int, tuple[Fraction, Fraction]] = {}
        for p, (a, b) in found.items():
            for q, (c, d) in factor.items():
                x, y = grown.get(p + q, (Fraction(0), Fraction(0)))
                grown[p + q] = x + a * c - b * d, y + a * d + b * c
        found = grown
    return found
