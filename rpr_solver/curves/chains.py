"""Chains of tubes, the full certificate of cusp curves: the proof that points are joined, to be checked.

    {"chains": [{"from": {"curve": "C1", "l1": "27"}, "to": {"curve": "C1", "l1": "28"}, "tubes": [
        {"parameter": "l1", "leg": 2, "half_alpha": ["s", "c"], "half_theta": ["s", "c"], "l1": "27",
         "slopes": ["…", "…"], "bends": ["…", "…"], "reach": "…", "radii": ["…", "…"]}, …]}, …]}

A chain leads from one point of the document to another, of the same curve or, past the end at which the two
curves join, of the other one. The first tube holds the first point, each other one begins on the curve in
the tube before it, and the last one holds the last point. A tube is a :class:`ShortTube`:
its numbers have few digits, as a certificate prints them, are exact, and are proved again as printed.

Rounding moves a tube's origin off the curve and bends its parabola, so the radii are computed again, and
Krawczyk's test is passed by the printed numbers themselves (mathematics.md#tubes).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import ceil, floor, gcd
from typing import Any

from flint import arb, ctx

from rpr_solver.contract import Progress
from rpr_solver.curves.cusp_curve import CurvePoint, CuspCurve
from rpr_solver.curves.follower import LostError, Tracker
from rpr_solver.curves.neighbourhood import CuspForms, Expansion, Frame, PoseBox, Two
from rpr_solver.curves.tubes import (
    BOUND_BITS,
    Bounds,
    Tube,
    by_power,
    on_parabola,
    preconditioned,
)
from rpr_solver.errors import Unproved
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import LengthRange

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


@dataclass(frozen=True)
class ProvedTube:
    """A short tube with its equations in balls of ``bits``, to test it and points in it.

    Attributes:
        frame: the origin of its coordinates.
        equations: J and E, preconditioned, by powers of its parameter.
    """

    tube: ShortTube
    bits: int
    frame: Frame
    equations: tuple[Expansion, Expansion]

    @classmethod
    def of(cls, tube: ShortTube, forms: CuspForms, bits: int) -> ProvedTube | None:
        """The tube; None if the curve is too steep in its parameter at the origin."""
        slice_map = forms.slice_map
        with ctx.workprec(bits):
            alpha, theta = ((arb(s), arb(c)) for s, c in (tube.alpha, tube.theta))
            frame = Frame(alpha, theta, ball_of(tube.length * slice_map.scale))
            singular, coalescence = forms.at(bits)
            e = coalescence[free_legs(slice_map.fixed_leg).index(tube.leg)]
            equations = preconditioned(
                *(by_power(form, tube.parameter) for form in frame.expanded(singular, e))
            )
        return None if equations is None else cls(tube, bits, frame, equations)

    def radii(self) -> Two | None:
        """Radii that pass the test; None if none are found."""
        with ctx.workprec(BOUND_BITS):
            return self._bounds().radii(ball_of(self.tube.reach), (arb(0), arb(0)))[0]

    def passes(self) -> bool:
        """Whether the printed radii pass the test."""
        with ctx.workprec(BOUND_BITS):
            return self._bounds().passes(ball_of(self.tube.reach), _balls(self.tube.radii))

    def middle(self) -> tuple[PoseBox, arb] | None:
        """A small box that is proved to hold the point with r = 0, and its lengths; None if none is found."""
        zero = arb(0), arb(0)
        with ctx.workprec(BOUND_BITS):
            p, q = (radius * _SLIM for radius in _balls(self.tube.radii))  # positive, at least
            radii, _ = Bounds.of(self.equations, zero, zero).radii(arb(0), (p, q))
        if radii is None:
            return None
        with ctx.workprec(self.bits):
            box = [arb(0, radius) for radius in radii]
            box.insert(self.tube.parameter, arb(0))
            return self.frame.outside(box[0], box[1]), self.frame.length * (1 + box[2])

    def contains(self, place: PoseBox, length: arb) -> bool:
        """Whether a box lies in the tube."""
        with ctx.workprec(self.bits):
            box = list(self.frame.inside(place, length))
            r = box.pop(self.tube.parameter)
            if not abs(r) <= ball_of(self.tube.reach):
                return False
            middle = on_parabola(_balls(self.tube.slopes), _balls(self.tube.bends), r)
            return all(
                bool(abs(w - m) < radius)
                for w, m, radius in zip(box, middle, _balls(self.tube.radii), strict=True)
            )

    def _bounds(self) -> Bounds:
        return Bounds.of(self.equations, _balls(self.tube.slopes), _balls(self.tube.bends))


def shortened(
    tube: Tube, forms: CuspForms, bits: int, before: ProvedTube | None, start: tuple[PoseBox, arb] | None
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
    proved = ProvedTube.of(tube, forms, bits)
    if proved is None:
        return None
    radii = proved.radii()
    if radii is None:
        return None
    p, q = (_rounded_to(fraction_of(radius), _RADIUS_DIGITS, ceil) for radius in radii)
    proved = replace(proved, tube=replace(tube, radii=(p, q)))
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
        here = PoseBox(*(HalfTangent(arb(s), arb(c)) for s, c in (alpha, theta)))
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


_MOST_TUBES = 1 << 13


@dataclass(frozen=True)
class _Link:
    """Two points, by their curves, that a chain is to join, and the lengths that it may not leave."""

    start: tuple[str, CurvePoint]
    stop: tuple[str, CurvePoint]
    low: Fraction
    high: Fraction
    upwards: bool

    def backwards(self) -> _Link:
        """The same from the other point; past an end at which two curves join, the way is the same."""
        turns = self.start[0] != self.stop[0]
        return _Link(self.stop, self.start, self.low, self.high, self.upwards is turns)


def full_certificate(
    tracker: Tracker, curves: tuple[CuspCurve, ...], span: LengthRange, progress: Progress
) -> dict[str, Any]:
    """The member ``full``: chains between the neighbouring points of each curve, and past the ends that join.

    Raises:
        Unproved: no tubes lead from one point to the other.
    """
    leg = tracker.eliminant.slice_map.fixed_leg
    links = list(_links(curves, span))
    chains = []
    for done, link in enumerate(links):
        progress(done, len(links))
        tubes = _chain(tracker, link)
        if tubes is None:
            link = link.backwards()
            tubes = _chain(tracker, link)
        if tubes is None:
            (name, point), (other, _) = link.start, link.stop
            raise Unproved(f"no tubes lead from {name} at {exact_str(point.length)} to {other}")
        ends = {
            side: {"curve": name, f"l{leg}": exact_str(point.length)}
            for side, (name, point) in (("from", link.start), ("to", link.stop))
        }
        chains.append({**ends, "tubes": [tube.to_json(leg) for tube in tubes]})
    progress(len(links), len(links))
    return {"chains": chains}


def _links(curves: tuple[CuspCurve, ...], span: LengthRange) -> Iterator[_Link]:
    by_name = {curve.name: curve for curve in curves}
    for curve in curves:
        for a, b in pairwise(curve.points):
            yield _Link((curve.name, a), (curve.name, b), a.length, b.length, upwards=True)
        for end, place, upwards in ((curve.start, 0, False), (curve.stop, -1, True)):
            other = by_name.get(end.joins or "")
            if other is None or other.name <= curve.name or not (curve.points and other.points):
                continue
            here, there, turn = curve.points[place], other.points[place], Fraction(end.length or 0)
            if here.length == there.length and turn in span:
                low, high = (here.length, 2 * turn) if upwards else (turn / 2, here.length)
                yield _Link((curve.name, here), (other.name, there), low, high, upwards)


def _chain(tracker: Tracker, link: _Link) -> list[ShortTube] | None:
    """The tubes from one point to the other; None if they lead elsewhere."""
    (_, start), (_, stop) = link.start, link.stop
    scale = tracker.eliminant.slice_map.scale
    follower = tracker.follower((start.length, start.cusp - 1), upwards=link.upwards)
    proved: list[ProvedTube] = []
    for _ in range(_MOST_TUBES):
        try:
            arrival = follower.walk(link.low * scale, link.high * scale, 0)
        except LostError:
            return None
        if arrival is not None:
            break
        assert follower.tube is not None
        before = proved[-1] if proved else None
        place = None if proved else tracker.place((start.length, start.cusp - 1), follower.bits)
        short = shortened(follower.tube, tracker.forms, follower.bits, before, place)
        if short is None:
            return None
        proved.append(short)
    else:
        return None
    last = proved[-1]
    goal = tracker.place((stop.length, stop.cusp - 1), last.bits)
    return [x.tube for x in proved] if last.contains(*goal) else None
