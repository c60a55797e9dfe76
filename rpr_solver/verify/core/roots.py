"""The real roots of a squarefree polynomial over ℤ[ω], isolated by Descartes' rule of signs.

(1 + x)ⁿ p(1/(1 + x)) has at least as many changes of sign as p has roots in (0, 1): none proves that there
is no root, one that there is exactly one. Bisection ends, as the roots are simple (Vincent). A form of
degree n has the whole line within reach: |u| < 1, |u| > 1 by the reversed form, and ±1 and ∞.

That roots are simple is proved modulo a prime: ω ↦ a square root of the radicand modulo p maps ℤ[ω] to the
field of p elements. If the image keeps its degree and is prime to its derivative, the discriminant is not 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, isqrt

from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Poly,
    Ring,
    Surd,
    derivative,
    negative,
    plus,
    primitive,
    size_of,
    trimmed,
)

_GUARD_BITS, _TRIES = 64, 4


@dataclass(frozen=True)
class Root:
    """A real root: the only one in the open interval, or the point itself where both ends agree.

    ``inverted`` says that the interval is one of 1/u; u = ∞ is 1/u = 0.
    """

    lower: Fraction
    upper: Fraction
    inverted: bool

    @property
    def width(self) -> Fraction:
        """The width of the interval."""
        return self.upper - self.lower

    @property
    def axis(self) -> int:
        """The cosine of the angle, if the root is its half tangent and it is exactly 0 or 180°; else 0."""
        return 0 if self.lower or self.upper else -1 if self.inverted else 1

    @property
    def ratio(self) -> tuple[int, int]:
        """The root, about, as a quotient, whose divisor may be 0."""
        n, d = ((self.lower + self.upper) / 2).as_integer_ratio()
        return (d, n) if self.inverted else (n, d)


def real_roots(ring: Ring, form: Sequence[Surd]) -> list[Root]:
    """All real roots, ∞ included, of a squarefree form whose formal degree is its length less 1."""
    roots = []
    for inverted in (False, True):
        p = list(reversed(form)) if inverted else list(form)
        if p[0] == ZERO:
            roots.append(Root(Fraction(0), Fraction(0), inverted))
        for sign in (1, -1):
            turned = [(a * sign**k, b * sign**k) for k, (a, b) in enumerate(p)]
            for lower, upper in _within_unit(ring, _without_zero(turned)):
                ends = sorted((sign * lower, sign * upper))
                roots.append(Root(ends[0], ends[1], inverted))
    for one in (1, -1):
        if ring.at(form, Fraction(one)) == ZERO:
            roots.append(Root(Fraction(one), Fraction(one), False))
    return roots


def refined(ring: Ring, form: Sequence[Surd], root: Root, width: Fraction) -> Root:
    """The same root in an interval of at most this width.

    By quadratic interval refinement (Abbott 2006): the interval is cut into 2^k pieces, and that where the
    chord is 0 is tried; k is doubled where it holds the root, and halved where not.
    """
    p = list(reversed(form)) if root.inverted else list(form)
    if root.lower == root.upper:
        return root
    lower, upper = root.lower, root.upper
    # the upper end may be another root, a simple one
    at_upper = ring.sign(ring.at(p, upper)) or -ring.sign(ring.at(derivative(tuple(p)), upper))
    values: dict[Fraction, Surd] = {}

    def at(x: Fraction) -> Surd:
        if x not in values:
            values[x] = ring.at(p, x)
        return values[x]

    k = 1
    while upper - lower > width:
        k = min(k, int((upper - lower) / width).bit_length())
        pieces = 1 << k
        step = (upper - lower) / pieces
        place = min(max(_chord(ring, at, len(p) - 1, lower, upper, pieces), 1), pieces - 1)
        ends = [lower + place * step]
        sides = [ring.sign(at(ends[0])) * at_upper]
        # the next point towards the root
        ends.append(ends[0] - step if sides[0] > 0 else ends[0] + step)
        if lower < ends[1] < upper:
            sides.append(ring.sign(at(ends[1])) * at_upper)
        for x, side in zip(ends, sides, strict=False):
            if not side:
                return replace(root, lower=x, upper=x)
            if side > 0:
                upper = min(upper, x)
            else:
                lower = max(lower, x)
        k = 2 * k if upper - lower <= step else max(k // 2, 1)
    return replace(root, lower=lower, upper=upper)


def has_root(ring: Ring, part: Poly, root: Root, other: Sequence[Surd]) -> bool:
    """Whether an isolated root of a squarefree form is one of another form too; both have formal degrees.

    A common divisor of both changes its sign at the root, and nowhere else in the interval.
    """
    p, q = (trimmed(form[::-1] if root.inverted else form) for form in (part, other))
    if not q:
        return True
    if root.lower == root.upper:
        return ring.at(q, root.lower) == ZERO
    common = ring.gcd(p, q)
    at_ends = [ring.sign(ring.at(common, x)) for x in (root.lower, root.upper)]
    if not at_ends[1]:  # the upper end may be another root, a simple one
        at_ends[1] = -ring.sign(ring.at(derivative(common), root.upper))
    if not at_ends[0]:
        at_ends[0] = ring.sign(ring.at(derivative(common), root.lower))
    return len(common) > 1 and at_ends[0] * at_ends[1] < 0


def _chord(
    ring: Ring, at: Callable[[Fraction], Surd], degree: int, lower: Fraction, upper: Fraction, pieces: int
) -> int:
    """The piece where the chord of a form is 0; any guess would do."""
    guard = _GUARD_BITS + ceil(pieces / (upper - lower)).bit_length()
    omega = isqrt(ring.radicand << (2 * guard))
    sides = [at(x) for x in (lower, upper)]
    first, second = (abs((a << guard) + b * omega) for a, b in sides)
    first, second = first * upper.denominator**degree, second * lower.denominator**degree
    return pieces * first // (first + second) if first + second else pieces // 2


def _within_unit(ring: Ring, p: list[Surd]) -> Iterator[tuple[Fraction, Fraction]]:
    """The roots strictly between 0 and 1, where p(0) ≠ 0."""
    todo = [(p, Fraction(0), Fraction(1))]
    while todo:
        q, lower, width = todo.pop()
        changes = _variations(ring, shifted(list(reversed(q))))
        if changes == 1:
            yield lower, lower + width
        if changes < 2:
            continue
        size = len(q) - 1
        left = [(a << (size - k), b << (size - k)) for k, (a, b) in enumerate(q)]
        right = shifted(left)
        middle = lower + width / 2
        if right[0] == ZERO:
            yield middle, middle
        todo += [(left, lower, width / 2), (_without_zero(right), middle, width / 2)]


def _without_zero(p: list[Surd]) -> list[Surd]:
    """Divided by the variable, if 0 is a root."""
    return p[1:] if p[0] == ZERO else p


def _variations(ring: Ring, p: Sequence[Surd]) -> int:
    """The number of changes of sign among the coefficients, counted up to 2."""
    last = changes = 0
    for x in p:
        sign = ring.sign(x)
        if sign and sign == -last:
            changes += 1
            if changes > 1:
                break
        last = sign or last
    return changes


def shifted(p: Sequence[Surd]) -> list[Surd]:
    """p(x + 1)."""
    spend(len(p) ** 2 // 2, size_of(p) // 8)
    first, second = [a for a, _ in p], [b for _, b in p]
    for part in (first, second):
        if any(part):
            for start in range(len(part) - 1):
                for k in range(len(part) - 2, start - 1, -1):
                    part[k] += part[k + 1]
    return list(zip(first, second, strict=True))


def square_root(ring: Ring, x: Surd) -> Surd | None:
    """The root ≥ 0 of a number, if it is in the ring."""
    (a, b), r = x, ring.radicand
    if r == 1 or not b:
        root = isqrt(max(a, 0))
        if root * root == a:
            return root, 0
        root = isqrt(max(a // r, 0))
        return (0, root) if r > 1 and r * root * root == a else None
    norm = isqrt(max(a * a - r * b * b, 0))
    for half in (a + norm, a - norm):
        c = isqrt(max(half // 2, 0))
        if c and not b % (2 * c):
            both = c, b // (2 * c)
            if ring.times(both, both) == x:
                return both if ring.sign(both) >= 0 else negative(both)
    return None


def quotients(ring: Ring, form: Poly) -> list[tuple[Surd, Surd]] | None:
    """The roots of a squarefree form, as quotients over ℤ[ω], if at most two are finite, and in ℚ(ω); else
    None."""
    if form[1:] and form[-1] == ZERO:
        rest = quotients(ring, form[:-1])
        return None if rest is None else [(ONE, ZERO), *rest]
    if len(form) == 3:
        c, b, a = ((2 * x, 2 * y) for x, y in form)  # twice: the root may have halves
        root = square_root(ring, plus(ring.times(b, b), ring.times((-4, 0), ring.times(a, c))))
        both = () if root is None else (root, negative(root))
        return [(plus(x, negative(b)), plus(a, a)) for x in both] or None
    return [(negative(form[0]), form[1])] if len(form) == 2 else [] if len(form) == 1 else None


def formal_parts(ring: Ring, form: Sequence[Surd]) -> dict[int, Poly]:
    """Multiplicity → the form of the roots with it; a root at infinity is a leading zero of its part."""
    finite = primitive(form)
    if len(finite) > 1 and simple_and_apart(ring, finite, (ONE,)):
        parts = {1: finite}
    else:
        parts = ring.squarefree_parts(finite)
    if finite and (missing := len(form) - len(finite)):
        parts[missing] = (*parts.get(missing, (ONE,)), ZERO)
    return parts


def simple_and_apart(ring: Ring, p: Poly, other: Poly) -> bool:
    """Whether some prime proves that ``p`` has only simple roots, and none in common with ``other``."""
    for prime, omega in _places(ring.radicand):
        image, beside = ([(a + b * omega) % prime for a, b in form] for form in (p, other))
        if _simple(image, prime) and _coprime(image, beside, prime):
            return True
    return False


def proves_simple(ring: Ring, p: Poly, prime: int, omega: int) -> bool:
    """Whether a prime, with a square root of the radicand modulo it, proves that ``p`` has only simple roots.

    The prime must be below 2^64, where SymPy's test of primes is a proof.
    """
    from sympy.ntheory import isprime

    if not 2 < prime < 1 << 64 or not isprime(prime) or (omega * omega - ring.radicand) % prime:
        return False
    return _simple([(a + b * omega) % prime for a, b in p], prime)


def _simple(image: Sequence[int], prime: int) -> bool:
    """Whether the image keeps the degree and is prime to its derivative."""
    return bool(image[-1]) and _coprime(image, [k * x % prime for k, x in enumerate(image)][1:], prime)


def _places(radicand: int) -> Iterator[tuple[int, int]]:
    """Primes below 2^61, each with a square root of the radicand."""
    from sympy.ntheory import prevprime, sqrt_mod

    prime, found = 1 << 61, 0
    while found < _TRIES:
        prime = int(prevprime(prime))
        root = sqrt_mod(radicand % prime, prime)
        if root is not None:
            found += 1
            yield prime, int(root)


def _coprime(p: Sequence[int], q: Sequence[int], prime: int) -> bool:
    """Whether two polynomials modulo a prime share no root in any extension."""
    p, q = _trimmed(p), _trimmed(q)
    while q:
        inverse = pow(q[-1], -1, prime)
        rest = list(p)
        for k in reversed(range(len(rest) - len(q) + 1)):
            factor = rest[k + len(q) - 1] * inverse % prime
            for i, x in enumerate(q, k):
                rest[i] = (rest[i] - factor * x) % prime
        p, q = q, _trimmed(rest)
    return len(p) == 1


def _trimmed(p: Sequence[int]) -> list[int]:
    size = len(p)
    while size and not p[size - 1]:
        size -= 1
    return list(p[:size])
