"""Rational forms in two half tangents as functions on the torus: derivatives in the angles, and factors.

A form of degrees (m, n) in t = tan(α/2) and u = tan(θ/2) stands for the function form / (1+t²)^(m/2) /
(1+u²)^(n/2), up to a sign if a degree is odd. The line α = 180° is a factor too: the form 1 of degree 1 in t.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from flint import fmpz_mpoly

from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.number_field import Algebraic, evaluate

_T, _U, _L = range(3)
_IMAGINARY = (T**2 + 1, U**2 + 1)


def rational_form(p: fmpz_mpoly, degree_t: int, degree_u: int) -> BiForm:
    """A form with rational coefficients."""
    return BiForm.of(p, 1, degree_t, degree_u)


def form_sum(first: BiForm, second: BiForm) -> BiForm:
    """The sum of two forms of equal degrees."""
    return replace(first, a=first.a + second.a, b=first.b + second.b)


def negative(form: BiForm) -> BiForm:
    """−form."""
    return replace(form, a=-form.a, b=-form.b)


def by_length(form: BiForm) -> tuple[BiForm, BiForm]:
    """The coefficients of L⁰ and L¹ of a rational form linear in L."""
    zeroth = form.a.subs({"L": 0})
    return replace(form, a=zeroth), replace(form, a=(form.a - zeroth).derivative(_L))


def along_alpha(form: BiForm) -> BiForm:
    """2 ∂/∂α, of the same degrees."""
    return replace(form, a=(1 + T**2) * form.a.derivative(_T) - form.degree_t * T * form.a)


def along_theta(form: BiForm) -> BiForm:
    """2 ∂/∂θ, of the same degrees."""
    return replace(form, a=(1 + U**2) * form.a.derivative(_U) - form.degree_u * U * form.a)


def curves(form: BiForm) -> Iterator[tuple[BiForm, int]]:
    """The factors irreducible over ℚ with their multiplicities, those without real points left out.

    A factor that is L alone is left out as well.
    """
    for factor, multiplicity in form.a.factor()[1]:
        t, u, *_ = factor.degrees()
        if (t or u) and factor not in _IMAGINARY:
            yield rational_form(factor, t, u), multiplicity
    missing_t, missing_u = (
        degree - actual
        for degree, actual in zip((form.degree_t, form.degree_u), form.a.degrees(), strict=False)
    )
    if missing_t:
        yield rational_form(T**0, 1, 0), missing_t
    if missing_u:
        yield rational_form(T**0, 0, 1), missing_u


def divides(curve: BiForm, form: BiForm) -> bool:
    """Whether a factor as given by :func:`curves` divides a form; every one divides 0."""
    if form.is_zero:
        return True
    if curve.a.is_one():
        t, u, *_ = form.a.degrees()
        return bool(form.degree_t > t if curve.degree_t else form.degree_u > u)
    return not (form.a % curve.a or form.b % curve.a)


def value(form: BiForm, t: Algebraic | None, u: Algebraic | None, one: Algebraic) -> Algebraic:
    """The form's value at a point of the torus, None standing for ∞; in the field of ``one``."""
    rows = form.above(u, one)
    return rows[-1] if t is None else evaluate(rows, t)
