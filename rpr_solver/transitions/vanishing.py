"""Whether a form vanishes at a common zero of two others, decided by balls and a bound, in no number field.

What is not 0 at an algebraic point cannot be arbitrarily small: a lower bound follows from the degrees and
the coefficients (mathematics.md#what-is-too-small). Balls that are nearer to 0 than that prove that it is
0. So an angle of 0 or 90 degrees, a closed leg, a rational length or two equal ones are proved by
evaluating one form; the number field of a root of an eliminant has a degree of up to 64, and takes minutes
beside special shapes.
"""

from __future__ import annotations

from collections.abc import Iterable

from flint import arb, ctx

from rpr_solver.exact.biform import OMEGA, BiForm, T, U
from rpr_solver.exact.factors import NormFactor, factor_at
from rpr_solver.exact.precision import GREATEST_BITS, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot
from rpr_solver.model.jets import HalfTangent, common_root
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import System

_FIRST_BITS, _OPEN_BITS = 512, 1 << 13
"""At which what is not 0 shows nearly always, before the bound is asked for."""
_MOST_BITS = 240_000
"""Of a bound that is tried, in about a second; roots can be refined to a few more."""
_SPARE_BITS = 64
_LOST_BITS = 1 << 11
"""More than the bound's, of the first precision at which it is tried."""


def vanishes(system: System, root: RealRoot, form: BiForm) -> bool | None:
    """Whether a form is 0 at the common zero (t, v) of a system above a simple root v of its eliminant.

    None if balls do not show that there is one zero above v, or if the bound has too many bits.
    """

    def decision(bits: int, enough: int | None = None) -> bool | None:
        v = root.refined(bits - _SPARE_BITS)
        with ctx.workprec(bits):
            t = common_root(*(_at(other, v, bits) for other in (system.first, system.second)))
            if t is None:
                return None
            value = abs(_value(_at(form, v, bits), t))
            if not value.contains(0):
                return False
            if enough is None:
                return None
            size = _size(t.numerator, t.denominator) ** form.degree_t * _size(v, arb(1)) ** form.degree_u
            return True if value < size * arb(2) ** -enough else None

    if decided_or_none(decision, _FIRST_BITS, _OPEN_BITS) is False:
        return False
    factor = factor_at(root, system.factors)
    enough = None if factor is None else gap_bits(system, factor, form)
    if enough is None or enough > _MOST_BITS:
        return None
    start = max(enough + _LOST_BITS, 2 * _OPEN_BITS)
    return decided_or_none(lambda bits: decision(bits, enough), start, min(4 * start, GREATEST_BITS))


def gap_bits(system: System, factor: NormFactor, form: BiForm) -> int:
    """The bits B of the bound: max(|t₀|, |t₁|)^a max(1, |v|)^b 2^−B, below which the form is 0.

    With D the degree of the field of (t, v) and h the height, B = (D − 1) log ‖form‖ + a D h(t) + b D h(v).
    v is a root of the factor of the eliminant's norm.
    """
    conjugates = 1 if form.radicand == 1 else 2
    # where the factor splits, v determines ω
    per_v = 1 if factor.extra else conjugates
    degree = per_v * int(factor.polynomial.degree())
    of_v = per_v * _bits([QuadraticPoly.rational(factor.polynomial)])
    first, second = system.first, system.second
    sizes = [_bits(p.rows) for p in (first, second)]
    # t is a root of the resultant by v, with all its conjugates, and one of either form above v
    of_t = min(
        conjugates * (second.degree_u * sizes[0] + first.degree_u * sizes[1]),
        *(degree * (1 + size) + p.degree_u * of_v for p, size in zip((first, second), sizes, strict=True)),
    )
    return (degree - 1) * _bits(form.rows) + form.degree_t * of_t + form.degree_u * of_v


def _bits(parts: Iterable[QuadraticPoly]) -> int:
    """Of the sum of the absolute values of all coefficients, for either sign of ω."""
    return sum(part.norm1() for part in parts).bit_length()


def _at(form: BiForm, v: arb, bits: int) -> list[arb]:
    return [row.ball(bits)(v) for row in form.rows]


def _value(form: list[arb], t: HalfTangent) -> arb:
    """A form by its ascending coefficients at numerator : denominator."""
    total, power = arb(0), arb(1)
    for c in reversed(form):
        total, power = total * t.numerator + c * power, power * t.denominator
    return total


def _size(x: arb, y: arb) -> arb:
    """A lower bound of the greater one of two absolute values."""
    return max(abs(x).lower(), abs(y).lower())


def level(slice_map: SliceMap) -> tuple[BiForm, BiForm]:
    """Forms that are 0 where α, and where θ, is 0 or 180 degrees."""
    rho, radicand = slice_map.rho, slice_map.radicand
    (x, y), (z, w) = ([part.a + OMEGA * part.b for part in axis] for axis in slice_map.axes)
    # of the turns 1 − ρt² : 2t and 1 : v, times the conjugates of the axes
    alpha, theta = 2 * T * x - (1 - rho * T**2) * y, U * z - w
    return BiForm.of(alpha, radicand, 2, 0), BiForm.of(theta, radicand, 0, 1)
