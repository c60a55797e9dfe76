"""What is proved about a path: J keeps its sign along it, the free legs keep their limits, and its image goes
round a point of the plane of the free legs; and its clearance, if that is asked for.

A path is cut into pieces until balls decide all questions on each. On a piece of half-width r about τ the
values lie in F(τ) + F′(τ)[−r, r] + F″(piece)[0, r²]/2, which shrinks with the square of the width
(mathematics.md#paths-without-a-singularity).

Limits are closed: a leg may be as long as its limit. Where the joint vector of the path itself lies on one,
balls cannot show that the path stays within it, but the slope of the length at the end shows that it leaves
the limit inwards.

The clearance of a path is how far it keeps from all singular poses of its slice: the radius, in degrees of
(α, θ), of a tube round the path in which J is proved to have no zero; and, as a change of leg lengths, what
both free legs may at least change together before the pose meets a fold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

from flint import acb, arb, ctx

from rpr_solver.errors import ControlFlow
from rpr_solver.exact.decimals import rounded_down
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.routes import (
    NO_LEGS,
    Arc,
    DecimalPose,
    EndLegs,
    EndPose,
    Image,
    Route,
    bounded,
    expanded,
)

NO_BOUNDS: Bounds = (None, None)


@dataclass(frozen=True)
class Wall:
    """One limit: ``side`` · (half the squared length) is at most ``side`` · ``height``.

    Attributes:
        leg: 0 or 1, the number of the free leg.
        side: 1 for a maximum, −1 for a minimum.
        height: half the square of the scaled limit.
        touched: whether the start of the path lies on it, and whether its end does; or is just inside it.
    """

    leg: int
    side: int
    height: Fraction
    touched: tuple[bool, bool]

    def room(self, value: arb) -> arb:
        """How far a value is inside; negative beyond the limit."""
        return (ball_of(self.height) - value) * self.side


_NEAR = Fraction(1, 100)
"""Of half the square of a limit: what is just inside it."""


@dataclass(frozen=True)
class PathLimits:
    """The limits of the two free legs of a path."""

    walls: tuple[Wall, ...] = ()

    @classmethod
    def of(
        cls,
        slice_map: SliceMap,
        bounds: Mapping[int, Bounds],
        ends: tuple[EndLegs, EndLegs] = (NO_LEGS, NO_LEGS),
    ) -> PathLimits:
        """The limits by the legs' numbers, in the user's unit; ``ends`` has the legs of the path's ends."""
        walls = []
        for number, leg in enumerate(free_legs(slice_map.fixed_leg)):
            lengths = [legs[1 + number] for legs in ends]
            for bound, side in zip(bounds.get(leg, NO_BOUNDS), (-1, 1), strict=True):
                if bound is not None:
                    limit = bound * slice_map.scale
                    touched = lengths[0] == limit, lengths[1] == limit
                    walls.append(Wall(number, side, limit * limit / 2, touched))
        return cls(tuple(walls))

    def closer(self, ends: tuple[EndPose, EndPose]) -> PathLimits:
        """The same limits; exact ends just inside one count as if they lay on it.

        That is sound for ends that keep the limits: a length that leaves a limit inwards from within it
        keeps it.
        """

        def is_near(wall: Wall, end: EndPose) -> bool:
            length = end.legs[1 + wall.leg]
            return length is not None and (wall.height - length**2 / 2) * wall.side < _NEAR * wall.height

        return PathLimits(
            tuple(
                replace(wall, touched=(is_near(wall, ends[0]), is_near(wall, ends[1]))) for wall in self.walls
            )
        )

    def hold(
        self, image: Sequence[arb], slopes: Sequence[arb], *, at_start: bool = False, at_stop: bool = False
    ) -> bool:
        """Whether a piece of a path is proved to keep the limits.

        Args:
            image: half the squared lengths on the piece.
            slopes: their derivatives along it.
            at_start: whether the piece begins where the path begins.
            at_stop: whether it ends where the path ends.
        """
        return all(
            wall.room(image[wall.leg]) >= 0
            or (wall.touched[0] and at_start and slopes[wall.leg] * wall.side < 0)
            or (wall.touched[1] and at_stop and slopes[wall.leg] * wall.side > 0)
            for wall in self.walls
        )

    def exclude(self, image: Sequence[arb]) -> bool:
        """Whether values of half the squared lengths are all proved to be beyond one of the limits."""
        return any(wall.room(image[wall.leg]) < 0 for wall in self.walls)


NO_LIMITS = PathLimits()
"""Every length is allowed."""


def outside(bounds: Mapping[int, Bounds], lengths: Sequence[Fraction]) -> list[int]:
    """The legs that are shorter or longer than their limits allow; lengths are L1, L2, L3.

    >>> outside({2: (Fraction(5), None)}, [Fraction(3), Fraction(4), Fraction(5)])
    [2]
    """
    found = []
    for leg, (low, high) in sorted(bounds.items()):
        length = lengths[leg - 1]
        if (low is not None and length < low) or (high is not None and length > high):
            found.append(leg)
    return found


PROOF_BITS = 160
"""The working precision of the proofs."""
_FIRST_CUT = 4
_SMALLEST = 2.0**-24


@dataclass(frozen=True)
class PathProof:
    """What is proved about a path.

    Attributes:
        sign: of J, the same all along.
        pieces: the number of pieces on which balls decided it.
        least: a lower bound of |J| / (L1 L2 L3) along the path (scaled).
        windings: for each point that was given, how often the image turns round it, counter-clockwise.
    """

    sign: int
    pieces: int
    least: arb
    windings: tuple[int, ...]


ProvedRoute: TypeAlias = tuple[Route, PathProof]


class Unfinished(ControlFlow):
    """Control flow between modules: a proof takes too many pieces.

    Attributes:
        share: how much of the last arc was proved.
    """

    def __init__(self, share: float) -> None:
        super().__init__(share)
        self.share = share


_MOST_PIECES = 4000


def prove(
    slice_map: SliceMap,
    arcs: Sequence[Arc],
    sign: int,
    centres: Sequence[Image] = (),
    most_pieces: int = _MOST_PIECES,
    limits: PathLimits = NO_LIMITS,
    at_ends: tuple[bool, bool] = (True, True),
) -> PathProof | None:
    """Proves that J has this sign along the arcs, and how often their closed image winds round each centre.

    The arcs must follow one another; with a centre, the image of the first point must be that of the last.
    ``at_ends`` says whether the first point is the start of the path, and the last one its end. Returns None
    if J changes its sign, the image meets a centre, a leg exceeds its limits, or the balls do not decide it.
    """
    try:
        return _proof(slice_map, arcs, sign, centres, most_pieces, limits, at_ends)
    except Unfinished:
        return None


def _proof(
    slice_map: SliceMap,
    arcs: Sequence[Arc],
    sign: int,
    centres: Sequence[Image],
    most_pieces: int,
    limits: PathLimits,
    at_ends: tuple[bool, bool],
) -> PathProof | None:
    """As :func:`prove`.

    Raises:
        Unfinished: it takes more pieces.
    """
    pieces, turns, least = 0, [arb(0)] * len(centres), arb("+inf")
    for arc, is_start, is_stop in _with_ends(arcs, at_ends):
        stack = _first_pieces()
        start = _seen(slice_map, arc, arb(0), centres)
        while stack:
            tau, half = stack.pop()
            pieces += 1
            near = expanded(slice_map, arc, tau, 1)
            if near.singularity[0] * sign < 0 or limits.exclude((near.first[0], near.second[0])):
                return None
            if pieces > most_pieces:
                raise Unfinished(float(tau.mid()) - half)
            wide = expanded(slice_map, arc, arb(tau, half), 2)
            radius = arb(half)
            value = bounded(near.singularity, wide.singularity, radius) * sign
            image = bounded(near.first, wide.first, radius), bounded(near.second, wide.second, radius)
            bends = None
            kept = limits.hold(
                image,
                (wide.first[1], wide.second[1]),
                at_start=is_start and tau == half,
                at_stop=is_stop and tau + half == 1,
            )
            if kept and all(x > 0 for x in (value, *image)):
                end = _seen(slice_map, arc, tau + radius, centres)
                bends = _bends(image, start, end, centres)
            if bends is not None:
                turns = [turn + bend for turn, bend in zip(turns, bends, strict=True)]
                legs = 2 * (image[0].abs_upper() * image[1].abs_upper()).sqrt()
                start, least = end, least.min((value.abs_lower() / legs).lower())
            elif half < _SMALLEST:
                return None
            else:
                quarter = half / 2
                stack += [(tau + quarter, quarter), (tau - quarter, quarter)]
    windings = _windings(turns)
    return None if windings is None else PathProof(sign, pieces, least, windings)


def proved_route(
    route: Route, sign: int, limits: PathLimits = NO_LIMITS, centres: Sequence[Image] = ()
) -> ProvedRoute | None:
    """A route with its proof, as :func:`prove` finds it at the working precision of proofs.

    Raises:
        Unproved: a pose at an end cannot be refined so far.
    """
    with suppress(Unfinished):
        return finished_route(route, sign, limits, centres)
    return None


def finished_route(
    route: Route, sign: int, limits: PathLimits, centres: Sequence[Image]
) -> ProvedRoute | None:
    """As :func:`proved_route`.

    Raises:
        Unproved: a pose at an end cannot be refined so far.
        Unfinished: the proof takes too many pieces.
    """
    with ctx.workprec(PROOF_BITS):
        arcs = route.at(PROOF_BITS - 64)
        proof = _proof(route.slice_map, arcs, sign, centres, _MOST_PIECES, limits, (True, True))
    return None if proof is None else (route, proof)


def _with_ends(arcs: Sequence[Arc], at_ends: tuple[bool, bool]) -> list[tuple[Arc, bool, bool]]:
    """Each arc, whether it begins at the start of the path, and whether it ends at the path's end."""
    last = len(arcs) - 1
    return [(arc, at_ends[0] and k == 0, at_ends[1] and k == last) for k, arc in enumerate(arcs)]


def _windings(turns: Sequence[arb]) -> tuple[int, ...] | None:
    """How often angles are whole turns; None if one is not decided."""
    found = [n for turn in turns if (n := (turn / (2 * arb.pi())).unique_fmpz()) is not None]
    return tuple(map(int, found)) if len(found) == len(turns) else None


def _first_pieces() -> list[tuple[arb, float]]:
    """The middles and half lengths of the first pieces of an arc, the last piece first."""
    return [(arb(2 * k + 1) / (2 * _FIRST_CUT), 0.5 / _FIRST_CUT) for k in reversed(range(_FIRST_CUT))]


def _seen(slice_map: SliceMap, arc: Arc, tau: arb, centres: Sequence[Image]) -> list[acb]:
    """The point of the image at a parameter, as each centre sees it."""
    if not centres:
        return []
    at = expanded(slice_map, arc, tau, 0)
    return [acb(at.first[0] - x, at.second[0] - y) for x, y in centres]


def _bends(
    image: Image, starts: Sequence[acb], ends: Sequence[acb], centres: Sequence[Image]
) -> list[arb] | None:
    """The angles through which a piece of the image turns about the centres; None if its box meets one.

    A box without the centre is seen from it under less than 180°.
    """
    bends = []
    for (x, y), start, end in zip(centres, starts, ends, strict=True):
        if acb(image[0] - x, image[1] - y).contains(0):
            return None
        angle = (end / start).arg()
        if not (angle.is_finite() and abs(angle) < arb.pi()):
            return None
        bends.append(angle)
    return bends


BEST = "best"
"""Asks for the widest path; a number, in degrees, for one with at least this clearance."""
BOUND_DIGITS = 6
"""The significant digits of bounds, which are rounded down."""


@dataclass(frozen=True)
class Clearance:
    """How far a path keeps from all singular poses with the same fixed length.

    Attributes:
        asked: ``"best"``, or what was required, in degrees.
        proved: in degrees: from any pose of the path, α and θ may change together (in the Euclidean norm) by
            less than this, and no singular pose is met. Rounded down.
        bound: in degrees: no path with these ends has a greater clearance, since an end is so near to a
            singular pose, proved. Rounded up; None if that is not proved, and for loops.
        legs: from any pose of the path, both free legs may change together (in the Euclidean norm) by less
            than this before a fold can be met; in the user's unit. Rounded down.
        radius: the least radius of curvature of the path, in degrees of (α, θ). Rounded down; None if the
            path has a corner, or is straight.
    """

    asked: str
    proved: Fraction
    bound: Fraction | None
    legs: Fraction
    radius: Fraction | None

    @classmethod
    def of(
        cls, route: Route, asked: Fraction, proved: Fraction, bound: Fraction | None, legs: Fraction
    ) -> Clearance:
        """That of a route, from exact numbers; ``asked`` is 0 for the greatest one."""
        wish = exact_str(asked) if asked else BEST
        proved, legs = (rounded_down(x, BOUND_DIGITS) for x in (proved, legs))
        return cls(wish, proved, bound, legs, turning_radius(route))

    def to_json(self) -> dict[str, str | None]:
        """The document's object."""
        return {
            "asked": self.asked,
            "proved": exact_str(self.proved),
            "bound": exact_or_none(self.bound),
            "legs": exact_str(self.legs),
            "radius": exact_or_none(self.radius),
        }


def turning_radius(route: Route) -> Fraction | None:
    """The least radius of curvature in degrees of (α, θ), rounded down; None with corners, or if straight."""
    if not all(_is_straight(arc[-2], arc[-1], following[1]) for arc, following in pairwise(route.arcs)):
        return None
    with ctx.workprec(PROOF_BITS):
        radii = [radius for arc in route.at(PROOF_BITS - 64) if (radius := _radius(arc)) is not None]
        if not radii:
            return None
        least = radii[0]
        for radius in radii[1:]:
            least = least.min(radius)
        bound = (least * 180 / arb.pi()).abs_lower()
        found = fraction_of(bound) if bound.is_finite() else None  # where only the fixed leg moves
    return rounded_down(found, BOUND_DIGITS) if found else None


def _is_straight(*points: DecimalPose | None) -> bool:
    """Whether a path goes straight on at the middle one of three points; not if one is a pose."""
    places = [(p.alpha_deg, p.theta_deg) for p in points if p is not None]
    steps = [(q[0] - p[0], q[1] - p[1]) for p, q in pairwise(places)]
    if len(steps) < len(points) - 1:
        return False
    (a, b), (c, d) = steps
    return a * d == b * c and a * c + b * d >= 0


def _radius(arc: Arc) -> arb | None:
    """A lower bound of the radius of curvature of an arc, |B′|³ / |B′ × B″|; None if it is straight."""
    (x, bend_x), (y, bend_y) = ((p[1], 2 * p[2]) for p in (arc.alpha, arc.theta))
    cross = abs(x * bend_y - y * bend_x)
    if cross == 0:
        return None
    bend = bend_x**2 + bend_y**2
    along = x * bend_x + y * bend_y
    ends = (x**2 + y**2).min((x + bend_x) ** 2 + (y + bend_y) ** 2)
    # the slope is shortest where it is at right angles to B″, if that is between the ends
    outside = along >= 0 or along + bend <= 0
    least = ends if outside else ends.min(cross**2 / bend)
    return least.sqrt() ** 3 / cross
