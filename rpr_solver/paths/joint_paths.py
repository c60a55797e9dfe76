"""Whether two poses are joined by a path without a singularity, and such a path.

In a slice: they are, exactly if both lie in one aspect. With the fixed leg free between two lengths a and b:
J / L is linear in L, so for each (α, θ) the lengths at which J has a sign form an interval that contains a or
b if it is not empty. A path then consists of moves in the slices a and b and of moves of the fixed leg alone
at poses where J has the sign in both. The polyline that is found becomes a short, smooth, proved route.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import chain, pairwise
from math import degrees, pi
from typing import TypeVar

from flint import ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.cells import Cell, Cells, Spot, reached
from rpr_solver.paths.proofs import NO_LIMITS, PROOF_BITS, PathLimits, ProvedRoute, prove, proved_route
from rpr_solver.paths.routes import Angles, Arc, DecimalPose, EndPose, Point, Route, local_map
from rpr_solver.singular.aspects import RangeTopology, UnionFind

T = TypeVar("T")
Corner = tuple[float, float, Fraction]
"""α and θ in radians, and the fixed length in the user's unit."""

_PLACES = 7
_ATTEMPTS = (False, _PLACES), (True, _PLACES), (True, 13)
"""Whether the lines of a way are proved before it is made a route, and the decimals of its corners; a way
round the tip of a curve may be nearer to it than the usual ones are."""
_ROUNDINGS = (Fraction(1, 2), Fraction(1, 4), Fraction(1, 16))


@dataclass(frozen=True)
class Straightener:
    """Makes routes of polylines, on which J has one sign and the free legs keep their limits."""

    slice_map: SliceMap
    sign: int
    limits: PathLimits = NO_LIMITS
    places: int = _PLACES

    def route(self, start: EndPose, stop: EndPose, corners: Sequence[Corner]) -> ProvedRoute | None:
        """A proved route along a polyline, its ends included, which are the poses; None without a proof."""
        inner = [DecimalPose(self._decimal(a), self._decimal(t), length) for a, t, length in corners[1:-1]]
        with ctx.workprec(PROOF_BITS):
            first, last = ((*pose.angles, ball_of(pose.legs[0])) for pose in (start, stop))
            kept = self._kept([first, *(corner.point(self.slice_map.scale) for corner in inner), last])
        if kept is None:
            return None
        pulled = [None, *(inner[k - 1] for k in kept[1:-1]), None]
        shapes = chain((rounded(pulled, share) for share in _ROUNDINGS), [tuple(pairwise(pulled))])
        found = (proved_route(Route(start, stop, arcs), self.sign, self.limits) for arcs in shapes)
        return next((route for route in found if route is not None), None)

    def joined(self, start: EndPose, stop: EndPose, corners: Sequence[Corner]) -> ProvedRoute:
        """The route along a polyline that ends at the stop, perhaps some turns further.

        Raises:
            Unproved: no route along it could be proved.
        """
        with ctx.workprec(PROOF_BITS):
            turns = [
                round((corner - float(angle)) / (2 * pi))
                for corner, angle in zip(corners[-1][:2], stop.angles, strict=True)
            ]
            ending = stop.turned((turns[0], turns[1]))
        found = self.route(start, ending, corners)
        if found is None:
            raise Unproved("the two poses are joined, but no path could be proved")
        return found

    def _decimal(self, angle: float) -> Fraction:
        """An angle in degrees, as a decimal."""
        unit = 10**self.places
        return Fraction(round(degrees(angle) * unit), unit)

    def _kept(self, points: Sequence[Point]) -> list[int] | None:
        """The numbers of few points, so that J keeps its sign on the straight lines between them."""
        kept, last = [0], len(points) - 1
        while (at := kept[-1]) < last:
            reach = last
            while not self._is_free(points, at, reach):
                if reach == at + 1:
                    return None
                reach = at + max(1, (reach - at) * 2 // 3)
            kept.append(reach)
        return kept

    def _is_free(self, points: Sequence[Point], first: int, last: int) -> bool:
        """Whether the straight line between two of the points is proved."""
        arcs, at_ends = [Arc.over([points[first], points[last]])], (first == 0, last == len(points) - 1)
        return prove(self.slice_map, arcs, self.sign, limits=self.limits, at_ends=at_ends) is not None


def rounded(
    corners: Sequence[DecimalPose | None], share: Fraction
) -> tuple[tuple[DecimalPose | None, ...], ...]:
    """Bézier arcs round the corners, each of which begins and ends at this share of the edges."""
    if len(corners) <= 3:
        return (tuple(corners),)
    arcs: list[tuple[DecimalPose | None, ...]] = []
    last: DecimalPose | None = None
    for corner, following in pairwise(corners[1:-1]):
        cut = _between(corner, following, share)
        arcs.append((last, corner, cut))
        last = cut
        if share < Fraction(1, 2):
            last = _between(following, corner, share)
            arcs.append((cut, last))
    return (*arcs, (last, corners[-2], None))


def _between(first: DecimalPose | None, second: DecimalPose | None, share: Fraction) -> DecimalPose:
    assert first is not None, "only the ends are poses"
    assert second is not None, "only the ends are poses"
    return DecimalPose(
        first.alpha_deg + share * (second.alpha_deg - first.alpha_deg),
        first.theta_deg + share * (second.theta_deg - first.theta_deg),
        first.length + share * (second.length - first.length),
    )


def sign_of(pose: EndPose) -> int:
    """The sign of J at a pose."""
    return sign_at(pose.slice_map, pose.legs[0], pose.angles)


def sign_at(slice_map: SliceMap, length: Fraction, angles: Angles) -> int:
    """The sign of J at a place of the slice of a scaled length; 0 if the balls do not decide it."""
    with ctx.workprec(PROOF_BITS):
        j = local_map(slice_map, ball_of(length), angles, 1).singularity().value
        return 1 if j > 0 else -1 if j < 0 else 0


def in_slice(cells: Cells, start: EndPose, stop: EndPose, sign: int) -> ProvedRoute | None:
    """A proved route in the slice; None if the poses are in different aspects.

    Raises:
        Unproved: they are in one aspect, but no route was found, or that could not be decided.
    """
    first, last = (cells.cell_of(pose.angles) for pose in (start, stop))
    length, spots = cells.length / cells.slice_map.scale, (_spot(start.angles), _spot(stop.angles))

    def attempt(is_careful: bool, places: int) -> ProvedRoute | None:
        way = cells.way(spots[0], first, spots[1], last, is_careful=is_careful)
        if way is None:
            return None
        corners = [(a, t, length) for a, t in way]
        return Straightener(cells.slice_map, sign, places=places).joined(start, stop, corners)

    return _attempted(attempt)


def _attempted(attempt: Callable[[bool, int], T]) -> T:
    """What comes of the first attempt that succeeds, or of the last one."""
    for terms in _ATTEMPTS[:-1]:
        with suppress(Unproved):
            return attempt(*terms)
    return attempt(*_ATTEMPTS[-1])


Node = tuple[int, int]
"""An end of a range, 0 or 1, and the number of an aspect of its slice."""
Bridge = tuple[Cell, Cell, Spot]
"""A cell of each of two slices, and a spot in both."""
Move = tuple[int, Cell, Spot, Cell]
"""An end of a range, and in its slice the cell that is left, a spot, and the cell of that."""


@dataclass(frozen=True)
class Range:
    """Two slices, and places where J has a sign in both: a bridge between any two aspects that overlap."""

    ends: tuple[Cells, Cells]
    sign: int
    bridges: tuple[Bridge, ...]

    @classmethod
    def of(cls, slice_map: SliceMap, lengths: tuple[Fraction, Fraction], sign: int) -> Range:
        """The range between two scaled lengths.

        Raises:
            SolverError: the singular curves of the ends are not supported, or could not be compared.
        """
        topology = RangeTopology.of(slice_map, *lengths, transposable=False)
        ends = [Cells(slice_map, length, own) for length, own in zip(lengths, topology.ends, strict=True)]
        floats = [FloatSlice.of(slice_map, length) for length in lengths]
        widest: dict[tuple[int, int], tuple[float, Bridge]] = {}
        for overlap in topology.overlaps:
            one, other = overlap.cells
            if ends[0].sign(one) == sign:
                spot = overlap.place(topology.first.chart)
                room = min(abs(end.on_line(spot[1]).value_and_slope(spot[0])[0]) for end in floats)
                pair = ends[0].aspects[one], ends[1].aspects[other]
                widest[pair] = max(widest.get(pair, (-1.0, (one, other, spot))), (room, (one, other, spot)))
        return cls((ends[0], ends[1]), sign, tuple(bridge for _, bridge in widest.values()))

    def route(self, start: EndPose, stop: EndPose) -> ProvedRoute | None:
        """A proved route between two poses in the range; None if they are in different aspects of it.

        Raises:
            Unproved: no route could be proved along the way that was found, or J is too near 0 at a pose.
        """
        starts, goals = (dict(self._ports(pose)) for pose in (start, stop))
        if not (starts and goals):
            raise Unproved("a pose is too near the singular curves of the range for its aspect to be decided")
        aims = {self._node(side, cell) for side, cell in goals.items()}
        before = reached((self._node(side, cell) for side, cell in starts.items()), self._beyond)
        node = next((node for node in before if node in aims), None)
        if node is None:
            return None
        # from the stop backwards: the side, the cells of both ends, and the spot at the last
        last, target = goals[node[0]], _spot(stop.angles)
        moves = []
        while (step := before[node]) is not None:
            moves.append((node[0], step[1][1], target, last))
            node, (last, _, target) = step
        moves.append((node[0], starts[node[0]], target, last))
        return _attempted(partial(self._along, start, stop, moves[::-1]))

    def _beyond(self, node: Node) -> Iterator[tuple[Node, tuple[Node, Bridge]]]:
        """The aspects to which bridges lead from one, each with that and the bridge from there."""
        side = node[0]
        for bridge in self.bridges:
            here, there, spot = bridge if side == 0 else (bridge[1], bridge[0], bridge[2])
            if self._node(side, here) == node:
                yield self._node(1 - side, there), (node, (here, there, spot))

    def _along(
        self, start: EndPose, stop: EndPose, moves: Sequence[Move], is_careful: bool, places: int
    ) -> ProvedRoute:
        corners = self._corners(_spot(start.angles), moves, is_careful)
        lengths = [pose.legs[0] / pose.slice_map.scale for pose in (start, stop)]
        whole = [(*_spot(start.angles), lengths[0]), *corners, (*corners[-1][:2], lengths[1])]
        return Straightener(start.slice_map, self.sign, places=places).joined(start, stop, whole)

    def component(self, pose: EndPose) -> Node:
        """A name of the aspect of the range that holds a pose with the sign of J; others have other names.

        Raises:
            Unproved: J is too near 0 at the pose.
        """
        for side, cell in self._ports(pose):
            return self._components.root(self._node(side, cell))
        raise Unproved("a pose is too near the singular curves of the range for its aspect to be decided")

    @cached_property
    def _components(self) -> UnionFind[Node]:
        ends = enumerate(self.ends)
        nodes = UnionFind((side, name) for side, cells in ends for name in cells.aspects.values())
        for one, other, _ in self.bridges:
            nodes.join(self._node(0, one), self._node(1, other))
        return nodes

    def _node(self, side: int, cell: Cell) -> Node:
        return side, self.ends[side].aspects[cell]

    def _ports(self, pose: EndPose) -> Iterator[tuple[int, Cell]]:
        """The ends of the range to which the fixed leg can move at a pose, with the cells there."""
        for side, cells in enumerate(self.ends):
            if sign_at(cells.slice_map, cells.length, pose.angles) == self.sign:
                yield side, cells.cell_of(pose.angles)

    def _corners(self, spot: Spot, moves: Sequence[Move], is_careful: bool) -> list[Corner]:
        """A polyline from a spot through moves in the slices, each from a cell to a spot of another cell."""
        corners: list[Corner] = []
        for side, first, target, last in moves:
            cells = self.ends[side]
            way = cells.way(spot, first, target, last, is_careful=is_careful)
            if way is None:
                raise Unproved("a way between two slices was lost")
            length = cells.length / cells.slice_map.scale
            corners += [(a, t, length) for a, t in way]
            spot = way[-1]
        return corners


def _spot(angles: Angles) -> Spot:
    return float(angles[0]), float(angles[1])
