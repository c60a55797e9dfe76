"""Poses that balls cannot decide, decided exactly: multiple roots, spurious coincidences, shared curves.

Every candidate becomes a pose over a real number field, where derivatives are zero or not by exact
arithmetic, and is told apart by the conditions of method.md section 2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

from rpr_solver.algebraic import (
    Algebraic,
    Field,
    adjoin_real_roots,
    evaluate,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.errors import SolverError
from rpr_solver.jets import LocalMap, Pose
from rpr_solver.poses import HalfTangent
from rpr_solver.roots import MAX_BITS, RealPolynomial, RealRoot, real_roots
from rpr_solver.shared_curves import Plane
from rpr_solver.surface import Pair, Surface

CUSP = "cusp"
_NOTHING = fmpz_poly([])
_FIRST_BITS, _APART_BITS = 256, 1 << 12


@dataclass(frozen=True)
class NormFactor:
    """An irreducible factor M over ℚ of the norm of A + ω B, and how it divides A + ω B.

    M divides both parts ``common`` times. Where ``extra`` > 0, M = P P̄ splits over ℚ(ω), P divides
    ``extra`` times more, and ω is a polynomial in a root of P, given as ``omega``.
    """

    polynomial: fmpz_poly
    common: int
    extra: int
    omega: fmpq_poly | None

    @property
    def shape(self) -> list[tuple[int, int]]:
        """(degree, multiplicity) of the factors of A + ω B that M stands for."""
        degree = int(self.polynomial.degree())
        if not self.extra:
            return [(degree, self.common)]
        parts = [(degree // 2, self.common + self.extra), (degree // 2, self.common)]
        return [part for part in parts if part[1]]


@dataclass(frozen=True)
class ExactRoot:
    """A real root u of the eliminant, as a root of an irreducible rational polynomial.

    ``omega`` is ω as a polynomial in u where u determines it, else None.
    """

    root: RealRoot
    multiplicity: int
    omega: fmpq_poly | None


@dataclass(frozen=True)
class ExactPose:
    """A classified pose, exact: tan(α/2), or None at α = 180°, tan(θ/2), and f, g in one field."""

    kind: str
    t: Algebraic | None
    u: Algebraic
    theta_offset: int
    f: Algebraic
    g: Algebraic
    surface: Surface

    def coordinates(self, bits: int) -> tuple[arb, arb, arb, arb]:
        """α and θ in degrees and the two free lengths in the user's unit, as balls."""
        u, f, g = (x.ball(bits) for x in (self.u, self.f, self.g))
        with ctx.workprec(bits):
            alpha = arb(180) if self.t is None else HalfTangent(self.t.ball(bits), arb(1)).degrees()
            theta = HalfTangent(u, arb(1)).degrees(self.theta_offset)
            scale = self.surface.scale_ball()
            lengths = [arb(0) if x.is_zero else b.sqrt() / scale for x, b in ((self.f, f), (self.g, g))]
            return alpha, theta, lengths[0], lengths[1]

    def exact_lengths(self) -> tuple[Fraction | None, Fraction | None]:
        """The two free lengths in the user's unit where they are rational, else None."""
        first, second = (_rational_sqrt(x.rational) for x in (self.f, self.g))
        scale = self.surface.scale
        return first and first / scale, second and second / scale


def norm_factors(pair: Pair, radicand: int) -> list[NormFactor]:
    """The factors of A + ω B, found by factoring A² − ω² B² over ℚ."""
    return [_norm_factor(pair, *factor) for factor in _irreducible(_norm(pair, radicand))]


def simple_and_other_roots(pair: Pair, radicand: int) -> tuple[list[RealRoot], list[ExactRoot]]:
    """The real roots of A + ω B that are simple even in the norm, and the others.

    Only the others need irreducible factors, which for a norm of high degree take long.
    """
    simple: list[RealRoot] = []
    factors = []
    for power, exponent in _norm(pair, radicand).factor_squarefree()[1]:
        if exponent == 1:
            roots = real_roots(RealPolynomial(power, _NOTHING, 1))
            simple += (root for root in roots if _is_root(pair, radicand, root))
        else:
            factors += [_norm_factor(pair, factor, exponent) for factor, _ in power.factor()[1]]
    return simple, list(exact_roots(factors))


def exactly(roots: Sequence[RealRoot], pair: Pair, radicand: int) -> list[ExactRoot]:
    """Some of the real roots of A + ω B, exactly; no other factor of the norm is looked at."""
    balls = [root.refined(_APART_BITS) for root in roots]

    def wanted(root: RealRoot) -> bool:
        own = root.refined(_APART_BITS)
        return any(own.overlaps(ball) for ball in balls)

    factors = [
        _norm_factor(pair, factor, exponent)
        for factor, exponent in _irreducible(_norm(pair, radicand))
        if any(map(wanted, real_roots(RealPolynomial(factor, _NOTHING, 1))))
    ]
    found = [root for root in exact_roots(factors) if wanted(root.root)]
    if len(found) != len(roots):
        raise SolverError("a root was lost between balls and exact arithmetic")
    return found


def _norm(pair: Pair, radicand: int) -> fmpz_poly:
    a, b = pair
    return a * a - radicand * b * b if b else a


def _irreducible(norm: fmpz_poly) -> Iterator[tuple[fmpz_poly, int]]:
    """The irreducible factors with their exponents."""
    for power, exponent in norm.factor_squarefree()[1]:
        yield from ((factor, exponent) for factor, _ in power.factor()[1])


def _is_root(pair: Pair, radicand: int, root: RealRoot) -> bool:
    """Whether a simple root of the norm is one of A + ω B, and not of A − ω B."""
    a, b = pair
    if not b:
        return True
    bits = _FIRST_BITS
    while bits <= MAX_BITS:
        u = root.refined(bits)
        with ctx.workprec(bits):
            own, other = (RealPolynomial(a, part, radicand).ball(bits)(u) for part in (b, -b))
            if own.contains(0) != other.contains(0):
                return bool(own.contains(0))
        bits *= 2
    raise SolverError("a root could not be told from its conjugate")


def _norm_factor(pair: Pair, factor: fmpz_poly, exponent: int) -> NormFactor:
    a, b = pair
    if not b:
        return NormFactor(factor, exponent, 0, None)
    common = 0
    while not a % factor and not b % factor:
        a, b, common = a / factor, b / factor, common + 1
    extra = exponent - 2 * common
    omega = None
    if extra:
        modulus = fmpq_poly(factor)
        _, inverse, _ = (fmpq_poly(b) % modulus).xgcd(modulus)
        omega = -(fmpq_poly(a) * inverse) % modulus
    return NormFactor(factor, common, extra, omega)


def exact_roots(factors: list[NormFactor]) -> Iterator[ExactRoot]:
    """The real roots u ≠ ∞ of A + ω B with their multiplicities."""
    for factor in factors:
        for root in real_roots(RealPolynomial(factor.polynomial, _NOTHING, 1)):
            omega = factor.omega
            if omega is not None and Algebraic(Field.of_root(root), omega).sign < 0:
                omega = None  # a root of the conjugate P̄
            if multiplicity := factor.common + (factor.extra if omega is not None else 0):
                yield ExactRoot(root, multiplicity, omega)


def poses_above(
    surface: Surface, length: Fraction, plane: Plane, root: ExactRoot, *, theta_offset: int = 0
) -> Iterator[ExactPose]:
    """All real poses with J = E = 0 at one root u, classified; ordinary singular poses are left out.

    With ``theta_offset`` 180 the surface is turned by half a turn, so that u = 0 is θ = 180°;
    ``length`` is then −L.
    """
    for u, omega in embedded(surface, root):
        yield from _poses(surface, length, plane, u, omega, theta_offset)


def embedded(surface: Surface, root: ExactRoot) -> Iterator[tuple[Algebraic, Algebraic]]:
    """The root and ω as elements of one real field (exactly one pair)."""
    field = Field.of_root(root.root)
    if root.omega is not None:
        yield field.generator, field(root.omega)
    elif surface.rational:
        yield field.generator, field(1)
    else:
        square = [field(-surface.radicand), field(0), field(1)]
        for extension in adjoin_real_roots(field, square):
            if extension.root.sign > 0:
                yield extension.generator, extension.root


def poses_at_half_turn(surface: Surface, length: Fraction, turned: Plane) -> Iterator[ExactPose]:
    """The poses with J = E = 0 at θ = 180° exactly, where u is infinite; ``turned`` belongs to −L."""
    zero = real_roots(RealPolynomial(fmpz_poly([0, 1]), _NOTHING, 1))[0]
    return poses_above(surface, -length, turned, ExactRoot(zero, 1, None), theta_offset=180)


def _poses(
    surface: Surface, length: Fraction, plane: Plane, u: Algebraic, omega: Algebraic, theta_offset: int
) -> Iterator[ExactPose]:
    j, e = ([value_at(pair, u, omega) for pair in form] for form in (plane.singular, plane.coalescence))
    if j[-1].is_zero and e[-1].is_zero:
        yield from _classified(surface, length, plane, None, u, omega, theta_offset)
    common = poly_gcd(trimmed(j), trimmed(e))
    if not common:
        raise SolverError("the singular curve holds a whole line theta = const")
    if len(common) == 1:
        return
    for extension in adjoin_real_roots(u.field, squarefree_part(common)):
        yield from _classified(
            surface, length, plane, extension.root, extension.lift(u), extension.lift(omega), theta_offset
        )


def _classified(
    surface: Surface,
    length: Fraction,
    plane: Plane,
    t: Algebraic | None,
    u: Algebraic,
    omega: Algebraic,
    theta_offset: int,
) -> Iterator[ExactPose]:
    if any(curve.holds(t, u) for curve in plane.shared):
        return
    field = u.field
    cos_a, sin_a = (field(-1), field(0)) if t is None else cos_sin(t)
    cos_t, sin_t = cos_sin(u)
    pose = Pose(cos_a, sin_a, cos_t, sin_t, field(length), omega)
    local = LocalMap.at(surface, pose, 4)
    kind = classify(surface, pose, local)
    if kind is not None:
        f, g = local.squared_lengths(surface, pose)
        yield ExactPose(kind, t, u, theta_offset, f, g, surface)


def classify(surface: Surface, pose: Pose[Algebraic], local: LocalMap[Algebraic]) -> str | None:
    """The name of the pose, or None if it is an ordinary singular pose (or not singular at all)."""
    gradients = {leg: (leg.alpha.value, leg.theta.value) for leg in (local.f, local.g)}
    regular = [leg for leg, slopes in gradients.items() if not all(x.is_zero for x in slopes)]
    if not regular:
        return "quadruple" if _hessians_independent(local) else "higher"
    leg = regular[0]
    j = local.singularity()
    if not j.value.is_zero:
        return None
    e = local.along(leg, j)
    if not e.value.is_zero:
        return None
    second = local.along(leg, e)
    if j.alpha.value.is_zero and j.theta.value.is_zero:
        aa, at, tt = j.alpha.alpha.value, j.alpha.theta.value, j.theta.theta.value
        hessian = (aa * tt - at * at).sign
        # J is L (J0 + L J1); with J = 0, its value at twice the length is a multiple of J1
        doubled = replace(pose, length=pose.length * 2)
        moves = not LocalMap.at(surface, doubled, 1).singularity().value.is_zero
        generic = moves and not second.value.is_zero
        if hessian > 0:
            return "lips" if generic else "isolated-point"
        if hessian < 0:
            return "beak-to-beak" if generic else "node"
        return "higher"
    if not second.value.is_zero:
        return CUSP
    return "swallowtail" if not local.along(leg, second).value.is_zero else "higher"


def _hessians_independent(local: LocalMap[Algebraic]) -> bool:
    """Whether the quadratic parts of f and g have no common zero: then exactly 4 poses coalesce."""
    f, g = (
        (leg.alpha.alpha.value, leg.alpha.theta.value * 2, leg.theta.theta.value)
        for leg in (local.f, local.g)
    )
    crossed = [f[i] * g[k] - f[k] * g[i] for i, k in ((0, 2), (0, 1), (1, 2))]
    return not (crossed[0] * crossed[0] - crossed[1] * crossed[2]).is_zero


def value_at(pair: Pair, u: Algebraic, omega: Algebraic) -> Algebraic:
    """A + ω B at u, exactly."""
    a, b = ([u.field(fmpq(c)) for c in part.coeffs()] for part in pair)
    total = evaluate(a, u)
    return total + evaluate(b, u) * omega if b else total


def cos_sin(half: Algebraic) -> tuple[Algebraic, Algebraic]:
    """Cosine and sine of the angle whose half has this tangent."""
    square = half * half
    norm = (square + 1).inverse()
    return (-square + 1) * norm, half * 2 * norm


def _rational_sqrt(x: Fraction | None) -> Fraction | None:
    if x is None or x < 0:
        return None
    n, d = fmpz(x.numerator), fmpz(x.denominator)
    if not (n.is_square() and d.is_square()):
        return None
    return Fraction(int(n.isqrt()), int(d.isqrt()))
