"""Mirrored congruent triangles: all cusps and events, in closed form; and which shape a manipulator has.

With the sides of landmarks.py, m = κ ā and n = κ b̄ with κ = ±1. A slice is X = L sin(θ − β) followed by
(β, X) ↦ h² − h X for both legs; 2 β is α, or α + 180° if κ = −1, and h = Im(a e^−iβ), or with b. L is in the
first step only, so each cusp of the second step is two cusps of all slices with L > |X|
(mathematics.md#special-shapes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.core.intervals import Interval, ends_of
from rpr_solver.verify.core.krawczyk import Directions, Pair
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, formal_parts, has_root, real_roots, refined
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Poly,
    Ring,
    formal_product,
    formal_sum,
    interpolated,
    size_of,
)
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits
from rpr_solver.verify.landmarks import Event, Landmark, Shape, Throughout, Unclear, told
from rpr_solver.verify.permanent import Vectors, conjugate

_RING = Ring(1)
_APART_BITS, _FINE = 512, 1 << 64
CIRCLE: Poly = (ONE, ZERO, ONE)


def shape_of(surface: Surface) -> Shape | None:
    """The special shape of a manipulator; None for all others."""
    v = Vectors.of(surface)
    times = v.times
    if v.ring.radicand != 1:
        return None
    a, b = ((x[0], y[0]) for x, y in (v.a, v.b))
    size = a[0] ** 2 + a[1] ** 2
    if times(v.m, v.b) == times(v.n, v.a):
        return Shape(surface, a, b, Fraction(times(v.m, conjugate(v.a))[0][0], size))
    if times(conjugate(v.a), v.b)[1] == times(conjugate(v.m), v.n)[1] == ZERO:
        return Shape(surface, a, b, Fraction(0))
    ratio = Fraction(times(v.m, v.a)[0][0], size)
    if times(v.m, conjugate(v.b)) == times(v.n, conjugate(v.a)) and ratio in (1, -1):
        return Mirrored(surface, a, b, ratio)
    return None


def nodes(surface: Surface, length: Fraction, bits: int) -> list[Event]:
    """Those of a slice of mirrored triangles: at X = ±L = S(β), but where S′ = 0, or both gradients are.

    Raises:
        Unclear: intervals do not tell.
    """
    shape = shape_of(surface)
    if not isinstance(shape, Mirrored):
        return []
    bits, scaled = max(bits, shape._bits), length * surface.unit
    first, second, slope, other = shape.heights
    special = formal(shape._turning, slope, other, formal_sum(first, second, -1))
    lines, _ = lines_of(entering(shape.singular, shape.area, scaled))
    here = Landmark(Interval.of(scaled, bits))
    return [shape._event("node", x, here, set(), bits) for x in lines if not x.is_root(special)]


@dataclass(frozen=True)
class _Line:
    """A value of t = tan β, a root of a squarefree form, ∞ too."""

    form: Poly
    root: Root

    def is_root(self, form: Poly) -> bool:
        """Whether it is a root of another form."""
        return has_root(_RING, self.form, self.root, form)

    def direction(self, bits: int) -> Pair:
        """Cosine and sine of β."""
        narrow = refined(_RING, self.form, self.root, Fraction(1, 1 << bits))
        x = Interval.of((narrow.lower + narrow.upper) / 2, bits, narrow.width / 2)
        one = Interval.of(1, bits)
        norm = (one + x * x).root()
        pair = one.over(norm), x.over(norm)
        return pair[::-1] if narrow.inverted else pair


class Mirrored(Shape):
    """Mirrored congruent triangles that are not flat; forms are in t = tan β, lengths are scaled."""

    @cached_property
    def heights(self) -> tuple[Poly, Poly, Poly, Poly]:
        """h of both legs, and their derivatives."""
        (ax, ay), (bx, by) = self.a, self.b
        rows = (ay, -ax), (by, -bx), (-ax, -ay), (-bx, -by)
        first, second, slope, other = (((x, 0), (y, 0)) for x, y in rows)
        return first, second, slope, other

    @cached_property
    def singular(self) -> Poly:
        """c S: the second step is singular at X = S(β), where c is the area, negative."""
        first, second, slope, other = self.heights
        return formal(((2, 0),), first, second, formal_sum(slope, other, -1))

    @cached_property
    def _turning(self) -> Poly:
        """c S′ / 2."""
        first, second, slope, other = self.heights
        mixed = formal_sum(formal(slope, second), formal(first, other), 1)
        heights = formal(first, second, formal_sum(first, second, -1))
        return formal_sum(formal(mixed, formal_sum(slope, other, -1)), heights, -1)

    @cached_property
    def coalescing(self) -> Poly:
        """The form whose simple roots are the cusps of the second step."""
        first, second, slope, other = self.heights
        return formal_sum(formal(slope, other, formal_sum(first, second, -1)), self._turning, 1)

    @cached_property
    def _cusps(self) -> list[_Line]:
        """The lines of the cusps of the second step.

        Raises:
            Unclear: one is of a higher order.
        """
        lines, multiplicity = lines_of(self.coalescing)
        if multiplicity > 1:
            raise Unclear
        return lines

    @cached_property
    def _bits(self) -> int:
        return _APART_BITS + 8 * size_of((*self.singular, *self.coalescing, (self.area, 0)))

    def place(self, line: _Line, bits: int) -> tuple[Pair, Interval]:
        """e^iβ and S(β)."""
        spend(60, bits)
        here = line.direction(bits)
        return here, value_of(self.singular, here).over(Interval.of(-self.area, bits))

    def _lengths(self, cubic: Poly, lines: Sequence[_Line], bits: int) -> list[Landmark]:
        """|S| on roots of a form; equal ones have one name.

        Raises:
            Unclear: intervals do not tell them apart.
        """
        places = [self.place(line, max(bits, self._bits))[1] for line in lines]
        squares = [x * x * Interval.of(self.area**2, x.bits) for x in places]
        names = _names(cubic, formal(self.singular, self.singular), squares)
        return [Landmark(x.scaled(x.sign or 1), ("S", n)) for x, n in zip(places, names, strict=True)]

    def _resting(self, bits: int) -> list[tuple[_Line, Landmark, set[str]]]:
        """Where both gradients vanish for one length > 0, this length, and the legs that are closed."""
        first, second, slope, other = self.heights
        found: dict[Fraction | None, tuple[_Line, Landmark, set[str]]] = {}
        # there X is 2 h of the legs that are closed
        for form, half in ((slope, second), (other, first), (formal_sum(first, second, -1), first)):
            (x, _), (y, _) = form
            height, *heights = (h[0][0] * y - h[1][0] * x for h in (half, first, second))
            if height:
                square = Fraction(4 * height**2, x**2 + y**2)
                [root] = real_roots(_RING, form)
                length = Landmark(Interval.of(square, 2 * bits).root().at(bits), square)
                legs = zip(heights, self.surface.free, strict=True)
                closed = {f"l{leg}" for own, leg in legs if own == height}
                found[Fraction(x, y) if y else None] = _Line(form, root), length, closed
        return list(found.values())

    def events(self, bits: int) -> list[Event]:
        """Where a cusp of the second step enters, and where both gradients vanish beside cusps.

        Raises:
            Unclear: intervals do not tell.
        """
        bits = max(bits, self._bits)
        cusps = list(zip(self._cusps, self._lengths(self.coalescing, self._cusps, bits), strict=True))
        resting, found = self._resting(bits), []
        for line, length, closed in resting:
            same = [x for own, x in cusps if own.is_root(line.form)]
            if same:
                found.append(self._event("higher", line, same[0], closed, bits))
            elif any(told((length.scaled - x.scaled).sign) > 0 for _, x in cusps):
                found.append(self._event("quadruple", line, length, closed, bits))
        for line, length in cusps:
            if not (line.is_root(self.singular) or any(line.is_root(x.form) for x, _, _ in resting)):
                found.append(self._event("node", line, length, set(), bits))
        return found

    def _event(self, kind: str, line: _Line, length: Landmark, zeros: set[str], bits: int) -> Event:
        """That where X = ±L = S: θ = β ± 90°."""
        (cos, sin), x = self.place(line, bits)
        sign = int(self.ratio)
        alpha = (cos * cos - sin * sin).scaled(sign), (cos * sin).scaled(2 * sign)
        theta = sin.scaled(-told(x.sign)), cos.scaled(x.sign)
        # α is 0 where β is 0, or 90° if κ = −1; θ is 0 where β is 90°
        names = ["alpha_deg"] if line.is_root((ZERO, ONE) if sign > 0 else (ONE, ZERO)) else []
        names += [f"theta{self.surface.fixed}_deg"] if line.is_root((ONE, ZERO)) else []
        # those of cusps are where both cusps of one of the second step enter
        beside = (0, 0) if kind == "quadruple" else (0, 2)
        return Event.at(kind, Directions(alpha, theta, 1), length, zeros.union(names), beside)

    def _square(self, line: _Line, leg: int, bits: int) -> Interval:
        """The squared length of a free leg at a cusp of the second step, less L²."""
        here, x = self.place(line, bits)
        height = value_of(self.heights[leg], here)
        return (height * (height - x)).scaled(4)

    def crossings(self, leg: int, limit: Fraction, bits: int) -> list[Landmark]:
        """Where L² is that of the limit less what does not depend on L."""
        bits, height, limit = max(bits, self._bits), self.heights[leg], (limit * self.surface.unit) ** 2
        squares = [self._square(line, leg, bits) for line in self._cusps]
        own = formal(((4 * -self.area, 0),), height, height, CIRCLE)
        above = formal_sum(own, formal(((4, 0),), height, self.singular), -1)
        scaled = [x * Interval.of(-self.area, x.bits) for x in squares]
        found = []
        for x, name in zip(squares, _names(self.coalescing, above, scaled), strict=True):
            square = Interval.of(limit, x.bits) - x
            if told(square.sign) > 0:
                found.append(Landmark(square.root(), (leg, limit, name)))
        return found

    def counted(self, length: Fraction, limits: Limits) -> tuple[int, bool] | None:
        """Two for each cusp of the second step with |X| < L; both have the same legs."""
        total, unit = 0, self.surface.unit
        for line in self._cusps:
            _, x = self.place(line, self._bits)
            own = Interval.of((length * unit) ** 2, x.bits)
            sides = [(own - x * x).sign]
            for n, leg in enumerate(self.surface.free):
                squared = self._square(line, n, self._bits) + own
                for bound, side in zip(limits.of_legs.get(leg, ()), (1, -1), strict=False):
                    if bound is not None:
                        sides.append(side * (squared - Interval.of((bound * unit) ** 2, x.bits)).sign)
            if -1 not in sides:
                if 0 in sides:
                    return None
                total += 2
        return total, True

    def throughout(self, start: Fraction, stop: Fraction | None, bits: int) -> list[Throughout]:
        """The nodes at X = ±L = S(β): their number changes where S′ = 0."""
        lines, _ = lines_of(self._turning)
        lengths = zip(lines, self._lengths(self._turning, lines, bits), strict=True)
        known = {x.square: x for line, x in lengths if not line.is_root(self.singular)}
        ends = sorted(known.values(), key=lambda x: x.scaled.middle)
        edges = [Fraction(0), *(edge for x in ends for edge in ends_of(x.scaled))]
        edges.append(2 * edges[-1] + 1)
        counts = []
        for low, high in zip(edges[::2], edges[1::2], strict=True):
            length = ((low + high) / 2).limit_denominator(_FINE)
            if not low < length < high:
                raise Unclear
            counts.append(len(lines_of(entering(self.singular, self.area, length))[0]))
        return self._runs(counts, ends, start, stop)


def entering(singular: Poly, area: int, length: Fraction) -> Poly:
    """The form whose roots are the lines with |S| = L, for c S, c and a scaled length L."""
    n, d = length.as_integer_ratio()
    above, circle = formal(singular, singular), formal(CIRCLE, CIRCLE, CIRCLE)
    return formal_sum(formal(((d * d, 0),), above), formal((((n * area) ** 2, 0),), circle), -1)


def lines_of(form: Poly) -> tuple[list[_Line], int]:
    """All real roots of a form, and the highest multiplicity of one.

    Raises:
        Unclear: the form vanishes.
    """
    if not any(map(any, form)):
        raise Unclear
    found, most = [], 0
    for multiplicity, part in formal_parts(_RING, form).items():
        own = [_Line(part, root) for root in real_roots(_RING, part)]
        most = max(most, multiplicity if own else 0)
        found += own
    return found, most


def _names(cubic: Poly, above: Poly, values: Sequence[Interval]) -> list[int]:
    """Names of the values of above / (1 + t²)ⁿ at some roots of a form, 2 n being the degree of ``above``.

    Those at all roots, complex ones too, are the roots of a resultant; equal values are one of its roots.

    Raises:
        Unclear: intervals do not tell which.
    """
    circle = formal(*[CIRCLE] * (len(above) // 2))
    points = [*range(len(cubic))]
    resultants = [_RING.resultant(cubic, formal_sum(above, formal(((y, 0),), circle), -1)) for y in points]
    short = interpolated(points, resultants)
    known, _ = lines_of(short + (ZERO,) * (len(cubic) - len(short)))
    found = []
    for value in values:
        width = Fraction(1, 1 << (value.bits // 2))
        near = [refined(_RING, line.form, line.root, width) for line in known]
        names = [n for n, root in enumerate(near) if _meets(value, root)]
        if len(names) != 1:
            raise Unclear
        found += names
    return found


def formal(*forms: Poly) -> Poly:
    """The product of forms, of its formal degree."""
    product: Poly = (ONE,)
    for form in forms:
        product = formal_product(_RING, product, form)
    return product


def value_of(form: Poly, here: Pair) -> Interval:
    """A form at a direction."""
    cos, sin = here
    total, power = Interval(0, 0, cos.bits), Interval.of(1, cos.bits)
    for a, _ in reversed(form):
        total, power = total * sin + power.scaled(a), power * cos
    return total


def _meets(x: Interval, root: Root) -> bool:
    """Whether a number may be a root."""
    one, ends = Interval.of(1, x.bits), (Interval.of(end, x.bits) for end in (root.lower, root.upper))
    low, high = sorted((x * y - one if root.inverted else x - y).sign for y in ends)
    return low <= 0 <= high
