"""The widest path between two poses that is found, the tube that proves its clearance, and a bound of all.

The bound is that of both ends: if a pose where J has the other sign, or none, is within X of an end of the
path, no path has a clearance above X.

A loop round a cusp begins and ends at one joint vector. Where that moves a little, both poses follow, and the
way between them, with two tails whose images are one curve run forth and back, goes round the cusp as before.
So the joint vector moves as long as the nearer of both poses gets away from J = 0; then the way between them
is widened as any other. Whether it still goes round the cusp alone is proved in the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import ROUND_DOWN
from fractions import Fraction
from math import ceil, hypot, log10
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import quotient, rounded_near, rounded_up
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.paths.joint_paths import rounded, sign_at
from rpr_solver.paths.pose_grid import PoseGrid, degrees_of
from rpr_solver.paths.proofs import (
    BOUND_DIGITS,
    NO_LIMITS,
    PROOF_BITS,
    Clearance,
    PathLimits,
    PathProof,
    ProvedRoute,
    proved_route,
)
from rpr_solver.paths.routes import DecimalPose, EndPose, IsolatedPose, Route
from rpr_solver.paths.singular_field import DEGREE, Pieces, Tube, followed, leg_lengths
from rpr_solver.paths.widest import on_arc, simplified, widened

if TYPE_CHECKING:
    from rpr_solver.paths.singular_field import Doubles

_SHARES = (0.985, 0.95, 0.85, 0.6, 0.3, 0.1)
"""Of the distance that is seen in floats, which a tube is tried with."""
_CLOSE = 1.03
"""How much wider a tube is that is no longer tried."""
_BEYOND = 0.002
"""The share of the way to the nearest zero of J by which a pose lies beyond it."""
_SAG = 0.004
"""What the pieces of an arc stray from their chords, at most, as a share of the room."""
_PROBES = 6
"""On each piece."""
_MOST_CUTS = 64
_CHANGE = 0.02
"""By which share of the room a change of the length on a piece may change it."""
_PARTS_OF_ARC = 40
"""Of an arc as a polyline."""


@dataclass(frozen=True)
class Corridors:
    """Paths in a slice or in a range of lengths where J has a sign, and how far they are from singular poses.

    Attributes:
        start: the first pose.
        stop: the last pose; its angles may differ by turns from where a path arrives.
        grid: on which paths are sought, where J has its sign at both.
        span: the scaled lengths of the fixed leg.
        limits: of the free legs.
        asked: the clearance that is required, in degrees; 0 for the greatest one.
    """

    start: EndPose
    stop: EndPose
    grid: PoseGrid
    span: tuple[Fraction, Fraction]
    limits: PathLimits = NO_LIMITS
    asked: Fraction = Fraction(0)

    @classmethod
    def of(
        cls,
        ends: tuple[EndPose, EndPose],
        span: tuple[Fraction, Fraction],
        sign: int,
        limits: PathLimits = NO_LIMITS,
        asked: Fraction = Fraction(0),
    ) -> Corridors:
        """Those between two poses with this sign of J, between two scaled lengths, which may be equal."""
        return cls(*ends, PoseGrid.of(ends, span, sign, limits), span, limits, asked)

    @property
    def sign(self) -> int:
        """The sign of J on the paths."""
        return self.grid.field.sign

    def widest(self, known: ProvedRoute) -> tuple[ProvedRoute, Clearance]:
        """The widest path that is found, if it is wider than a known one, with its clearance.

        Raises:
            Unproved: the poses are too near to J = 0.
        """
        routes = [known]
        if parts := self.grid.way((self.start, self.stop), is_wide=True):
            first, inner, last = parts
            wide = widened(self.grid, np.concatenate([first[-1:], inner, last[:1]]))
            found = proved_route(
                self.route_along(np.concatenate([first[:-1], wide, last[1:]])), self.sign, self.limits
            )
            routes[:0] = [] if found is None else [found]
        routes.sort(key=lambda found: -self.pieces(found[0])[1])
        for found in routes:
            clearance = self.clearance(found[0])
            if clearance is not None:
                return found, clearance
        raise Unproved("the clearance of the path could not be proved; a pose is too near a singularity")

    def route_along(self, way: Doubles) -> Route:
        """The smooth route along a way, round few of its spots."""
        way = simplified(self.grid, way)
        inner = zip(way[1:-1].tolist(), self.grid.nearest(way[1:-1])[0].tolist(), strict=True)
        points = [
            DecimalPose(decimal(alpha, room), decimal(theta, room), self.length_at(length))
            for (alpha, theta, length), room in inner
        ]
        return Route(*self.turned_ends(way), rounded([None, *points, None], Fraction(1, 2)))

    def length_at(self, length: float) -> Fraction:
        """A length of the grid in the user's unit: a short decimal in the range."""
        scale = self.start.slice_map.scale
        near = rounded_near(Fraction(length) * self.grid.field.unit / scale, 10)
        return min(max(near, self.span[0] / scale), self.span[1] / scale)

    def turned_ends(self, way: Doubles) -> tuple[EndPose, EndPose]:
        """Both poses in the turns in which a way begins and ends."""
        ends = []
        for pose, spot in ((self.start, way[0]), (self.stop, way[-1])):
            turns = [round((x - y) / 360) for x, y in zip(spot[:2].tolist(), degrees_of(pose), strict=True)]
            ends.append(pose.turned((turns[0], turns[1])))
        return ends[0], ends[1]

    def controls(self, route: Route) -> list[Doubles]:
        """The control points of the arcs of a route, as spots of the grid."""
        factor = route.slice_map.scale / self.grid.field.unit
        poses = zip((route.start, route.stop), self.grid.ends, strict=True)
        ends = iter([(*degrees_of(pose), length) for pose, length in poses])
        return [
            np.array(
                [
                    next(ends)
                    if p is None
                    else (float(p.alpha_deg), float(p.theta_deg), double(p.length * factor))
                    for p in arc
                ]
            )
            for arc in route.arcs
        ]

    def pieces(self, route: Route) -> tuple[Pieces, float]:
        """The pieces of a route, and its distance from J = 0, in units, as floats see it."""
        arcs = self.controls(route)
        bends = [abs(p[0] - 2 * p[1] + p[2]) / 4 if len(p) == 3 else 0 * p[0] for p in arcs]
        rough = np.concatenate([on_arc(p, 4) for p in arcs])
        rooms = np.maximum(self.grid.nearest(rough)[0].reshape(-1, 5).min(axis=1), 1e-9).tolist()
        steep = self.grid.steepness(rough)
        cuts = []
        for p, bend, room in zip(arcs, bends, rooms, strict=True):
            needs = (hypot(*bend[:2]) / (_SAG * room)) ** 0.5, hypot(*(p[-1] - p[0])[:2]) / room
            change = float(np.ptp(p[:, 2])) * steep / (_CHANGE * room)
            cuts.append(min(max(1, *map(ceil, (*needs, change))), _MOST_CUTS))
        spots = [on_arc(p, _PROBES * n) for p, n in zip(arcs, cuts, strict=True)]
        least = float(self.grid.nearest(np.concatenate(spots))[0].min())
        kept = slice(2 if self.grid.is_held else 3)
        first, last = (
            np.concatenate([x[k::_PROBES][:n, kept] for x, n in zip(spots, cuts, strict=True)])
            for k in (0, _PROBES)
        )
        strays = np.concatenate([np.tile(x / n**2, (n, 1)) for x, n in zip(bends, cuts, strict=True)])
        return Pieces.of(first, last, strays), least * DEGREE

    def clearance(self, route: Route, *, bounded: bool = True) -> Clearance | None:
        """The proved clearance of a route, and, if that is wanted, a bound of all that join its ends."""
        tube = self._tube(*self.pieces(route))
        if tube is None:
            return None
        proved = Fraction(tube.radius) / Fraction(DEGREE)
        legs = Fraction(tube.rate) * self.grid.field.unit / self.start.slice_map.scale
        bounds = (self._bound(end) for end in (0, 1)) if bounded else ()
        return Clearance.of(route, self.asked, proved, min(filter(None, bounds), default=None), legs)

    def _tube(self, pieces: Pieces, seen: float) -> Tube | None:
        """The widest tube that is proved, or one nearly as wide."""
        most, field = _SHARES[0], self.grid.field
        for share in _SHARES if seen > 0 else ():
            if tube := Tube.proved(field, pieces, share * seen):
                break
            most = share
        else:
            return None
        # Invariant: ``tube`` has the radius ``share``, and that of ``most`` was not proved, or is the same.
        # It ends as their ratio falls with each step.
        while most > share * _CLOSE:
            middle = (most + share) / 2
            if wider := Tube.proved(field, pieces, middle * seen):
                tube, share = wider, middle
            else:
                most = middle
        return tube

    def _bound(self, end: int) -> Fraction | None:
        """How far a pose is at most from one where J has the other sign, in degrees: no path from it has a
        greater clearance. None if that is not proved."""
        pose = (self.start, self.stop)[end]
        spot = np.array(degrees_of(pose))
        foot = self.grid.slices[self.grid.slice_of(end)].nearest(spot[None])[1][0]
        beyond = [Fraction(x) for x in (foot + (foot - spot) * _BEYOND).tolist()]
        with ctx.workprec(PROOF_BITS):
            alpha, theta = (ball_of(x) * arb.pi() / 180 for x in beyond)
            if sign_at(pose.slice_map, pose.legs[0], (alpha, theta)) != -self.sign:
                return None
            away = [ball_of(x) - y * 180 / arb.pi() for x, y in zip(beyond, pose.angles, strict=True)]
            far = (away[0] ** 2 + away[1] ** 2).sqrt().abs_upper()
            return rounded_up(fraction_of(far), BOUND_DIGITS)


Proves = Callable[[Route], PathProof | None]
"""Whether a route is proved to be a loop round its cusp alone, within limits."""

_MOST_MOVES = 60
_FIRST_MOVE, _LAST_MOVE = 0.03, 1e-5
"""Of the joint vector, in units of the slice."""
_FARTHEST = 8.0
"""How many degrees a pose may go in one move."""
_OF_TRAIL = (1.0, 0.7, 0.45, 0.25, 0.1, 0.0)
_LEG_PLACES = 4
_DIGITS_OF_DOUBLES = 17


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
        loop = self._polyline(known[0])
        trail = self._trail(loop)
        for share in _OF_TRAIL:
            last = round(share * (len(trail) - 1))
            found = self._at(trail[: last + 1], loop)
            if found is not None and (best is None or found[1].proved > best[1].proved):
                best = found
            if best is not None and share <= _OF_TRAIL[2]:
                break
        if best is None and (clearance := self.corridors.clearance(known[0], bounded=False)):
            best = known, clearance
        if best is None or best[1].proved < self.corridors.asked:
            most = "none" if best is None else f"{exact_str(best[1].proved)}°"
            raise Unproved(f"no loop with this clearance was found; the greatest that was proved is {most}")
        return best

    def _polyline(self, route: Route) -> Doubles:
        """Spots of a route."""
        arcs = [on_arc(controls, _PARTS_OF_ARC) for controls in self.corridors.controls(route)]
        return np.concatenate([arcs[0][:1], *(arc[1:] for arc in arcs)])

    def _trail(self, loop: Doubles) -> Doubles:
        """The poses at both ends (by moves, ends, angles), while their joint vector gets a greater room."""
        [own], field = self.corridors.grid.slices, self.corridors.grid.field
        here = loop[[0, -1], :2]
        trail = [here]
        room = own.nearest(here)[0].min()
        size = _FIRST_MOVE
        circle = np.exp(2j * np.pi * np.arange(12) / 12)
        while size > _LAST_MOVE and len(trail) < _MOST_MOVES:
            goals = leg_lengths(field, here[:1])[0] + size * np.stack([circle.real, circle.imag], -1)
            ends = np.stack([followed(field, np.tile(end, (len(goals), 1)), goals) for end in here], 1)
            good = np.isfinite(ends).all((1, 2)) & (abs(ends - here).max((1, 2)) < _FARTHEST)
            rooms = np.zeros(len(goals))
            if good.any():
                rooms[good] = own.nearest(ends[good].reshape(-1, 2))[0].reshape(-1, 2).min(axis=1)
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
        way = np.concatenate([trail[:0:-1, 0], loop[:, :2], trail[1:, 1]])
        way = np.concatenate([way, np.full((len(way), 1), corridors.grid.ends[0])], axis=1)
        route = corridors.route_along(widened(corridors.grid, way))
        proof = self.proves(route)
        if proof is None or (clearance := corridors.clearance(route, bounded=False)) is None:
            return None
        return (route, proof), clearance

    def _ends(self, spots: Doubles) -> tuple[IsolatedPose, IsolatedPose] | None:
        """Both poses of a joint vector of short decimals near those of these poses."""
        pose, field = self.corridors.start, self.corridors.grid.field
        slice_map = pose.slice_map
        scale = field.unit / slice_map.scale
        lengths = [scale * Fraction(x) for x in leg_lengths(field, spots[:1])[0].tolist()]
        if not all(lengths):
            return None
        places = max(0, _LEG_PLACES - quotient(max(lengths), 1, ROUND_DOWN).adjusted())
        legs = [
            rounded_near(Fraction(round(x * 10**places), 10**places), _DIGITS_OF_DOUBLES) for x in lengths
        ]
        if not all(leg > 0 for leg in legs):
            return None
        joint = pose.legs[0], legs[0] * slice_map.scale, legs[1] * slice_map.scale
        with ctx.workprec(PROOF_BITS):
            starts = [(arb(x) * arb.pi() / 180, arb(y) * arb.pi() / 180) for x, y in spots.tolist()]
            first, last = (IsolatedPose.near(slice_map, joint, start) for start in starts)
        return (first, last) if first and last else None


def decimal(angle: float, room: float) -> Fraction:
    """An angle as a short decimal that differs from it by little of the room."""
    places = max(4, 4 - ceil(log10(max(room, 1e-12))))
    return Fraction(round(angle * 10**places), 10**places)
