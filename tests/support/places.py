"""Cusps of tables as numbers, and numbers as boxes: between mpmath and FLINT's balls."""

from fractions import Fraction

import mpmath as mp
from flint import arb, ctx

from rpr_solver import Eliminant, Manipulator
from rpr_solver.curves.neighbourhood import CuspForms, Neighbourhood, PoseBox
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.cusp_table import SliceTable, solve_slice
from tests.support.definitions import Point


def number(x: arb) -> mp.mpf:
    """The middle of a ball."""
    mantissa, exponent = x.mid().man_exp()
    return mp.ldexp(mp.mpf(int(mantissa)), int(exponent))


def ball(x: mp.mpf) -> arb:
    """A ball round a number, as small as mpmath's working precision."""
    with ctx.workprec(mp.mp.prec + 32):
        return arb(mp.nstr(x, mp.mp.dps, strip_zeros=False))


def half_tangent(angle: mp.mpf, radius: float = 0.0) -> HalfTangent:
    """An angle in radians, with the same radius in the sine and the cosine of its half."""
    sin, cos = (arb(ball(f(angle / 2)).mid(), radius) for f in (mp.sin, mp.cos))
    return HalfTangent(sin, cos)


def place(alpha: mp.mpf, theta: mp.mpf, radius: float = 0.0) -> PoseBox:
    return PoseBox(half_tangent(alpha, radius), half_tangent(theta, radius))


def angle_of(t: HalfTangent) -> mp.mpf:
    """The middle of a box, in radians."""
    return 2 * mp.atan2(number(t.numerator), number(t.denominator))


def scaled(slice_map: SliceMap, length: mp.mpf) -> arb:
    """A length in the units of the slice map."""
    return ball(length) * slice_map.scale.numerator / slice_map.scale.denominator


def neighbourhood(
    m: Manipulator, point: Point, bits: int, fixed_leg: int = 1, radius: float = 1e-30
) -> Neighbourhood:
    """The neighbourhood of a cusp that is known to so many digits."""
    forms = CuspForms(SliceMap.of(m, fixed_leg))
    return Neighbourhood.at(forms, place(*point[:2], radius), scaled(forms.slice_map, point[2]), bits)


def cusps_in(table: SliceTable) -> list[Point]:
    """(α, θ, L) of each cusp of a table, in its order."""
    names = "alpha_deg", f"theta{table.fixed_leg}_deg"
    length = mp.mpf(table.length.numerator) / table.length.denominator
    rows: list[dict[str, str]] = table.to_json()["cusps"]  # type: ignore[assignment]
    return [(*(mp.radians(mp.mpf(row[name])) for name in names), length) for row in rows]  # type: ignore[misc]


def cusps_of(eliminant: Eliminant, length: Fraction, digits: int = 20) -> list[Point]:
    """(α, θ, L) of each cusp of a slice, in the order of its table."""
    return cusps_in(solve_slice(eliminant, length, digits))
