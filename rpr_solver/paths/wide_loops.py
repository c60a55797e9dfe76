"""Loops round a cusp that keep far from J = 0: their ends are moved, too, in floats, before they are proved.

A loop begins and ends at one joint vector. Where that moves a little, both poses follow, and the way between
them, with two tails whose images are one curve run forth and back, goes round the cusp as before. So the
joint vector moves as long as the nearer of both poses gets away from J = 0; then the way between them is
widened as any other. Whether it still goes round the cusp alone is proved in the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.rationals import exact_str
from rpr_solver.paths.corridors import Corridors
from rpr_solver.paths.proofs import PROOF_BITS, PathProof, ProvedRoute
from rpr_solver.paths.route import IsolatedPose, Route
from rpr_solver.paths.samples import Clearance
from rpr_solver.paths.widest import polyline, simplified, widened

if TYPE_CHECKING:
    from rpr_solver.paths.singular_field import Doubles, SingularField

Proves = Callable[[Route], PathProof | None]
"""Whether a route is proved to be a loop round its cusp alone, within limits."""

_NEWTON_STEPS = 6
_CLOSE = 1e-9
_MOST_MOVES = 60
_FIRST_MOVE, _LAST_MOVE = 0.03, 1e-5
"""Of the joint vector, in units of the slice."""
_FARTHEST = 8.0
"""How many degrees a pose may go in one move."""
_SHARES = (1.0, 0.7, 0.45, 0.25, 0.1, 0.0)
_PLACES = 4


@dataclass(frozen=True)
class WideLoops:
    """The search for a wide loop.

    Attributes:
        corridors: the slice, and the poses at the ends of a loop that is known.
        proves: whether a route is a loop as it should be.
    """

    corridors: Corridors
    proves: Proves

    def widest(self, known: ProvedRoute) -> tuple[ProvedRoute, Clearance]:
        """The widest loop that is found, or the known one, with its clearance.

        Raises:
            Unproved: it has less than the clearance that is asked for.
        """
        best: tuple[ProvedRoute, Clearance] | None = None
        trail = self._trail(known[0])
        loop = polyline(known[0])
        for share in _SHARES:
            last = round(share * (len(trail) - 1))
            found = self._at(trail[: last + 1], loop)
            if found is not None and (best is None or found[1].proved > best[1].proved):
                best = found
            if best is not None and share <= _SHARES[2]:
                break
        if best is None and (clearance := self.corridors.clearance(known[0], bounded=False)):
            best = known, clearance
        asked = self.corridors.asked
        if best is None or best[1].proved < asked:
            most = "none" if best is None else f"{exact_str(best[1].proved)}°"
            raise Unproved(f"no loop with this clearance was found; the greatest that was proved is {most}")
        return best

    def _trail(self, route: Route) -> Doubles:
        """The poses at both ends (by moves, ends, angles), while their joint vector gets a greater room."""
        grid, field = self.corridors.grid, self.corridors.field
        way = polyline(route)
        here = way[[0, -1]]
        trail = [here]
        room = grid.nearest(here)[0].min()
        size = _FIRST_MOVE
        circle = np.exp(2j * np.pi * np.arange(12) / 12)
        while size > _LAST_MOVE and len(trail) < _MOST_MOVES:
            goals = leg_lengths(field, here[:1])[0] + size * np.stack([circle.real, circle.imag], -1)
            ends = np.stack([followed(field, np.tile(end, (len(goals), 1)), goals) for end in here], 1)
            good = np.isfinite(ends).all((1, 2)) & (abs(ends - here).max((1, 2)) < _FARTHEST)
            rooms = np.zeros(len(goals))
            if good.any():
                spots = ends[good].reshape(-1, 2)
                own = grid.nearest(spots)[0] * np.sign(grid.signs(spots))
                rooms[good] = own.reshape(-1, 2).min(axis=1)
            best = int(rooms.argmax())
            if rooms[best] <= room * (1 + 1e-3):
                size /= 2
                continue
            here, room = ends[best], rooms[best]
            trail.append(here)
        return np.array(trail)

    def _at(self, trail: Doubles, loop: Doubles) -> tuple[ProvedRoute, Clearance] | None:
        """The proved loop whose ends are those at the end of a trail."""
        ends = self._ends(trail[-1]) if len(trail) > 1 else (self.corridors.start, self.corridors.stop)
        if ends is None:
            return None
        corridors = replace(self.corridors, start=ends[0], stop=ends[1])
        way = np.concatenate([trail[:0:-1, 0], loop, trail[1:, 1]])
        way = widened(self.corridors.grid, way)
        room, _ = self.corridors.grid.nearest(way)
        route = corridors.route_along(way[simplified(way, room)])
        proof = self.proves(route)
        if proof is None or (clearance := corridors.clearance(route, bounded=False)) is None:
            return None
        return (route, proof), clearance

    def _ends(self, spots: Doubles) -> tuple[IsolatedPose, IsolatedPose] | None:
        """Both poses of a joint vector of short decimals near those of these poses."""
        pose, field = self.corridors.start, self.corridors.field
        slice_map = pose.slice_map
        scale = field.unit / slice_map.scale
        lengths = leg_lengths(field, spots[:1])[0].tolist()
        size = float(scale) * max(lengths)
        places = max(0, _PLACES - int(np.floor(np.log10(size))))
        legs = [Fraction(round(x * float(scale), places)).limit_denominator(10**places) for x in lengths]
        if not all(leg > 0 for leg in legs):
            return None
        joint = pose.legs[0], legs[0] * slice_map.scale, legs[1] * slice_map.scale
        with ctx.workprec(PROOF_BITS):
            starts = [(arb(x) * arb.pi() / 180, arb(y) * arb.pi() / 180) for x, y in spots.tolist()]
            first, last = (IsolatedPose.near(slice_map, joint, start) for start in starts)
        return (first, last) if first and last else None


def leg_lengths(field: SingularField, spots: Doubles) -> Doubles:
    """The lengths of both free legs at poses in degrees, in the unit of the slice."""
    return _legs(field, spots)[0]


def _legs(field: SingularField, spots: Doubles) -> tuple[Doubles, Doubles]:
    """The lengths, and their derivatives by degrees (by poses, legs, angles)."""
    turned, tip = (np.exp(1j * np.deg2rad(spots[:, n])) for n in (0, 1))
    tip = field.length * tip
    lengths, slopes = [], []
    for m, a in field.legs:
        vector = tip + turned * m - a
        size = abs(vector)
        lengths.append(size)
        parts = [(np.conj(vector) * 1j * part).real / size for part in (turned * m, tip)]
        slopes.append(np.stack(parts, -1) * np.pi / 180)
    return np.stack(lengths, -1), np.stack(slopes, 1)


def followed(field: SingularField, spots: Doubles, goals: Doubles) -> Doubles:
    """The poses near others that have these leg lengths, by Newton's method; not finite where it fails."""
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            lengths, slopes = _legs(field, spots)
            missing = goals - lengths
            det = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0]
            alpha = (missing[:, 0] * slopes[:, 1, 1] - missing[:, 1] * slopes[:, 0, 1]) / det
            theta = (missing[:, 1] * slopes[:, 0, 0] - missing[:, 0] * slopes[:, 1, 0]) / det
            spots = spots + np.stack([alpha, theta], -1)
        missing = goals - leg_lengths(field, spots)
        spots[abs(missing).max(axis=1) > _CLOSE] = np.nan
    return spots
