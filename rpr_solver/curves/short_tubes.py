"""Tubes in few digits, as a certificate prints them: exact rational numbers, proved again as printed.

Rounding moves a tube's origin off the curve and bends its parabola, so the radii are computed again, and
Krawczyk's test is passed by the printed numbers themselves (mathematics.md#tubes).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor, gcd
from typing import Any

from flint import arb, ctx

from rpr_solver.curves.neighbourhood import CuspForms, Expansion, Frame, Place, Two
from rpr_solver.curves.tubes import (
    BOUND_BITS,
    Bounds,
    Tube,
    by_power,
    on_parabola,
    preconditioned,
)
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.model.joint_points import free_legs

_SPARE_BITS = (6, 12, 24, 48)
"""How far below a tube's radii its other numbers are rounded, in order of trial."""
_REACH_DIGITS, _RADIUS_DIGITS = 6, 3
_SLIM = arb(2) ** -128
_LINK = 1 << 12
"""A tube begins within a 1000th of the reach of the one before."""
_LONG = 8
"""The number of decimal places from which on a number is written with an exponent."""

Pair = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class ShortTube:
    """A tube of few digits about a point of a cusp curve.

    Attributes:
        parameter: the coordinate r along the tube, 0 for x = tan((α − α₀)/2), 1 for y = tan((θ − θ₀)/2) and
            2 for z = L/L₀ − 1. The other two, in this order, are p and q.
        leg: the free leg along which E is taken.
        alpha: integers (s, c) with tan(α₀/2) = s/c; the origin.
        theta: the same of θ₀.
        length: L₀, in the user's unit.
        slopes: those of p and q.
        bends: of p and q, so that p = slope · r + bend · r² on the parabola.
        reach: the greatest |r|.
        radii: in p and in q round the parabola; for each r there is one point with J = E = 0.
    """

    parameter: int
    leg: int
    alpha: tuple[int, int]
    theta: tuple[int, int]
    length: Fraction
    slopes: Pair
    bends: Pair
    reach: Fraction
    radii: Pair

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The member of a certificate."""
        return {
            "parameter": ("alpha", "theta", f"l{fixed_leg}")[self.parameter],
            "leg": self.leg,
            "half_alpha": [str(x) for x in self.alpha],
            "half_theta": [str(x) for x in self.theta],
            f"l{fixed_leg}": _text(self.length),
            "slopes": [_text(x) for x in self.slopes],
            "bends": [_text(x) for x in self.bends],
            "reach": _text(self.reach),
            "radii": [_text(x) for x in self.radii],
        }


class ProvedTube:
    """A short tube with its equations in balls of ``bits``, to test it and points in it."""

    def __init__(self, tube: ShortTube, forms: CuspForms, bits: int) -> None:
        self.tube, self.bits = tube, bits
        slice_map = forms.slice_map
        with ctx.workprec(bits):
            alpha, theta = ((arb(s), arb(c)) for s, c in (tube.alpha, tube.theta))
            self._frame = Frame(alpha, theta, ball_of(tube.length * slice_map.scale))
            singular, coalescence = forms.at(bits)
            legs = free_legs(slice_map.fixed_leg)
            first, second = self._frame.expanded(singular, coalescence[legs.index(tube.leg)])
            self._forms: tuple[Expansion, Expansion] | None = preconditioned(
                by_power(first, tube.parameter), by_power(second, tube.parameter)
            )

    def radii(self) -> Two | None:
        """Radii that pass the test; None if none are found."""
        if self._forms is None:
            return None
        with ctx.workprec(BOUND_BITS):
            return self._bounds().radii(ball_of(self.tube.reach), (arb(0), arb(0)))[0]

    def passes(self) -> bool:
        """Whether the printed radii pass the test."""
        if self._forms is None:
            return False
        with ctx.workprec(BOUND_BITS):
            return self._bounds().passes(ball_of(self.tube.reach), _balls(self.tube.radii))

    def middle(self) -> tuple[Place, arb] | None:
        """A small box that is proved to hold the point with r = 0, and its lengths; None if none is found."""
        if self._forms is None:
            return None
        zero = arb(0), arb(0)
        with ctx.workprec(BOUND_BITS):
            p, q = (radius * _SLIM for radius in _balls(self.tube.radii))  # positive, at least
            radii, _ = Bounds.of(self._forms, zero, zero).radii(arb(0), (p, q))
        if radii is None:
            return None
        with ctx.workprec(self.bits):
            box = [arb(0, radius) for radius in radii]
            box.insert(self.tube.parameter, arb(0))
            return self._frame.outside(box[0], box[1]), self._frame.length * (1 + box[2])

    def contains(self, place: Place, length: arb) -> bool:
        """Whether a box lies in the tube."""
        with ctx.workprec(self.bits):
            box = list(self._frame.inside(place, length))
            r = box.pop(self.tube.parameter)
            if not abs(r) <= ball_of(self.tube.reach):
                return False
            middle = on_parabola(_balls(self.tube.slopes), _balls(self.tube.bends), r)
            return all(
                bool(abs(w - m) < radius)
                for w, m, radius in zip(box, middle, _balls(self.tube.radii), strict=True)
            )

    def _bounds(self) -> Bounds:
        assert self._forms is not None
        return Bounds.of(self._forms, _balls(self.tube.slopes), _balls(self.tube.bends))


def shortened(
    tube: Tube, forms: CuspForms, bits: int, before: ProvedTube | None, start: tuple[Place, arb] | None
) -> ProvedTube | None:
    """A tube in few digits that holds the start, and whose own point with r = 0 lies in the tube before.

    None if this precision does not suffice.
    """
    for spare in _SPARE_BITS:
        proved = _proved(_rounded(tube, forms, bits, before, spare), forms, bits)
        if proved is None or (start is not None and not proved.contains(*start)):
            continue
        middle = proved.middle()
        if middle is not None and (before is None or before.contains(*middle)):
            return proved
    return None


def _proved(tube: ShortTube, forms: CuspForms, bits: int) -> ProvedTube | None:
    """The tube with radii that are found for it."""
    radii = ProvedTube(tube, forms, bits).radii()
    if radii is None:
        return None
    p, q = (_rounded_to(fraction_of(radius), _RADIUS_DIGITS, ceil) for radius in radii)
    proved = ProvedTube(replace(tube, radii=(p, q)), forms, bits)
    return proved if proved.passes() else None


def _rounded(tube: Tube, forms: CuspForms, bits: int, before: ProvedTube | None, spare: int) -> ShortTube:
    """The tube with rounded numbers, without radii."""
    slice_map, fine = forms.slice_map, Fraction(1, 1 << spare)
    reach = fraction_of(tube.reach)
    radius = min(map(fraction_of, tube.radii))
    sizes = [radius, reach / _LINK]
    if before is not None:
        sizes += [*before.tube.radii, before.tube.reach / _LINK]
    places = _places(min(sizes) * fine)
    alpha, theta = (_direction(pair, places) for pair in (tube.frame.alpha, tube.frame.theta))
    with ctx.workprec(bits):
        here = Place(*(HalfTangent(arb(s), arb(c)) for s, c in (alpha, theta)))
        leg = forms.steeper(here, tube.frame.length, bits)
    length = fraction_of(tube.frame.length) / slice_map.scale
    once, twice = (_places(radius / reach**k * fine) for k in (1, 2))
    return ShortTube(
        tube.axis,
        free_legs(slice_map.fixed_leg)[leg],
        alpha,
        theta,
        round(length, places + _places(length)),
        _pair(round(fraction_of(x), once) for x in tube.slopes),
        _pair(round(fraction_of(x), twice) for x in tube.bends),
        _rounded_to(reach, _REACH_DIGITS, floor),
        (Fraction(0), Fraction(0)),
    )


def _direction(half: Two, places: int) -> tuple[int, int]:
    s, c = (round(fraction_of(x) * Fraction(10) ** places) for x in half)
    common = gcd(s, c) or 1
    return s // common, c // common


def _places(size: Fraction) -> int:
    """The least number of decimal places, perhaps negative, whose unit is at most ``size`` > 0."""
    places = 0
    while Fraction(10) ** -places > size:
        places += 1
    while Fraction(10) ** -(places - 1) <= size:
        places -= 1
    return places


def _rounded_to(x: Fraction, digits: int, rounding: Callable[[Fraction], int]) -> Fraction:
    """A number > 0 with this number of significant digits."""
    unit = Fraction(10) ** (1 - digits - _places(x))
    return rounding(x / unit) * unit


def _balls(pair: Pair) -> Two:
    return ball_of(pair[0]), ball_of(pair[1])


def _pair(numbers: Iterable[Fraction]) -> Pair:
    p, q = numbers
    return p, q


def _text(x: Fraction) -> str:
    """An exact decimal, with an exponent if that is shorter."""
    text = exact_str(x)
    whole, _, part = text.partition(".")
    if whole.lstrip("-") != "0" or len(part) < _LONG:
        return text
    return f"{'-' * (x < 0)}{part.lstrip('0')}e-{len(part)}"
