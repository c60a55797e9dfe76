"""The resultant of J and E in tan(α/2), divided exactly by its spurious factors, and its lines.

A *line* is a value of u = tan(θ/2). Every pose in which three or more poses coalesce has J = E = 0, so it
lies on a line where the resultant vanishes, and the order of the resultant there is at least the number of
these poses. Above a simple root of Q is exactly one; on other lines α is cut into pieces until J, or E along
either leg, excludes 0 on each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import count, islice

from rpr_solver.verify.core.intervals import Interval, cos_sin, ends_of, pi
from rpr_solver.verify.core.krawczyk import Directions, Pair, direction, meet
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, real_roots, refined, simple_and_apart
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Indivisible,
    Poly,
    Ring,
    Surd,
    interpolated,
    primitive,
    radical,
    rational,
    without,
)
from rpr_solver.verify.core.system import System, Trig, at_half_tangent, derivative, longest

DEGREE = 24
_SAMPLES = 6
_LINE_BITS, _LEAST_APART = 128, 32
_PIECES, _DEPTH = 48, 40
NEARBY = 20
"""Poses are cut out with 2^−20 radians on either side."""


@dataclass(frozen=True)
class _Cut:
    """How often J and E are divided by t = tan(α/2), by 1/t, and by u² + 1, which has no real line.

    J is divided by every power of what both share, E by as many as J at most.
    """

    at_zero: tuple[int, int] = (0, 0)
    at_infinity: tuple[int, int] = (0, 0)
    circular: tuple[int, int] = (0, 0)

    @classmethod
    def of(cls, system: System) -> _Cut:
        # polynomials of degree 6 in u at most, so 13 values of u decide
        samples = range(-_SAMPLES, _SAMPLES + 1)
        counts = []
        for p, degree in ((system.singular, 2), (system.legs[0].kernel, 3)):
            rows = [at_half_tangent(p, degree, u) for u in samples]
            zeros = [min(map(_leading_zeros, part)) for part in (rows, [row[::-1] for row in rows])]
            columns = [interpolated(samples, column) for column in zip(*rows, strict=True)]
            circular = min((_circular(system.ring, column) for column in columns if column), default=0)
            counts.append((*zeros, circular))
        return cls(*((j, min(j, e)) if e else (0, 0) for j, e in zip(*counts, strict=True)))

    @property
    def curves(self) -> list[str]:
        """The shared curves, as documents write them."""
        names = ("alpha = 0 deg", self.at_zero), ("alpha = 180 deg", self.at_infinity)
        return [name for name, orders in names if any(orders)]

    def applied(self, row: tuple[Surd, ...], which: int, u: int) -> tuple[Surd, ...]:
        """The coefficients in t of J (0) or E (1) without what they share, at a value of u."""
        divisor = (u * u + 1) ** self.circular[which]
        short = row[self.at_zero[which] : len(row) - self.at_infinity[which]]
        return tuple((a // divisor, b // divisor) for a, b in short)


def _leading_zeros(row: Sequence[Surd]) -> int:
    return next((k for k, x in enumerate(row) if x != ZERO), len(row))


def _circular(ring: Ring, p: Poly) -> int:
    """How often u² + 1 divides a polynomial that is not 0."""
    order, circle = 0, rational([1, 0, 1])
    with suppress(Indivisible):
        while True:
            p, order = ring.quotient(p, circle), order + 1
    return order


def _values(system: System, cut: _Cut) -> Iterator[tuple[int, Surd]]:
    """The resultant of J and E in t, at u = 0, 1, −1, 2, …"""
    for k in count():
        u = (k + 1) // 2 * (1 if k % 2 else -1)
        j, e = (
            cut.applied(at_half_tangent(p, degree, u), which, u)
            for which, (p, degree) in enumerate(((system.singular, 2), (system.legs[0].kernel, 3)))
        )
        yield u, system.ring.resultant(j, e)


def _whole(system: System, cut: _Cut) -> Poly:
    """The resultant of the quotients of J and E by the shared curves."""
    points, values = zip(*islice(_values(system, cut), 2 * DEGREE + 1), strict=True)
    return interpolated(points, values)


def _quotient(system: System) -> Poly:
    """The resultant of J and E divided by its spurious factors, in each of its values.

    Raises:
        Indivisible: they do not divide it.
    """
    w, q = primitive(system.along), primitive(system.closed)
    points: list[int] = []
    values: list[Surd] = []
    for u, value in _values(system, _Cut()):
        first, second = (system.ring.at(p, Fraction(u))[0] for p in (w, q))
        if not first or not second:
            continue
        points.append(u)
        values.append(system.ring.over(value, (first**2 * second * (u * u + 1) ** 9, 0)))
        if len(points) > DEGREE:
            break
    return interpolated(points, values)


@dataclass(frozen=True)
class Eliminant:
    """Q, a form of degree 24 in u, and the two spurious quadratics; Res_t(J, E) = w² (u²+1)⁹ q Q.

    ``form`` is empty if the resultant vanishes identically. Then J and E share the curves of ``cut``, and
    ``rest`` is the resultant of their quotients by what they share, not divided by anything.
    """

    ring: Ring
    form: tuple[Surd, ...]
    along: Poly
    closed: Poly
    cut: _Cut = field(default_factory=lambda: _Cut())
    rest: Poly = ()

    @classmethod
    def of(cls, system: System) -> Eliminant:
        """Eliminates α.

        Raises:
            Indivisible: the spurious factors do not divide the resultant.
        """
        ring, w, q = system.ring, system.along, system.closed
        if not (short := _quotient(system)):
            cut = _Cut.of(system)
            return cls(ring, (), w, q, cut, _whole(system, cut) if cut.curves else ())
        return cls(ring, short + (ZERO,) * (DEGREE + 1 - len(short)), w, q)

    @cached_property
    def finite(self) -> Poly:
        """Q without its roots at u = ∞."""
        return primitive(self.form)

    @property
    def at_infinity(self) -> int:
        """The multiplicity of the root u = ∞."""
        return len(self.form) - len(self.finite)

    @cached_property
    def generic(self) -> bool:
        """Whether a prime proves that all 24 roots are finite, simple and apart from the spurious ones.

        And whether these are different: then all cusps are above roots of Q (mathematics.md#simple-roots).
        """
        if not self.form or self.at_infinity:
            return False
        ring, (w, q) = self.ring, (p + (ZERO,) * (3 - len(p)) for p in (self.along, self.closed))
        spurious = ring.product(self.along, self.closed)
        return ring.resultant(w, q) != ZERO and simple_and_apart(ring, self.finite, spurious)

    @cached_property
    def parts(self) -> dict[int, Poly]:
        """Multiplicity → the product of the finite factors of Q with it."""
        if not self.form:
            return {}
        return {1: self.finite} if self.generic else self.ring.squarefree_parts(self.finite)

    @cached_property
    def factors(self) -> dict[int, Poly]:
        """The finite factors of Q, or of the rest if Q is 0, by their multiplicity."""
        return self.parts if self.form else self.ring.squarefree_parts(primitive(self.rest))

    @property
    def shape(self) -> dict[int, int]:
        """Multiplicity → total degree of these factors, and of Q at infinity."""
        shape = {multiplicity: len(part) - 1 for multiplicity, part in self.factors.items()}
        if self.at_infinity:
            shape[self.at_infinity] = shape.get(self.at_infinity, 0) + 1
        return shape

    @cached_property
    def single(self) -> Poly:
        """The product of the simple factors that share no root with the spurious ones."""
        simple = self.parts.get(1, (ONE,))
        if self.generic:
            return simple
        for factor in (self.along, self.closed):
            simple = without(self.ring, simple, factor)
        return simple

    @cached_property
    def single_roots(self) -> list[Root]:
        """The real lines on which exactly one pose has J = E = 0, and this pose is a cusp."""
        return real_roots(self.ring, self.single)

    @cached_property
    def finite_real_roots(self) -> int:
        """The number of different finite real roots of these factors."""
        return sum(len(real_roots(self.ring, part)) for part in self.factors.values())

    @cached_property
    def special(self) -> Poly:
        """A squarefree polynomial of all other finite lines: multiple roots of Q, and spurious ones."""
        ring = self.ring
        if self.generic:
            return (ONE,)
        whole = ring.product(primitive(self.along), primitive(self.closed))
        if not self.form:
            whole = ring.product(whole, self.rest)
        for multiplicity, part in self.parts.items():
            rest = ring.field_quotient(part, self.single) if multiplicity == 1 else part
            whole = ring.product(whole, rest)
        return radical(ring, whole)

    @cached_property
    def special_roots(self) -> list[Root]:
        """The finite lines that may hold several poses with J = E = 0, or spurious ones."""
        return real_roots(self.ring, self.special) if len(self.special) > 1 else []

    @property
    def special_at_infinity(self) -> bool:
        """Whether the line u = ∞, where θ = 180°, is one of them."""
        spurious = len(self.along) < 3 or len(self.closed) < 3
        return not self.generic and (spurious or not self.form or bool(self.at_infinity))


def opposite(bits: int) -> Pair:
    """The line θ = 180°."""
    return Interval.of(-1, bits), Interval.of(0, bits)


def separation(eliminant: Eliminant) -> int:
    """Bits at which the directions of all real lines are told apart."""
    bits, ring = _LEAST_APART, eliminant.ring
    forms = ((eliminant.single, eliminant.single_roots), (eliminant.special, eliminant.special_roots))
    roots = [(form, root) for form, roots in forms for root in roots]
    while True:
        roots = [(form, refined(ring, form, root, Fraction(1, 1 << bits))) for form, root in roots]
        lines = [direction(ring, form, root, bits) for form, root in roots]
        if eliminant.special_at_infinity:
            lines.append(opposite(bits))
        if not any(meet(x, y) for n, x in enumerate(lines) for y in lines[:n]):
            return bits
        bits *= 2


def special_lines(system: System, eliminant: Eliminant, apart: int) -> Iterator[Pair]:
    """The real lines that may hold several poses with J = E = 0, or spurious ones.

    Args:
        system: the slice.
        eliminant: its lines.
        apart: bits to which they are needed besides.
    """
    bits = _LINE_BITS + longest(system.singular, *(leg.kernel for leg in system.legs)) + 2 * apart
    for root in eliminant.special_roots:
        yield direction(system.ring, eliminant.special, root, bits)
    if eliminant.special_at_infinity:
        yield opposite(bits)


@dataclass(frozen=True)
class _OnLine:
    """A trigonometric polynomial in α alone, with its derivative."""

    value: dict[tuple[int, int], Interval]
    slope: dict[tuple[int, int], Interval]

    @classmethod
    def of(cls, p: Trig, line: Pair, radicand: int) -> _OnLine:
        return cls(*(_collapsed(q, line, radicand) for q in (p, derivative(p, theta=False))))

    def excludes_zero(self, pair: Pair, middle: Pair, radius: Interval) -> bool:
        """Whether it has no zero for any α of an interval, by the mean value theorem if not at once."""
        if _sum(self.value, pair).sign:
            return True
        return bool((_sum(self.value, middle) + _sum(self.slope, pair) * radius).sign)


def unlisted(system: System, line: Pair, listed: Sequence[Interval], apart: int) -> Fraction | None:
    """An α in radians near which a pose with J = E = 0 cannot be excluded on a line; None if there is none.

    Args:
        system: the slice.
        line: cosine and sine of θ.
        listed: intervals of α, in radians, that are left out.
        apart: the line is known to so many bits besides, and as many more cuts are made.
    """
    bits, functions = line[0].bits, (system.singular, *(leg.kernel for leg in system.legs))
    on_line = [_OnLine.of(p, line, system.ring.radicand) for p in functions]
    half = pi(bits).upper
    step = -(-2 * half // _PIECES)
    todo = [(-half + k * step, -half + (k + 1) * step, 0) for k in range(_PIECES)]
    holes = [hole for x in listed for hole in _turned(x, bits)]
    while todo:
        lower, upper, depth = todo.pop()
        if any(a <= lower and upper <= b for a, b in holes):
            continue
        alpha = Interval(lower, upper, bits)
        middle = (lower + upper) // 2
        pair, at_middle = cos_sin(alpha), cos_sin(Interval(middle, middle, bits))
        radius = Interval(lower - middle, upper - middle, bits)
        if any(f.excludes_zero(pair, at_middle, radius) for f in on_line):
            continue
        if depth == _DEPTH + apart:
            return alpha.middle
        todo += [(lower, middle, depth + 1), (middle, upper, depth + 1)]
    return None


def _turned(x: Interval, bits: int) -> list[tuple[int, int]]:
    """An interval of α, and the same a turn away, in units of 2^−bits."""
    turn = 2 * pi(bits).lower
    low, high = (Interval.of(end, bits) for end in ends_of(x))
    # rounded inwards, and 2π being known to two units only
    return [(low.upper + k * turn + 4, high.lower + k * turn - 4) for k in (-1, 0, 1)]


def nearby(x: Interval) -> Interval:
    """All angles within 2^−20 radians of an interval."""
    return Interval.of(x.middle, x.bits, x.radius + Fraction(1, 1 << NEARBY))


def _collapsed(p: Trig, line: Pair, radicand: int) -> dict[tuple[int, int], Interval]:
    bits = line[0].bits
    one = Interval.of(1, bits)
    at = Directions((one, one), line, radicand)
    rows: dict[tuple[int, int], dict[tuple[int, int, int, int], tuple[int, int]]] = {}
    for (i, j, k, m), x in p.items():
        rows.setdefault((i, j), {})[0, 0, k, m] = x
    return {key: at.value(row) for key, row in rows.items()}


def _sum(coefficients: dict[tuple[int, int], Interval], alpha: Pair) -> Interval:
    cos, sin = alpha
    spend(8 * len(coefficients), cos.bits)
    total = Interval(0, 0, cos.bits)
    powers = [Interval.of(1, cos.bits)]
    for (i, j), x in coefficients.items():
        while len(powers) <= i:
            powers.append(powers[-1] * cos)
        term = x * powers[i]
        total += term * sin if j else term
    return total
