"""Paths from pose to pose that keep joint limits, or the proof that there is none.

First the route without limits is tried. If it exceeds them, a subdivision (:mod:`rpr_solver.paths.search`)
looks for another one, or proves that there is none.

A way on a coarse grid of poses, as far as possible from singularities and limits, in floats, is a proposal
alone: the polyline is proved, or dropped. Wide ways are found at once like this, where a subdivision would
have to cut very many boxes, above all with the fixed leg free.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from heapq import heappop, heappush
from itertools import product
from math import floor, tau
from typing import TYPE_CHECKING, TypeAlias

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.numerals import double
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import cross, gradient_in_doubles
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.boxes import Boxes, PosePoint, Resolution, Spot, decimal_pose
from rpr_solver.paths.cells import chained
from rpr_solver.paths.joint_paths import Corner, Straightener
from rpr_solver.paths.proofs import PROOF_BITS, PathLimits, ProvedRoute, prove, proved_route
from rpr_solver.paths.routes import Arc, DecimalPose, EndPose, GivenPose, IsolatedPose, Legs
from rpr_solver.paths.search import Outcome, Search

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Grid: TypeAlias = NDArray[np.float64]

Span: TypeAlias = tuple[Fraction, Fraction]
Searches: TypeAlias = dict[tuple[int, Span], Search]
_INWARDS = [Fraction(1, 10**k) for k in range(2, 9)]
"""Shares of a leg's length by which a pose on a limit is tried to be moved inwards, one after another."""


@dataclass(frozen=True)
class LimitedSearch:
    """The search for a path between two poses within limits.

    Attributes:
        sign: that of J at both poses.
        start: the first pose.
        stop: the second pose.
        limits: of the free legs; both poses keep them.
        span: the scaled lengths between which the fixed leg may move, both the same if it is held.
        searches: subdivisions by sign and span, shared by searches within the same limits.
    """

    sign: int
    start: EndPose
    stop: EndPose
    limits: PathLimits
    span: Span
    searches: Searches = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        start: EndPose,
        stop: EndPose,
        sign: int,
        bounds: Mapping[int, Bounds],
        span: tuple[Fraction, Fraction] | None,
    ) -> LimitedSearch:
        """The search with limits by the legs' numbers and the range of the fixed leg, in the user's unit."""
        slice_map, length = start.slice_map, start.legs[0]
        ends = (length, length) if span is None else (span[0] * slice_map.scale, span[1] * slice_map.scale)
        return cls(sign, start, stop, PathLimits.of(slice_map, bounds, (start.legs, stop.legs)), ends)

    def found(self, unlimited: ProvedRoute | None) -> ProvedRoute | Outcome:
        """A proved route, if possible the one without limits; or the outcome of the subdivision without one.

        Raises:
            Unproved: there is a path, but it could not be proved; or an end is too near to what is excluded.
        """
        if unlimited is not None and (kept := self.kept(unlimited)) is not None:
            return kept
        closer = replace(self, limits=self.limits.closer((self.start, self.stop)))
        try:
            outcome = self._searched()
        except Unproved:
            return closer._searched()
        if closer.limits != self.limits and isinstance(outcome, Outcome) and not outcome.is_separated:
            # ends just inside limits are left as those on limits are
            with suppress(Unproved):
                return closer._searched()
        return outcome

    def _searched(self) -> ProvedRoute | Outcome:
        """A route from boxes or from the coarse grid, or the outcome of the subdivision.

        Raises:
            Unproved: as :meth:`found`.
        """
        inner = [self._inside(pose, end) for end, pose in enumerate((self.start, self.stop))]
        # a route in the slice is found sooner than one in the range
        held = [(self.start.legs[0],) * 2] if self.start.legs[0] == self.stop.legs[0] else []
        spans = dict.fromkeys([*held, self.span])
        for span in spans:
            # boxes of three coordinates are many, so that the coarse grid comes first
            if span[0] != span[1] and (coarse := self._coarse(inner, span)):
                return coarse
            key = self.sign, span
            if key not in self.searches:
                self.searches[key] = Search(self._boxes(span))
            search = self.searches[key]
            places = _place(inner[0]), _place(inner[1])
            try:
                outcome = search.outcome(*places)
            except Unproved:  # a pose is nearer to a limit than the narrowest boxes are wide
                outcome = Outcome(None, False, search.narrowest())
            if outcome.way is not None:
                return self._along(inner, outcome.way)
            if span[0] == span[1] and not outcome.is_separated and (coarse := self._coarse(inner, span)):
                return coarse
        return outcome if outcome.is_separated else replace(outcome, near=search.stuck(*places))

    def _coarse(self, inner: Sequence[EndPose], span: tuple[Fraction, Fraction]) -> ProvedRoute | None:
        """A proved route along a way on a coarse grid between two poses that are not on a limit."""
        grid = CoarseGrid(self.start.slice_map, self.sign, self.limits, *span)
        nodes = [grid.seen(pose) for pose in inner]
        if nodes[0] is None or nodes[1] is None or (way := grid.way(nodes[0], nodes[1])) is None:
            return None
        last = _place(inner[1])
        shifts = [tau * (a - b) / grid.sizes[0] for a, b in zip(way[-1], nodes[1], strict=True)]
        ending = float(last[0]) + shifts[0], float(last[1]) + shifts[1], last[2]
        first = float(inner[0].angles[0]), float(inner[0].angles[1]), inner[0].legs[0]
        try:
            return self._along(inner, [first, *map(grid.spot, way), ending])
        except Unproved:
            return None

    def _along(self, inner: Sequence[EndPose], way: Sequence[Spot]) -> ProvedRoute:
        """The route along a polyline, from the start by way of the poses that are not on a limit.

        Raises:
            Unproved: it could not be proved.
        """
        slice_map = self.start.slice_map
        corners: list[Corner] = [(a, t, length / slice_map.scale) for a, t, length in way]
        before, after = (pose is not own for pose, own in zip(inner, (self.start, self.stop), strict=True))
        corners = [*corners[:1] * before, *corners, *corners[-1:] * after]
        return Straightener(slice_map, self.sign, self.limits).joined(self.start, self.stop, corners)

    def kept(self, unlimited: ProvedRoute) -> ProvedRoute | None:
        """A route without limits, if it is proved to keep them."""
        return proved_route(unlimited[0], self.sign, self.limits)

    def resolution(self, outcome: Outcome) -> Resolution:
        """The size of the smallest boxes of an outcome."""
        size = (self.span[1] - self.span[0]) / self.start.slice_map.scale
        length = size / self._boxes(self.span).lengths(outcome.level) if size else None
        return Resolution(Fraction(360, 1 << outcome.level), length)

    def near(self, outcome: Outcome) -> DecimalPose | None:
        """About where an outcome stays undecided."""
        return outcome.near and decimal_pose(outcome.near, self.start.slice_map.scale)

    def _boxes(self, span: tuple[Fraction, Fraction]) -> Boxes:
        return Boxes(self.start.slice_map, self.sign, self.limits, *span)

    def _inside(self, pose: EndPose, end: int) -> EndPose:
        """A pose that is not on a limit, and is joined to an end by a straight line within the limits."""
        if isinstance(pose, GivenPose) or not any(wall.touched[end] for wall in self.limits.walls):
            return pose
        for share in _INWARDS:
            with ctx.workprec(PROOF_BITS):
                inner = IsolatedPose.near(pose.slice_map, self._shifted(pose.legs, share, end), pose.angles)
                if inner is not None:
                    points = [(*own.angles, ball_of(own.legs[0])) for own in (pose, inner)]
                    arcs = [Arc.over(points[::-1] if end else points)]
                    at_ends = end == 0, end == 1
                    if prove(pose.slice_map, arcs, self.sign, limits=self.limits, at_ends=at_ends):
                        return inner
        raise Unproved("no way from a limit inwards could be proved")

    def _shifted(self, legs: Legs, share: Fraction, end: int) -> Legs:
        """Leg lengths changed by this share of them, away from the limits on which they lie."""
        fixed, *free = legs
        for wall in self.limits.walls:
            if wall.touched[end]:
                free[wall.leg] *= 1 - wall.side * share
        return fixed, free[0], free[1]


def _place(pose: EndPose) -> PosePoint:
    return *pose.angles, pose.legs[0]


Node = tuple[int, int, int]
"""The numbers along α, θ and L; the angles are not confined to a turn."""

_HELD = (180, 1)
"""Angles in a turn, and lengths, if the fixed leg is held; answers may depend on it, their truth does not."""
_FREE = (90, 9)
"""The same between two lengths."""
_AROUND = 2
"""So many nodes to each side of a pose are looked at."""
_MOST_NODES = 12
"""So many of them are tried, those with the most room first."""


@dataclass(frozen=True)
class CoarseGrid:
    """Poses of a slice, or of a range of the fixed leg (scaled), where J shall have a sign within limits."""

    slice_map: SliceMap
    sign: int
    limits: PathLimits
    low: Fraction
    high: Fraction

    @property
    def sizes(self) -> tuple[int, int]:
        """The number of angles in a turn, and that of lengths."""
        return _HELD if self.low == self.high else _FREE

    def spot(self, node: Node) -> tuple[float, float, Fraction]:
        """α and θ in radians, and the scaled length."""
        turn, lengths = self.sizes
        share = Fraction(node[2], max(lengths - 1, 1))
        return tau * node[0] / turn, tau * node[1] / turn, self.low + (self.high - self.low) * share

    def seen(self, pose: EndPose) -> Node | None:
        """A node near a pose, with as much room as possible, that a proved straight line joins to it."""
        alpha, theta = pose.angles
        for node in self._around(float(alpha), float(theta), pose.legs[0])[:_MOST_NODES]:
            a, t, length = self.spot(node)
            with ctx.workprec(PROOF_BITS):
                ends = (alpha, theta, ball_of(pose.legs[0])), (arb(a), arb(t), ball_of(length))
                arcs = [Arc.over(ends)]
                if prove(self.slice_map, arcs, self.sign, limits=self.limits, at_ends=(False, False)):
                    return node
        return None

    def _around(self, alpha: float, theta: float, length: Fraction) -> list[Node]:
        """The allowed nodes near a pose, those with the most room first."""
        turn, lengths = self.sizes
        i, k = (floor(angle / tau * turn) for angle in (alpha, theta))
        m = round((length - self.low) / (self.high - self.low) * (lengths - 1)) if lengths > 1 else 0
        steps = range(-_AROUND, _AROUND + 2)
        levels = range(max(m - 1, 0), min(m + 1, lengths - 1) + 1)
        nodes = [
            (i + x, k + y, z)
            for x, y, z in product(steps, steps, levels)
            if self._room((i + x, k + y, z)) > 0
        ]
        return sorted(nodes, key=self._room, reverse=True)

    def way(self, start: Node, stop: Node) -> list[Node] | None:
        """Neighbours from one node to another, so that the least room is as great as possible."""
        turn = self.sizes[0]
        goal = stop[0] % turn, stop[1] % turn, stop[2]
        before: dict[Node, Node | None] = {}
        heap: list[tuple[float, int, Node, Node | None]] = [(-self._room(start), 0, start, None)]
        reached: set[Node] = set()
        while heap:
            room, steps, node, last = heappop(heap)
            own = node[0] % turn, node[1] % turn, node[2]
            if own in reached:
                continue
            reached.add(own)
            before[node] = last
            if own == goal:
                return chained(before, node)[::-1]
            for other in self._neighbours(node):
                place = other[0] % turn, other[1] % turn, other[2]
                if place not in reached and (other_room := self._room(other)) > 0:
                    heappush(heap, (max(room, -other_room), steps + 1, other, node))
        return None

    def _neighbours(self, node: Node) -> Iterator[Node]:
        i, k, m = node
        yield from ((i - 1, k, m), (i + 1, k, m), (i, k - 1, m), (i, k + 1, m))
        yield from ((i, k, z) for z in (m - 1, m + 1) if 0 <= z < self.sizes[1])

    def _room(self, node: Node) -> float:
        turn, lengths = self.sizes
        return self._rooms[(node[0] % turn * turn + node[1] % turn) * lengths + node[2]]

    @cached_property
    def _rooms(self) -> Sequence[float]:
        """How many steps a node is away from J = 0 and from the limits, about; negative beyond them."""
        import numpy as np

        turn, lengths = self.sizes
        angle = np.exp(1j * tau * np.arange(turn) / turn)
        legs = self.slice_map.f, self.slice_map.g
        size = self.high + sum(leg.size for leg in legs)
        reach = np.linspace(double(self.low / size), double(self.high / size), lengths)
        arm, tip = angle[:, None, None], angle[None, :, None]
        squares, slopes = [], []
        for leg in legs:
            m, a = leg.doubles(size)
            turned = arm * m
            vector = turned + tip * reach - a
            squares.append(abs(vector) ** 2 / 2)
            slopes.append(gradient_in_doubles(vector, turned, tip))
        rooms = _steps(cross(slopes[0], slopes[1]) * self.sign)
        for wall in self.limits.walls:
            height = double(wall.height / size**2)
            rooms = np.minimum(rooms, _steps((height - squares[wall.leg]) * wall.side))
        found: list[float] = rooms.ravel().tolist()
        return found


def _steps(values: Grid) -> Grid:
    """About how many steps of the grid away from each node the values vanish."""
    import numpy as np

    slope = sum(abs(np.roll(values, 1, axis) - np.roll(values, -1, axis)) / 2 for axis in (0, 1))
    if values.shape[2] > 1:
        slope = slope + abs(np.gradient(values, axis=2))
    steps: Grid = values / (slope + 1e-300)
    return steps
