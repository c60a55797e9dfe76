"""J = 0 of one slice as a form in two half tangents, in a chart where neither angle is special at 180°.

The sweep (sweep.py) reads J as a form in t = tan(α′/2) whose coefficients are polynomials in u = tan(θ′/2),
with α = α′ + α₀ and θ = θ′ + θ₀. The turns α₀ and θ₀ have rational half tangents, so the form stays over
ℤ[ω]. In a *good* chart

- t = ∞ is crossed transversally and away from critical lines: the leading coefficient is squarefree and
  prime to the discriminant;
- u = ∞ is no critical line and no line where t = ∞ is crossed.

Nothing is then lost at 180°. Repeated components, which only flat congruent triangles are known to have, are
taken once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from math import atan, isqrt, sqrt

from flint import fmpz_mat, fmpz_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import BiForm, Rows, T, U
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.quadratic import Form, QuadraticPoly
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.slice_map import SliceMap


@dataclass(frozen=True)
class Turn:
    """A turn by an angle with the half tangent ``sin``/``cos``, in a plane with y in √ρ."""

    sin: int
    cos: int
    rho: int = 1

    @property
    def angle(self) -> float:
        """The angle in radians."""
        return 2 * atan(sqrt(self.rho) * self.sin / self.cos)

    @property
    def rotation(self) -> tuple[int, int, int]:
        """Multiples of c, s and 1."""
        sin2 = self.rho * self.sin**2
        return self.cos**2 - sin2, 2 * self.sin * self.cos, self.cos**2 + sin2

    def whole(self, t: HalfTangent) -> HalfTangent:
        """The half tangent of the whole angle, from that in the chart."""
        n, d = t.numerator, t.denominator
        return HalfTangent(n * self.cos + d * self.sin, d * self.cos - n * self.sin * self.rho)

    def in_chart(self, t: HalfTangent) -> HalfTangent:
        """The half tangent in the chart, from that of the whole angle."""
        return Turn(-self.sin, self.cos, self.rho).whole(t)

    def powers(self, degree: int) -> list[fmpz_poly]:
        """The powers of the whole angle's half tangent, in terms of that in the chart, as forms."""
        up, down = fmpz_poly([self.sin, self.cos]), fmpz_poly([self.cos, -self.rho * self.sin])
        return [up**k * down ** (degree - k) for k in range(degree + 1)]


_TURNS = (
    ((1, 3), (1, 2)),
    ((2, 7), (2, 5)),
    ((5, 6), (3, 8)),
    ((3, 7), (4, 9)),
    ((5, 11), (7, 12)),
    ((8, 11), (9, 13)),
)
_FINENESS = 16
"""The denominators of other turns, times √ρ: they are known to a few degrees."""


@lru_cache(maxsize=256)
def turns_of(rho: int) -> list[tuple[Turn, Turn]]:
    """The turns of α and θ of the charts that are tried: about the same angles for all ρ."""
    return [(_turn(*alpha, rho), _turn(*theta, rho)) for alpha, theta in _TURNS]


def _turn(sin: int, cos: int, rho: int) -> Turn:
    if rho == 1:
        return Turn(sin, cos)
    near = Fraction(sin / cos / sqrt(rho)).limit_denominator(_FINENESS * (isqrt(rho) + 1))
    return Turn(near.numerator, near.denominator, rho)


@dataclass(frozen=True)
class Chart:
    """The form of a slice in one chart.

    Attributes:
        slice_map: the integer model.
        at: the length of the fixed leg, *scaled*; None for the limit of J / L² as it grows beyond all bounds.
        alpha, theta: the turns α₀ and θ₀.
        rows: the coefficients of t⁰, t¹, …, polynomials in u.
        degree_u: their formal degree.
        whole: the coefficients of J itself, which differ where a repeated component was taken once.
        transposed: whether α and θ have changed places: t belongs to θ, and u to α.
    """

    slice_map: SliceMap
    at: Fraction | None
    alpha: Turn
    theta: Turn
    rows: Rows
    degree_u: int
    whole: Rows
    transposed: bool = False

    @property
    def length(self) -> Fraction:
        """The scaled length of a slice, not of a limit."""
        assert self.at is not None, "limits are compared, not drawn"
        return self.at

    @cached_property
    def offsets(self) -> tuple[float, float]:
        """The article's α and θ where the angles of the chart are 0, in radians."""
        alpha, theta = Bridge.of(self.slice_map).offsets
        return self.alpha.angle - alpha, self.theta.angle - theta

    @property
    def repeated(self) -> bool:
        """Whether a repeated component was taken once, so that J may keep its sign across the curve."""
        return len(self.whole) != len(self.rows)

    @cached_property
    def discriminant(self) -> Form:
        """The discriminant in t, without 1 + ρu²: its real roots are the critical lines θ = const."""
        polynomial, degree = _discriminant(self.rows), 2 * (len(self.rows) - 2) * self.degree_u
        circular = fmpz_poly([1, 0, self.slice_map.rho])
        while not polynomial.is_zero and not (polynomial.a % circular or polynomial.b % circular):
            polynomial, degree = polynomial / circular, degree - 2
        return Form(polynomial.primitive(), degree)

    @cached_property
    def lines(self) -> QuadraticPoly:
        """The real roots are the critical lines and those on which a branch crosses t = ∞."""
        return self.discriminant.polynomial * self.lead

    @property
    def lead(self) -> QuadraticPoly:
        """The leading coefficient in t: its real roots are the lines on which a branch crosses t = ∞."""
        return self.rows[-1]

    @cached_property
    def _columns(self) -> tuple[fmpz_mat, fmpz_mat]:
        """The coefficients of A and of B, a row for each power of t and a column for each power of u."""
        a, b = (_matrix(part, self.degree_u) for part in zip(*((x.a, x.b) for x in self.rows), strict=True))
        return a, b

    def above(self, u: Fraction) -> QuadraticPoly:
        """The form on the line of one u, a polynomial in t, times the sign-free power of u's denominator."""
        n, d, degree = u.numerator, u.denominator, self.degree_u
        powers = fmpz_mat(degree + 1, 1, [n**k * d ** (degree - k) for k in range(degree + 1)])
        a, b = (fmpz_poly((columns * powers).entries()) for columns in self._columns)
        return QuadraticPoly(a, b, self.slice_map.radicand)


def _closes_at_infinity(slice_map: SliceMap, length: Fraction, theta: Turn) -> bool:
    """Whether a leg is closed at u = ∞, which no root of a polynomial in u tells."""
    forms = (leg.closed(length) for leg in (slice_map.f, slice_map.g))
    up, down = theta.cos, -theta.rho * theta.sin
    return any(
        all(p[0] * down * down + p[1] * up * down + p[2] * up * up == 0 for p in (form.a, form.b))
        for form in forms
    )


def chart_of(
    slice_map: SliceMap,
    length: Fraction | None,
    turns: Sequence[tuple[Turn, Turn]] | None = None,
    *,
    transposed: bool = False,
) -> tuple[Chart, bool]:
    """A good chart of the slice of one *scaled* length, and whether all its critical lines are simple.

    Length 0 is the limit of J / L, None that of J / L² as L grows beyond all bounds.

    On a simple critical line the form has one double root, at a smooth point of the curve. ``turns`` are the
    charts that are tried, if not all.

    Raises:
        SolverError: the singular curve has a component that this version does not draw.
    """
    form = slice_map.singular.sliced(length)
    if transposed:
        form = form.transposed
    if not form.joined:
        raise SolverError("every pose of this slice is singular, so it has no singular curve")
    whole = _without_circular_points(form, slice_map.rho)
    form = _without_repetition(whole)
    if form.degree_t == 0 and form.degree_u > 0:
        raise SolverError("the singular curve consists of whole lines theta = const; they are not drawn")
    for alpha, theta in turns_of(slice_map.rho) if turns is None else turns:
        if length and not transposed and _closes_at_infinity(slice_map, length, theta):
            continue
        rows = turned_rows(form.rows, form.degree_u, alpha, theta)
        own = rows if whole is form else turned_rows(whole.rows, whole.degree_u, alpha, theta)
        chart = Chart(slice_map, length, alpha, theta, rows, int(form.degree_u), own, transposed)
        if chart.discriminant.polynomial.is_zero:
            raise SolverError("the singular curve has a repeated component that is not rational")
        simple = simple_and_finite(chart.lines, chart.discriminant.degree + chart.degree_u)
        if simple or _good(chart):
            return chart, simple
    raise SolverError(
        "the singular curve has a whole line theta = const, or touches every line alpha = const tried"
    )


def _good(chart: Chart) -> bool:
    """Proof that the chart is good; critical lines may be multiple."""
    discriminant = chart.discriminant
    return discriminant.zeros_at_infinity == 0 and simple_and_finite(
        chart.lead, chart.degree_u, apart_from=[discriminant.polynomial]
    )


def turned_rows(rows: Rows, degree_u: int, alpha: Turn, theta: Turn) -> Rows:
    """The rows of a form, in terms of the half tangents of a chart."""
    across = _matrix(theta.powers(degree_u), degree_u)
    parts = [_matrix(part, degree_u) * across for part in zip(*((row.a, row.b) for row in rows), strict=True)]
    if alpha.sin:
        along = _matrix(alpha.powers(len(rows) - 1), len(rows) - 1).transpose()
        parts = [along * part for part in parts]
    tables = ([fmpz_poly(row) for row in part.tolist()] for part in parts)
    return tuple(QuadraticPoly(x, y, rows[0].radicand) for x, y in zip(*tables, strict=True))


def _matrix(polynomials: Sequence[fmpz_poly], degree: int) -> fmpz_mat:
    """Their coefficients, a row for each."""
    return fmpz_mat([[polynomial[k] for k in range(degree + 1)] for polynomial in polynomials])


def _without_circular_points(form: BiForm, rho: int) -> BiForm:
    """Divided by 1 + ρt² and 1 + ρu², which have no real zeros and are factors for similar triangles."""
    for circular in (rho * T**2 + 1, rho * U**2 + 1):
        while not (form.a % circular or form.b % circular):
            form = form / circular
    return form


def _without_repetition(form: BiForm) -> BiForm:
    """Each rational component taken once, also α = 180°, which is t = ∞."""
    common = form.a * 0
    for part in (form.a, form.b):
        for p in (part, part.derivative(0), part.derivative(1)):
            common = common.gcd(p)
    form = form if common.is_constant() else form / common
    beyond = form.zeros_at_infinity - 1
    return replace(form, degree_t=form.degree_t - beyond) if beyond > 0 else form


def _discriminant(c: Sequence[QuadraticPoly]) -> QuadraticPoly:
    """Of a form of degree 1 to 4, from its coefficients, up to a constant factor."""
    if len(c) == 5:
        i = c[4] * c[0] * 12 - c[3] * c[1] * 3 + c[2] * c[2]
        n = (c[4] * c[0] * 8 + c[3] * c[1]) * c[2] * 9 - c[4] * c[1] * c[1] * 27
        n = n - c[3] * c[3] * c[0] * 27 - c[2] * c[2] * c[2] * 2
        return i * i * i * 4 - n * n
    if len(c) == 4:
        squares = c[1] * c[1] * c[2] * c[2] - c[3] * c[1] * c[1] * c[1] * 4 - c[2] * c[2] * c[2] * c[0] * 4
        return squares - c[3] * c[3] * c[0] * c[0] * 27 + c[3] * c[2] * c[1] * c[0] * 18
    if len(c) == 3:
        return c[1] * c[1] - c[2] * c[0] * 4
    return QuadraticPoly.rational([1], c[0].radicand)
