"""The poses at which cusps are born or die as the fixed leg's length L passes (method.md section 5).

J is linear in L: J = J0 + L J1, so L = −J0/J1 on the singularity slice_map, and a degenerate pose is an
isolated point of the torus (α, θ):

- ∇J = 0 (lips, beak-to-beak): M1 = M2 = 0, the Wronskians of J0 and J1 in α and in θ;
- v·∇E = 0 (swallowtail): C = W = 0, where E = F_θ C / J1² and v·∇E = J0 F_θ² W / J1³ with L put in.

In half tangents (t, u) their bidegrees are (6, 6), (6, 6), (10, 8) and (8, 8). With all degrees formal,

    Res_t(C, W)   = (u²+1)¹⁶ · Y⁴ · P,    144 = 32 + 48 + 64
    Res_t(M1, M2) = (u²+1)¹⁰ · Z · P,      72 = 20 + 16 + 36

where Z = Res_t(J0, J1) / (u²+1)² belongs to the poses that are singular for every L, and
Y = Z / A, A = Res_t(F_θ, G_θ) / (u²+1)² for those of them with three parallel legs. P is what remains.
These are identities in the parameters; a spare point checks them modulo each prime.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import count, islice

from flint import fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly, nmod_mat, nmod_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.modular import formal_resultant, pair_residue, reconstruct, vandermonde
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.quadratic import Pair, univariate
from rpr_solver.exact.real_roots import RealPolynomial
from rpr_solver.model.slice_map import TRIG, BiForm, Leg, SliceMap, d_alpha, d_theta, half_angles, slopes
from rpr_solver.transitions.shared_angles import SharedAngles, constant_lengths

_RING = fmpz_mpoly_ctx.get(("t", "u", "omega"), "lex")
_OMEGA = _RING.gen(2)
ELIMINATION_STEPS = 4
"""How many steps :meth:`EventSystems.of` reports."""


class NotGeneric(Exception):  # noqa: N818 - a signal between modules; no error of the user's
    """An eliminant vanishes identically: the events of this geometry are not all isolated."""


@dataclass(frozen=True)
class Form:
    """A form A(u) + ω B(u) of formal degree ``degree``: a lower actual degree is a zero at u = ∞."""

    pair: Pair
    degree: int

    def real(self, radicand: int) -> RealPolynomial:
        """The form as a polynomial with real coefficients."""
        return RealPolynomial(*self.pair, radicand)


@dataclass(frozen=True)
class System:
    """Two forms in (t, u) whose common zeros are events, and their eliminant P(u)."""

    first: BiForm
    second: BiForm
    eliminant: Form


@dataclass(frozen=True)
class EventSystems:
    """Everything about events that depends on the geometry only."""

    slice_map: SliceMap
    j0: BiForm
    j1: BiForm
    swallowtails: System
    critical: System
    beside: tuple[System, ...]
    """Where cusps may meet poses that are degenerate along a whole angle α."""
    levels: tuple[Algebraic, ...]
    """The lengths (scaled) at which all poses of an angle α have ∇J = 0."""
    permanent: Form
    """Z(u): the poses that are singular for every L."""
    not_parallel: Form
    """Y(u): those of them without three parallel legs."""

    @classmethod
    def of(cls, slice_map: SliceMap, progress: Callable[[int, int], None] | None = None) -> EventSystems:
        """Derive and eliminate; ``progress`` is told the steps done and their number.

        Raises:
            NotGeneric: an eliminant vanishes identically.
        """
        trig = _Trig.of(slice_map)
        j0, j1 = trig.form(trig.j0, (2, 1)), trig.form(trig.j1, (1, 2))
        f_theta, g_theta = (trig.form(slopes(leg)[1], (1, 1)) for leg in (slice_map.f, slice_map.g))
        m1, m2 = (trig.form(trig.j0 * d(trig.j1) - trig.j1 * d(trig.j0), (3, 3)) for d in (d_alpha, d_theta))
        c, w = _swallowtail_forms(trig, j0, f_theta)
        _report(progress, 1)
        parallel = _eliminate(slice_map, f_theta, g_theta, 2)
        permanent = _eliminate(slice_map, j0, j1, 2)
        y = _form_quotient(permanent, parallel, slice_map.radicand)
        _report(progress, 2)
        critical, angles = _system(slice_map, m1, m2, 10, permanent, 1)
        levels = () if angles is None else tuple(constant_lengths(slice_map, j0, j1, angles))
        _report(progress, 3)
        swallowtails, angles = _system(slice_map, c, w, 16, y, 4)
        beside = () if angles is None else (_beside(slice_map, swallowtails.first, angles),)
        _report(progress, 4)
        return cls(slice_map, j0, j1, swallowtails, critical, beside, levels, permanent, y)


def _system(
    slice_map: SliceMap, first: BiForm, second: BiForm, circular: int, known: Form, exponent: int
) -> tuple[System, BiForm | None]:
    """Two forms and their eliminant, without the angles α that they share, and these angles.

    Raises:
        NotGeneric: they share more than that.
    """
    try:
        return System(first, second, _eliminate(slice_map, first, second, circular, known, exponent)), None
    except NotGeneric:
        shared = SharedAngles.of(slice_map, first, second)
        if shared is None:
            raise
        first, second = shared.first, shared.second
        return System(first, second, _eliminate(slice_map, first, second, 0)), shared.angles


def _beside(slice_map: SliceMap, cusps: BiForm, angles: BiForm) -> System:
    return System(cusps, angles, _eliminate(slice_map, cusps, angles, 0))


def limit_system(systems: EventSystems, leg: Leg, square: Fraction) -> System:
    """Where a cusp has the squared free leg ``square`` (scaled): C and (f − square) J1², L put in.

    Their eliminant of t is (u²+1)²⁰ · (Y Z)² · P, with P of degree 48; where C was divided by angles that
    it shares, it is taken as it is.

    Raises:
        NotGeneric: the eliminant vanishes identically.
    """
    slice_map = systems.slice_map
    trig = _Trig.of(slice_map)
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    x, y = leg.m * cos_a - leg.n * omega * sin_a, leg.m * sin_a + leg.n * omega * cos_a
    both = cos_t * x + sin_t * y - leg.ax * cos_t - leg.ay * sin_t
    constant = leg.m**2 + leg.n**2 * slice_map.radicand + leg.ax**2 + leg.ay**2
    n, d = square.numerator, square.denominator
    on_surface = (
        d * trig.j0**2
        - 2 * d * trig.j0 * trig.j1 * both
        + trig.j1**2 * (d * constant - n - 2 * d * (leg.ax * x + leg.ay * y))
    )
    form = trig.form(on_surface, (4, 4))
    cusps = systems.swallowtails.first
    if systems.beside:
        return System(cusps, form, _eliminate(slice_map, cusps, form, 0))
    known = _form_product(systems.permanent, systems.not_parallel, slice_map.radicand)
    return System(cusps, form, _eliminate(slice_map, cusps, form, 20, known, 2))


@dataclass(frozen=True)
class _Trig:
    """J and E as polynomials in cosines, sines and ω, by powers of L."""

    slice_map: SliceMap
    j0: fmpz_mpoly
    j1: fmpz_mpoly
    e: tuple[fmpz_mpoly, ...]
    along_e: tuple[fmpz_mpoly, ...]

    @classmethod
    def of(cls, slice_map: SliceMap) -> _Trig:
        radicand = slice_map.radicand
        j, e = (_reduced(p, radicand) for p in slice_map.trigonometric)
        f_alpha, f_theta = slopes(slice_map.f)
        along_e = _reduced(f_alpha * d_theta(e) - TRIG.gen(4) * f_theta * d_alpha(e), radicand)
        j0, j1 = _by_length(j, 1)
        return cls(slice_map, j0, j1, _by_length(e, 2), _by_length(along_e, 3))

    def form(self, p: fmpz_mpoly, orders: tuple[int, int]) -> BiForm:
        """A polynomial without L as a primitive form in t and u.

        Raises:
            NotGeneric: it vanishes identically.
        """
        if not p:
            raise NotGeneric
        form = half_angles(_reduced(p, self.slice_map.radicand), orders, self.slice_map.radicand)
        return _primitive([row[0] for row in form.coefficients], form.degree_u)

    def on_surface(self, coefficients: Sequence[fmpz_mpoly]) -> fmpz_mpoly:
        """Σ cₖ Lᵏ with L = −J0/J1, times J1 to the degree."""
        top = len(coefficients) - 1
        total = TRIG.gen(0) * 0
        for k, c in enumerate(coefficients):
            total += c * (-self.j0) ** k * self.j1 ** (top - k)
        return total


def _report(progress: Callable[[int, int], None] | None, done: int) -> None:
    if progress is not None:
        progress(done, ELIMINATION_STEPS)


def _swallowtail_forms(trig: _Trig, j0: BiForm, f_theta: BiForm) -> tuple[BiForm, BiForm]:
    """C and W."""
    radicand = trig.slice_map.radicand
    e = _joined(trig.form(trig.on_surface(trig.e), (6, 5)))
    along_e = _joined(trig.form(trig.on_surface(trig.along_e), (8, 7)))
    s, j = _joined(f_theta), _joined(j0)
    if not (e and along_e and s and j):
        raise NotGeneric
    c = _divided(e, s, radicand)
    w = _divided(_divided(_divided(along_e, s, radicand), s, radicand), j, radicand)
    return _primitive(_rows(c, 10), 8), _primitive(_rows(w, 8), 8)


def _eliminate(
    slice_map: SliceMap,
    first: BiForm,
    second: BiForm,
    circular: int,
    known: Form | None = None,
    exponent: int = 0,
) -> Form:
    """Res_t(first, second) / ((u²+1)^circular · known^exponent), primitive.

    The quotient is multiplied by the conjugate of ``known``, so that only a primitive rational
    polynomial is divided by, and the coefficients stay in ℤ[ω].

    Raises:
        NotGeneric: the resultant vanishes identically.
    """
    grid = _LineGrid.of(slice_map, first, second, circular, known, exponent)
    a, b = reconstruct(slice_map.primes(), grid.image, grid.bound(), rational=slice_map.rational)
    if not (any(a) or any(b)):
        raise NotGeneric
    return Form((fmpz_poly(a), fmpz_poly(b)), grid.degree)


@dataclass(frozen=True, eq=False)
class _LineGrid:
    """The points u at which a resultant is taken and its known factors are divided out."""

    slice_map: SliceMap
    first: BiForm
    second: BiForm
    circular: int
    exponent: int
    degree: int
    conjugate: Pair
    norm: fmpz_poly
    us: tuple[int, ...]

    @classmethod
    def of(
        cls,
        slice_map: SliceMap,
        first: BiForm,
        second: BiForm,
        circular: int,
        known: Form | None,
        exponent: int,
    ) -> _LineGrid:
        degree = first.degree_t * second.degree_u + second.degree_t * first.degree_u - 2 * circular
        conjugate, norm = (fmpz_poly([1]), fmpz_poly([])), fmpz_poly([1])
        if known is not None:
            degree -= exponent * known.degree
            a, b = known.pair
            norm = a * a - slice_map.radicand * b * b if b else a
            conjugate = (a, -b) if b else conjugate
            norm = norm / norm.content()
        # the last point is a spare one, to check the known factors
        us = tuple(islice((u for u in count(2) if norm(u) != 0), degree + 2))
        return cls(slice_map, first, second, circular, exponent, degree, conjugate, norm, us)

    def bound(self) -> int:
        """A bound on the coefficients, by Mahler measures as in eliminant.py."""
        omega = int(fmpz(self.slice_map.radicand).isqrt()) + 1
        conjugate = sum(
            abs(int(c)) * weight
            for part, weight in zip(self.conjugate, (1, omega), strict=True)
            for c in part.coeffs()
        )
        first, second = self.first.norm1(omega), self.second.norm1(omega)
        size: int = first**self.second.degree_t * second**self.first.degree_t * conjugate**self.exponent
        return size << self.degree

    def image(self, p: int, omega: int, _first: bool) -> list[int] | None:
        """The coefficients modulo p; None if p divides a known factor at a point."""
        divisors = [
            int(self.norm(u) ** self.exponent * fmpz(u * u + 1) ** self.circular % p) for u in self.us
        ]
        if not all(divisors):
            return None
        first, second = (_residues(form, p, omega) for form in (self.first, self.second))
        conjugate = pair_residue(*self.conjugate, p, omega)
        values = []
        for u, divisor in zip(self.us, divisors, strict=True):
            resultant = formal_resultant([int(c(u)) for c in first], [int(c(u)) for c in second], p)
            values.append(resultant * pow(int(conjugate(u)), self.exponent, p) * pow(divisor, -1, p) % p)
        *used, expected = values
        n = len(used)
        result = _inverse_vandermonde(self.us[:-1], p) * nmod_mat(n, 1, used, p)
        coefficients = [int(x) for x in result.entries()]
        if int(nmod_poly(coefficients, p)(self.us[-1])) != expected:
            raise SolverError(
                "an eliminant of the census lacks its known factors; please report this geometry"
            )
        return coefficients


@lru_cache(maxsize=2)
def _inverse_vandermonde(us: tuple[int, ...], p: int) -> nmod_mat:
    return vandermonde(us, p).inv()


def _residues(form: BiForm, p: int, omega: int) -> list[nmod_poly]:
    return [pair_residue(*row[0], p, omega) for row in form.coefficients]


def _reduced(p: fmpz_mpoly, radicand: int) -> fmpz_mpoly:
    """With sin² = 1 − cos² and ω² = radicand, so that the degree is the true one."""
    cos_a, _, cos_t, _, _, _ = TRIG.gens()
    total = TRIG.gen(0) * 0
    for (i, j, k, m, power, w), c in p.to_dict().items():
        term = TRIG.from_dict({(i, j % 2, k, m % 2, power, w % 2): c * fmpz(radicand) ** (w // 2)})
        total += term * (1 - cos_a**2) ** (j // 2) * (1 - cos_t**2) ** (m // 2)
    return total


def _by_length(p: fmpz_mpoly, top: int) -> tuple[fmpz_mpoly, ...]:
    """The coefficients of L⁰ … L^top."""
    rows: list[dict[tuple[int, ...], int | fmpz]] = [{} for _ in range(top + 1)]
    for (i, j, k, m, power, w), c in p.to_dict().items():
        rows[power][i, j, k, m, 0, w] = c
    return tuple(TRIG.from_dict(row) for row in rows)


def _joined(form: BiForm) -> fmpz_mpoly:
    terms: dict[tuple[int, ...], int | fmpz] = {
        (i, k, w): c
        for i, row in enumerate(form.coefficients)
        for w, part in enumerate(row[0])
        for k, c in enumerate(part.coeffs())
        if c
    }
    return _RING.from_dict(terms)


def _rows(p: fmpz_mpoly, degree_t: int) -> list[Pair]:
    parts: list[tuple[dict[int, fmpz], dict[int, fmpz]]] = [({}, {}) for _ in range(degree_t + 1)]
    for (i, k, w), c in p.to_dict().items():
        parts[i][w][k] = c

    return [(univariate(a), univariate(b)) for a, b in parts]


def _primitive(rows: Sequence[Pair], degree_u: int) -> BiForm:
    content = fmpz(0)
    for pair in rows:
        for part in pair:
            content = content.gcd(part.content())
    if content > 1:
        rows = [(a / content, b / content) for a, b in rows]
    return BiForm(len(rows) - 1, degree_u, tuple((row,) for row in rows))


def _divided(p: fmpz_mpoly, q: fmpz_mpoly, radicand: int) -> fmpz_mpoly:
    """p / q over ℚ(ω), up to a rational factor; q must divide p."""
    conjugate = q.compose(*_RING.gens()[:2], -_OMEGA)
    norm = _omega_reduced(q * conjugate, radicand).primitive()[1]
    quotient: fmpz_mpoly = _omega_reduced(p * conjugate, radicand) / norm
    return quotient


def _omega_reduced(p: fmpz_mpoly, radicand: int) -> fmpz_mpoly:
    terms: dict[tuple[int, ...], int | fmpz] = {}
    for (i, k, w), c in p.to_dict().items():
        key = (i, k, w % 2)
        terms[key] = terms.get(key, 0) + c * fmpz(radicand) ** (w // 2)
    return _RING.from_dict(terms)


def _form_quotient(p: Form, q: Form, radicand: int) -> Form:
    """p / q, up to a rational factor; q must divide p."""
    dividend, divisor = (_joined(BiForm(0, form.degree, ((form.pair,),))) for form in (p, q))
    [pair] = _rows(_divided(dividend, divisor, radicand), 0)
    return Form(pair, p.degree - q.degree)


def _form_product(p: Form, q: Form, radicand: int) -> Form:
    (a, b), (c, d) = p.pair, q.pair
    return Form((a * c + radicand * (b * d), a * d + b * c), p.degree + q.degree)
