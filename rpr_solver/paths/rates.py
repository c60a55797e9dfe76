"""How fast leg lengths change along the arcs of a path: proved bounds of their derivatives by τ.

On a piece of half-width r about τ the k-th Taylor coefficient of a leg length lies in
cₖ(τ) + (k + 1) cₖ₊₁(piece) [−r, r], which is narrower than cₖ(piece) (mean value theorem).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PROOF_BITS
from rpr_solver.paths.routes import Arc, Route, by_leg, expanded

PIECES = 32
"""The number of equal pieces of τ of each arc."""
_ORDER = 3
_SMALL, _SMALLEST = Fraction(1, 1 << 11), Fraction(1, 1 << 24)
"""Half the width of the smallest pieces, for better bounds and for any."""
_SHARE = 1 / 16

LegRates: TypeAlias = tuple[Fraction, ...]
"""Upper bounds of |dL/dτ|, |d²L/dτ²| and |d³L/dτ³|, in the user's unit."""
Rates: TypeAlias = tuple[LegRates, ...]
"""Those of leg 1, leg 2 and leg 3."""
_STILL: LegRates = (Fraction(0),) * _ORDER
_EVEN = tuple(Fraction(k, PIECES) for k in range(PIECES + 1))


@dataclass(frozen=True)
class ArcRates:
    """The bounds on each piece of one arc, or of arcs that are run through by one parameter from 0 to 1.

    Attributes:
        pieces: the bounds on pieces.
        marks: the parameters at the ends of the pieces.
    """

    pieces: tuple[Rates, ...]
    marks: tuple[Fraction, ...] = _EVEN

    @classmethod
    def of(cls, slice_map: SliceMap, arc: Arc, *, is_held: bool) -> ArcRates:
        """The bounds of an arc, on which the fixed leg keeps its length if ``is_held``.

        Raises:
            Unproved: a leg is too near to length zero.
        """
        half = Fraction(1, 2 * PIECES)
        with ctx.workprec(PROOF_BITS):
            found = [_on(slice_map, arc, (2 * k + 1) * half, half) for k in range(PIECES)]
        leg = slice_map.fixed_leg
        return cls(tuple(by_leg(leg, [_STILL if is_held else legs[0], *legs[1:]]) for legs in found))

    @classmethod
    def joined(cls, arcs: Sequence[ArcRates], shares: Sequence[Fraction]) -> ArcRates:
        """The bounds of arcs one after another, each on its share of the parameter."""
        pieces, marks, start = [], [Fraction(0)], Fraction(0)
        for arc, share in zip(arcs, shares, strict=True):
            factors = 1 / share, 1 / share**2, 1 / share**3
            pieces += [tuple(multiplied(own, factors) for own in rates) for rates in arc.pieces]
            marks += [start + share * mark for mark in arc.marks[1:]]
            start += share
        return cls(tuple(pieces), tuple(marks))

    def meeting(self, low: Fraction, high: Fraction) -> slice:
        """The pieces that the part low ≤ τ ≤ high meets."""
        first = min(bisect_right(self.marks, low), len(self.pieces)) - 1
        return slice(first, max(bisect_left(self.marks, high), first + 1))

    def between(self, low: Fraction, high: Fraction) -> Rates:
        """The bounds for low ≤ τ ≤ high."""
        return greatest(self.pieces[self.meeting(low, high)])

    @cached_property
    def all(self) -> Rates:
        """The bounds on the whole arc."""
        return greatest(self.pieces)


def multiplied(numbers: Sequence[Fraction], factors: Sequence[Fraction]) -> tuple[Fraction, ...]:
    """Numbers, each times its factor."""
    return tuple(x * factor for x, factor in zip(numbers, factors, strict=True))


def greatest(pieces: Sequence[Rates]) -> Rates:
    """The bounds that hold on all of some pieces."""
    if len(pieces) == 1:
        return pieces[0]
    return tuple(tuple(map(max, *legs)) for legs in zip(*pieces, strict=True))


def rates_of(route: Route) -> tuple[ArcRates, ...]:
    """The bounds of all arcs of a path.

    Raises:
        Unproved: a leg is too near to length zero.
    """
    own = [pose.legs[0] / route.slice_map.scale for pose in (route.start, route.stop)]
    lengths = {*own, *(p.length for arc in route.arcs for p in arc if p is not None)}
    arcs = route.at(PROOF_BITS - 64)
    return tuple(ArcRates.of(route.slice_map, arc, is_held=len(lengths) == 1) for arc in arcs)


def _on(slice_map: SliceMap, arc: Arc, tau: Fraction, half: Fraction) -> Rates:
    """The bounds for the fixed leg and both others at a distance of at most ``half`` from a parameter.

    Where they are much greater than in the middle the piece is halved.
    """
    middle, reach = ball_of(tau), arb(0, ball_of(half).abs_upper())
    near, wide = (legs_near(slice_map, arc, at, _ORDER + k) for k, at in ((0, middle), (1, middle + reach)))
    scale, found = slice_map.scale_ball(), []
    fastest = max(float(abs(x[1])) for x in near)
    for x, y in zip(near, wide, strict=True):
        bounds = [(abs(x[k] + (k + 1) * y[k + 1] * reach)).upper() for k in range(1, _ORDER + 1)]
        is_finite = all(bound.is_finite() for bound in bounds)
        if half > (_SMALL if is_finite else _SMALLEST) and _are_loose(bounds, (x[1], x[2]), fastest):
            return greatest([_on(slice_map, arc, tau + side * half / 2, half / 2) for side in (-1, 1)])
        if not is_finite:
            raise Unproved("a leg is too short to bound its speed")
        sizes = (factorial * bound / scale for factorial, bound in zip((1, 2, 6), bounds, strict=True))
        found.append(tuple(fraction_of(size.upper()) for size in sizes))
    return tuple(found)


def _are_loose(bounds: Sequence[arb], middle: Sequence[arb], fastest: float) -> bool:
    """Whether the first bounds are infinite, or much greater than the values in the middle."""
    return any(
        not bound.is_finite() or float(bound) > 2 * float(abs(at)) + more
        for bound, at, more in zip(bounds, middle, (_SHARE * fastest, fastest), strict=False)
    )


def legs_near(slice_map: SliceMap, arc: Arc, tau: arb, order: int) -> list[arb_series]:
    """The Taylor series of the fixed leg and of the others, scaled; over a ball, bounds of them."""
    at = expanded(slice_map, arc, tau, order)
    fixed = arb_series(list(arc.length(arb_poly([tau, 1]))), prec=order + 1)
    return [fixed, (2 * at.first).sqrt(), (2 * at.second).sqrt()]
