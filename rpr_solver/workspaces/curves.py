"""Circles, lines and conics, their common points, exact, and what lies on them in order.

A point is exact: three coordinates (x : y : w) in a tower, or a real root of the quartic that the
half-tangent of a circle's angle fulfils where it meets the conic. So whether a curve passes through a point,
and whether two are tangent there, is decided exactly; balls of the point give all else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

from flint import acb_poly, arb, arb_poly, ctx

from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.workspaces.orientation import Vector
from rpr_solver.workspaces.tower import Number, Open

Pair: TypeAlias = tuple[arb, arb]
"""A point or a vector, in balls at the working precision."""

_FIRST_BITS = 128
_DIRECTIONS = tuple(
    (Fraction(a, c), Fraction(b, c))
    for a, b, c in (
        (1, 0, 1),
        (3, 4, 5),
        (-5, 12, 13),
        (-8, -15, 17),
        (7, -24, 25),
        (20, 21, 29),
        (-12, -35, 37),
    )
)
"""Unit vectors with rational coordinates: no more than six directions are special in any sense below."""


@dataclass(frozen=True, eq=False)
class Place:
    """A point with exact coordinates x/w and y/w."""

    x: Number
    y: Number
    w: Number

    def ball(self, bits: int) -> Pair:
        """The point.

        Raises:
            Open: at this precision its coordinates are not finite.
        """
        with ctx.workprec(bits):
            w = self.w.ball(bits)
            return _finite((self.x.ball(bits) / w, self.y.ball(bits) / w))


@dataclass(frozen=True, eq=False)
class Root:
    """A point where a circle meets the conic: one of the real roots of its quartic, by their number."""

    quartic: Quartic
    number: int

    def ball(self, bits: int) -> Pair:
        """The point.

        Raises:
            Open: at this precision the roots are not told apart.
        """
        with ctx.workprec(bits):
            t = self.quartic.roots(bits)[self.number]
            return self.quartic.place(t, bits)


Point: TypeAlias = Place | Root


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle, on which one or more legs have their least or greatest length.

    Attributes:
        centre: its centre, exact.
        radius: > 0.
        limits: of which legs, and whether it is their greatest length.
    """

    centre: Vector
    radius: Fraction
    limits: tuple[tuple[int, bool], ...]

    @property
    def name(self) -> str:
        """As in documents."""
        return " ".join(f"l{leg}_{'max' if is_max else 'min'}" for leg, is_max in self.limits)

    def value(self, p: Place) -> Number:
        """|p − c|² − r², times w²."""
        u, v = self.slopes(p)
        return u * u + v * v - p.w * p.w * self.radius**2

    def slopes(self, p: Place) -> Vector:
        """Half the gradient of this, times w."""
        return p.x - self.centre[0] * p.w, p.y - self.centre[1] * p.w

    def at(self, p: Pair, bits: int) -> arb:
        """|p − c|² − r²."""
        u, v = self.gradient(p, bits)
        return u * u + v * v - ball_of(self.radius) ** 2

    def gradient(self, p: Pair, bits: int) -> Pair:
        """p − c, along the gradient."""
        return p[0] - self.centre[0].ball(bits), p[1] - self.centre[1].ball(bits)


@dataclass(frozen=True, eq=False)
class Line:
    """The line n · p + m = 0, a part of a degenerate conic."""

    normal: Vector
    constant: Number

    name = "singular"

    def value(self, p: Place) -> Number:
        """n · p + m, times w."""
        return self.normal[0] * p.x + self.normal[1] * p.y + self.constant * p.w

    def slopes(self, _p: Place) -> Vector:
        """Its gradient."""
        return self.normal

    def at(self, p: Pair, bits: int) -> arb:
        """n · p + m."""
        u, v = self.gradient(p, bits)
        return u * p[0] + v * p[1] + self.constant.ball(bits)

    def gradient(self, _p: Pair, bits: int) -> Pair:
        """n."""
        return self.normal[0].ball(bits), self.normal[1].ball(bits)


@dataclass(frozen=True, eq=False)
class Conic:
    """A x² + B x y + C y² + D x + E y + F = 0; with the coefficients of a conic that is no pair of lines."""

    coefficients: tuple[Number, ...]
    through: Place
    """A point of it, exact, that lies on no circle."""

    name = "singular"

    def value(self, p: Place) -> Number:
        """The polynomial, times w²."""
        value: Number = evaluated(self.coefficients, p.x, p.y, p.w)
        return value

    def slopes(self, p: Place) -> Vector:
        """Its gradient, times w."""
        a, b, c, d, e, _ = self.coefficients
        return a * p.x * 2 + b * p.y + d * p.w, b * p.x + c * p.y * 2 + e * p.w

    def at(self, p: Pair, bits: int) -> arb:
        """The polynomial."""
        value: arb = evaluated(self.balls(bits), p[0], p[1], arb(1))
        return value

    def gradient(self, p: Pair, bits: int) -> Pair:
        """Its gradient."""
        return gradient(self.balls(bits), p)

    def balls(self, bits: int) -> list[arb]:
        """The coefficients."""
        return [x.ball(bits) for x in self.coefficients]

    def quadratic(self, d: Pair, bits: int) -> arb:
        """The terms of degree 2 in a direction."""
        return quadratic(self.balls(bits), d)

    def in_direction(self, d: Pair, bits: int) -> Pair:
        """The point of the conic that is seen from :attr:`through` in a direction, or against it."""
        x, y = origin = self.through.ball(bits)
        u, v = self.gradient(origin, bits)
        # Q(o + λ d) = λ (g · d) + λ² q(d)
        over = -(u * d[0] + v * d[1]) / self.quadratic(d, bits)
        return _finite((x + over * d[0], y + over * d[1]))


Curve: TypeAlias = Circle | Line | Conic


@dataclass(frozen=True, eq=False)
class Quartic:
    """Where a circle meets the conic: the half-tangents t of the angle from a direction, with a polynomial.

    Attributes:
        circle: the circle.
        direction: the one of which the angle is 0; the opposite one is not on the conic.
        polynomial: the coefficients, of t⁰ first, squarefree.
        shared: the greatest common divisor of the polynomial and its derivative before it was made
            squarefree; its roots are the points where conic and circle are tangent.
    """

    circle: Circle
    direction: tuple[Fraction, Fraction]
    polynomial: tuple[Number, ...]
    shared: tuple[Number, ...]

    @classmethod
    def of(cls, circle: Circle, conic: Sequence[Number]) -> Quartic:
        """That of a circle whose centre lies on a conic."""
        for u, v in _DIRECTIONS:
            # e = ((u, v) (1 − t²) + (−v, u) 2 t) / (1 + t²)
            whole = _quartic(circle, conic, [u, -2 * v, -u], [v, 2 * u, -v])
            if not whole[-1].is_zero:
                break
        shared = common_divisor(whole, derivative(whole))
        return cls(circle, (u, v), quotient(whole, shared) if len(shared) > 1 else whole, shared)

    @cached_property
    def points(self) -> tuple[Root, ...]:
        """All common points."""

        def count(bits: int) -> int | None:
            try:
                return len(self.roots(bits))
            except Open:
                return None

        number = decided(count, _FIRST_BITS, GREATEST_BITS, "common points could not be told apart")
        return tuple(Root(self, k) for k in range(number))

    def roots(self, bits: int) -> list[arb]:
        """The real roots, ascending.

        Raises:
            Open: at this precision they are not told apart.
        """
        return real_roots([x.ball(bits) for x in self.polynomial], bits)

    def is_tangent(self, number: int) -> bool:
        """Whether the circle and the conic are tangent at the root of a number."""
        if len(self.shared) == 1:
            return False
        multiple = squarefree(self.shared)

        def tangent(bits: int) -> bool | None:
            try:
                roots, others = self.roots(bits), real_roots([x.ball(bits) for x in multiple], bits)
            except Open:
                return None
            near = [[k for k, x in enumerate(roots) if x.overlaps(y)] for y in others]
            # each multiple root is one of the roots
            return None if any(len(places) != 1 for places in near) else [number] in near

        return decided(tangent, _FIRST_BITS, GREATEST_BITS, "whether two curves are tangent is open")

    def place(self, t: arb, bits: int) -> Pair:
        """The point of a half-tangent."""
        u, v = map(ball_of, self.direction)
        c, s, over = 1 - t * t, 2 * t, ball_of(self.circle.radius) / (1 + t * t)
        x, y = (z.ball(bits) for z in self.circle.centre)
        return _finite((x + over * (u * c - v * s), y + over * (v * c + u * s)))


def intersections(one: Circle | Line, other: Circle | Line) -> list[Place]:
    """The common points of two different circles or lines."""
    if isinstance(one, Line):
        return _of_lines(one, other) if isinstance(other, Line) else _of_line(one, other)
    return _of_line(other, one) if isinstance(other, Line) else _of_circles(one, other)


def evaluated(conic: Sequence[Any], x: Any, y: Any, w: Any) -> Any:
    """The polynomial of a conic at (x : y : w), times w², in numbers or in balls."""
    a, b, c, d, e, f = conic
    return (a * x + b * y + d * w) * x + (c * y + e * w) * y + f * w * w


def gradient(conic: Sequence[arb], p: Pair) -> Pair:
    """The gradient of a conic's polynomial."""
    a, b, c, d, e, _ = conic
    return 2 * a * p[0] + b * p[1] + d, b * p[0] + 2 * c * p[1] + e


def quadratic(conic: Sequence[arb], d: Pair) -> arb:
    """The terms of degree 2 of a conic's polynomial."""
    a, b, c, *_ = conic
    return a * d[0] * d[0] + b * d[0] * d[1] + c * d[1] * d[1]


def unit_vectors() -> tuple[tuple[Fraction, Fraction], ...]:
    """Unit vectors with rational coordinates, of different lines."""
    return _DIRECTIONS


def _finite(p: Pair) -> Pair:
    if not (p[0].is_finite() and p[1].is_finite()):
        raise Open
    return p


def _of_circles(one: Circle, other: Circle) -> list[Place]:
    """Where two circles meet: c + (k d ± √(4 |d|² r² − k²) d⊥)/(2 |d|²), k = |d|² + r² − s²."""
    d = other.centre[0] - one.centre[0], other.centre[1] - one.centre[1]
    square = d[0] * d[0] + d[1] * d[1]
    if square.is_zero:
        return []
    r, s = one.radius**2, other.radius**2
    k = square + (r - s)
    return _across(one, d, k, square * (4 * r) - k * k, square * 2)


def _of_line(line: Line, circle: Circle) -> list[Place]:
    """Where a line meets a circle: c + (−h n ± √(r² |n|² − h²) n⊥)/|n|², h = n · c + m."""
    (u, v), (x, y) = line.normal, circle.centre
    h, square = u * x + v * y + line.constant, u * u + v * v
    return _across(circle, line.normal, -h, square * circle.radius**2 - h * h, square)


def _across(circle: Circle, d: Vector, k: Number, discriminant: Number, w: Number) -> list[Place]:
    sign = discriminant.sign
    if sign < 0:
        return []
    signs = (1, -1) if sign else (1,)
    root = discriminant.tower.with_root(discriminant)[1] if sign else discriminant.tower.number(0)
    x, y = circle.centre
    return [
        Place(x * w + k * d[0] - root * d[1] * side, y * w + k * d[1] + root * d[0] * side, w)
        for side in signs
    ]


def _of_lines(one: Line, other: Line) -> list[Place]:
    (a, b), (c, d) = one.normal, other.normal
    e, f = one.constant, other.constant
    w = a * d - b * c
    return [] if w.is_zero else [Place(b * f - d * e, c * e - a * f, w)]


def _quartic(
    circle: Circle, conic: Sequence[Number], x: Sequence[Fraction], y: Sequence[Fraction]
) -> tuple[Number, ...]:
    """r q(n) + g · n (1 + t²), n being the numerator of the direction e, and g the gradient at the centre."""
    a, b, c, d, e, _ = conic
    p, q = circle.centre
    g, h = a * p * 2 + b * q + d, b * p + c * q * 2 + e
    found = [d.tower.number(0)] * 5
    for i in range(3):
        for j in range(3):
            form = a * (x[i] * x[j]) + b * (x[i] * y[j]) + c * (y[i] * y[j])
            found[i + j] = found[i + j] + form * circle.radius
        for shift in (0, 2):
            found[i + shift] = found[i + shift] + g * x[i] + h * y[i]
    return tuple(found)


def real_roots(polynomial: Sequence[arb], bits: int) -> list[arb]:
    """The real roots of a squarefree polynomial in balls, ascending.

    Raises:
        Open: at this precision they are not told apart.
    """
    if len(polynomial) == 1:
        return []
    with ctx.workprec(bits):
        if not all(x.is_finite() for x in polynomial) or polynomial[-1].contains(0):
            raise Open
        try:
            found = acb_poly(list(polynomial)).roots()
        except ValueError:
            raise Open from None
        own, near = arb_poly(list(polynomial)), [_widened(z.real, bits) for z in found if z.imag.contains(0)]
        if any(x.overlaps(y) for x, y in combinations(near, 2)):
            raise Open
        for x in near:
            # each disc has one root; if the sign changes on both sides of its real part, this is real
            low, high = own(arb(x.lower())), own(arb(x.upper()))
            if not ((low < 0 and high > 0) or (low > 0 and high < 0)):
                raise Open
        return sorted((_sharpened(own, x, bits) for x in near), key=lambda x: x.mid())


def _widened(x: arb, bits: int) -> arb:
    """A ball with a ball inside."""
    return arb(x.mid(), 2 * x.rad() + (1 + abs(x.mid())) * arb(2) ** -bits)


def _sharpened(polynomial: arb_poly, x: arb, bits: int) -> arb:
    """A ball round the only root in a ball, by interval Newton steps while they make it smaller."""
    slope = polynomial.derivative()
    for _ in range(bits.bit_length() + 8):
        middle = arb(x.mid())
        nearer = middle - polynomial(middle) / slope(x)
        if not nearer.is_finite() or not nearer.rad() < x.rad():
            break
        x = nearer
    return x


def derivative(p: Sequence[Number]) -> tuple[Number, ...]:
    """The derivative of a polynomial, of t⁰ first."""
    return tuple(x * k for k, x in enumerate(p) if k)


def common_divisor(p: Sequence[Number], q: Sequence[Number]) -> tuple[Number, ...]:
    """The greatest common divisor of two polynomials, by remainders that need no division; exact."""
    one, other = _trimmed(p), _trimmed(q)
    while len(other) > 1:
        one, other = other, _trimmed(_remainder(one, other)[1])
    return other or one


def quotient(p: Sequence[Number], q: Sequence[Number]) -> tuple[Number, ...]:
    """p / q times a constant, where q divides p."""
    return _trimmed(_remainder(p, q)[0])


def squarefree(p: Sequence[Number]) -> tuple[Number, ...]:
    """A polynomial with the same roots, all simple."""
    shared = common_divisor(p, derivative(p))
    return quotient(p, shared) if len(shared) > 1 else tuple(p)


def _remainder(p: Sequence[Number], q: Sequence[Number]) -> tuple[list[Number], list[Number]]:
    """Quotient and remainder of p, times a power of the leading coefficient of q, by q."""
    rest, lead = list(p), q[-1]
    found: list[Number] = []
    while len(rest) >= len(q):
        top = rest[-1]
        found = [x * lead for x in found]
        found.insert(0, top)
        shift = len(rest) - len(q)
        rest = [x * lead - (q[k - shift] * top if k >= shift else 0) for k, x in enumerate(rest[:-1])]
    return found, rest


def _trimmed(p: Sequence[Number]) -> tuple[Number, ...]:
    """Without leading coefficients that are 0."""
    count = len(p)
    while count and p[count - 1].is_zero:
        count -= 1
    return tuple(p[:count])
