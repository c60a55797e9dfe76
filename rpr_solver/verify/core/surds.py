"""Exact numbers a + b ω with integers a, b and ω = √radicand, and polynomials of them in one variable.

A radicand of 1 stands for the rational integers: every b is 0. Otherwise ω is irrational, so ℤ[ω] is a
domain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm, prod

from rpr_solver.verify.core.reader import spend, spend_by_digits

Surd = tuple[int, int]
Poly = tuple[Surd, ...]
"""Coefficients from the constant one on; without leading zeros, unless a formal degree is meant."""

_LEADING_BITS = 128

ZERO: Surd = (0, 0)
ONE: Surd = (1, 0)


class Indivisible(ArithmeticError):  # noqa: N818 - a verdict, not a fault
    """A division that should leave nothing leaves a remainder."""


@dataclass(frozen=True)
class Ring:
    """The ring ℤ[ω]."""

    radicand: int

    def times(self, x: Surd, y: Surd) -> Surd:
        """The product of two numbers."""
        (a, b), (c, d) = x, y
        if not b and not d:
            return a * c, 0
        first, second = a * c, b * d
        return first + self.radicand * second, (a + b) * (c + d) - first - second

    def power(self, x: Surd, exponent: int) -> Surd:
        """A power with an exponent ≥ 0."""
        result = ONE
        for _ in range(exponent):
            result = self.times(result, x)
        return result

    def over(self, x: Surd, y: Surd) -> Surd:
        """The exact quotient.

        Raises:
            Indivisible: it is not in the ring.
        """
        [quotient] = self.shares((x,), y)
        return quotient

    def shares(self, p: Sequence[Surd], y: Surd) -> list[Surd]:
        """The exact quotients of some numbers by one.

        Raises:
            Indivisible: one is not in the ring.
        """
        c, d = y
        if d:
            p, c = [self.times(x, (c, -d)) for x in p], c * c - self.radicand * d * d
        _charge(self, len(p), p)
        spend_by_digits(2 * len(p), max(size_of(p) - c.bit_length(), 0), c.bit_length())
        result = []
        for x in p:
            (a, ra), (b, rb) = divmod(x[0], c), divmod(x[1], c)
            if ra or rb:
                raise Indivisible("a quotient of surds is not integral")
            result.append((a, b))
        return result

    def sign(self, x: Surd) -> int:
        """−1, 0 or 1."""
        a, b = x
        if not b or (a > 0) == (b > 0):
            return (a > 0) - (a < 0) if a else (b > 0) - (b < 0)
        if not a or _is_less(self.radicand, abs(a), abs(b)):
            return 1 if b > 0 else -1
        return 1 if a > 0 else -1

    def product(self, p: Poly, q: Poly) -> Poly:
        """The product of two polynomials."""
        if not p or not q:
            return ()
        _charge(self, len(p) * len(q), p)
        result = [ZERO] * (len(p) + len(q) - 1)
        for i, x in enumerate(p):
            if x != ZERO:
                for k, y in enumerate(q, i):
                    a, b = self.times(x, y)
                    result[k] = (result[k][0] + a, result[k][1] + b)
        return trimmed(result)

    def quotient(self, p: Poly, q: Poly) -> Poly:
        """The exact quotient of two polynomials, ``q`` with its true degree.

        Raises:
            Indivisible: it has coefficients outside the ring, or a remainder.
        """
        _charge(self, len(p) * len(q), p)
        rest, result = list(p), [ZERO] * max(len(p) - len(q) + 1, 0)
        for k in reversed(range(len(result))):
            x = result[k] = self.over(rest[k + len(q) - 1], q[-1])
            if x != ZERO:
                _subtract(self, rest, x, q, k)
        if any(x != ZERO for x in rest):
            raise Indivisible("a polynomial does not divide another")
        return trimmed(result)

    def pseudo_remainder(self, p: Poly, q: Poly) -> Poly:
        """lc(q)^(deg p − deg q + 1) · p modulo q."""
        rest, steps = list(p), len(p) - len(q) + 1
        for k in reversed(range(steps)):
            *rest, lead = rest  # which vanishes
            _charge(self, 2 * len(p), rest)
            rest = [self.times(q[-1], x) for x in rest]
            _subtract(self, rest, lead, q[:-1], k)
        return trimmed(rest)

    def chain(self, p: Poly, q: Poly) -> tuple[list[Poly], Surd]:
        """The subresultant remainders of two polynomials, p and q first, and their resultant.

        Both have their true degrees, that of q not above that of p (Collins 1967; Cohen 1993, 3.3.7).
        """
        rows, sign, lead, scale = [p, q], 1, ONE, ONE
        while len(q) > 1:
            step = len(p) - len(q)
            sign = -sign if len(p) % 2 == 0 == len(q) % 2 else sign
            divisor = self.times(lead, self.power(scale, step))
            rest = self.pseudo_remainder(p, q)
            p, q = q, tuple(self.shares(rest, divisor))
            lead = p[-1]
            if step:
                scale = self.over(self.power(lead, step), self.power(scale, step - 1))
            if not q:
                return rows, ZERO
            rows.append(q)
        degree = len(p) - 1
        last = self.over(self.power(q[0], degree), self.power(scale, degree - 1)) if degree else ONE
        return rows, (sign * last[0], sign * last[1])

    def gcd(self, p: Poly, q: Poly) -> Poly:
        """A greatest common divisor over ℚ(ω), primitive over ℤ, its leading coefficient rational."""
        p, q = sorted((self.leading_rational(p), self.leading_rational(q)), key=len, reverse=True)
        last = self.chain(p, q)[0][-1] if q else p
        return self.leading_rational(last) if len(last) > 1 else (ONE,)

    def leading_rational(self, p: Poly) -> Poly:
        """A multiple over ℚ(ω), primitive over ℤ, with a rational leading coefficient: no factor is left."""
        c, d = p[-1] if p else ONE
        return primitive(tuple(self.times(x, (c, -d)) for x in p) if d else p)

    def resultant(self, p: Sequence[Surd], q: Sequence[Surd]) -> Surd:
        """Sylvester's determinant for the formal degrees, which are the lengths less 1."""
        m, n = len(p) - 1, len(q) - 1
        first, second = trimmed(p), trimmed(q)
        k, i = m + 1 - len(first), n + 1 - len(second)
        if not first or not second or (k and i):
            return ZERO
        sign = -1 if k * n % 2 else 1
        factor = self.times(self.power(first[-1], i), self.power(second[-1], k))
        if len(first) < len(second):
            sign = -sign if (len(first) - 1) * (len(second) - 1) % 2 else sign
            first, second = second, first
        a, b = content(first), content(second)
        scale = sign * a ** (len(second) - 1) * b ** (len(first) - 1)
        x, y = self.times(factor, self.chain(primitive(first), primitive(second))[1])
        return scale * x, scale * y

    def squarefree_parts(self, p: Poly) -> dict[int, Poly]:
        """Multiplicity → the product of the factors over ℚ(ω) with this multiplicity (Yun)."""
        parts: dict[int, Poly] = {}
        common = self.gcd(p, derivative(p))
        rest, multiplicity = self.field_quotient(p, common), 1
        while len(rest) > 1:
            shared = self.gcd(rest, common)
            if len(own := self.field_quotient(rest, shared)) > 1:
                parts[multiplicity] = own
            rest, common = shared, self.field_quotient(common, shared)
            multiplicity += 1
        return parts

    def field_quotient(self, p: Poly, q: Poly) -> Poly:
        """p / q over ℚ(ω), where q divides p there; primitive over ℤ.

        Raises:
            Indivisible: it does not divide p.
        """
        whole, divisor = self.leading_rational(p), self.leading_rational(q)
        lead = divisor[-1][0] ** (len(p) - len(q) + 1)
        return primitive(self.quotient(tuple((a * lead, b * lead) for a, b in whole), divisor))

    def at(self, p: Sequence[Surd], x: Fraction) -> Surd:
        """p(x) times the denominator of x to the formal degree of p."""
        n, d = x.numerator, x.denominator
        spend_by_digits(2 * len(p), size_of(p) + len(p) * d.bit_length() // 2, d.bit_length())
        a = b = 0
        power = 1
        for u, v in reversed(p):
            a, b = a * n + u * power, b * n + v * power
            power *= d
        return a, b


def radical(ring: Ring, p: Poly) -> Poly:
    """The product of the different factors over ℚ(ω): all roots are simple."""
    return ring.field_quotient(p, ring.gcd(p, derivative(p))) if len(p) > 1 else p


def without(ring: Ring, p: Poly, other: Poly) -> Poly:
    """p without all factors that it shares with another polynomial."""
    while len(shared := ring.gcd(p, other)) > 1:
        p = ring.field_quotient(p, shared)
    return p if len(p) > 1 else (ONE,)


def _charge(ring: Ring, products: int, p: Sequence[Surd]) -> None:
    """Counts products with numbers of some size."""
    spend(products if ring.radicand == 1 else 3 * products, size_of(p))


def _is_less(radicand: int, a: int, b: int) -> bool:
    """Whether a < b ω, by the leading bits of long numbers where they decide it."""
    cut = max(a.bit_length(), b.bit_length()) - _LEADING_BITS
    if cut > 0:
        x, y = a >> cut, b >> cut
        if (x + 1) ** 2 <= radicand * y * y:
            return True
        if x * x >= radicand * (y + 1) ** 2:
            return False
    return a * a < radicand * b * b


def _subtract(ring: Ring, rest: list[Surd], x: Surd, q: Poly, shift: int) -> None:
    """Subtracts x · q · variable^shift in place."""
    for i, y in enumerate(q, shift):
        a, b = ring.times(x, y)
        rest[i] = (rest[i][0] - a, rest[i][1] - b)


def size_of(p: Sequence[Surd]) -> int:
    """About the bits of the longest coefficient."""
    return max((part.bit_length() for x in (*p[:1], *p[-1:]) for part in x), default=0)


def trimmed(p: Sequence[Surd]) -> Poly:
    """Without leading zeros."""
    size = len(p)
    while size and p[size - 1] == ZERO:
        size -= 1
    return tuple(p[:size])


def content(p: Sequence[Surd]) -> int:
    """The greatest integer that divides all coefficients; 1 if all are 0."""
    return gcd(*(part for x in p for part in x)) or 1


def primitive(p: Sequence[Surd]) -> Poly:
    """Divided by its content."""
    divisor = content(p)
    return trimmed([(a // divisor, b // divisor) for a, b in p])


def derivative(p: Poly) -> Poly:
    """The derivative of a polynomial."""
    return tuple((k * a, k * b) for k, (a, b) in enumerate(p) if k)


def rational(coefficients: Sequence[int]) -> Poly:
    """A polynomial with integer coefficients."""
    return trimmed([(c, 0) for c in coefficients])


def interpolated(points: Sequence[int], values: Sequence[tuple[Fraction | int, Fraction | int]]) -> Poly:
    """A multiple in ℤ[ω] of the polynomial with these values at different integers, by Lagrange's formula."""
    whole = [1]  # Π (x − point)
    for point in points:
        whole = [below - point * x for below, x in zip([0, *whole], [*whole, 0], strict=True)]
    unit = lcm(*(Fraction(x).denominator for value in values for x in value))
    shares, divisors = [], []
    for point in points:
        share, carry = [], 0
        for x in reversed(whole):  # whole / (x − point), by Horner's scheme
            share.append(carry := x + point * carry)
        shares.append(share[-2::-1])  # without the remainder, 0
        divisors.append(prod(point - other for other in points if other != point))
    common = lcm(*divisors)
    result = [ZERO] * len(points)
    for share, divisor, value in zip(shares, divisors, values, strict=True):
        a, b = (int(x * unit) * (common // divisor) for x in value)
        spend(2 * len(points), max(a.bit_length(), b.bit_length()) // 4)
        result = [(c + a * x, d + b * x) for (c, d), x in zip(result, share, strict=True)]
    return primitive(result)


def plus(x: Surd, y: Surd) -> Surd:
    """The sum of two numbers."""
    return x[0] + y[0], x[1] + y[1]


def negative(x: Surd) -> Surd:
    """The number with the other sign."""
    return -x[0], -x[1]


def formal_product(ring: Ring, p: Poly, q: Poly) -> Poly:
    """The product, of the formal degree that is the sum of both."""
    product = ring.product(p, q)
    return product + (ZERO,) * (len(p) + len(q) - 1 - len(product))


def formal_sum(p: Poly, q: Poly, sign: int) -> Poly:
    """p + q or p − q, of the formal degree of p, the greater one."""
    q = q + (ZERO,) * (len(p) - len(q))
    return tuple((a + sign * c, b + sign * d) for (a, b), (c, d) in zip(p, q, strict=True))


def formal_quotient(ring: Ring, p: Poly, q: Poly) -> tuple[Poly, Fraction]:
    """The exact quotient, of the formal degree that is the difference of both, and its factor.

    Raises:
        ZeroDivisionError: the divisor vanishes.
        Indivisible: there is a remainder.
    """
    size, q = len(p) - len(q) + 1, trimmed(q)
    if not q:
        raise ZeroDivisionError("a divisor vanishes on a line")
    whole, q, conjugate, scale = content(q), primitive(q), ONE, 1
    try:
        short = ring.quotient(trimmed(p), q)
    except Indivisible:  # it may have denominators
        c, d = q[-1]
        conjugate = (c, -d) if d else ONE
        integral = tuple(ring.times(x, conjugate) for x in q)
        scale = integral[-1][0] ** max(len(p) - len(q) + 1, 1)
        short = ring.quotient(trimmed([(a * scale, b * scale) for a, b in p]), integral)
    result = [ring.times(x, conjugate) for x in short]
    divisor = content(result)
    row: Poly = tuple((a // divisor, b // divisor) for a, b in result)
    return row + (ZERO,) * (size - len(row)), Fraction(divisor, scale * whole)


def at_quotient(ring: Ring, form: Sequence[Surd], x: tuple[Surd, Surd]) -> Surd:
    """A form at the quotient of two numbers, times the second one to the formal degree."""
    total = ZERO
    for k, c in enumerate(form):
        term = ring.times(ring.power(x[0], k), ring.power(x[1], len(form) - 1 - k))
        total = plus(total, ring.times(c, term))
    return total


@dataclass(frozen=True)
class Ratio:
    """A quotient n/d in ℚ(ω), or ∞, where d is 0."""

    ring: Ring
    n: Surd
    d: Surd

    @property
    def form(self) -> Poly:
        """The form of degree 1 that vanishes here alone."""
        return negative(self.n), self.d

    def is_root(self, form: Sequence[Surd]) -> bool:
        """Whether a form vanishes here."""
        return at_quotient(self.ring, form, (self.n, self.d)) == ZERO

    def is_same(self, other: Ratio) -> bool:
        """Whether two quotients are equal."""
        return self.ring.times(self.n, other.d) == self.ring.times(self.d, other.n)

    def divided(self, form: Sequence[Surd]) -> Poly:
        """A form that vanishes here, divided by that of this quotient; of its formal degree less 1."""
        if self.d == ZERO:
            return tuple(form[:-1])
        short = self.ring.field_quotient(trimmed(form), self.form)
        return short + (ZERO,) * (len(form) - 1 - len(short))
