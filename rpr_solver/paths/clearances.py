"""The clearance of any path that is known, wide or narrow.

A wide path has a tube in doubles (:class:`~rpr_solver.paths.corridors.Corridors`). One that nearly touches a
singularity, as those of a machine that was rounded, has a bound by balls: on each of its pieces
|J| ≥ v, |∇J| ≤ s, and the second derivatives of J in the slice are at most b, so that no zero is nearer than
2 v / (s + √(s² + 2 b v)).
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import degrees

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.paths.corridors import Corridors
from rpr_solver.paths.path import Path
from rpr_solver.paths.proofs import PROOF_BITS, Clearance
from rpr_solver.paths.routes import Arc, Route, bounded, expanded, local_map
from rpr_solver.paths.samples import bend_bound

_FIRST_PIECES, _MOST_PIECES = 8, 1500
_CLOSE = 0.9
"""A bound is near enough to what a piece has in its middle, as a share of it."""
_OF_DOUBLES = 1e-5
"""Degrees: a path that is not known to keep so far has no tube in doubles."""


def with_clearance(path: Path, asked: Fraction = Fraction(0)) -> Path:
    """A path with its clearance: the path itself, if it has one already.

    Args:
        path: any path.
        asked: what it was to have, in degrees; 0 if nothing was asked for.
    """
    if path.clearance is not None and path.clearance.asked == _asked(asked):
        return path
    if path.clearance is not None:
        return replace(path, clearance=replace(path.clearance, asked=_asked(asked)))
    route = path.route
    rough = clearance_in_balls(route)
    found = None
    if rough > _OF_DOUBLES:
        lengths = [point.length for arc in route.arcs for point in arc if point is not None]
        scaled = [x * route.slice_map.scale for x in lengths] + [
            end.legs[0] for end in (route.start, route.stop)
        ]
        corridors = Corridors.of((route.start, route.stop), (min(scaled), max(scaled)), path.sign)
        found = corridors.clearance(route, bounded=False)
    if found is None or found.proved < rough:
        found = Clearance.of(route, Fraction(0), Fraction(rough), None, Fraction(0))
    return replace(path, clearance=replace(found, asked=_asked(asked)))


def _asked(asked: Fraction) -> str:
    return exact_str(asked)


def clearance_in_balls(route: Route) -> float:
    """A lower bound, in degrees, of how far a path keeps from the singular poses of its slices.

    Raises:
        Unproved: J may be 0 on it.
    """
    with ctx.workprec(PROOF_BITS):
        arcs = route.at(PROOF_BITS - 64)
        half = 0.5 / _FIRST_PIECES
        pieces = [
            (*_on_piece(route, arc, (2 * k + 1) * half, half), number, (2 * k + 1) * half, half)
            for number, arc in enumerate(arcs)
            for k in range(_FIRST_PIECES)
        ]
        heapify(pieces)
        # Invariant: the pieces cover the path, and its clearance is at least that of the first one.
        # It ends after so many pieces, or when the first one cannot be much better.
        for _ in range(_MOST_PIECES):
            least, most, number, tau, half = pieces[0]
            if least >= _CLOSE * most:
                break
            heappop(pieces)
            for side in (-half / 2, half / 2):
                own = _on_piece(route, arcs[number], tau + side, half / 2)
                heappush(pieces, (*own, number, tau + side, half / 2))
        if pieces[0][0] <= 0:
            raise Unproved("the clearance of a path could not be proved; it is too near a singularity")
        return pieces[0][0]


def _on_piece(route: Route, arc: Arc, tau: float, half: float) -> tuple[float, float]:
    """A lower bound of the clearance on a piece, and about that in its middle, in degrees."""
    slice_map, radius = route.slice_map, arb(half)
    near, wide = expanded(slice_map, arc, arb(tau), 1), expanded(slice_map, arc, arb(tau, half), 2)
    value = bounded(near.singularity, wide.singularity, radius)
    bounds = []
    for at, j_over in ((arb(tau, half), value), (arb(tau), near.singularity[0])):
        alpha, theta, length = (p(at) for p in (arc.alpha, arc.theta, arc.length))
        jet = local_map(slice_map, length, (alpha, theta), 2).singularity()
        slope = (jet.alpha.value**2 + jet.theta.value**2).sqrt().upper()
        bend = bend_bound(slice_map, length).upper()
        least = (length * j_over).abs_lower()
        found = 2 * least / (slope + (slope**2 + 2 * bend * least).sqrt())
        bounds.append(float(fraction_of(found.lower())) if found.is_finite() else 0.0)
    low, middle = (degrees(max(x, 0.0)) * (1 - 1e-12) for x in bounds)
    return low, middle
