"""J = 0 of a slice as a form in two half tangents, and the lines on which its arcs meet.

In a *chart*, whose angles are turned by rational half tangents, J is a form of degree 4 in t = tan(α′/2), and
its coefficients are forms of degree 4 in u = tan(θ′/2). The *lines* are the real roots u of the discriminant,
on which two arcs meet, and of the leading coefficient, on which one arc passes t = ∞. None of them is u = ∞.
Each is read on itself; where the root is simple, J = 0 is smooth (mathematics.md#the-sweep).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Pair
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
    plus,
    primitive,
    rational,
    size_of,
)
from rpr_solver.verify.core.system import System, half_angle_form

_DEGREE = 4
_DISCRIMINANT = 24
TURNS = (((11, 37), (17, 31)), ((2, 7), (2, 5)), ((5, 6), (3, 8)), ((3, 7), (4, 9)), ((5, 11), (7, 12)))
"""Sine and cosine, up to a factor, of half the angles by which the charts that are tried are turned."""
_APART, _TRIES = 48, 6
FAR = 1 << 4096
"""More than all half tangents that are told from ∞."""
UNDECIDED = "intervals do not tell which arcs of the singular curve meet"


@dataclass(frozen=True)
class Chart:
    """J as a form in t and u: ``rows[k]`` is the coefficient of tᵏ, a form in u, up to a positive factor.

    The angles are those of the chart and twice those with the tangents ``alpha`` and ``theta``, quotients.
    """

    ring: Ring
    alpha: tuple[int, int]
    theta: tuple[int, int]
    rows: tuple[tuple[Surd, ...], ...]

    @classmethod
    def of(cls, system: System, alpha: tuple[int, int], theta: tuple[int, int]) -> Chart:
        """The chart of a slice that is turned so far."""
        rows = [[ZERO] * (_DEGREE + 1) for _ in range(_DEGREE + 1)]
        forms = [_turned(turn) for turn in (alpha, theta)]
        for (i, j, k, m), (a, b) in system.singular.items():
            spend(80, 32 + a.bit_length() + b.bit_length())
            first, second = (_in_chart(form, *key) for form, key in zip(forms, ((i, j), (k, m)), strict=True))
            for p, x in enumerate(first):
                for q, y in enumerate(second):
                    rows[p][q] = (rows[p][q][0] + a * x * y, rows[p][q][1] + b * x * y)
        return cls(system.ring, alpha, theta, tuple(map(tuple, rows)))

    @cached_property
    def discriminant(self) -> Poly:
        """The discriminant in t, without u² + 1; by its values at 25 integers."""
        points = range(-_DISCRIMINANT // 2, _DISCRIMINANT // 2 + 1)
        values = [
            _discriminant(self.ring, [self.ring.at(row, Fraction(u)) for row in self.rows]) for u in points
        ]
        return without_circle(self.ring, interpolated(points, values))

    @cached_property
    def lines(self) -> tuple[Poly, Poly] | None:
        """The squarefree form whose real roots are the lines, and one of those that are multiple.

        None if an arc passes t = ∞ on a line where arcs meet, or u = ∞ is a line.
        """
        ring, lead = self.ring, self.rows[-1]
        if lead[-1] == ZERO or not self.discriminant or len(self.discriminant) % 2 == 0:
            return None
        if simple_and_apart(ring, ring.product(self.discriminant, lead), (ONE,)):
            return ring.product(self.discriminant, lead), (ONE,)
        whole: Poly = lead
        multiple: Poly = (ONE,)
        for order, part in ring.squarefree_parts(primitive(self.discriminant)).items():
            whole = ring.product(whole, part)
            multiple = ring.product(multiple, part) if order > 1 else multiple
        return (whole, multiple) if simple_and_apart(ring, whole, (ONE,)) else None

    @property
    def is_whole(self) -> bool:
        """Whether u = ∞ is no root of the discriminant: its degree is then even, and that of the form."""
        top = [row[-1] for row in self.rows]
        return _discriminant(self.ring, top) != ZERO

    def above(self, u: Fraction) -> list[Surd]:
        """The form in t on one line, up to a positive factor."""
        return [self.ring.at(row, u) for row in self.rows]

    def count_below(self, t: Fraction, u: Fraction) -> int:
        """How many arcs have a smaller t at a point with J ≠ 0 that is on no line."""
        ring, form = self.ring, self.above(u)
        number = 0
        for root in real_roots(ring, form):
            width = Fraction(1, 1 << _APART)
            low, high = ends(root)
            while low < t < high:
                root = refined(ring, form, root, width)
                low, high = ends(root)
                width /= 1 << _APART
            number += high <= t
        return number

    def form_of(self, form: Poly) -> Poly:
        """A form of degree 2 in tan(θ/2), of integers, as one in u that has no more real roots."""
        (a, _), (b, _), (c, _) = form
        rows = (_in_chart(_turned(self.theta), *key) for key in ((0, 0), (1, 0), (0, 1)))
        return tuple(((a + c) * x + (a - c) * y + b * z, 0) for x, y, z in zip(*rows, strict=True))

    def values(self, x: Interval, *, inverted: bool) -> list[Interval]:
        """Its coefficients for all u, or 1/u, of an interval, up to a positive factor."""
        bits = x.bits
        spend(12 * len(self.rows), bits + size_of(self.rows[-1]))
        omega = Interval.of(self.ring.radicand, bits).root()
        result = []
        for row in self.rows:
            total = Interval(0, 0, bits)
            for a, b in row if inverted else reversed(row):
                term = Interval.of(a, bits) + omega.scaled(b) if b else Interval.of(a, bits)
                total = total * x + term
            result.append(total)
        return result

    def half_tangents(self, alpha: Pair, theta: Pair) -> tuple[Interval, Interval]:
        """t and u from the cosines and sines of α and θ.

        Raises:
            ZeroDivisionError: one of them may be ∞.
        """
        t, u = (_half_tangent(*pair) for pair in zip((alpha, theta), (self.alpha, self.theta), strict=True))
        return t, u


def _turned(half: tuple[int, int]) -> list[tuple[int, int]]:
    """Forms of degree 1 in the half tangent of a chart: sine and cosine of half the whole angle."""
    s, c = half
    return [(s, c), (c, -s)]


def _in_chart(half: list[tuple[int, int]], cos: int, sin: int) -> list[int]:
    """cosⁱ sinʲ of an angle as a form of degree 4 in the half tangent of a chart."""
    (s0, s1), (c0, c1) = half
    result = [0] * (_DEGREE + 1)
    for power, factor in enumerate(half_angle_form(cos, sin, _DEGREE // 2)):
        form = [factor]
        for a, b in [(s0, s1)] * power + [(c0, c1)] * (_DEGREE - power):
            form = [x * a + y * b for x, y in zip([*form, 0], [0, *form], strict=True)]
        result = [x + y for x, y in zip(result, form, strict=True)]
    return result


def _half_tangent(angle: Pair, half: tuple[int, int]) -> Interval:
    s, c = half
    p, q = c * c - s * s, 2 * s * c
    cos = angle[0].scaled(p) + angle[1].scaled(q)
    sin = angle[1].scaled(p) - angle[0].scaled(q)
    return sin.over(cos + Interval.of(s * s + c * c, cos.bits))


def whole_angle(x: Interval, half: tuple[int, int]) -> Pair:
    """Cosine and sine of a whole angle, from its half tangent in a chart."""
    s, c = half
    p, q, one = c * c - s * s, 2 * s * c, Interval.of(1, x.bits)
    norm, cos, sin = one + x * x, one - x * x, x.scaled(2)
    size = norm.scaled(s * s + c * c)
    return (cos.scaled(p) - sin.scaled(q)).over(size), (sin.scaled(p) + cos.scaled(q)).over(size)


def _discriminant(ring: Ring, c: Sequence[Surd]) -> Surd:
    """27 times the discriminant of a form of degree 4."""

    def product(factor: int, *terms: Surd) -> Surd:
        result = (factor, 0)
        for x in terms:
            result = ring.times(result, x)
        return result

    def total(terms: Iterable[Surd]) -> Surd:
        result = ZERO
        for x in terms:
            result = plus(result, x)
        return result

    spend(60, 2 * max(part.bit_length() for x in c for part in x))
    i = total([product(12, c[4], c[0]), product(-3, c[3], c[1]), product(1, c[2], c[2])])
    terms = [product(72, c[4], c[2], c[0]), product(9, c[3], c[2], c[1]), product(-27, c[4], c[1], c[1])]
    n = total([*terms, product(-27, c[3], c[3], c[0]), product(-2, c[2], c[2], c[2])])
    return plus(product(4, i, i, i), product(-1, n, n))


def without_circle(ring: Ring, form: Poly) -> Poly:
    """A form without all of its factors u² + 1."""
    try:
        while len(form) > 2:
            form = ring.quotient(form, rational([1, 0, 1]))
    except Indivisible:
        pass
    return form


def ends(root: Root) -> tuple[Fraction, Fraction]:
    """Ends of an interval of the root; where it is beyond all bounds, so wide that nothing is decided."""
    if not root.inverted:
        return root.lower, root.upper
    if root.lower < 0 < root.upper or (root.lower == root.upper == 0):
        raise OpenError(UNDECIDED)
    far = Fraction(FAR)
    if root.lower == 0:
        return 1 / root.upper, far
    return (-far, 1 / root.lower) if root.upper == 0 else (1 / root.upper, 1 / root.lower)


def short(x: Fraction, error: Fraction) -> Fraction:
    """A number with few digits within an error, > 0, of another."""
    unit = 1 << max((error.denominator // error.numerator).bit_length() + 1, 1) if error else x.denominator
    return Fraction(round(x * unit), unit)


def value_at(values: Sequence[Interval], t: Interval) -> Interval:
    """The values of a form at t."""
    total = Interval(0, 0, t.bits)
    for x in reversed(values):
        total = total * t + x
    return total


def ascending(ring: Ring, form: Poly) -> list[Root]:
    """The roots of a form, none of them ∞, in disjoint closed intervals by ascending u."""
    roots, width = real_roots(ring, form), Fraction(1, 1 << _APART)
    for _ in range(_TRIES):
        roots = [refined(ring, form, root, width) for root in roots]
        roots.sort(key=lambda root: ends(root)[0])
        if all(ends(x)[1] < ends(y)[0] for x, y in pairwise(roots)):
            return roots
        width = width**2
    raise OpenError(UNDECIDED)
