"""Certified real roots of polynomials over ℤ[ω], to any accuracy.

A root is proved real if its isolating disc, reflected in the real axis, meets the disc of no other root: then
the root is its own conjugate (mathematics.md#real-roots). The precision doubles until every root is decided.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count, pairwise

from flint import acb_poly, arb, arb_poly, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.precision import GREATEST_BITS, decided, precisions
from rpr_solver.exact.quadratic import QuadraticPoly, changes_at, changes_between, sturm_chain

_NEWTON_STEPS = 64
_FIRST_BITS = 192
_SPARE_BITS = 64
"""Precision of a Newton step beyond the bits that it is to find."""
_BISECTION_BITS = 768
_FIRST_LEAP = 4
"""By how many bits an interval is first narrowed at once."""
_SHARPENINGS = 16
_CUTS = 4
"""How many times an interval is cut between two trials of a Newton step, which cost as much."""
_UNEQUAL = 3
"""Bits by which the ends of an interval differ that is cut by size."""
_STURM_BITS = (256, 512, 1024, 2048, 4096, 8192, 16384)
_SWIFT_BITS = 64
"""By this many bits FLINT's iteration has converged, or Sturm's theorem is faster."""


def ball_of(x: Fraction) -> arb:
    """A rational number as a ball at the working precision."""
    return arb(x.numerator) / x.denominator


def fraction_of(x: arb) -> Fraction:
    """The middle of a ball."""
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


@dataclass(frozen=True)
class RealRoot:
    """One simple real root: the polynomial, and a ball that contains this root and no other."""

    polynomial: QuadraticPoly
    ball: arb

    def refined(self, bits: int) -> arb:
        """A ball round the root with ``bits`` correct bits, by interval Newton steps; a root 0 is exact.

        Raises:
            Unproved: the accuracy cannot be reached within the precision limit.
        """
        if not (self.polynomial.a[0] or self.polynomial.b[0]) and self.ball.contains(0):
            return arb(0)
        # from low precision up, where FLINT evaluates wide balls by a tighter scheme
        x, last = self.ball, bits + _SPARE_BITS
        for work in precisions(min(_FIRST_BITS, last), GREATEST_BITS, stop_at=last):
            polynomial, goal = self.polynomial.ball(work), min(bits, work - _SPARE_BITS)
            with ctx.workprec(work):
                slope = polynomial.derivative()
                for _ in range(_NEWTON_STEPS):
                    mid = x.mid()
                    value = polynomial(mid)
                    y = mid - value / slope(x)
                    if y.is_finite() and y.rel_accuracy_bits() >= goal:
                        if goal == bits:
                            return y
                        x = y
                        break
                    if not (y.is_finite() and 2 * y.rad() < x.rad()):
                        # the slope varies too much across the ball, as in a cluster of roots: bisect
                        half = _half(x, value, slope(x))
                        if half is None:
                            break
                        y = half
                    x = y
        raise Unproved(f"a root could not be refined to {bits} bits")


def _half(x: arb, value: arb, slope: arb) -> arb | None:
    """The half of x that holds the root, from the value at its middle and a slope without zero."""
    if value.contains(0) or slope.contains(0):
        return None
    # the ball of a product may hold 0 where its factors do not
    return x.mid().union(x.lower() if (value > 0) == (slope > 0) else x.upper())


def real_roots(polynomial: QuadraticPoly) -> list[RealRoot]:
    """All real roots of a squarefree polynomial, ascending, each with its isolating ball.

    The leading coefficient must not be zero.

    Raises:
        Unproved: the roots cannot be separated within the precision limit.
    """
    if polynomial.degree < 1:
        return []

    def isolated(bits: int) -> list[RealRoot] | None:
        # FLINT's iteration misses some clusters far from the unit circle; Descartes' rule does not
        if bits >= _BISECTION_BITS and (intervals := bisected(polynomial.ball(bits), bits)) is not None:
            return [RealRoot(polynomial, x) for x in intervals]
        # FLINT's first discs are cheap and often good enough
        for tolerance_bits in (0, bits // 4) if bits == _FIRST_BITS else (bits // 4,):
            roots = _isolate(polynomial, bits, tolerance_bits)
            if roots is not None:
                return roots
        return None

    message = "two roots of the eliminant could not be told apart; it should have been squarefree"
    return decided(isolated, _FIRST_BITS, GREATEST_BITS, message)


def number_of_real_roots(polynomial: QuadraticPoly) -> int:
    """How many real roots a squarefree polynomial has, in a fraction of the time that it takes to find them.

    The leading coefficient must not be zero. By Sturm's theorem if degrees fall by one in his sequence; else
    the roots are isolated.

    Raises:
        Unproved: the roots cannot be separated within the precision limit.
    """
    if polynomial.degree < 1:
        return 0
    for bits in _STURM_BITS:
        if (found := count_of_real_roots(polynomial.ball(bits), bits)) is not None:
            return found
    return len(real_roots(polynomial))


def count_of_real_roots(polynomial: arb_poly, bits: int) -> int | None:
    """How many real roots a polynomial has, by Sturm's theorem at this precision; None if that stays open.

    It stays open if the polynomial may not be squarefree, or a degree falls by several.
    """
    degree = polynomial.degree()
    with ctx.workprec(bits):
        first, second, leads = polynomial, polynomial.derivative(), [polynomial[degree]]
        for k in range(degree - 1, -1, -1):
            leads.append(second[k])
            if second[k].contains(0):
                return None
            first, second = second, -(first % second)
        changes = changes_between(leads)
    return None if changes is None else degree - 2 * changes


def separated_roots(polynomial: QuadraticPoly) -> list[RealRoot]:
    """As :func:`real_roots`, but faster where roots are of very unequal size or near each other.

    The balls are others, and what documents print of a pose may depend on them: this is for counts.

    Raises:
        Unproved: the roots cannot be separated within the precision limit.
    """
    if polynomial.degree < 1:
        return []
    if (roots := _isolate(polynomial, _FIRST_BITS, 0, _SWIFT_BITS)) is not None:
        return roots
    for bits in _STURM_BITS:
        if (intervals := separated(polynomial.ball(bits), bits)) is not None:
            return [RealRoot(polynomial, x) for x in intervals]
    return real_roots(polynomial)


def roots_below(polynomial: arb_poly, points: Sequence[Fraction | None], bits: int) -> list[int] | None:
    """How many real roots a polynomial has below each point, where None is ∞; None if that stays open.

    By Sturm's theorem, from the remainders of p and p′ at this precision (mathematics.md#real-roots). It
    stays open if a point may be a root, the polynomial may not be squarefree, or a degree falls by several.
    """
    with ctx.workprec(bits):
        if (chain := sturm_chain(polynomial)) is None:
            return None
        found = [changes_at(chain, None if x is None else ball_of(x)) for x in points]
        above = changes_at(chain, None) or 0
    # at −∞ there is a change where there is none at ∞
    below = [polynomial.degree() - above - changes for changes in found if changes is not None]
    return below if len(below) == len(points) else None


def separated(polynomial: arb_poly, bits: int) -> list[arb] | None:
    """Isolating intervals of all real roots, ascending; None if the precision is too low, or 0 is a root.

    Sturm's theorem with bisection: by size far from each other, and towards several roots by Newton steps.
    """
    with ctx.workprec(bits):
        chain, n = sturm_chain(polynomial), polynomial.degree()
        if chain is None or polynomial[0].contains(0):
            return None
        far, near = _edge(polynomial), 1 / _edge(arb_poly([polynomial[n - i] for i in range(n + 1)]))
        slope, intervals = chain[0][1], []
        sides = (-far, -near), (near, far)
        todo = [
            (*side, changes_at(chain, side[0]), changes_at(chain, side[1]), _FIRST_LEAP) for side in sides
        ]
        while todo:
            low, high, first, last, leap = todo.pop()
            cut = _cut_by_size(low, high, bits)
            if first is None or last is None or not low < cut < high:
                return None
            if first - last == 1:
                x = _bracketed(polynomial, slope, low, high, 2 * bits, _cut_by_size)
                if x is None:
                    return None
                intervals.append(x)
            elif first > last:
                ends = _nearer(polynomial, slope, (low, cut, high), first - last, leap)
                if ends and [changes_at(chain, end) for end in ends] == [first, last]:
                    todo.append((*ends, first, last, 2 * leap))
                else:
                    between, leap = changes_at(chain, cut), max(leap // 2, _FIRST_LEAP)
                    todo += [(low, cut, first, between, leap), (cut, high, between, last, leap)]
        return sorted(intervals, key=lambda x: x.mid())


def _edge(polynomial: arb_poly) -> arb:
    """A power of two beyond all roots; the leading coefficient must not be 0."""
    n = polynomial.degree()
    bound = max((abs(polynomial[i] / polynomial[n]).upper() for i in range(n)), default=arb(0)) + 1
    return next(edge for edge in map(arb(2).__pow__, count(1)) if edge > bound)


def _cut_by_size(low: arb, high: arb, bits: int) -> arb:
    """As :func:`_cut` for numbers of one sign, but between them in size if their sizes are unequal."""
    if high < 0:
        return -_cut_by_size(-high, -low, bits)
    (least, above), (most, over) = low.man_exp(), high.man_exp()
    sizes = int(above) + int(least).bit_length(), int(over) + int(most).bit_length()
    if sizes[1] - sizes[0] < _UNEQUAL:
        return _cut(low, high, bits)
    return _cut(arb(0), arb(2) ** (sum(sizes) // 2 + 1), bits)


def bisected(polynomial: arb_poly, bits: int) -> list[arb] | None:
    """Isolating intervals of all real roots, ascending; None if the precision is insufficient.

    Descartes' rule of signs with bisection: if the coefficients transformed to an interval have no sign
    change, it has no root; if they have one, it has exactly one, and a Newton step contracts the interval.
    Roots that are near each other are approached by Newton steps for a multiple root.
    """
    with ctx.workprec(bits):
        if polynomial[polynomial.degree()].contains(0):
            return None
        edge = _edge(polynomial)
        exponent = int(edge.man_exp()[1])
        slope, intervals = polynomial.derivative(), []
        todo = [(-edge, edge, _sign_changes(polynomial, -edge, edge), 0, _FIRST_LEAP)]
        while todo:
            low, high, changes, depth, leap = todo.pop()
            if changes is None or depth > bits + exponent:
                return None
            if changes == 1:
                x = _bracketed(polynomial, slope, low, high, bits + exponent - depth)
                if x is None:
                    return None
                intervals.append(x)
            elif changes and (near := _near_all(polynomial, slope, low, high, changes, leap)):
                todo.append((*near, changes, depth + leap, 2 * leap))
            elif changes:
                leap = max(leap // 2, _FIRST_LEAP)
                parts = _parts(polynomial, slope, low, high, changes)
                todo += [(*part, depth + 1, leap) for part in parts]
        return sorted(intervals, key=lambda x: x.mid())


def _parts(
    polynomial: arb_poly, slope: arb_poly, low: arb, high: arb, changes: int
) -> list[tuple[arb, arb, int | None]]:
    """The two parts of an interval with their sign changes, first that to which a Newton step leads.

    The other one is left out if the first has all of them (see :func:`_near_all`).
    """
    cut = _cut(low, high, ctx.prec)
    parts = [(low, cut), (cut, high)]
    if polynomial(cut) * slope(cut) < 0:
        parts.reverse()
    first = _sign_changes(polynomial, *parts[0])
    if first == changes:
        return [(*parts[0], first)]
    return [(*parts[0], first), (*parts[1], _sign_changes(polynomial, *parts[1]))]


def _cut(low: arb, high: arb, bits: int) -> arb:
    """Not the middle, which is the likeliest point to be a root; another point at each precision."""
    return (low + (high - low) * (450 + bits * 7919 % 127) / 1024).mid()


def _near_all(
    polynomial: arb_poly, slope: arb_poly, low: arb, high: arb, changes: int, leap: int
) -> tuple[arb, arb] | None:
    """An interval 2^leap times as narrow with as many sign changes, so with all roots; None if none is found.

    The sign changes on the parts of an interval are together at most those on the whole (Schoenberg 1930).
    """
    ends = _nearer(polynomial, slope, (low, _cut(low, high, ctx.prec), high), changes, leap)
    return ends if ends and _sign_changes(polynomial, *ends) == changes else None


def _nearer(
    polynomial: arb_poly, slope: arb_poly, points: tuple[arb, arb, arb], roots: int, leap: int
) -> tuple[arb, arb] | None:
    """The interval, 2^leap times as narrow, to which a Newton step for this many roots at once leads."""
    low, start, high = points
    steep = slope(start)
    if steep.contains(0):
        return None
    centre, reach = (start - roots * polynomial(start) / steep).mid(), (high - low) / 2 ** (leap + 1)
    first, last = (centre - reach).mid(), (centre + reach).mid()
    return (first, last) if low < first and last < high else None


def _bracketed(
    polynomial: arb_poly, slope: arb_poly, low: arb, high: arb, times: int, cut_of: Callable[..., arb] = _cut
) -> arb | None:
    """A small ball of the only root between two points, which is simple; None if a sign is not certain.

    The sign at a point decides on which side the root is, much faster than Descartes' rule.
    """
    above = polynomial(high) > 0
    for k in range(times):
        if not k % _CUTS:
            whole = low.union(high)
            x = _sharpened(polynomial, slope, whole)
            if x is not None and whole.contains(x):
                return x
        cut = cut_of(low, high, ctx.prec)
        value = polynomial(cut)
        if value.contains(0):
            return None
        low, high = (low, cut) if (value > 0) == above else (cut, high)
    return None


def _sign_changes(polynomial: arb_poly, low: arb, high: arb) -> int | None:
    """The sign changes of (1+x)ⁿ p((low + high x)/(1+x)), or None if a sign is not certain."""
    onto = polynomial(arb_poly([low, high - low]))
    n = polynomial.degree()
    coefficients = arb_poly([onto[n - i] for i in range(n + 1)])(arb_poly([1, 1]))
    signs = []
    for i in range(n + 1):
        c = coefficients[i]
        at_an_end = i in (0, n)
        if c.contains(0) and (at_an_end or not c.is_zero()):
            return None
        signs += [bool(c > 0)] if not c.is_zero() else []
    return sum(a != b for a, b in pairwise(signs))


def _sharpened(polynomial: arb_poly, slope: arb_poly, x: arb) -> arb | None:
    """A smaller ball round the root in x, on which direct evaluation of the slope excludes zero.

    The polynomial is expanded about the middle of x, where its slope on x has a much tighter enclosure.
    """
    shifted = polynomial(arb_poly([x.mid(), 1]))
    for _ in range(_SHARPENINGS):
        step = shifted[0] / shifted.derivative()(arb(0, x.rad()))
        y = x.mid() - step
        if not (y.is_finite() and 2 * y.rad() < x.rad()):
            return None
        if not slope(y).contains(0):
            return y
        x = y
        shifted = polynomial(arb_poly([x.mid(), 1]))
    return None


def _isolate(
    polynomial: QuadraticPoly, bits: int, tolerance_bits: int, most: int | None = None
) -> list[RealRoot] | None:
    """The real roots, or None if this precision is insufficient, or FLINT's iteration needs ``most`` bits."""
    ball = polynomial.ball(bits)
    with ctx.workprec(bits):
        try:
            tolerance = arb(2) ** -tolerance_bits if tolerance_bits else None
            roots = acb_poly(ball).roots(tol=tolerance, maxprec=most or bits)
        except ValueError:
            return None
        slope = ball.derivative()
        real = []
        for i, root in enumerate(roots):
            if not root.imag.contains(0):
                continue
            mirror = root.conjugate()
            if any(mirror.overlaps(other) for j, other in enumerate(roots) if j != i):
                return None
            x = root.real if not slope(root.real).contains(0) else _sharpened(ball, slope, root.real)
            if x is None:
                return None
            real.append(RealRoot(polynomial, x))
        return sorted(real, key=lambda r: r.ball.mid())
