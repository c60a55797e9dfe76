"""The lengths of one leg at which poses merge, while both other legs keep theirs: all of them, exact.

With leg c at A_c and another leg h held, the platform is the coupler of a four-bar linkage, and its poses are
a curve. In the half tangent t of α the closure of leg h is linear in X = B_c, with v, of which N = |v|²:

    w v·X = r,        |X|² = s    ⟹    X = (r v + W v⊥) / (w N),        ρ W² = q(t) = w² s N − r².

So the curve is W² = q/ρ, q of degree 4, and the squared length of the leg that moves is on it

    S = (U + W V) / Z.

A pose is singular where S is stationary along the curve (mathematics.md#poses-along-a-leg): where
A + W B = 0 with

    A = 2 q (V′ Z − V Z′) + q′ V Z,        B = 2ρ (U′ Z − U Z′),

so that t is a root of R = ρ A² − B² q. A real root t of R at which B is not 0 has one real pose, W = −A/B;
where A and B both vanish, both signs of √(q/ρ) are poses. Values of S that balls do not tell apart are told
apart, or shown to be equal, as roots of a rational polynomial.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise

from flint import arb, ctx, fmpq, fmpq_poly, fmpz_mat, fmpz_poly

from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact import decided
from rpr_solver.exact.factors import ExactRoot, exact_roots, minimal_polynomial, norm_factors
from rpr_solver.exact.modular import simple_and_finite, sylvester
from rpr_solver.exact.number_field import Algebraic, adjoin_real_roots
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import DivisionError, QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.fibre import Closure
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import Turn, turns_of

_DEGREE = 16
"""That of R in t."""
_APART_BITS = 512
"""Balls of values that differ are apart with this many bits, but for nearly special machines."""
_FIRST_BITS = 128


@dataclass(frozen=True)
class Place:
    """Where a singular pose is: above a root t of R, or where v = 0.

    Attributes:
        root: t.
        sign: that of √(q/ρ) in the place of W; None for W = −A/B.
        free: t, ω and the vector X in one field, where v = 0.
    """

    root: RealRoot
    sign: int | None = None
    free: tuple[Algebraic, Algebraic, Algebraic, Algebraic] | None = None


@dataclass(frozen=True)
class Fold:
    """A length of the moving leg at which poses are singular.

    Attributes:
        square: its square, scaled, as a ball of about so many correct bits.
        places: where the singular poses are; of a whole circle of them none is listed.
        is_simple: whether exactly two poses merge, in one.
        four_bar: the poses with both other legs held.
    """

    square: Callable[[int], arb]
    places: tuple[Place, ...]
    is_simple: bool
    four_bar: FourBar

    def values(self) -> fmpz_poly:
        """A rational polynomial of which the square is a root."""
        return self.four_bar.values()

    def compared(self, square: Fraction) -> int:
        """−1, 0 or 1: whether the fold's square is less than another one, equal, or greater."""

        def apart(bits: int) -> int | None:
            own = self.square(bits)
            with ctx.workprec(bits):
                other = ball_of(square)
                return None if own.overlaps(other) else 1 if own > other else -1

        if (found := _tried(apart)) is not None:
            return found
        n, d = square.numerator, square.denominator
        if self.values()(fmpq(n, d)) == 0:
            roots = _isolated(self.values())
            if place_of(self.square, roots) == place_of(partial(_ball, square), roots):
                return 0
        return decided(apart, 2 * _APART_BITS, GREATEST_BITS, "two lengths could not be told apart")


def _ball(x: Fraction, bits: int) -> arb:
    with ctx.workprec(bits):
        return ball_of(x)


def _tried(attempt: Callable[[int], int | None]) -> int | None:
    return next((x for bits in (_FIRST_BITS, _APART_BITS) if (x := attempt(bits)) is not None), None)


def folds(slice_map: SliceMap, moving: int, squares: tuple[Fraction, Fraction]) -> list[Fold]:
    """All lengths of a free leg at which poses are singular, ascending, with both other legs held.

    Args:
        slice_map: of a held leg.
        moving: which of the free legs moves, 0 for f and 1 for g.
        squares: the squares of the fixed leg's length and of the other held one, scaled.

    Raises:
        SolverError: the length of the moving leg stays the same along a whole curve of poses.
    """
    four_bar = FourBar.of(slice_map, moving, squares)
    own: list[tuple[Callable[[int], arb], Place | None, bool]] = [
        *four_bar.stationary_values(),
        *((x.ball, place, False) for x, place in four_bar.of_parallelogram),
    ]
    balls = [value(_APART_BITS) for value, *_ in own]
    order = sorted(range(len(own)), key=lambda k: balls[k].mid())
    groups = [[k] for k in order]
    if any(balls[k].overlaps(balls[m]) for k, m in pairwise(order)):
        roots = _isolated(four_bar.values())
        places: dict[int, list[int]] = {}
        for k in order:
            places.setdefault(place_of(own[k][0], roots), []).append(k)
        groups = [group for _, group in sorted(places.items())]
    return [
        Fold(
            own[k][0],
            tuple(place for i in group if (place := own[i][1])),
            len(group) == 1 and own[k][2],
            four_bar,
        )
        for group in groups
        for k in group[:1]
    ]


def _isolated(values: fmpz_poly) -> list[RealRoot]:
    if not values:
        raise Unproved("two lengths could not be told apart")
    return real_roots(QuadraticPoly.rational(values / values.gcd(values.derivative())))


def place_of(value: Callable[[int], arb], roots: Sequence[RealRoot]) -> int:
    """Which of the roots, of which one is the value, it is."""

    def attempt(bits: int) -> int | None:
        own = value(bits)
        near = [k for k, root in enumerate(roots) if root.refined(bits).overlaps(own)]
        return near[0] if len(near) == 1 else None

    return decided(attempt, _FIRST_BITS, GREATEST_BITS, "two lengths could not be told apart")


@dataclass(frozen=True)
class FourBar:
    """The poses with two legs held, in a chart where no singular one has t = ∞; in scaled units.

    Attributes:
        slice_map: of the first held leg.
        square: s.
        n: N without its factor 1 + ρt².
        right: r.
        other: the vector of the moving leg, and the factor of 1 + ρt² by which it is divided.
        den, turn: the denominator of the closure, and the turn of the chart.
        q, u, v, z, r: the polynomials q, U, V, Z and R of the formulas, R without the factors of N.
        a, b: A and B.
    """

    slice_map: SliceMap
    square: Fraction
    n: QuadraticPoly
    right: QuadraticPoly
    vector: tuple[QuadraticPoly, QuadraticPoly]
    other: tuple[QuadraticPoly, QuadraticPoly, QuadraticPoly]
    den: int
    turn: Turn
    q: QuadraticPoly
    u: QuadraticPoly
    v: QuadraticPoly
    z: QuadraticPoly
    a: QuadraticPoly
    b: QuadraticPoly
    r: QuadraticPoly

    @classmethod
    def of(cls, slice_map: SliceMap, moving: int, squares: tuple[Fraction, Fraction]) -> FourBar:
        """In the first chart that is good.

        Raises:
            SolverError: the length of the moving leg stays the same along a curve of poses.
        """
        for turn, _ in turns_of(slice_map.rho):
            found = cls._in_chart(slice_map, moving, squares, turn)
            if found is not None:
                return found
        raise SolverError(
            "the length of the moving leg stays the same along a curve of poses of the other two, or all "
            "of these poses are singular"
        )

    @classmethod
    def _in_chart(
        cls, slice_map: SliceMap, moving: int, squares: tuple[Fraction, Fraction], turn: Turn
    ) -> FourBar | None:
        fixed, held = squares
        rho, radicand = slice_map.rho, slice_map.radicand
        free = (Fraction(0), held) if moving == 0 else (held, Fraction(0))
        closure = Closure(slice_map, (fixed, *free))
        circular = fmpz_poly([1, 0, rho])
        cos, sin, one = (QuadraticPoly.rational(c, radicand) for c in ([1, 0, -rho], [0, 2], [1, 0, rho]))
        c, s, size = turn.rotation
        turned = cos * c - sin * (rho * s), sin * c + cos * s, one * size
        system = closure.linear(*turned, QuadraticPoly.omega(radicand))
        pairs = [(system.first, system.right[0]), (system.second, system.right[1])]
        (other, offset), (vector, right) = pairs[moving], pairs[1 - moving]
        (x, y), (p, k) = vector, other
        # vectors are isotropic, of one direction, at the roots of 1 + ρt²
        n = (x * x + y * y * rho) / circular
        along, across = (x * p + y * k * rho) / circular, (x * k - y * p) / circular
        den = closure.denominator
        q = n * one * (4 * den * int(den * fixed)) - right * right
        u, v, z = right * along - n * offset, across * rho, n * one
        slope = _slope(z)
        a = q * (_slope(v) * z - v * slope) * 2 + _slope(q) * v * z
        b = (_slope(u) * z - u * slope) * (2 * rho)
        r = a * a * rho - b * b * q
        if r.degree < _DEGREE or n.degree < 2:
            return None
        for factor in (_double(n) or n, one.primitive()):
            r = _without(r, factor)
        end = vector, (*other, turned[2])
        return cls(slice_map, fixed, n, right, *end, den, turn, q, u, v, z, a, b, r)

    @property
    def unit(self) -> int:
        """S times this is (U + W V) / Z."""
        return self.den * self.turn.rotation[2]

    @cached_property
    def _is_simple(self) -> bool:
        """Whether all roots of R are simple, and none is one of B."""
        return simple_and_finite(self.r, self.r.degree, apart_from=[self.b])

    @cached_property
    def exact_roots(self) -> list[ExactRoot]:
        """The real roots of R, exactly."""
        return list(exact_roots(norm_factors(self.r)))

    def stationary_values(self) -> Iterator[tuple[Callable[[int], arb], Place, bool]]:
        """S of each singular pose at which v is not 0, its place, and whether it is known to be a simple
        fold."""
        if self._is_simple:
            for root in real_roots(self.r):
                yield self._value(root, None), Place(root), True
            return
        for exact in self.exact_roots:
            t, omega = exact.in_field()
            if self.n(t, omega).is_zero:
                continue
            if not self.b(t, omega).is_zero:
                yield self._value(exact.root, None), Place(exact.root), exact.multiplicity == 1
                continue
            sign = self.q(t, omega).sign
            signs = (0,) if not sign else (1, -1) if sign > 0 else ()
            yield from ((self._value(exact.root, k), Place(exact.root, k), False) for k in signs)

    def w(self, t: arb, omega: arb, sign: int | None) -> arb:
        """W = −A/B, or a root with a sign in its place, by balls."""
        if sign is None:
            return -self.a(t, omega) / self.b(t, omega)
        # q is 0 here if the sign is, and positive otherwise
        return sign * (self.q(t, omega) / self.slice_map.rho).sqrt() if sign else arb(0)

    def _value(self, root: RealRoot, sign: int | None) -> Callable[[int], arb]:
        """S above a root t."""

        def square(bits: int) -> arb:
            def attempt(work: int) -> arb | None:
                t = root.refined(work)
                omega = omega_ball(self.slice_map.radicand, work)
                with ctx.workprec(work):
                    w = self.w(t, omega, sign)
                    value = (self.u(t, omega) + w * self.v(t, omega)) / (self.z(t, omega) * self.unit)
                    exact_enough = value.is_finite() and (
                        value.rel_accuracy_bits() >= bits or value.rad() < arb(2) ** -bits
                    )
                    return value if exact_enough else None

            return decided(attempt, 2 * bits, GREATEST_BITS, "the length of a fold could not be found")

        return square

    @cached_property
    def of_parallelogram(self) -> list[tuple[Algebraic, Place | None]]:
        """S of the singular poses with v = 0, where X turns freely about A_c, and their places, or None for
        all X.

        With V the vector of the moving leg less X, S = s + |V|² + 2 X·V is stationary where X is along V; and
        where these poses meet the others, X is normal to the direction in which v becomes 0.
        """
        if _double(self.n) is None:
            return []
        [root] = exact_roots(norm_factors(self.n))
        t, omega = root.in_field()
        if not self.right(t, omega).is_zero:
            return []
        field, rho = t.field, self.slice_map.rho
        p, q, one = (part(t, omega) for part in self.other)
        over = one.inverse()
        p, q = p * over, q * over
        x, y = (_slope(part)(t, omega) for part in self.vector)
        s = field(fmpq(self.square.numerator, self.square.denominator))
        if p.is_zero and q.is_zero:
            # congruent triangles: all poses of the circle have this length
            return [(s, None)]
        # twice the same if the normal is along V
        ways = [(p, q)] if (p * x + q * y * rho).is_zero else [(p, q), (y * -rho, x)]
        found: list[tuple[Algebraic, Place | None]] = []
        for u, v in ways:
            zero = field(0)
            for turned in adjoin_real_roots(field, [-s * (u * u + v * v * rho).inverse(), zero, zero + 1]):
                lift, w = turned.lift, turned.root
                a, b = lift(u) * w, lift(v) * w
                value = lift(s + p * p + q * q * rho) + (a * lift(p) + b * lift(q) * rho) * 2
                found.append((value, Place(root.root, None, (lift(t), lift(omega), a, b))))
        return found

    def values(self) -> fmpz_poly:
        """A rational polynomial whose roots all values of S are, and others."""
        if self._is_simple:
            roots = self.r
        else:
            product = fmpz_poly([1])
            for factor in norm_factors(self.r):
                product *= factor.polynomial
            roots = QuadraticPoly.rational(product, self.slice_map.radicand)
        rho, z = self.slice_map.rho, self.z * self.unit
        # ρ (S Z − U)² = V² q
        square, linear = z * z * rho, z * self.u * (-2 * rho)
        constant = self.u * self.u * rho - self.v * self.v * self.q
        degree = 2 * roots.degree * (2 if self.slice_map.radicand > 1 else 1)
        found = [_resultant(roots, square * (k * k) + linear * k + constant) for k in range(degree + 1)]
        polynomial = _interpolated(found)
        for x, _ in self.of_parallelogram:
            polynomial *= minimal_polynomial(x).numer()
        return polynomial


def _slope(p: QuadraticPoly) -> QuadraticPoly:
    return QuadraticPoly(p.a.derivative(), p.b.derivative(), p.radicand)


def _double(n: QuadraticPoly) -> QuadraticPoly | None:
    """The factor of a square, else None."""
    slope = _slope(n)
    try:
        n.quotient(slope * slope)
    except DivisionError:
        return None
    return slope


def _without(p: QuadraticPoly, factor: QuadraticPoly) -> QuadraticPoly:
    """A polynomial without a factor, however often it has it; the degree falls in each round."""
    while p.degree >= factor.degree:
        try:
            p = p.quotient(factor)
        except DivisionError:
            break
    return p.primitive()


def _resultant(p: QuadraticPoly, q: QuadraticPoly) -> int:
    """The resultant over ℚ; over ℚ(ω) its norm: a + bω is the matrix of its multiplication."""
    size = p.radicand
    first, second = ([(int(x.a[i]), int(x.b[i])) for i in range(x.degree + 1)] for x in (p, q))
    rows = sylvester(first, second, (0, 0))
    if size == 1:
        return int(fmpz_mat([[a for a, _ in row] for row in rows]).det())
    upper = [[x for a, b in row for x in (a, b * size)] for row in rows]
    lower = [[x for a, b in row for x in (b, a)] for row in rows]
    return int(fmpz_mat([row for pair in zip(upper, lower, strict=True) for row in pair]).det())


def _interpolated(values: Sequence[int]) -> fmpz_poly:
    """A multiple of the polynomial with these values at 0, 1, …, by divided differences."""
    differences = [fmpq(x) for x in values]
    for k in range(1, len(values)):
        for i in range(len(values) - 1, k - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / k
    polynomial = fmpq_poly([])
    for k in reversed(range(len(values))):
        polynomial = polynomial * fmpq_poly([-k, 1]) + differences[k]
    return polynomial.numer()
