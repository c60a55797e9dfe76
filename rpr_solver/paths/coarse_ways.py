"""A way on a coarse grid of poses, as far as possible from singularities and limits, in floats.

It is a proposal alone: the polyline is proved, or dropped. Wide ways are found at once like this, where a
subdivision would have to cut very many boxes, above all with the fixed leg free.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from heapq import heappop, heappush
from itertools import product
from math import floor, sqrt, tau
from typing import TYPE_CHECKING, TypeAlias

from flint import arb, ctx

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PROOF_BITS, PathLimits, prove
from rpr_solver.paths.route import Arc, EndPose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Grid: TypeAlias = NDArray[np.float64]

Node = tuple[int, int, int]
"""The numbers along α, θ and L; the angles are not confined to a turn."""

_HELD, _FREE = (180, 1), (90, 9)
"""Angles in a turn, and lengths: with the fixed leg held, and between two lengths."""
_AROUND = 2
_MOST_NODES = 12


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
                return _back(before, node)
            for other in self._beside(node):
                place = other[0] % turn, other[1] % turn, other[2]
                if place not in reached and (other_room := self._room(other)) > 0:
                    heappush(heap, (max(room, -other_room), steps + 1, other, node))
        return None

    def _beside(self, node: Node) -> Iterator[Node]:
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
        size = self.high + sum(abs(leg.ax) + abs(leg.ay) + abs(leg.m) for leg in legs)
        reach = np.linspace(float(self.low / size), float(self.high / size), lengths)
        arm, tip = angle[:, None, None], angle[None, :, None]
        squares, slopes = [], []
        for leg in legs:
            height = sqrt(Fraction(leg.n**2 * leg.radicand) / size**2)
            turned = arm * complex(float(leg.m / size), height if leg.n >= 0 else -height)
            vector = np.conj(turned + tip * reach - complex(float(leg.ax / size), float(leg.ay / size)))
            squares.append(abs(vector) ** 2 / 2)
            slopes.append(((vector * 1j * turned).real, (vector * 1j * tip).real))
        (fa, ft), (ga, gt) = slopes
        rooms = _steps((fa * gt - ft * ga) * self.sign)
        for wall in self.limits.walls:
            height = float(wall.height / size**2)
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


def _back(before: dict[Node, Node | None], node: Node) -> list[Node]:
    chain = [node]
    while (last := before[chain[-1]]) is not None:
        chain.append(last)
    return chain[::-1]
