"""Poses of an event at an angle α that is known exactly, proved without a number field.

The angle of a symmetric manipulator may be exactly 0, and one of L = 0 is where J0 vanishes for every θ. Such
half tangents t are zeros of a form over ℤ[ω] of degree 1 or 2. What its resultants with the two forms of a
system have in common is a polynomial in v of a small degree, which balls compare with the root v of the
eliminant (mathematics.md#angles-that-are-known). A number field of that root has up to twice its degree.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

from flint import arb, arb_poly, ctx, fmpz_poly

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.precision import EXACT_BITS, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot
from rpr_solver.model.jets import HalfTangent, common_root
from rpr_solver.transitions.event_systems import System

_FIRST_BITS = 512


@dataclass(frozen=True)
class KnownTangents:
    """The half tangents t that are zeros of a form a + b t, or of a + b t + c t² with c ≠ 0.

    If b = 0 in the first one, t is ∞. The coefficients are numbers of ℤ[ω].
    """

    coefficients: tuple[QuadraticPoly, ...]

    def is_above(self, system: System, root: RealRoot) -> bool:
        """Whether the common zero of a system above a simple root v has such a t; False gives no proof.

        What the resultants of either form and this one have in common has a root in an interval round v:
        there either form is 0 at one of these t. It is the same t if a form that is not 0 at all of them is
        not 0 at another one. If the Jacobian is regular on a box that holds this zero and the one above v,
        these are one.
        """
        forms = (system.first, system.second)
        shared = self._resultant(forms[0]).common(self._resultant(forms[1]))
        if shared.degree < 1:
            return False

        def proved(bits: int) -> bool | None:
            with ctx.workprec(bits):
                v = root.refined(bits) * arb(1, arb(2) ** (-bits // 2))
                values = shared.ball(bits)
                if not values(v).contains(0):
                    return False
                if not values(v.lower()) * values(v.upper()) < 0:
                    return None
                return True if self._is_only_zero(forms, v, bits) else None

        return bool(decided_or_none(proved, _FIRST_BITS, EXACT_BITS))

    def _resultant(self, form: BiForm) -> QuadraticPoly:
        """The resultant of a form and this one, a polynomial in v, up to a constant factor."""
        x, y = self._remainder(form)
        if len(self.coefficients) == 2:
            return x
        a, b, c = self.coefficients
        return x * x * c - x * y * b + y * y * a

    def _remainder(self, form: BiForm) -> tuple[QuadraticPoly, QuadraticPoly]:
        """The remainder x + y t of a form divided by this one, up to a constant factor."""
        one, zero = (QuadraticPoly.rational(x, form.radicand) for x in ([1], []))
        a, b, *rest = self.coefficients
        lead = rest[0] if rest else b
        total, power = (zero, zero), (one, zero)
        for row in form.rows:
            # the remainder of (lead t)ᵏ is the power, that of the terms so far times leadᵏ the total
            x, y = power
            total = total[0] * lead + row * x, total[1] * lead + row * y
            power = (-(a * y), lead * x - b * y) if rest else (-(a * x), zero)
        return total

    def _zeros(self, bits: int) -> list[tuple[arb, arb]]:
        """Numerators and denominators of these t."""
        a, b, *rest = (part.ball(bits)[0] for part in self.coefficients)
        if not rest:
            return [(-a, b)]
        spread = (b * b - 4 * a * rest[0]).sqrt()
        return [(sign * spread - b, 2 * rest[0]) for sign in (1, -1)]

    def _is_only_zero(self, forms: tuple[BiForm, BiForm], v: arb, bits: int) -> bool:
        """Whether the common root t above v is one of these, if either form has one on the interval v."""
        rows = [[row.ball(bits) for row in form.rows] for form in forms]
        at_v = [[row(v) for row in form] for form in rows]
        t = common_root(*at_v)
        if t is None:
            return False
        # a form that is divided by this one is 0 at all of them
        divided = [all(part.is_zero for part in self._remainder(form)) for form in forms]
        others = [form for form, is_divided in zip(at_v, divided, strict=True) if not is_divided]
        near = self._only_zero_at(t, others, bits)
        return near is not None and _is_regular(rows, v, t, near)

    def _only_zero_at(self, t: HalfTangent, forms: list[list[arb]], bits: int) -> HalfTangent | None:
        """The one of these in the ball t, if none of some forms may be 0 at another one."""
        zeros = self._zeros(bits)
        near = [(n, d) for n, d in zeros if (t.numerator * d - t.denominator * n).contains(0)]
        others = [zero for zero in zeros if zero not in near]
        if len(near) != 1 or any(_at(form, *zero).contains(0) for form in forms for zero in others):
            return None
        return HalfTangent(*near[0])


def _is_regular(rows: list[list[arb_poly]], v: arb, t: HalfTangent, other: HalfTangent) -> bool:
    """Whether the Jacobian of two forms is regular on a box that holds v and two t; by 1/t if large."""
    if abs(other.numerator) > abs(other.denominator):
        rows = [form[::-1] for form in rows]
        t, other = (HalfTangent(x.denominator, x.numerator) for x in (t, other))
    if t.denominator.contains(0):
        return False
    box = (t.numerator / t.denominator).union(other.numerator / other.denominator)
    (a, b), (c, d) = (
        (
            arb_poly([row(v) for row in form]).derivative()(box),
            arb_poly([row.derivative()(v) for row in form])(box),
        )
        for form in rows
    )
    return not (a * d - b * c).contains(0)


def _at(form: list[arb], n: arb, d: arb) -> arb:
    """A form by its ascending coefficients at n : d."""
    total, power = arb(0), arb(1)
    for c in reversed(form):
        total, power = total * n + c * power, power * d
    return total


def level(radicand: int) -> KnownTangents:
    """t = 0."""
    return KnownTangents((QuadraticPoly.rational([], radicand), QuadraticPoly.rational([1], radicand)))


def closing_angles(j0: BiForm) -> KnownTangents | None:
    """The angles at which J0 = 0 for every v, so that its singular poses have L = 0; None if there are none.

    J0 has the degree 2 in t and 1 in v.
    """
    a, b = ([[part[k] for part in parts] for k in range(j0.degree_u + 1)] for parts in _parts(j0))
    columns = [
        QuadraticPoly(fmpz_poly(first), fmpz_poly(second), j0.radicand)
        for first, second in zip(a, b, strict=True)
    ]
    shared = reduce(QuadraticPoly.common, (column for column in columns if not column.is_zero))
    at_infinity = all(column.degree < j0.degree_t for column in columns)
    if shared.degree + at_infinity == 0 or (at_infinity and shared.degree):
        return None
    # with a rational leading coefficient; else numbers of ℤ[ω] may be much smaller than their terms
    top = shared.degree
    lead = QuadraticPoly(fmpz_poly([shared.a[top]]), fmpz_poly([-shared.b[top]]), j0.radicand)
    shared = (shared * lead).primitive()
    coefficients = (
        QuadraticPoly(fmpz_poly([shared.a[k]]), fmpz_poly([shared.b[k]]), j0.radicand)
        for k in range(max(top, 1) + 1)
    )
    return KnownTangents(tuple(coefficients))


def _parts(form: BiForm) -> tuple[list[fmpz_poly], list[fmpz_poly]]:
    """A and B of the coefficients of t⁰, t¹, …"""
    return [row.a for row in form.rows], [row.b for row in form.rows]
