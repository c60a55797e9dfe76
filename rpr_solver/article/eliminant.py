"""Steps 1–4 of the article's algorithm: F1, E1, the eliminant of degree 96, and what its factors are.

With t = tan(α/2), u = tan(θ1/2) and h kept symbolic (as a multiple of ω), F1 has degree 4 and E1
degree 12 in both t and u, and the eliminant of t is, up to a constant, for every geometry and L1,

    (u²+1)¹⁸ · q2² · q3² · w⁴ · s² · b1² · b3⁺² · b3⁻² · Q,    96 = 36 + 4 + 4 + 8 + 8 + 4 + 4 + 4 + 24

On a singular pose the adjugate (8) has rank 1, so (10) is the true condition for three coalescing
poses times u1 v1², where u1 and v1 vanish with the adjugate's first row and column; and where a leg
closes, its angle says nothing. All factors but Q are those poses, in closed form:

- q2, q3: leg 2 or leg 3 has length zero;
- w: legs 1 and 3 lie on the line A1A3 (k2 = k4 = 0);
- s: legs 2 and 3 lie on the line A2A3 (k1 = k3 = 0);
- b1: the leg lines meet in B1, legs 2 and 3 along its platform sides (k2 = k5 = 0);
- b3±: the leg lines meet in B3, |A1B3| = |L1 ± d3| (k1 = k4 = 0).

Hence Q holds every cusp: the article's conjecture, and here the reason.

For a flat platform (h = 0) the constraint Jacobian (5) is singular in every pose, (14) follows from
(13), and their resultant is 0. It then matters that h is a symbol until step 5: the eliminant is a
polynomial in h, and the coefficient of its lowest power of h is what remains when h is divided out.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly, nmod_mat, nmod_poly

from rpr_solver.article.equations import Legs, coalescence
from rpr_solver.errors import SolverError
from rpr_solver.exact.modular import formal_resultant, reconstruct, residue, vandermonde
from rpr_solver.exact.quadratic import Pair, primitive_pair
from rpr_solver.model.slice_map import Leg, SliceMap

DEGREE = 96
DEGREE_Q = 24
_RING = fmpz_mpoly_ctx.get(("t", "u", "omega"), "lex")
_T, _U, _OMEGA = _RING.gens()
_ONE_T, _ONE_U = 1 + _T**2, 1 + _U**2
_ZERO = fmpz_poly([])
_Form = tuple[tuple[fmpz_poly, ...], ...]
"""Coefficients of tⁱ, each by powers of ω."""


@dataclass(frozen=True)
class KnownFactor:
    """A factor in closed form: a form in u of this degree, what it is, and why it holds no cusp."""

    pair: Pair
    degree: int
    multiplicity: int
    origin: str
    reason: str
    closed_leg: int | None = None
    """The leg whose length is zero at the roots."""


@dataclass(frozen=True)
class ArticleEliminant:
    """F1 and E1 as forms in t and u, their eliminant, and its factors."""

    slice_map: SliceMap
    length: Fraction
    f1: tuple[Pair, ...]
    e1: tuple[Pair, ...]
    flat: bool
    """h = 0, so that (14) follows from (13) and says nothing."""
    whole: Pair
    known: tuple[KnownFactor, ...]
    q: Pair

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> ArticleEliminant:
        """Steps 1–4 for leg 1 of this scaled length.

        Raises:
            SolverError: the eliminant vanishes identically.
        """
        flat = slice_map.g.n == 0
        f1, e1 = article_forms(slice_map, length)
        whole = _flat_eliminant(slice_map, length) if flat else _eliminant(slice_map, f1, e1)
        if not (whole[0] or whole[1]):
            raise SolverError(
                "the article's eliminant vanishes identically in this slice:"
                " (13) and (14) hold together on a whole curve of poses, and its algorithm gives no answer"
            )
        known = known_factors(slice_map, length)
        q = whole
        for factor in known:
            for _ in range(factor.multiplicity):
                q = _quotient(q, factor.pair, slice_map.radicand)
        return cls(slice_map, length, f1, e1, flat, whole, known, q)


def article_forms(slice_map: SliceMap, length: Fraction) -> tuple[tuple[Pair, ...], tuple[Pair, ...]]:
    """Steps 1 and 2: (13) and (14) by coefficients of t, of degrees 4 and 12, for a scaled L1."""
    f1, e1 = _equations(slice_map, length, slice_map.g.n, slice_map.radicand)
    return _pairs(f1), _pairs(e1)


def _equations(
    slice_map: SliceMap, length: Fraction, height: int, radicand: int | None
) -> tuple[_Form, _Form]:
    """(13) and (14) for B3 at the height ``height`` ω; ω stays a symbol where ``radicand`` is None."""
    n, d = length.numerator, length.denominator
    one = _ONE_T * _ONE_U
    x1, y1 = (1 - _U**2) * _ONE_T * n, 2 * _U * _ONE_T * n
    cos, sin = 1 - _T**2, 2 * _T

    def vector(leg: Leg, height: int) -> tuple[fmpz_mpoly, fmpz_mpoly]:  # (12), times Lᵢ
        x, y = cos * leg.m - sin * height * _OMEGA, sin * leg.m + cos * height * _OMEGA
        return x1 + d * (x * _ONE_U - leg.ax * one), y1 + d * (y * _ONE_U - leg.ay * one)

    def reduced(polynomial: fmpz_mpoly) -> fmpz_mpoly:
        return polynomial if radicand is None else _reduced(polynomial, radicand)

    f, g = slice_map.f, slice_map.g
    legs = Legs(((x1, y1), vector(f, 0), vector(g, height)), d * f.ax, d * g.ax, d * g.ay, one)
    f1 = reduced(legs.singularity) / one
    k = {i: reduced(x) / one for i, x in legs.k.items()}
    h = [[[reduced(x) / one for x in row] for row in m] for m in legs.second_derivatives]
    e1 = reduced(coalescence(k, h)) / one
    return _by_power(f1, 4), _by_power(e1, 12)


def known_factors(slice_map: SliceMap, length: Fraction) -> tuple[KnownFactor, ...]:
    """The closed forms of all factors but Q, for a scaled L1."""
    f, g = slice_map.f, slice_map.g
    n, d = length.numerator, length.denominator
    cos, sin, one = fmpz_poly([1, 0, -1]), fmpz_poly([0, 2]), fmpz_poly([1, 0, 1])

    def closed(leg: Leg) -> Pair:  # |X − a|² = |m|²
        constant = n * n + d * d * (leg.ax**2 + leg.ay**2 - leg.m**2 - leg.n**2 * slice_map.radicand)
        return one * constant - (cos * leg.ax + sin * leg.ay) * (2 * n * d), _ZERO

    side = g.ax - f.ax, g.ay - f.ay
    # B1 is as far from the line A2A3 as from the line B2B3: |B2B3| is the same number of units
    distance = (cos * side[1] - sin * side[0]) * n - one * (d * (f.ax * side[1] - f.ay * side[0]))
    bx, by = g.m - f.m, g.n - f.n  # B2B3; by and the area hold ω
    area2 = (f.m * by - bx * f.n) ** 2 * slice_map.radicand
    platform2 = bx**2 + by**2 * slice_map.radicand
    along = distance * distance * platform2 - one * one * (d * d * area2 * (side[0] ** 2 + side[1] ** 2))

    def angle(dot_m: int, cross_m: int, dot: fmpz_poly, cross: fmpz_poly) -> Pair:
        """Two directed angles are equal modulo 180°; the platform's cross product holds ω."""
        first, second = cross * dot_m, dot * -cross_m
        return (first + second, _ZERO) if slice_map.rational else (first, second)

    # at B1: from A2 and A3 as from B2 and B3
    dot = one * (n * n + d * d * (f.ax * g.ax + f.ay * g.ay))
    dot -= (cos * (f.ax + g.ax) + sin * (f.ay + g.ay)) * (n * d)
    cross = one * (d * d * (f.ax * g.ay - f.ay * g.ax))
    cross -= (cos * (g.ay - f.ay) - sin * (g.ax - f.ax)) * (n * d)
    at_b1 = angle(f.m * g.m + f.n * g.n * slice_map.radicand, f.m * g.n - f.n * g.m, dot, cross)

    # at B3 = ρ e(θ): from A1 and A2 as from B1 and B2, with ρ = L1 ± d3
    d3 = Fraction(g.m**2 + g.n**2 * slice_map.radicand)
    root = Fraction(int(fmpz(d3.numerator).isqrt()))
    dot_m = g.m * bx + g.n * by * slice_map.radicand
    cross_m = g.m * by - g.n * bx

    def at_b3(rho: Fraction) -> Pair:
        p, q = rho.numerator, rho.denominator
        to_a1_a2 = one * p - (cos * f.ax + sin * f.ay) * q
        turn = -(cos * f.ay - sin * f.ax) * q
        return angle(dot_m, cross_m, to_a1_a2, turn)

    def factor(
        pair: Pair, degree: int, multiplicity: int, origin: str, reason: str, closed_leg: int | None = None
    ) -> KnownFactor:
        return KnownFactor(primitive_pair(*pair), degree, multiplicity, origin, reason, closed_leg)

    row, column = "the adjugate's first row vanishes", "the adjugate's first column vanishes"
    collinear = fmpz_poly([g.ay, -2 * g.ax, -g.ay]), _ZERO
    meets = "the three leg lines meet in"
    return (
        factor((one, _ZERO), 2, 18, "circular points", "u² = −1 is no angle"),
        factor(closed(f), 2, 2, "L2 = 0", "leg 2 has length zero", 2),
        factor(closed(g), 2, 2, "L3 = 0", "leg 3 has length zero", 3),
        factor(collinear, 2, 4, "legs 1 and 3 on line A1A3", f"k2 = k4 = 0: {column}"),
        factor((along, _ZERO), 4, 2, "legs 2 and 3 on line A2A3", f"k1 = k3 = 0: {column}"),
        factor(at_b1, 2, 2, f"{meets} B1", f"k2 = k5 = 0: {row}"),
        factor(at_b3(length + root), 2, 2, f"{meets} B3, |A1B3| = L1 + d3", f"k1 = k4 = 0: {column}"),
        factor(at_b3(length - root), 2, 2, f"{meets} B3, |A1B3| = |L1 - d3|", f"k1 = k4 = 0: {column}"),
    )


def _eliminant(slice_map: SliceMap, f1: tuple[Pair, ...], e1: tuple[Pair, ...]) -> Pair:
    """Step 4: Res_t(F1, E1) with formal degrees, from its values modulo primes."""

    def image(p: int, omega: int, _: bool) -> list[int]:
        return _resultant_modulo(f1, e1, p, omega)

    omega = int(fmpz(slice_map.radicand).isqrt()) + 1
    bound = _norm1(f1, omega) ** (len(e1) - 1) * _norm1(e1, omega) ** (len(f1) - 1)
    a, b = reconstruct(slice_map.primes(), image, bound, rational=slice_map.rational)
    return fmpz_poly(a), fmpz_poly(b)


def _flat_eliminant(slice_map: SliceMap, length: Fraction) -> Pair:
    """Step 4 with h a symbol: the coefficient of the lowest power of h in Res_t(F1, E1)."""
    f1, e1 = _equations(slice_map, length, 1, None)
    degree = sum((len(other) - 1) * (max(map(len, form)) - 1) for form, other in ((f1, e1), (e1, f1)))
    heights = range(1, degree + 2)
    lowest = degree + 1

    def image(p: int, _omega: int, _first: bool) -> list[int]:
        nonlocal lowest
        values = [x for height in heights for x in _resultant_modulo(f1, e1, p, height)]
        by_power = vandermonde(heights, p).inv() * nmod_mat(len(heights), DEGREE + 1, values, p)
        rows = [[int(by_power[i, k]) for k in range(DEGREE + 1)] for i in range(len(heights))]
        order = next((i for i, row in enumerate(rows) if any(row)), degree)
        if lowest > degree:
            lowest = order
        elif order < lowest:
            raise SolverError("the first prime divides the lowest coefficient in h; please report this")
        return rows[lowest]

    bound = _norm1(f1, 1) ** (len(e1) - 1) * _norm1(e1, 1) ** (len(f1) - 1)
    a, _ = reconstruct(slice_map.primes(), image, bound, rational=True)
    return fmpz_poly(a), _ZERO


def _resultant_modulo(f1: _Form, e1: _Form, p: int, omega: int) -> list[int]:
    """The coefficients of Res_t(F1, E1) modulo p at one value of ω."""
    points = range(DEGREE + 1)
    first, second = (
        [
            sum((residue(c, p) * pow(omega, k, p) for k, c in enumerate(row)), nmod_poly([0], p))
            for row in form
        ]
        for form in (f1, e1)
    )
    values = [formal_resultant([int(c(u)) for c in first], [int(c(u)) for c in second], p) for u in points]
    return [int(x) for x in (_interpolation(p) * nmod_mat(DEGREE + 1, 1, values, p)).entries()]


@lru_cache(maxsize=2)
def _interpolation(p: int) -> nmod_mat:
    """From the values at 0 … 96 to the coefficients; one prime serves several values of ω."""
    return vandermonde(range(DEGREE + 1), p).inv()


def _norm1(form: _Form, omega: int) -> int:
    """The sum of the absolute values of all coefficients."""
    return sum(abs(int(c)) * omega**k for row in form for k, part in enumerate(row) for c in part.coeffs())


def _quotient(pair: Pair, by: Pair, radicand: int) -> Pair:
    """The quotient over ℚ(ω), primitive.

    Raises:
        SolverError: the division leaves a remainder, against the identity.
    """
    (a, b), (c, d) = pair, by
    if d:
        a, b = a * c - b * d * radicand, b * c - a * d
        c = c * c - d * d * radicand
    c = primitive_pair(c, _ZERO)[0]
    if not c or a % c or b % c:
        raise SolverError("the article's eliminant does not have its known factors; please report this")
    return primitive_pair(a / c, b / c)


def _reduced(polynomial: fmpz_mpoly, radicand: int) -> fmpz_mpoly:
    """With ω² replaced by its value."""
    terms: dict[tuple[int, ...], int | fmpz] = {}
    for (i, k, power), c in polynomial.to_dict().items():
        key = (i, k, 0 if radicand == 1 else power % 2)
        terms[key] = terms.get(key, 0) + c * fmpz(radicand) ** (power // 2)
    return _RING.from_dict(terms)


def _by_power(polynomial: fmpz_mpoly, degree: int) -> _Form:
    """The coefficients of t⁰ … t^degree, each by powers of ω (at least two), in u."""
    terms = polynomial.to_dict()
    powers = max([1, *(omega for _, _, omega in terms)]) + 1
    rows: list[list[dict[int, fmpz]]] = [[{} for _ in range(powers)] for _ in range(degree + 1)]
    for (i, k, omega), c in terms.items():
        rows[i][omega][k] = c
    return tuple(tuple(_univariate(part) for part in row) for row in rows)


def _pairs(form: _Form) -> tuple[Pair, ...]:
    """A form reduced by ω², without its content."""
    content = fmpz(0)
    for row in form:
        for part in row:
            content = content.gcd(part.content())
    divisor = content or fmpz(1)
    return tuple((row[0] / divisor, row[1] / divisor) for row in form)


def _univariate(terms: dict[int, fmpz]) -> fmpz_poly:
    return fmpz_poly([terms.get(k, 0) for k in range(max(terms, default=-1) + 1)])
