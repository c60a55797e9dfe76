"""The eliminants of events in v = tan θ of the fixed leg, by exact values on lines v = const.

On J = 0 the length is L = −J0/J1. With it E = φ C / J1² and v·∇E = J0 φ² W / J1³, and ∇J is a multiple of
(M1, M2), the Wronskians of J0 and J1. In t = tan(α/2) and v = tan θ, with formal degrees,

    Res_t(C, W)   = (v²+1)⁸ · Y⁴ · P,       Z = Res_t(J0, J1) / (v²+1),
    Res_t(M1, M2) = (v²+1)⁵ · Z · P,        Y = Z (v²+1) / Res_t(φ, γ),
    Res_t(C, K)   = (v²+1)¹⁰ · (Y Z)² · P,  K = J1² (f − s) for either leg and the square s of a joint limit

(mathematics.md#the-eliminants-of-the-census). These P, of degrees 32, 18 and 24, are interpolated, exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, Pair
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, formal_parts, real_roots
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Indivisible,
    Poly,
    Ring,
    Surd,
    content,
    interpolated,
    rational,
    trimmed,
)
from rpr_solver.verify.core.surds import derivative as slope_of
from rpr_solver.verify.core.system import (
    Graded,
    Monomial,
    Surface,
    Trig,
    derivative,
    in_half_tangent,
    multiple,
)
from rpr_solver.verify.cusps import angle_of


@dataclass(frozen=True)
class EventSystem:
    """Two equations in t and v, and their eliminant P.

    Attributes:
        name: what their common zeros are.
        degree: that of P.
        powers: P is the resultant times Res_t(φ, γ)^a, divided by Res_t(J0, J1)^b (v²+1)^c.
        kinds: the kinds of events above the roots.
        leg, square: for cusps at a joint limit, which free leg (0, 1) has it, and its square, scaled.
    """

    name: str
    degree: int
    powers: tuple[int, int, int]
    kinds: tuple[str, ...]
    leg: int = 0
    square: Fraction = Fraction(0)

    @property
    def is_critical(self) -> bool:
        """Whether the equations are those of ∇J = 0; else E = 0 is one of them."""
        return self.name == "critical poses"


SWALLOWTAILS = EventSystem("swallowtails", 32, (4, 4, 8), ("swallowtail",))
CRITICAL = EventSystem("critical poses", 18, (0, 1, 4), ("lips", "beak-to-beak"))
AT_LIMIT = EventSystem("cusps at a limit", 24, (2, 4, 8), ("limit",))
_MOST_POINTS = 200
_ONE: Monomial = (0, 0, 0, 0)
Row = tuple[Surd, ...]
"""Coefficients in t, of formal degree."""
Pairs = tuple[Row, Row, Fraction]
"""Two forms in t, and a factor of their resultant that was left out."""


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


class EventLine:
    """A value n/d of v = tan θ, and the forms in t there."""

    def __init__(self, surface: Surface, n: int, d: int) -> None:
        self.surface, self.ring, self._n, self._d = surface, surface.ring, n, d
        self._square = n * n + d * d

    def form(self, p: Trig, alpha: int, theta: int) -> Row:
        """A polynomial of these degrees in α and θ, which has one parity in θ, as one in t."""
        spend(5 * len(p))

        def weight(cos: int, sin: int) -> int:
            rest, odd = divmod(theta - cos - sin, 2)
            if odd or rest < 0:
                raise ArithmeticError("a form in the direction of the leg is not homogeneous")
            return self._square**rest * self._d**cos * self._n**sin  # type: ignore[no-any-return]

        return in_half_tangent(p, alpha, weight)

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

    def pair(self, system: EventSystem) -> Pairs:
        """(C, W), (M1, M2) or (C, K).

        Raises:
            ZeroDivisionError: a divisor vanishes on this line.
        """
        if system.is_critical:
            return self._critical()
        c, first = _quotient(self.ring, self._coalescing, self._slopes[0])
        if system.kinds == ("limit",):
            k = self._at_limit(system)
            return c, k, first ** (len(k) - 1)
        w, second = self._along_kernel, Fraction(1)
        # the terms of v·∇E are of degree 9 in α, their sum of degree 8
        for divisor in (rational([1, 0, 1]), self._slopes[0], self._slopes[0], self.singular[0]):
            w, factor = _quotient(self.ring, w, divisor)
            second *= factor
        return c, w, first ** (len(w) - 1) * second ** (len(c) - 1)

    def _critical(self) -> Pairs:
        j0, j1 = self.singular
        rows = []
        for theta in (False, True):
            d0, d1 = (derivative(p, theta=theta) for p in self.surface.singular)
            slopes = self.form(d0, 2, 1), self.form(d1, 1, 2)
            rows.append(_sum(_times(self.ring, j0, slopes[1]), _times(self.ring, j1, slopes[0]), -1))
        return rows[0], rows[1], Fraction(1)

    def clear(self, system: EventSystem) -> bool:
        """Whether no pose of this line is an event: the pair has no common root where L > 0 is possible.

        Where J1 = 0 a pose is permanent, where J0 = 0 the length is 0; where φ = 0 ≠ J1, leg f is closed.
        """
        ring, factors = self.ring, [*self.singular]
        if system.is_critical:
            p, q, _ = self._critical()
        else:
            p = self._coalescing
            q = self._at_limit(system) if system.kinds == ("limit",) else self._along_kernel
            factors.append(self._slopes[0])
        if not all(map(any, factors)):
            return True
        if p[-1] == q[-1] == ZERO and ZERO not in [factor[-1] for factor in factors]:
            return False
        common = ring.gcd(trimmed(p), trimmed(q))
        for factor in factors:
            while len(shared := ring.gcd(common, trimmed(factor))) > 1:
                common = ring.field_quotient(common, shared)
        once = ring.field_quotient(common, ring.gcd(common, slope_of(common))) if len(common) > 2 else common
        return len(once) == 1 or (len(once) > 1 and not real_roots(ring, once))

    def value(self, system: EventSystem) -> tuple[Fraction, Fraction]:
        """The eliminant of a system at this line, where d = 1, but for a factor that is that of all lines.

        Raises:
            ZeroDivisionError: a known factor vanishes.
        """
        p, q, factor = self.pair(system)
        ring, (parallel, permanent, circular) = self.ring, system.powers
        above = ring.times(ring.resultant(p, q), ring.power(ring.resultant(*self._slopes), parallel))
        below = ring.power(ring.resultant(*self.singular), permanent)
        a, b = ring.times(above, (below[0], -below[1]))
        norm = below[0] ** 2 - ring.radicand * below[1] ** 2
        scale = factor / (norm * self._square**circular)
        return a * scale, b * scale

    def angles(self, bits: int) -> Iterator[Interval]:
        """θ in radians, in either sense."""
        cos, sin = (Interval.of(x, bits) for x in (self._d, self._n))
        size = Interval.of(self._square, bits).root()
        for sign in (1, -1):
            yield angle_of((cos.scaled(sign).over(size), sin.scaled(sign).over(size)))

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
        minus = tuple((-a, -b) for a, b in j0)
        for k, degree in enumerate(degrees):
            term = self.form(graded[k] if k < len(graded) else {}, *degree)
            for factor in [minus] * k + [j1] * (len(degrees) - 1 - k):
                term = _times(self.ring, term, factor)
            total = _sum(term, total, 1)
        return total


def _times(ring: Ring, p: Row, q: Row) -> Row:
    product = ring.product(p, q)
    return product + (ZERO,) * (len(p) + len(q) - 1 - len(product))


def _sum(p: Row, q: Row, sign: int) -> Row:
    q = q + (ZERO,) * (len(p) - len(q))
    return tuple((a + sign * c, b + sign * d) for (a, b), (c, d) in zip(p, q, strict=True))


def _quotient(ring: Ring, p: Row, q: Row) -> tuple[Row, Fraction]:
    """The exact quotient, of the formal degree that is the difference of both, and its factor.

    Raises:
        ZeroDivisionError: the divisor vanishes.
        Indivisible: there is a remainder.
    """
    size, q = len(p) - len(q) + 1, trimmed(q)
    if not q:
        raise ZeroDivisionError("a divisor vanishes on a line")
    c, d = q[-1]
    conjugate: Surd = (c, -d) if d else ONE
    integral = tuple(ring.times(x, conjugate) for x in q)
    scale = integral[-1][0] ** max(len(p) - len(q) + 1, 1)
    short = ring.quotient(trimmed([(a * scale, b * scale) for a, b in p]), integral)
    result = [ring.times(x, conjugate) for x in short]
    divisor = content(result)
    row = tuple((a // divisor, b // divisor) for a, b in result)
    return row + (ZERO,) * (size - len(row)), Fraction(divisor, scale)


def less(squared: Graded, square: Fraction) -> Graded:
    """A multiple of a squared length less a number."""
    n, d = square.as_integer_ratio()
    rows = [multiple(row, d) for row in squared]
    a, b = rows[0].get(_ONE, ZERO)
    return ({**rows[0], _ONE: (a - n, b)}, *rows[1:])


def event_eliminant(surface: Surface, system: EventSystem) -> EventEliminant:
    """An eliminant, interpolated; all 0 if it vanishes, or known factors vanish everywhere."""
    degree, points, values = system.degree, [], []
    for k in range(_MOST_POINTS):
        v = (k + 1) // 2 * (1 if k % 2 else -1)
        try:
            values.append(EventLine(surface, v, 1).value(system))
        except ZeroDivisionError:
            continue
        except Indivisible:  # which no theorem excludes where permanent poses are not isolated
            break
        points.append(v)
        if len(points) > degree:
            break
    if len(points) <= degree:
        return EventEliminant(system, surface.ring, (ZERO,) * (degree + 1))
    short = interpolated(points, values)
    return EventEliminant(system, surface.ring, short + (ZERO,) * (degree + 1 - len(short)))
