"""The poses at which cusps are born or vanish as the fixed leg's length L varies.

J / L is linear in L: J0 + L J1, so L = −J0/J1 on the singularity surface, and a degenerate pose is an
isolated point of the torus (α, θ):

- ∇J = 0 (lips, beak-to-beak): M1 = M2 = 0, the Wronskians of J0 and J1 in α and in θ;
- v·∇E = 0 (swallowtail): C = W = 0, where E = F_θ C / J1² and v·∇E = J0 F_θ² W / J1³ for this L
  (mathematics.md#the-surface-of-singular-poses).

With the length −L the fixed leg has the same end as in the direction θ + π. So all these are polynomials in
t = tan(α/2) and v = tan θ, where each v stands for two directions, of which L > 0 picks one. Their bidegrees
are (6, 3), (6, 3), (10, 4) and (8, 4). With all degrees formal,

    Res_t(C, W)   = (v²+1)⁸ · Y⁴ · P,    72 = 16 + 24 + 32
    Res_t(M1, M2) = (v²+1)⁵ · Z · P,     36 = 10 + 8 + 18

where the roots of Z = Res_t(J0, J1) / (v²+1) are the poses that are singular for every L, those of
A = Res_t(F_θ, G_θ) / (v²+1) are the ones among them with three parallel legs, Y = Z / A, and P is the
quotient. These are identities in the parameters (mathematics.md#the-eliminants-of-the-census).

For some symmetric and right-angled manipulators all poses of one α (mostly 0 or 180 degrees) are degenerate
at their L, or all of them have ∇J = 0 at the same L (mathematics.md#shared-angles). Such angles, at which two
forms in (t, v) vanish for every v, are found and divided out.

An event is such a length of the fixed leg, with its degenerate poses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Protocol

from flint import arb, ctx, fmpz, fmpz_mpoly, fmpz_poly

from rpr_solver.contract import Progress, silent
from rpr_solver.errors import ControlFlow, Unproved
from rpr_solver.exact import decided
from rpr_solver.exact.biform import RING, BiForm, scale
from rpr_solver.exact.decimals import digit_bits, round_all, round_fraction
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.factors import NormFactor, norm_factors
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    exact_omega,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.precision import EXACT_BITS, GREATEST_BITS, TIMES_BEFORE_EXACT
from rpr_solver.exact.quadratic import DivisionError, Form, QuadraticPoly
from rpr_solver.model.joint_points import ExactPose, JointPoint, PoseKind, joint_point, point_of_pose
from rpr_solver.model.slice_map import (
    TRIG,
    Leg,
    SliceMap,
    d_alpha,
    d_theta,
    excess,
    in_tangents,
    reduced,
    slopes,
)

Coordinates = tuple[arb, arb, arb, arb]
"""α and θ in degrees, and the free legs in the user's unit."""


@dataclass(frozen=True)
class BallPose:
    """The degenerate pose of an event: its kind, and its coordinates as balls at a precision in bits."""

    kind: PoseKind
    coordinates: Callable[[int], Coordinates]
    exact: Callable[[], ExactPose]
    """The same pose in a number field."""


class Event(Protocol):
    """A length L at which the number of cusps may change (scaled units)."""

    @property
    def pose(self) -> ExactPose | BallPose | None:
        """The degenerate pose; None if only the length is known."""

    @property
    def exact_length(self) -> Algebraic | None:
        """L (scaled) as an algebraic number, or None if it is only known by balls."""

    @property
    def lasting(self) -> bool:
        """Whether neighbouring slices have a degenerate pose of the same kind beside this one."""

    @property
    def change(self) -> int | None:
        """By how much the number of cusps changes here as L grows; None if that is not proved.

        If 0, no pose is degenerate.
        """

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""


@dataclass(frozen=True)
class Landmark:
    """A length, exact, at which the number of cusps may change, with its degenerate pose if one is known."""

    exact_length: Algebraic
    pose: ExactPose | None = None
    lasting: bool = False
    change: int | None = None

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self.exact_length.ball(bits)


def length_text(slice_map: SliceMap, group: Sequence[Event], digits: int) -> str:
    """The length of simultaneous events as a correctly rounded decimal in the user's unit."""
    for event in group:
        if event.exact_length is not None and event.exact_length.rational is not None:
            return round_fraction(event.exact_length.rational / slice_map.scale, digits)

    def length(bits: int) -> list[arb]:
        ball = group[0].scaled_length(bits)
        with ctx.workprec(bits):
            return [ball / slice_map.scale_ball()]

    return _rounded(length, digits, GREATEST_BITS)[0]


def event_point(pose: ExactPose | BallPose, fixed_leg: int, digits: int) -> JointPoint:
    """The degenerate pose of an event."""
    if isinstance(pose, ExactPose):
        return point_of_pose(pose, digits).point
    try:
        # beside a special shape, angles and lengths are tiny
        limit = max(TIMES_BEFORE_EXACT * digit_bits(digits), EXACT_BITS)
        texts = _rounded(pose.coordinates, digits, limit)
        return joint_point(texts, fixed_leg)
    except Unproved:
        return point_of_pose(pose.exact(), digits).point


def _rounded(balls: Callable[[int], Sequence[arb]], digits: int, limit: int) -> list[str]:
    def texts(bits: int) -> list[str] | None:
        values = balls(bits)
        with ctx.workprec(bits):
            return round_all(values, digits)

    return decided(texts, digit_bits(digits) + 128, limit, "the digits of a transition could not be decided")


@dataclass(frozen=True)
class SharedAngles:
    """Two forms divided by the angles that they shared, and these angles as the zeros of a form in t."""

    first: BiForm
    second: BiForm
    angles: BiForm

    @classmethod
    def of(cls, first: BiForm, second: BiForm) -> SharedAngles | None:
        """Divides both forms by every power of the shared angles; None if they share none."""
        omega = exact_omega(first.radicand)
        common: Polynomial = []
        for column in (*_columns(first, omega), *_columns(second, omega)):
            common = poly_gcd(common, trimmed(column))
        finite = squarefree_part(common)
        at_infinity = bool(first.zeros_at_infinity and second.zeros_at_infinity)
        if len(finite) == 1 and not at_infinity:
            return None
        angles = _form(finite, first.radicand)
        divided = [_without(form, angles) for form in (first, second)]
        if at_infinity:
            angles = replace(angles, degree_t=angles.degree_t + 1)
            divided = [replace(x, degree_t=x.degree_t - x.zeros_at_infinity) for x in divided]
        return cls(divided[0], divided[1], angles)


def _without(form: BiForm, angles: BiForm) -> BiForm:
    """Divided by all powers of a form that divide."""
    if not angles.degree_t:
        return form
    while True:
        try:
            form = form.quotient(angles)
        except DivisionError:
            return form


def _columns(form: BiForm, omega: Algebraic) -> list[list[Algebraic]]:
    """For each power of v the coefficients of t⁰, t¹, …"""
    return [[row.coefficient(k, omega) for row in form.rows] for k in range(form.degree_u + 1)]


def _form(polynomial: Polynomial, radicand: int) -> BiForm:
    """A polynomial in t over ℚ(ω) as a form, up to a rational factor."""
    unit = lcm(*(int(c.poly.denom()) for c in polynomial))
    a, b = (
        RING.from_dict({(i, 0, 0, 0): (c.poly[part] * unit).p for i, c in enumerate(polynomial)})
        for part in (0, 1)
    )
    return BiForm(a, b, radicand, len(polynomial) - 1, 0)


ELIMINATION_STEPS = 4
"""The number of progress steps of :meth:`EventSystems.of`."""


class NotGeneric(ControlFlow):
    """An eliminant vanishes identically: not all events of this geometry are isolated."""


@dataclass(frozen=True)
class Limit:
    """A leg and its squared length at a joint limit (scaled)."""

    leg: Leg
    square: Fraction


@dataclass(frozen=True, eq=False)
class System:
    """Two forms in t and v = tan θ/√ρ whose common zeros are events, and their eliminant P(v)."""

    slice_map: SliceMap
    first: BiForm
    second: BiForm
    eliminant: Form
    limit: Limit | None = None

    @cached_property
    def factors(self) -> list[NormFactor]:
        """Those of the eliminant: they take a third of a second where its norm has 25,000 bits."""
        return norm_factors(self.eliminant.polynomial)

    @classmethod
    def of(
        cls,
        slice_map: SliceMap,
        first: BiForm,
        second: BiForm,
        known: Form | None = None,
        content: Fraction = Fraction(1),
    ) -> System:
        """Eliminates t and divides by a known factor and content, see :func:`resultant`.

        Raises:
            NotGeneric: the resultant vanishes identically.
        """
        eliminant = resultant(first, second, known, content)
        if eliminant.polynomial.is_zero:
            raise NotGeneric
        return cls(slice_map, first, second, eliminant)

    @classmethod
    def without_shared_angles(
        cls, slice_map: SliceMap, first: BiForm, second: BiForm, known: Form, content: Fraction = Fraction(1)
    ) -> tuple[System, BiForm | None]:
        """As :meth:`of`, without the angles α at which both forms vanish for every v; also these angles.

        Raises:
            NotGeneric: the forms share another factor.
        """
        try:
            return cls.of(slice_map, first, second, known, content), None
        except NotGeneric:
            shared = SharedAngles.of(first, second)
            if shared is None:
                raise
            return cls.of(slice_map, shared.first, shared.second), shared.angles


@dataclass(frozen=True)
class EventSystems:
    """The equations of the events of one manipulator and one fixed leg."""

    slice_map: SliceMap
    swallowtails: System
    critical: System
    near_shared_angles: tuple[System, ...]
    """Where cusps may meet poses of an angle α at which every pose is degenerate for its own L."""
    permanent: System
    """J0 = J1 = 0 and Z(v): the poses that are singular for every L."""
    not_parallel: Form
    """Y(v): those of the permanent poses without three parallel legs."""

    @classmethod
    def of(cls, slice_map: SliceMap, progress: Progress = silent) -> EventSystems:
        """Derives the equations and eliminates t; ``progress`` is a callback ``progress(done, total)``.

        Raises:
            NotGeneric: an eliminant vanishes identically.
        """
        trig = _Trig.of(slice_map)
        j0, j1 = trig.form(trig.j0, (2, 1)), trig.form(trig.j1, (1, 2))
        f_theta, g_theta = (trig.form(slopes(leg)[1], (1, 1)) for leg in (slice_map.f, slice_map.g))
        rho, radicand = slice_map.rho, slice_map.radicand
        m1, m2 = (
            trig.form(trig.j0 * d(trig.j1, rho) - trig.j1 * d(trig.j0, rho), (3, 3))
            for d in (d_alpha, d_theta)
        )
        e = trig.form(trig.on_surface(trig.e), (6, 5))
        c = e.quotient(f_theta)
        along_e = trig.form(trig.on_surface(trig.along_e), (8, 7))
        w = along_e.quotient(f_theta).quotient(f_theta).quotient(j0)
        scales = scale(e, f_theta, c), scale(along_e, f_theta, f_theta, j0, w)
        progress(1, ELIMINATION_STEPS)
        parallel = System.of(slice_map, f_theta.primitive(), g_theta.primitive(), _circular(1, rho, radicand))
        permanent = System.of(slice_map, j0.primitive(), j1.primitive(), _circular(1, rho, radicand))
        z, y = permanent.eliminant, permanent.eliminant.quotient(parallel.eliminant)
        progress(2, ELIMINATION_STEPS)
        known = z * _circular(5, rho, radicand)
        # along an angle that M1 and M2 share, L is constant and changes its sign: it is 0
        first, second = m1.primitive(), m2.primitive()
        content = _content(slice_map, 1, 54) / (scale(m1, first) * scale(m2, second)) ** 6
        critical, _ = System.without_shared_angles(slice_map, first, second, known, content)
        progress(3, ELIMINATION_STEPS)
        known = y * y * y * y * _circular(8, rho, radicand)
        content = _content(slice_map, 4, 120) / (scales[0] ** 8 * scales[1] ** 10)
        swallowtails, angles = System.without_shared_angles(slice_map, c, w, known, content)
        near_shared_angles = () if angles is None else (System.of(slice_map, swallowtails.first, angles),)
        progress(4, ELIMINATION_STEPS)
        return cls(slice_map, swallowtails, critical, near_shared_angles, permanent, y)


def _content(slice_map: SliceMap, sides: int, lengths: int) -> Fraction:
    """The product of three squared sides to the power ``sides``, and of the unit to the power ``lengths``
    (mathematics.md#the-contents-of-the-census)."""
    squares = slice_map.f.platform2 * slice_map.g.platform2 * slice_map.side2
    return Fraction(squares**sides * slice_map.unit**lengths)


def limit_system(systems: EventSystems, leg: Leg, square: Fraction) -> System:
    """The equations of a cusp with squared free leg ``square`` (scaled): C and (f − square) J1² at L =
    −J0/J1.

    Eliminating t from them gives (1+ρv²)¹⁰ · (Y Z)² · P, with P of degree 24
    (mathematics.md#the-eliminants-of-the-census, mathematics.md#joint-limits). If C was divided by shared
    angles, the factors before P are not removed.

    Raises:
        NotGeneric: the eliminant vanishes identically.
    """
    slice_map, form = systems.slice_map, leg_form(systems.slice_map, leg, square)
    known = None
    if not systems.near_shared_angles:
        factor = systems.permanent.eliminant * systems.not_parallel
        known = factor * factor * _circular(10, slice_map.rho, slice_map.radicand)
    system = System.of(slice_map, systems.swallowtails.first, form, known)
    return replace(system, limit=Limit(leg, square))


def leg_form(slice_map: SliceMap, leg: Leg, square: Fraction) -> BiForm:
    """(f − square) J1² at L = −J0/J1.

    Raises:
        NotGeneric: it vanishes identically.
    """
    trig = _Trig.of(slice_map)
    constant, linear, quadratic = excess(leg, square)
    on_surface = quadratic * trig.j0**2 - linear * trig.j0 * trig.j1 + constant * trig.j1**2
    return trig.form(on_surface, (4, 4)).primitive()


def length_form(slice_map: SliceMap, squares: fmpz_poly) -> BiForm:
    """A polynomial in L², times J1 to its degree, at L = −J0/J1.

    Raises:
        NotGeneric: it vanishes identically.
    """
    trig = _Trig.of(slice_map)
    top = squares.degree()
    terms = (c * trig.j0 ** (2 * k) * trig.j1 ** (2 * (top - k)) for k, c in enumerate(squares.coeffs()))
    return trig.form(sum(terms, TRIG.gen(0) * 0), (4 * top, 4 * top)).primitive()


def _circular(exponent: int, rho: int, radicand: int) -> Form:
    """(1+ρv²)^exponent."""
    return Form(QuadraticPoly.rational(fmpz_poly([1, 0, rho]) ** exponent, radicand), 2 * exponent)


@dataclass(frozen=True)
class _Trig:
    """J and E as polynomials in turns and ω, by powers of L."""

    slice_map: SliceMap
    j0: fmpz_mpoly
    j1: fmpz_mpoly
    e: tuple[fmpz_mpoly, ...]
    along_e: tuple[fmpz_mpoly, ...]

    @classmethod
    def of(cls, slice_map: SliceMap) -> _Trig:
        rho, radicand = slice_map.rho, slice_map.radicand
        j, e = (reduced(p, rho, radicand) for p in slice_map.trigonometric)
        f_alpha, f_theta = slopes(slice_map.f)
        along_e = reduced(f_alpha * d_theta(e, rho) - TRIG.gen(4) * f_theta * d_alpha(e, rho), rho, radicand)
        j0, j1 = _by_length(j, 1)
        return cls(slice_map, j0, j1, _by_length(e, 2), _by_length(along_e, 3))

    def form(self, p: fmpz_mpoly, orders: tuple[int, int]) -> BiForm:
        """A polynomial without L as a form in t and v.

        Raises:
            NotGeneric: it vanishes identically.
        """
        rho, radicand = self.slice_map.rho, self.slice_map.radicand
        form = in_tangents(reduced(p, rho, radicand), orders, rho, radicand)
        if form.is_zero:
            raise NotGeneric
        return form

    def on_surface(self, coefficients: Sequence[fmpz_mpoly]) -> fmpz_mpoly:
        """Σ cₖ Lᵏ with L = −J0/J1, times J1 to the degree."""
        top = len(coefficients) - 1
        terms = (c * (-self.j0) ** k * self.j1 ** (top - k) for k, c in enumerate(coefficients))
        return sum(terms, TRIG.gen(0) * 0)


def _by_length(p: fmpz_mpoly, top: int) -> tuple[fmpz_mpoly, ...]:
    """The coefficients of L⁰ … L^top."""
    rows: list[dict[tuple[int, ...], int | fmpz]] = [{} for _ in range(top + 1)]
    for (i, j, k, m, power, w), c in p.to_dict().items():
        rows[power][i, j, k, m, 0, w] = c
    return tuple(TRIG.from_dict(row) for row in rows)
