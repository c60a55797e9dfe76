"""How fast the legs change along the arcs of a path: their derivatives by τ, in intervals.

On a piece, whose parameter runs from 0 to 1, the k-th Taylor coefficient of a leg lies in
cₖ(middle) + (k + 1) cₖ₊₁(piece) [−1/2, 1/2]. Those of α, θ and L are in the hulls of differences of control
points; those of sines, products and roots follow from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from math import comb, factorial

from rpr_solver.verify.arcs import Controls, Piece, hull_of, in_radians
from rpr_solver.verify.core.intervals import Interval, cos_sin
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.system import Surface

ORDERS = 3
BITS = 128
Series = list[Interval]
"""Taylor coefficients, from that of order 0."""
Rates = list[Series]
"""Of legs 1, 2 and 3 the derivatives of order 1, 2 and 3, in the user's unit."""
_MIDDLE = Interval(-1, 1, 1).at(BITS)


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
        own = [
            Piece(x.forms, tuple((p[0].at(BITS), p[1].at(BITS), p[2].at(BITS)) for p in x.controls))
            for x in pieces
        ]
        return cls(pieces[0].forms.surface, own, lengths)

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
            for n in reversed(range(depth)):
                side = number >> n & 1
                piece, lengths = piece.halves[side], _half(lengths, side)
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
        unit, rates = Interval.of(self.surface.unit, BITS), {}
        for leg, middle, wide in zip(self.surface.free, middles, around, strict=True):
            rates[leg] = [
                (middle[k] + wide[k + 1].scaled(k + 1) * _MIDDLE).scaled(factorial(k) << depth * k).over(unit)
                for k in range(1, ORDERS + 1)
            ]
        rates[self.surface.fixed] = _of_polynomial(lengths, depth)
        return [rates[leg] for leg in (1, 2, 3)]

    def _free(self, point: Sequence[Series], order: int) -> list[Series]:
        """The series of both free legs from those of α, θ and L; none if one may be closed."""
        spend(160 * order**2, BITS)
        omega = Interval.of(self.surface.ring.radicand, BITS).root()
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
                    size = Interval.of(a, BITS) + omega.scaled(b)
                    square = [x + y * size for x, y in zip(square, product(key), strict=True)]
            if square[0].lower <= 0:
                return []
            found.append(_root(square))
        return found


def _half(lengths: Sequence[Fraction], side: int) -> Sequence[Fraction]:
    """The control points of one half, exact."""
    found, points = [], list(lengths)
    if len(set(points)) == 1:
        return points
    while points:
        found.append(points[-side])
        points = [(x + y) / 2 for x, y in pairwise(points)]
    return found[::-1] if side else found


def _of_polynomial(lengths: Sequence[Fraction], depth: int) -> Series:
    """The derivatives of a polynomial on a piece, by the differences of its control points."""
    row, factor, found = list(lengths), 1, []
    for _ in range(ORDERS):
        factor *= max(len(row) - 1, 0) << depth
        row = [y - x for x, y in pairwise(row)]
        found.append(hull_of([Interval.of(x * factor, BITS) for x in row or [Fraction(0)]]))
    return found


def _coefficients(
    controls: Controls, order: int, of: Callable[[Sequence[Interval]], Interval]
) -> list[Series]:
    """Series of α and θ in radians and of L, by what is made of the differences of control points."""
    degree, found = len(controls) - 1, []
    for n, column in enumerate(zip(*controls, strict=True)):
        row, series = list(column), []
        for k in range(order + 1):
            x = of(row).scaled(comb(degree, k)) if row else Interval(0, 0, BITS)
            series.append(in_radians(x) if n < 2 else x)
            row = [y - x for x, y in pairwise(row)]
        found.append(series)
    return found


def _constant(x: int, order: int) -> Series:
    return [Interval.of(x, BITS), *[Interval(0, 0, BITS)] * order]


def _times(p: Series, q: Series) -> Series:
    return [_sum([p[i] * q[k - i] for i in range(k + 1)]) for k in range(len(p))]


def _sum(terms: Sequence[Interval]) -> Interval:
    return Interval(sum(x.lower for x in terms), sum(x.upper for x in terms), BITS)


def _cos_sin(angle: Series) -> tuple[Series, Series]:
    """Cosine and sine of a series: c′ = −s a′ and s′ = c a′."""
    cos, sin = ([x] for x in cos_sin(angle[0]))
    for k in range(1, len(angle)):
        steps = [angle[i].scaled(i) for i in range(1, k + 1)]
        back = range(k - 1, -1, -1)
        one, two = (_sum([row[n] * x for n, x in zip(back, steps, strict=True)]) for row in (sin, cos))
        whole = Interval.of(k, BITS)
        cos.append(Interval(-one.upper, -one.lower, BITS).over(whole))
        sin.append(two.over(whole))
    return cos, sin


def _root(square: Series) -> Series:
    """The root of a series: S = L², so 2 L₀ Lₖ = Sₖ − Σ Lᵢ Lₖ₋ᵢ over 0 < i < k."""
    root = [square[0].root()]
    twice = root[0].scaled(2)
    for k in range(1, len(square)):
        root.append((square[k] - _sum([root[i] * root[k - i] for i in range(1, k)])).over(twice))
    return root
