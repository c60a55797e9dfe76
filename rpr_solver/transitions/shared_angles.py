"""Angles α = const at which two forms in (t, v) vanish for every v: their detection and removal.

For some symmetric and right-angled manipulators all poses of one α (mostly 0 or 180 degrees) are degenerate
at their L, or all of them have ∇J = 0 at the same L (mathematics.md#shared-angles).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import lcm

from rpr_solver.exact.biform import RING, BiForm
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    exact_omega,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.quadratic import DivisionError


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
