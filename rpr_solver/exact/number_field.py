"""Real algebraic numbers, exactly: a number field with one real embedding.

For the rare poses that balls cannot decide (a multiple root, an angle of exactly 180°). An element is a
polynomial in the field's generator, so equality with zero is decided exactly, and the sign by proof.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import count, islice

from flint import arb, arb_poly, ctx, fmpq, fmpq_mat, fmpq_mpoly_ctx, fmpq_poly, fmpz_poly, nmod_poly

from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact.modular import primes
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, bisected, real_roots

_START_BITS = 128
_MOST_PRIMES = 40
_MOST_WORK = 30_000_000
"""The cubed degree of a field, times the bits, of an inverse: a quarter of a second."""
_MOST_BITS = 1 << 15
"""Of an inverse in any field; Euclid's algorithm lengthens its numbers with each step."""
_PLANE = fmpq_mpoly_ctx.get(("x", "y"), "lex")


@dataclass(frozen=True, eq=False)
class Field:
    """ℚ[x]/(modulus), modulus irreducible, with x sent to one of its real roots."""

    root: RealRoot
    """The embedding: a root of the modulus, which has integer coefficients."""

    @classmethod
    def rationals(cls) -> Field:
        """ℚ, with the modulus x."""
        return cls(*real_roots(QuadraticPoly.rational([0, 1])))

    @cached_property
    def modulus(self) -> fmpq_poly:
        """The minimal polynomial of the root, up to a rational factor."""
        return fmpq_poly(self.root.polynomial.a)

    @property
    def degree(self) -> int:
        """The degree over ℚ."""
        return int(self.modulus.degree())

    def __call__(self, value: int | fmpq | Fraction | fmpq_poly) -> Algebraic:
        if isinstance(value, fmpq_poly):
            return Algebraic(self, value % self.modulus)
        if isinstance(value, Fraction):
            value = fmpq(value.numerator, value.denominator)
        return Algebraic(self, fmpq_poly([value]))

    @property
    def generator(self) -> Algebraic:
        """The root itself."""
        return self(fmpq_poly([0, 1]))

    @cached_property
    def place(self) -> tuple[int, int] | None:
        """A prime p and a simple root of the modulus modulo p, to which the generator may be sent; or None.

        The elements without p in their denominators belong to a discrete valuation ring with the field 𝔽ₚ of
        residues.
        """
        coefficients = self.root.polynomial.a
        for p, _ in islice(primes(1), _MOST_PRIMES):
            image = nmod_poly(coefficients, p)
            if image.degree() == self.degree:
                for root, multiplicity in image.roots():
                    if multiplicity == 1:
                        return p, int(root)
        return None

    def generator_ball(self, bits: int) -> arb:
        """The generator's real value to a relative accuracy of ``bits`` bits."""
        if self.degree == 1:
            with ctx.workprec(bits):
                return arb(-self.modulus[0] / self.modulus[1])
        return self.root.refined(bits)


@dataclass(frozen=True, eq=False)
class Algebraic:
    """An element of a :class:`Field`."""

    field: Field
    poly: fmpq_poly

    def __add__(self, other: Algebraic | int) -> Algebraic:
        return Algebraic(self.field, self.poly + _poly(other))

    def __sub__(self, other: Algebraic | int) -> Algebraic:
        return Algebraic(self.field, self.poly - _poly(other))

    def __mul__(self, other: Algebraic | int) -> Algebraic:
        return Algebraic(self.field, self.poly * _poly(other) % self.field.modulus)

    def __neg__(self) -> Algebraic:
        return Algebraic(self.field, -self.poly)

    def inverse(self) -> Algebraic:
        """1 / self.

        Raises:
            ZeroDivisionError: self is 0.
            Unproved: it takes too long.
        """
        if not self.poly:
            raise ZeroDivisionError("inverse of 0 in a number field")
        if self.poly.degree() == 0:
            return self.field(1 / self.poly[0])
        return Algebraic(self.field, inverse_modulo(self.poly, self.field.modulus))

    @property
    def is_zero(self) -> bool:
        """Exactly zero."""
        return not self.poly

    @property
    def bits(self) -> int:
        """Of the longest of the integers that stand for it."""
        return max(int(self.poly.numer().height_bits()), int(self.poly.denom()).bit_length())

    @property
    def rational(self) -> Fraction | None:
        """The value if it is rational, else None."""
        if self.poly.degree() > 0:
            return None
        value = self.poly[0]
        return Fraction(int(value.p), int(value.q))

    def ball(self, bits: int) -> arb:
        """The real value as a ball, computed with ``bits`` bits."""
        generator = self.field.generator_ball(bits)
        with ctx.workprec(bits):
            return arb_poly(self.poly)(generator)

    @property
    def sign(self) -> int:
        """−1, 0 or 1, proved."""
        if self.is_zero:
            return 0

        def sign(bits: int) -> int | None:
            ball = self.ball(bits)
            return None if ball.contains(0) else 1 if ball > 0 else -1

        return decided(
            sign, _START_BITS, GREATEST_BITS, "the sign of an algebraic number could not be decided"
        )


def inverse_modulo(polynomial: fmpq_poly, modulus: fmpq_poly) -> fmpq_poly:
    """1 / polynomial modulo an irreducible one.

    Raises:
        Unproved: it takes too long.
    """
    degree = int(modulus.degree())
    bits = polynomial.numer().height_bits() + modulus.numer().height_bits()
    if degree**3 * bits > _MOST_WORK or bits > _MOST_BITS:
        raise Unproved(
            f"this takes numbers of {bits} bits in a number field of degree {degree}, which is too long"
        )
    _, inverse, _ = polynomial.xgcd(modulus)
    return inverse % modulus


def exact_omega(radicand: int) -> Algebraic:
    """ω in ℚ(ω): the generator, or 1 in ℚ where the radicand is 1."""
    if radicand == 1:
        return Field.rationals()(1)
    return Field(real_roots(QuadraticPoly.rational([-radicand, 0, 1]))[-1]).generator


Polynomial = list[Algebraic]
"""Ascending coefficients in one field; the last is not zero; [] is the zero polynomial."""


def trimmed(coefficients: Sequence[Algebraic]) -> Polynomial:
    """Without leading zeros."""
    result = list(coefficients)
    while result and result[-1].is_zero:
        result.pop()
    return result


def poly_sum(a: Sequence[Algebraic], b: Sequence[Algebraic]) -> Polynomial:
    """a + b."""
    short, long = sorted((a, b), key=len)
    return trimmed([*(x + y for x, y in zip(short, long, strict=False)), *long[len(short) :]])


def poly_product(a: Sequence[Algebraic], b: Sequence[Algebraic]) -> Polynomial:
    """a b."""
    total: list[Algebraic] = []
    for x in reversed(a):
        total = poly_sum([x.field(0), *total], [x * y for y in b])
    return total


def poly_mod(a: Polynomial, b: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Quotient and remainder; b must not be zero."""
    lead, rest = b[-1].inverse(), list(a)
    quotient: list[Algebraic] = []
    while len(rest) >= len(b):
        factor = rest[-1] * lead
        shift = len(rest) - len(b)
        for i, c in enumerate(b[:-1]):
            rest[shift + i] = rest[shift + i] - factor * c
        rest.pop()
        quotient.append(factor)
    return trimmed(quotient[::-1]), trimmed(rest)


def poly_gcd(a: Polynomial, b: Polynomial) -> Polynomial:
    """The monic greatest common divisor."""
    if a and b and _coprime_at_a_place(a, b):
        return [a[0].field(1)]
    while b:
        a, b = b, poly_mod(a, b)[1]
    if not a:
        return a
    lead = a[-1].inverse()
    return [c * lead for c in a]


def _coprime_at_a_place(a: Polynomial, b: Polynomial) -> bool:
    """Proves that two polynomials have no common divisor, by their images over 𝔽ₚ; False gives no proof.

    A common divisor would have an image of its own degree (mathematics.md#coprime-at-one-place).
    """
    place = a[0].field.place
    if place is None:
        return False
    first, second = (_residues(x, *place) for x in (a, b))
    if first is None or second is None or not (first[-1] or second[-1]):
        return False
    p, _ = place
    return bool(nmod_poly(first, p).gcd(nmod_poly(second, p)).degree() == 0)


def _residues(polynomial: Polynomial, p: int, generator: int) -> list[int] | None:
    """The coefficients modulo p; None if p divides a denominator."""
    residues = []
    for c in polynomial:
        denominator = int(c.poly.denom()) % p
        if not denominator:
            return None
        value = int(nmod_poly(c.poly.numer(), p)(generator))
        residues.append(value * pow(denominator, -1, p) % p)
    return residues


def squarefree_part(a: Polynomial) -> Polynomial:
    """The polynomial with the same zeros, each once."""
    derivative = trimmed([c * i for i, c in enumerate(a)][1:])
    return poly_mod(a, poly_gcd(a, derivative))[0]


def evaluate(a: Sequence[Algebraic], x: Algebraic) -> Algebraic:
    """Horner's rule."""
    total = x.field(0)
    for c in reversed(a):
        total = total * x + c
    return total


@dataclass(frozen=True)
class Extension:
    """A larger field, by the image of the old generator and the root that was adjoined."""

    generator: Algebraic
    root: Algebraic

    def lift(self, x: Algebraic) -> Algebraic:
        """An element of the old field in the new one."""
        return evaluate([self.root.field(c) for c in x.poly.coeffs()], self.generator)


def adjoin_real_roots(field: Field, polynomial: Polynomial) -> Iterator[Extension]:
    """One extension for each real root of a squarefree polynomial over the field, ascending."""
    if len(polynomial) <= 1:
        return
    if len(polynomial) == 2:
        yield Extension(field.generator, _linear_root(polynomial))
        return
    shift, norm = _squarefree_norm(field, polynomial)
    primitive = fmpz_poly(norm.numer())
    factors = [QuadraticPoly.rational(f) for f, _ in primitive.factor()[1]]
    candidates = [root for f in factors for root in real_roots(f)]
    for ball in real_balls(polynomial):
        # w = root + shift · generator generates the new field
        new = Field(_match(candidates, ball, field, shift))
        yield _extension(field, polynomial, shift, new)


def common_roots(
    first: Sequence[Algebraic], second: Sequence[Algebraic], *carried: Algebraic
) -> list[tuple[Algebraic | None, list[Algebraic]]] | None:
    """The real common roots t of two forms over a field, given by ascending coefficients.

    None stands for t = ∞ and comes first, the others ascend. Each root comes with the images of the elements
    ``carried`` (at least one) of the old field in its own. Returns None if both forms are zero, so that every
    t is a root.
    """
    common = poly_gcd(trimmed(first), trimmed(second))
    if not common:
        return None
    roots: list[tuple[Algebraic | None, list[Algebraic]]] = []
    if first[-1].is_zero and second[-1].is_zero:
        roots.append((None, list(carried)))
    for extension in adjoin_real_roots(carried[0].field, squarefree_part(common)):
        roots.append((extension.root, [extension.lift(x) for x in carried]))
    return roots


def _squarefree_norm(field: Field, polynomial: Polynomial) -> tuple[int, fmpq_poly]:
    """A shift s such that N(w) = Res_x(modulus(x), polynomial(w − s x)) is squarefree, and N."""
    x, y = _PLANE.gens()
    modulus = field.modulus.coeffs()
    m = sum((c * x**i for i, c in enumerate(modulus)), x * 0)
    for shift in count():
        step = y - shift * x
        total = x * 0
        for c in reversed(polynomial):
            total = total * step + sum((a * x**i for i, a in enumerate(c.poly.coeffs())), x * 0)
        norm_xy = m.resultant(total, "x") if total.degrees()[0] else total**field.degree
        norm = fmpq_poly([norm_xy[0, i] for i in range(norm_xy.degrees()[1] + 1)])
        if norm.gcd(norm.derivative()).degree() == 0:
            return shift, norm
    raise AssertionError("unreachable: all but finitely many shifts are good")


def real_balls(polynomial: Polynomial) -> list[BallRoot]:
    """Functions that give the real roots as balls at any precision, ascending."""

    def isolated(bits: int) -> list[arb] | None:
        with ctx.workprec(bits):
            balls = arb_poly([c.ball(bits) for c in polynomial])
        return bisected(balls, bits)

    message = "the roots of a polynomial over a number field could not be told apart"
    return [BallRoot(polynomial, x) for x in decided(isolated, _START_BITS, GREATEST_BITS, message)]


@dataclass(frozen=True)
class BallRoot:
    """A real root of a polynomial over a number field, refined on demand."""

    polynomial: Polynomial
    ball: arb

    def __call__(self, bits: int) -> arb:
        with ctx.workprec(bits):
            balls = arb_poly([c.ball(bits) for c in self.polynomial])
            slope, x = balls.derivative(), self.ball
            while True:
                mid, value = x.mid(), balls(x.mid())
                y = mid - value / slope(x)
                if not (y.is_finite() and 2 * y.rad() < x.rad()):
                    # the slope varies too much across the ball: bisect
                    at_lower = balls(x.lower())
                    # the ball of a product may hold 0 where its factors do not
                    y = mid.union(x.upper() if (value > 0) == (at_lower > 0) else x.lower())
                    if value.contains(0) or at_lower.contains(0) or not y.rad() < x.rad():
                        return x
                x = y


def _match(candidates: list[RealRoot], root: BallRoot, field: Field, shift: int) -> RealRoot:
    """The candidate equal to root + shift × generator, at a precision that excludes all others."""

    def match(bits: int) -> RealRoot | None:
        with ctx.workprec(bits):
            ball = root(bits) + field.generator_ball(bits) * shift
        near = [c for c in candidates if c.refined(bits).overlaps(ball)]
        return near[0] if len(near) == 1 else None

    return decided(match, _START_BITS, GREATEST_BITS, "an algebraic number could not be placed in its field")


def _extension(old: Field, polynomial: Polynomial, shift: int, new: Field) -> Extension:
    """The images of the old generator x and of the root y in the field of w = y + shift x.

    In the algebra of x and y, whose dimension is the degree of the norm, the powers of w are a basis, since
    the norm is squarefree. So x is a combination of them, by one linear system; new is a factor of it.
    """
    n, lead = old.degree, polynomial[-1].inverse()
    tail = [-(c * lead) for c in polynomial[:-1]]
    slope, size = old.generator * shift, n * len(tail)
    power, rows = [old(1), *(old(0) for _ in tail[1:])], []
    for _ in range(size):
        rows.append([c.poly[i] for c in power for i in range(n)])
        # y times it, with the highest power of y replaced, and shift x times it
        raised = [power[-1] * c for c in tail]
        for k, c in enumerate(power):
            raised[k] = raised[k] + slope * c
            if k + 1 < len(power):
                raised[k + 1] = raised[k + 1] + c
        power = raised
    target = [old.generator.poly[i] for i in range(n)] + [fmpq(0)] * (size - n)
    solution = fmpq_mat(rows).transpose().solve(fmpq_mat([[c] for c in target]))
    generator = new(fmpq_poly([solution[i, 0] for i in range(size)]))
    return Extension(generator, new.generator - generator * shift)


def _linear_root(polynomial: Polynomial) -> Algebraic:
    if len(polynomial) != 2:
        raise SolverError("a primitive element did not separate the roots")
    return -(polynomial[0] * polynomial[1].inverse())


def _poly(x: Algebraic | int) -> fmpq_poly:
    return x.poly if isinstance(x, Algebraic) else fmpq_poly([x])
