"""Angles α = const at which two forms in (t, u) vanish for every u: found, divided out, and kept apart.

For some symmetric and right-angled machines all poses of one α (0 or 180 degrees, mostly) are degenerate at
their L, or all of them have ∇J = 0 at one and the same L.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import lcm

from flint import fmpq_poly, fmpz_poly

from rpr_solver.exact.factors import value_at
from rpr_solver.exact.number_field import (
    Algebraic,
    Field,
    Polynomial,
    adjoin_real_roots,
    poly_gcd,
    poly_mod,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.quadratic import Pair
from rpr_solver.exact.real_roots import RealPolynomial, real_roots
from rpr_solver.model.slice_map import BiForm, SliceMap

_NOTHING = fmpz_poly([])


@dataclass(frozen=True)
class SharedAngles:
    """Two forms without the angles that they shared, and these: the zeros of a form in t alone."""

    first: BiForm
    second: BiForm
    angles: BiForm

    @classmethod
    def of(cls, slice_map: SliceMap, first: BiForm, second: BiForm) -> SharedAngles | None:
        """Divide every power of the shared angles out of both forms; None if they share none."""
        field = omega_field(slice_map)
        columns = [_columns(form, field) for form in (first, second)]
        common: Polynomial = []
        for column in (c for cs in columns for c in cs):
            common = poly_gcd(common, trimmed(column))
        finite = squarefree_part(common)
        at_infinity = all(_top_vanishes(form) for form in (first, second))
        if len(finite) == 1 and not at_infinity:
            return None
        divided = []
        for form, rows in zip((first, second), columns, strict=True):
            degree = form.degree_t
            while len(finite) > 1 and (quotients := _quotients(rows, finite)) is not None:
                rows, degree = quotients, degree - (len(finite) - 1)
            if at_infinity:
                degree = max((len(trimmed(c)) for c in rows), default=1) - 1
            divided.append(_form(rows, degree, form.degree_u))
        angles = _form([finite], len(finite) - 1 + at_infinity, 0)
        return cls(divided[0], divided[1], angles)


def omega_field(slice_map: SliceMap) -> Field:
    """ℚ(ω), ω being the generator, or ℚ where ω is 1."""
    if slice_map.rational:
        return Field.rationals()
    minimal = RealPolynomial(fmpz_poly([-slice_map.radicand, 0, 1]), _NOTHING, 1)
    return Field.of_root(real_roots(minimal)[-1])


def constant_lengths(slice_map: SliceMap, j0: BiForm, j1: BiForm, angles: BiForm) -> Iterator[Algebraic]:
    """L = −J0/J1 (scaled) at each real angle of a form in t alone, where L depends on the angle only."""
    field = omega_field(slice_map)
    [polynomial] = _columns(angles, field)
    omega = field(1) if slice_map.rational else field.generator
    for extension in adjoin_real_roots(field, trimmed(polynomial)):
        yield from _length(j0, j1, extension.root, extension.lift(omega))
    if _top_vanishes(angles):
        yield from _length(j0, j1, None, omega)


def _length(j0: BiForm, j1: BiForm, t: Algebraic | None, omega: Algebraic) -> Iterator[Algebraic]:
    """None is t = ∞."""
    for place in range(j1.degree_u + 1):
        u = omega.field(place)
        bottom = _at(j1, t, u, omega)
        if not bottom.is_zero:
            yield -_at(j0, t, u, omega) * bottom.inverse()
            return


def _at(form: BiForm, t: Algebraic | None, u: Algebraic, omega: Algebraic) -> Algebraic:
    rows = [value_at(row[0], u, omega) for row in form.coefficients]
    if t is None:
        return rows[-1]
    total = omega.field(0)
    for row in reversed(rows):
        total = total * t + row
    return total


def _top_vanishes(form: BiForm) -> bool:
    return not any(form.coefficients[-1][0])


def _columns(form: BiForm, field: Field) -> list[list[Algebraic]]:
    """For each power of u the coefficients of t⁰, t¹, …"""

    def entry(pair: Pair, k: int) -> Algebraic:
        return field(fmpq_poly([part[k] for part in pair]))

    return [[entry(row[0], k) for row in form.coefficients] for k in range(form.degree_u + 1)]


def _quotients(columns: Sequence[Sequence[Algebraic]], divisor: Polynomial) -> list[list[Algebraic]] | None:
    """All columns divided; None if one of them is no multiple."""
    divided = [poly_mod(trimmed(column), divisor) for column in columns]
    return None if any(rest for _, rest in divided) else [quotient for quotient, _ in divided]


def _form(columns: Sequence[Sequence[Algebraic]], degree_t: int, degree_u: int) -> BiForm:
    """The primitive form with these columns, up to a rational factor."""

    def part(i: int, column: Sequence[Algebraic], omega: int) -> tuple[int, int]:
        value = column[i].poly[omega] if i < len(column) else fmpq_poly([])[0]
        return int(value.p), int(value.q)

    sizes = range(degree_t + 1)
    unit = lcm(*(part(i, column, w)[1] for column in columns for i in sizes for w in (0, 1)))

    def pair(i: int) -> Pair:
        parts = []
        for omega in (0, 1):
            values = [part(i, column, omega) for column in columns]
            parts.append(fmpz_poly([p * (unit // q) for p, q in values]))
        return parts[0], parts[1]

    return BiForm(degree_t, degree_u, tuple((pair(i),) for i in sizes))
