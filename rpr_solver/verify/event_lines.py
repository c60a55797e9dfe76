"""The eliminants of events in v = tan θ of the fixed leg, by exact values on lines v = const.

On J = 0 the length is L = −J0/J1. With it E = φ C / J1² and v·∇E = J0 φ² W / J1³, and ∇J is a multiple of
(M1, M2), the Wronskians of J0 and J1. In t = tan(α/2) and v = tan θ, with formal degrees,

    Res_t(C, W)   = (v²+1)⁸ · Y⁴ · P,       Z = Res_t(J0, J1) / (v²+1),
    Res_t(M1, M2) = (v²+1)⁵ · Z · P,        Y = Z (v²+1) / Res_t(φ, γ),
    Res_t(C, K)   = (v²+1)¹⁰ · (Y Z)² · P,  K = J1² (f − s) for either leg and the square s of a joint limit

(mathematics.md#the-eliminants-of-the-census). These P, of degrees 32, 18 and 24, are interpolated, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Self, TypeVar

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, Pair, angle_of, direction
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, formal_parts, real_roots
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Indivisible,
    Poly,
    Ratio,
    Ring,
    Surd,
    formal_product,
    formal_quotient,
    formal_sum,
    interpolated,
    negative,
    plus,
    radical,
    rational,
    size_of,
    trimmed,
    without,
)
from rpr_solver.verify.core.system import (
    Graded,
    Monomial,
    Surface,
    Trig,
    derivative,
    in_half_tangent,
    less,
)


@dataclass(frozen=True)
class EventSystem:
    """Two equations in t and v, and their eliminant P.

    Attributes:
        name: what their common zeros are.
        degree: that of P.
        powers: P is the resultant times Res_t(φ, γ)^a, divided by Res_t(J0, J1)^b (v²+1)^c.
        kinds: the kinds of events above the roots.
        leg, square: for cusps at a joint limit, which free leg (0, 1) has it, and its square, scaled.
        shared: what both equations are divided by, forms in t, if they vanish at whole angles α.
    """

    name: str
    degree: int
    powers: tuple[int, int, int]
    kinds: tuple[str, ...]
    leg: int = 0
    square: Fraction = Fraction(0)
    shared: tuple[Poly, Poly] = ((ONE,), (ONE,))

    @property
    def is_critical(self) -> bool:
        """Whether the equations are those of ∇J = 0; else E = 0 is one of them."""
        return self.name == "critical poses"


SWALLOWTAILS = EventSystem("swallowtails", 32, (4, 4, 8), ("swallowtail",))
CRITICAL = EventSystem("critical poses", 18, (0, 1, 4), ("lips", "beak-to-beak"))
AT_LIMIT = EventSystem("cusps at a limit", 24, (2, 4, 8), ("limit",))
_MOST_POINTS = 200
_SPARE_BITS = 64
Row = tuple[Surd, ...]
"""Coefficients in t, of formal degree."""
Pairs = tuple[Row, Row, tuple[Fraction, Fraction]]
"""Two forms in t, and the factors that were left out of them."""


@dataclass(frozen=True)
class EventEliminant:
    """An eliminant of events in v = tan θ, a form of formal degree; all 0 where events are not isolated."""

    system: EventSystem
    ring: Ring
    form: Row

    @property
    def name(self) -> str:
        """What its roots are."""
        return self.system.name

    @cached_property
    def parts(self) -> Mapping[int, Poly]:
        """Multiplicity → the form of the roots with it, infinity too."""
        return formal_parts(self.ring, self.form)

    @property
    def finite_parts(self) -> Mapping[int, Poly]:
        """The same without infinity."""
        return {m: part for m, p in self.parts.items() if len(part := trimmed(p)) > 1}


class _Forms:
    """The forms in t on a line, a value v = n/d of tan θ."""

    def __init__(self, surface: Surface, n: Surd, d: Surd) -> None:
        self.surface, self.ring = surface, surface.ring
        self.v = Ratio(self.ring, n, d)
        self._square: Surd = plus(*(self.ring.times(x, x) for x in (n, d)))
        self._weights: dict[tuple[int, int, int], Surd] = {}

    @classmethod
    def of(cls, surface: Surface, v: Fraction | int) -> Self:
        """The line of a rational value."""
        n, d = v.as_integer_ratio()
        return cls(surface, (n, 0), (d, 0))

    def form(self, p: Trig, alpha: int, theta: int) -> Row:
        """A polynomial of these degrees in α and θ, which has one parity in θ, as one in t."""
        spend(10 * len(p))
        rows: dict[Monomial, Surd] = {}
        for (i, j, cos, sin), x in p.items():
            rest, odd = divmod(theta - cos - sin, 2)
            if odd or rest < 0:
                raise ArithmeticError("a form in the direction of the leg is not homogeneous")
            here = self.ring.times(x, self._weight(cos, sin, rest))
            rows[i, j, 0, 0] = plus(rows.get((i, j, 0, 0), ZERO), here)
        return in_half_tangent(rows, alpha, lambda _cos, _sin: 1)

    def _weight(self, *powers: int) -> Surd:
        """cosᵏ sinᵐ (cos² + sin²)ⁿ."""
        if powers not in self._weights:
            product = ONE
            for x, power in zip((self.v.d, self.v.n, self._square), powers, strict=True):
                product = self.ring.times(product, self.ring.power(x, power))
            self._weights[powers] = product  # type: ignore[index]
        return self._weights[powers]  # type: ignore[index]

    @cached_property
    def singular(self) -> tuple[Row, Row]:
        """J0 and J1."""
        j0, j1 = self.surface.singular
        return self.form(j0, 2, 1), self.form(j1, 1, 2)

    @cached_property
    def _slopes(self) -> tuple[Row, Row]:
        """φ and γ."""
        f, g = (self.form(leg.theta[1], 1, 1) for leg in self.surface.legs)
        return f, g

    @cached_property
    def _coalescing(self) -> Row:
        """The numerator of E on the surface J = 0."""
        return self._on_surface(self.surface.legs[0].kernel, [(4, 1), (3, 2), (2, 3)])

    @cached_property
    def _along_kernel(self) -> Row:
        """The numerator of v·∇E there."""
        return self._on_surface(self.surface.legs[0].kernel2, [(6, 1), (5, 2), (4, 3), (3, 4)])

    def _at_limit(self, system: EventSystem) -> Row:
        """K, that of the squared length of a leg less that of its limit."""
        return self._on_surface(
            less(self.surface.legs[system.leg].squared, system.square), [(2, 0), (1, 1), (0, 2)]
        )

    def _on_surface(self, graded: Graded, degrees: Sequence[tuple[int, int]]) -> Row:
        """Σ pₖ (−J0)ᵏ J1ⁿ⁻ᵏ."""
        j0, j1 = self.singular
        total: Row = (ZERO,)
        minus = tuple(map(negative, j0))
        for k, degree in enumerate(degrees):
            term = self.form(graded[k] if k < len(graded) else {}, *degree)
            for factor in [minus] * k + [j1] * (len(degrees) - 1 - k):
                term = formal_product(self.ring, term, factor)
            total = formal_sum(term, total, 1)
        return total


class EventLine(_Forms):
    """A line with the pairs of all systems."""

    def pair(self, system: EventSystem) -> Pairs:
        """(C, W), (M1, M2) or (C, K), divided by what they share.

        Raises:
            ZeroDivisionError: a divisor vanishes on this line.
        """
        *forms, factors = self._whole_pair(system)
        parts = [formal_quotient(self.ring, *both) for both in zip(forms, system.shared, strict=True)]
        (p, first), (q, second) = parts
        return p, q, (factors[0] * first, factors[1] * second)

    def _whole_pair(self, system: EventSystem) -> Pairs:
        if system.is_critical:
            return self._critical()
        c, first = self._quotient
        if system.kinds == ("limit",):
            k = self._at_limit(system)
            return c, k, (first, Fraction(1))
        w, second = self._along_kernel, Fraction(1)
        # the terms of v·∇E are of degree 9 in α, their sum of degree 8
        for divisor in (rational([1, 0, 1]), self._slopes[0], self._slopes[0], self.singular[0]):
            w, factor = formal_quotient(self.ring, w, divisor)
            second *= factor
        return c, w, (first, second)

    @cached_property
    def _quotient(self) -> tuple[Row, Fraction]:
        """C, and a factor of it."""
        return formal_quotient(self.ring, self._coalescing, self._slopes[0])

    @cached_property
    def _known(self) -> tuple[Surd, Surd]:
        """Res_t(φ, γ) and Res_t(J0, J1)."""
        return self.ring.resultant(*self._slopes), self.ring.resultant(*self.singular)

    def _critical(self) -> Pairs:
        j0, j1 = self.singular
        rows = []
        for theta in (False, True):
            d0, d1 = (derivative(p, theta=theta) for p in self.surface.singular)
            first = formal_product(self.ring, j0, self.form(d1, 1, 2))
            second = formal_product(self.ring, j1, self.form(d0, 2, 1))
            rows.append(formal_sum(first, second, -1))
        return rows[0], rows[1], (Fraction(1), Fraction(1))

    def common(self, system: EventSystem) -> tuple[Poly, bool]:
        """The product of t − t₀ over the common roots with finite lengths > 0, and whether ∞ is one; empty if
        all t are.

        Where J1 = 0 a pose is permanent, where J0 = 0 the length is 0; where φ = 0 ≠ J1, leg f is closed.
        """
        ring, factors = self.ring, [*self.singular]
        if system.is_critical:
            p, q, _ = self._critical()
        else:
            p = self._coalescing
            q = self._at_limit(system) if system.kinds == ("limit",) else self._along_kernel
            factors.append(self._slopes[0])
        if not all(any(map(any, factor)) for factor in factors):
            return (ONE,), False
        p, q = (formal_quotient(ring, *both)[0] for both in zip((p, q), system.shared, strict=True))
        if not any(map(any, (*p, *q))):
            return (), True
        at_infinity = p[-1] == q[-1] == ZERO and ZERO not in [factor[-1] for factor in factors]
        common = ring.gcd(trimmed(p), trimmed(q))
        for factor in factors:
            common = without(ring, common, trimmed(factor))
        return radical(ring, common), at_infinity

    def clear(self, system: EventSystem) -> bool:
        """Whether no pose of this line is an event: the pair has no common root where L > 0 is possible."""
        common, at_infinity = self.common(system)
        return not at_infinity and (
            len(common) == 1 or (len(common) > 1 and not real_roots(self.ring, common))
        )

    def poses(self, system: EventSystem, bits: int) -> list[tuple[Directions, Interval]]:
        """The events of this line, each with its length.

        Raises:
            ZeroDivisionError: intervals do not tell them from infinite ones.
        """
        common, at_infinity = self.common(system)
        if not common:
            raise ZeroDivisionError("two forms are one")
        work = 2 * bits + 2 * max(map(size_of, (common, *self.singular))) + _SPARE_BITS
        places = [direction(self.ring, common, root, work) for root in real_roots(self.ring, common)]
        if at_infinity:
            places.append((Interval.of(-1, work), Interval.of(0, work)))
        return [self._directed(place, work) for place in places]

    def _direction(self, bits: int) -> Pair:
        """Cosine and sine of θ."""
        omega = Interval.of(self.ring.radicand, bits).root()
        cos, sin = (Interval.of(a, bits) + omega.scaled(b) for a, b in (self.v.d, self.v.n))
        size = (cos * cos + sin * sin).root()
        return cos.over(size), sin.over(size)

    def _directed(self, alpha: Pair, bits: int) -> tuple[Directions, Interval]:
        """The pose with J = 0 on this line, in the one of both directions of θ with L = −J0/J1 > 0, and L."""
        cos, sin = self._direction(bits)
        here = Directions(alpha, (cos, sin), self.ring.radicand)
        above, below = (here.value(p) for p in self.surface.singular)
        length = above.over(below).scaled(-1)
        sign = length.sign or 1
        return replace(here, theta=(cos.scaled(sign), sin.scaled(sign))), length.scaled(sign)

    def value(self, system: EventSystem) -> tuple[Fraction, Fraction]:
        """The eliminant of a system at this line, where d = 1, but for a factor that is that of all lines.

        Raises:
            ZeroDivisionError: a known factor vanishes.
        """
        p, q, (first, second) = self.pair(system)
        factor = first ** (len(q) - 1) * second ** (len(p) - 1)
        ring, (parallel, permanent, circular) = self.ring, system.powers
        above = ring.times(ring.resultant(p, q), ring.power(self._known[0], parallel))
        below = ring.power(self._known[1], permanent)
        a, b = ring.times(above, (below[0], -below[1]))
        norm = below[0] ** 2 - ring.radicand * below[1] ** 2
        scale = factor / (norm * self._square[0] ** circular)
        return a * scale, b * scale

    def angles(self, bits: int) -> Iterator[Interval]:
        """θ in radians, in either sense."""
        cos, sin = self._direction(bits)
        for sign in (1, -1):
            yield angle_of((cos.scaled(sign), sin.scaled(sign)))

    def length(self, alpha: Interval, theta: Interval) -> Fraction | None:
        """L = −J0/J1, scaled; None if it is not > 0."""
        here = Directions.of(alpha, theta, self.ring.radicand)
        above, below = (here.value(p).middle for p in self.surface.singular)
        return -above / below if below and above * below < 0 else None

    def near(self, theta: Pair, root: Root) -> bool:
        """Whether a direction may be above a root."""
        cos, sin = theta
        if root.inverted:
            cos, sin = sin, cos
        sides = [(sin - cos * Interval.of(x, sin.bits)).sign for x in (root.lower, root.upper)]
        return 0 in sides or sides[0] != sides[1]


Found = TypeVar("Found")


def on_lines(
    surface: Surface,
    number: int,
    find: Callable[[EventLine], Found],
    lines: dict[int, EventLine] | None = None,
) -> dict[int, Found]:
    """What is found on so many lines v = 0, 1, −1, 2, …, without those on which a divisor vanishes.

    Args:
        surface: the equations.
        number: of lines.
        find: what is done on each.
        lines: some that are known; others are added.

    Raises:
        Indivisible: there are too few such lines, or on one a known factor is none, which no theorem excludes
            where permanent poses are not isolated.
    """
    found: dict[int, Found] = {}
    lines = {} if lines is None else lines
    for k in range(_MOST_POINTS):
        v = (k + 1) // 2 * (1 if k % 2 else -1)
        with suppress(ZeroDivisionError):
            found[v] = find(lines.setdefault(v, EventLine.of(surface, v)))
        if len(found) == number:
            return found
    raise Indivisible("a divisor vanishes on too many lines")


def event_eliminant(
    surface: Surface,
    system: EventSystem,
    lines: dict[int, EventLine] | None = None,
    value: Callable[[EventLine], tuple[Fraction, Fraction]] | None = None,
) -> EventEliminant:
    """An eliminant, interpolated from its values; all 0 if it vanishes, or known factors vanish everywhere.

    Lines that are given are kept for other systems.
    """
    size = system.degree + 1
    try:
        values = on_lines(surface, size, value or (lambda line: line.value(system)), lines)
    except Indivisible:
        return EventEliminant(system, surface.ring, (ZERO,) * size)
    short = interpolated([*values], [*values.values()])
    return EventEliminant(system, surface.ring, short + (ZERO,) * (size - len(short)))
