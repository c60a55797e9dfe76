"""Arcs of a path in (α, θ, L) and pieces of them, with J and the legs on each in intervals.

A piece of a Bézier arc lies in the hull of its control points, and its derivative in that of their
differences. So a function on a piece over [0, 1] is within F(1/2) + F′(piece) [−1/2, 1/2], and halving the
piece makes the second part about two times smaller.

How fast the legs change follows likewise: the k-th Taylor coefficient of a leg lies in
cₖ(middle) + (k + 1) cₖ₊₁(piece) [−1/2, 1/2]. Those of α, θ and L are in the hulls of differences of control
points; those of sines, products and roots follow from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import comb, factorial
from typing import TypeVar

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval, cos_sin, halved, pi
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.reader import spend, spend_exact
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


ORDERS = 3
RATE_BITS = 128
Series = list[Interval]
"""Taylor coefficients, from that of order 0."""
Rates = list[Series]
"""Of legs 1, 2 and 3 the derivatives of order 1, 2 and 3, in the user's unit."""
_MIDDLE = Interval(-1, 1, 1).at(RATE_BITS)


@dataclass(frozen=True)
class LegRates:
    """The derivatives of the legs on dyadic pieces of the arcs.

    Attributes:
        pieces: the arcs.
        lengths: the exact lengths of the fixed leg at their control points, in the user's unit.
    """

    surface: Surface
    pieces: Sequence[Piece]
    lengths: Sequence[Sequence[Fraction]]
    known: dict[tuple[int, int, int], Rates | None] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, pieces: Sequence[Piece], lengths: Sequence[Sequence[Fraction]]) -> LegRates:
        """Those of arcs, at a precision that is enough for rates."""
        rounded = (
            tuple((a.at(RATE_BITS), t.at(RATE_BITS), z.at(RATE_BITS)) for a, t, z in x.controls)
            for x in pieces
        )
        forms = pieces[0].forms
        return cls(forms.surface, [Piece(forms, controls) for controls in rounded], lengths)

    def on(self, arc: int, low: Fraction, high: Fraction, depth: int) -> Rates | None:
        """All derivatives for low ≤ τ ≤ high on an arc, by pieces of length 2^−depth; None if a leg may be
        closed on one."""
        size = 1 << depth
        first = min(int(low * size), size - 1)
        found = [self._known(arc, depth, n) for n in range(first, max(-int(-high * size // 1), first + 1))]
        if len(found) == 1 or None in found:
            return found[0] if len(found) == 1 else None
        return [[hull_of(x) for x in zip(*legs, strict=True)] for legs in zip(*found, strict=True)]

    def _known(self, arc: int, depth: int, number: int) -> Rates | None:
        key = arc, depth, number
        if key not in self.known:
            piece, lengths = self.pieces[arc], self.lengths[arc]
            spend_exact((2 + depth) * len(lengths) ** 2, *lengths)
            for n in reversed(range(depth)):
                side = number >> n & 1
                piece, lengths = piece.halves[side], halves_of(lengths, mean)[side]
            self.known[key] = self._found(piece, lengths, depth)
        return self.known[key]

    def _found(self, piece: Piece, lengths: Sequence[Fraction], depth: int) -> Rates | None:
        # the left half ends in the middle; read from there, its parameter runs back, and twice as fast
        back = _coefficients(piece.halves[0].controls[::-1], ORDERS, lambda column: column[0])
        near = [[x.scaled((-2) ** k) for k, x in enumerate(row)] for row in back]
        middles = self._free(near, ORDERS)
        around = self._free(_coefficients(piece.controls, ORDERS + 1, hull_of), ORDERS + 1)
        if not middles or not around:
            return None
        unit, rates = Interval.of(self.surface.unit, RATE_BITS), {}
        for leg, middle, wide in zip(self.surface.free, middles, around, strict=True):
            rates[leg] = [
                (middle[k] + wide[k + 1].scaled(k + 1) * _MIDDLE).scaled(factorial(k) << depth * k).over(unit)
                for k in range(1, ORDERS + 1)
            ]
        rates[self.surface.fixed] = _of_polynomial(lengths, depth)
        return [rates[leg] for leg in (1, 2, 3)]

    def _free(self, point: Sequence[Series], order: int) -> list[Series]:
        """The series of both free legs from those of α, θ and L; none if one may be closed."""
        spend(120 * order**2, RATE_BITS)
        omega = Interval.of(self.surface.ring.radicand, RATE_BITS).root()
        directions = [*_cos_sin(point[0]), *_cos_sin(point[1])]
        products = {(0, 0, 0, 0): _constant(1, order)}

        def product(key: tuple[int, ...]) -> Series:
            if key not in products:
                place = next(n for n in range(4) if key[n])
                lesser = (*key[:place], key[place] - 1, *key[place + 1 :])
                products[key] = _times(product(lesser), directions[place])  # type: ignore[index]
            return products[key]  # type: ignore[index]

        found = []
        for leg in self.surface.legs:
            square = _constant(0, order)
            for row in reversed(leg.squared):
                square = _times(square, point[2])
                for key, (a, b) in row.items():
                    size = Interval.of(a, RATE_BITS) + omega.scaled(b)
                    square = [x + y * size for x, y in zip(square, product(key), strict=True)]
            if square[0].lower <= 0:
                return []
            found.append(_root(square))
        return found


def _of_polynomial(lengths: Sequence[Fraction], depth: int) -> Series:
    """The derivatives of a polynomial on a piece, by the differences of its control points."""
    row, factor, found = list(lengths), 1, []
    for _ in range(ORDERS):
        factor *= max(len(row) - 1, 0) << depth
        row = [y - x for x, y in pairwise(row)]
        found.append(hull_of([Interval.of(x * factor, RATE_BITS) for x in row or [Fraction(0)]]))
    return found


def _coefficients(
    controls: Controls, order: int, of: Callable[[Sequence[Interval]], Interval]
) -> list[Series]:
    """Series of α and θ in radians and of L, by what is made of the differences of control points."""
    degree, found = len(controls) - 1, []
    for n, column in enumerate(zip(*controls, strict=True)):
        row, series = list(column), []
        for k in range(order + 1):
            x = of(row).scaled(comb(degree, k)) if row else Interval(0, 0, RATE_BITS)
            series.append(in_radians(x) if n < 2 else x)
            row = [y - x for x, y in pairwise(row)]
        found.append(series)
    return found


def _constant(x: int, order: int) -> Series:
    return [Interval.of(x, RATE_BITS), *[Interval(0, 0, RATE_BITS)] * order]


def _times(p: Series, q: Series) -> Series:
    return [_sum([p[i] * q[k - i] for i in range(k + 1)]) for k in range(len(p))]


def _sum(terms: Sequence[Interval]) -> Interval:
    return Interval(sum(x.lower for x in terms), sum(x.upper for x in terms), RATE_BITS)


def _cos_sin(angle: Series) -> tuple[Series, Series]:
    """Cosine and sine of a series: c′ = −s a′ and s′ = c a′."""
    cos, sin = ([x] for x in cos_sin(angle[0]))
    for k in range(1, len(angle)):
        steps = [angle[i].scaled(i) for i in range(1, k + 1)]
        back = range(k - 1, -1, -1)
        one, two = (_sum([row[n] * x for n, x in zip(back, steps, strict=True)]) for row in (sin, cos))
        whole = Interval.of(k, RATE_BITS)
        cos.append(Interval(-one.upper, -one.lower, RATE_BITS).over(whole))
        sin.append(two.over(whole))
    return cos, sin


def _root(square: Series) -> Series:
    """The root of a series: S = L², so 2 L₀ Lₖ = Sₖ − Σ Lᵢ Lₖ₋ᵢ over 0 < i < k."""
    root = [square[0].root()]
    twice = root[0].scaled(2)
    for k in range(1, len(square)):
        root.append((square[k] - _sum([root[i] * root[k - i] for i in range(1, k)])).over(twice))
    return root
