"""Poses of an event at an angle α that is known exactly, proved without a number field.

The angle of a symmetric manipulator may be exactly 0, and one of L = 0 is where J0 vanishes for every θ. Such
a half tangent t is a number of ℚ(ω), put into the two forms of a system: their greatest common divisor is a
polynomial in v of a small degree, which balls compare with the root v of the eliminant
(mathematics.md#angles-that-are-known). A number field of that root has twice the degree of the eliminant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

from flint import arb, arb_poly, ctx, fmpz_poly

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.precision import EVENT_BITS, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot
from rpr_solver.model.jets import common_root
from rpr_solver.transitions.event_systems import System

_FIRST_BITS = 512


@dataclass(frozen=True)
class KnownTangent:
    """A half tangent t = numerator / denominator; both are numbers of ℤ[ω], the denominator is 0 at 180°."""

    numerator: QuadraticPoly
    denominator: QuadraticPoly

    def is_above(self, system: System, root: RealRoot) -> bool:
        """Whether the common zero of a system above a simple root v has this t; False gives no proof.

        If the greatest common divisor of the forms at this t has a root in an interval round v, they have a
        zero there; if their Jacobian is regular on a box that holds this zero and the one above v, these are
        one.
        """
        forms = (system.first, system.second)
        shared = self._put_into(forms[0]).common(self._put_into(forms[1]))
        if shared.degree < 1:
            return False

        def proved(bits: int) -> bool | None:
            with ctx.workprec(bits):
                v = root.refined(bits) * arb(1, arb(2) ** (-bits // 2))
                values = shared.ball(bits)
                if not values(v.lower()) * values(v.upper()) < 0:
                    return None
                return True if self._is_only_zero(forms, v, bits) else None

        return bool(decided_or_none(proved, _FIRST_BITS, EVENT_BITS))

    def _put_into(self, form: BiForm) -> QuadraticPoly:
        """A form at this t, a polynomial in v."""
        powers = [QuadraticPoly.rational([1], form.radicand)]
        for _ in range(form.degree_t):
            powers = [self.denominator * powers[0], *(self.numerator * power for power in powers)]
        return reduce(
            QuadraticPoly.__add__, (row * power for row, power in zip(form.rows, powers, strict=True))
        )

    def _is_only_zero(self, forms: tuple[BiForm, BiForm], v: arb, bits: int) -> bool:
        """Whether the common root t above v is this one, if there is a zero of this t on the interval v."""
        n, d = (part.ball(bits)[0] for part in (self.numerator, self.denominator))
        rows = [[row.ball(bits) for row in form.rows] for form in forms]
        t = common_root(*([row(v) for row in form] for form in rows))
        if t is None:
            return False
        own = t.numerator, t.denominator
        if abs(n) > abs(d):  # by 1/t
            rows = [form[::-1] for form in rows]
            n, d, own = d, n, own[::-1]
        if own[1].contains(0):
            return False
        box = (own[0] / own[1]).union(n / d)
        (a, b), (c, e) = (
            (
                arb_poly([row(v) for row in form]).derivative()(box),
                arb_poly([row.derivative()(v) for row in form])(box),
            )
            for form in rows
        )
        return not (a * e - b * c).contains(0)


def level(radicand: int) -> KnownTangent:
    """t = 0."""
    return KnownTangent(QuadraticPoly.rational([], radicand), QuadraticPoly.rational([1], radicand))


def closing_angle(j0: BiForm) -> KnownTangent | None:
    """The only angle at which J0 = 0 for every v, so that its singular poses have L = 0; None if none is.

    J0 has the degree 1 in v.
    """
    columns = [
        [
            fmpz_poly([part[k] for part in side])
            for side in zip(*((row.a, row.b) for row in j0.rows), strict=True)
        ]
        for k in range(j0.degree_u + 1)
    ]
    parts = [QuadraticPoly(a, b, j0.radicand) for a, b in columns]
    shared = reduce(QuadraticPoly.common, (part for part in parts if not part.is_zero))
    at_infinity = all(part.degree < j0.degree_t for part in parts)
    constant = QuadraticPoly.rational
    if at_infinity and not shared.degree:
        return KnownTangent(constant([1], j0.radicand), constant([], j0.radicand))
    if at_infinity or shared.degree != 1:
        return None
    n, d = (QuadraticPoly(fmpz_poly([shared.a[k]]), fmpz_poly([shared.b[k]]), j0.radicand) for k in (0, 1))
    return KnownTangent(-n, d)
