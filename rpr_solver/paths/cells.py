"""The cells of a slice, where J ≠ 0: which one holds a pose, and ways from one to another.

Cells are the gaps between the arcs of J = 0 in the slabs of the sweep (:mod:`rpr_solver.singular.sweep`),
and a gap that continues through a line leads from cell to cell. Two poses are in one aspect exactly if such
steps lead from one's cell to the other's. A way is a polyline through the middles of the gaps; it is a
proposal in floats, which is then proved.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import ceil, floor, pi, sqrt
from typing import TypeVar

from flint import arb, ctx

from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact import decided
from rpr_solver.exact.real_roots import RealRoot, ball_of, fraction_of, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.jets import whole_angle
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import prove
from rpr_solver.paths.routes import Angles, Arc
from rpr_solver.singular.charts import Chart
from rpr_solver.singular.sweep import Sweep, sweep
from rpr_solver.singular.tracing import angle_of, arcs_at, arcs_beside

N = TypeVar("N", bound=Hashable)
S = TypeVar("S")

Cell = tuple[int, int]
"""A slab and the number of a gap in it."""
Spot = tuple[float, float]
"""α and θ in radians, not confined to a turn."""

_FIRST_BITS, _MOST_BITS = 128, 1 << 12
_LEVELS = (0.5, 0.25, 0.75, 0.1, 0.9)
_STEPS_IN_A_SLAB = 6
_MOST_HALVINGS = 10
_PROBES = 16


@dataclass(frozen=True)
class _Step:
    """A step from one cell through a line, towards greater θ or not, to another cell."""

    before: Cell
    after: Cell
    line: int
    rightwards: bool


@dataclass(frozen=True)
class Cells:
    """The cells of the slice of one scaled length."""

    slice_map: SliceMap
    length: Fraction
    sweep: Sweep

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> Cells:
        """The cells of the slice of one *scaled* length.

        Raises:
            SolverError: the singular curves are not supported or could not be decided.
        """
        return cls(slice_map, length, sweep(slice_map, length))

    def sign(self, cell: Cell) -> int:
        """The sign of J in a cell."""
        return self.sweep.slabs[cell[0]].signs[cell[1]]

    def cell_of(self, angles: Angles) -> Cell:
        """The cell that holds a pose with J ≠ 0, a small ball of angles in radians.

        Raises:
            Unproved: the ball is too near a line or an arc.
        """
        chart = self.sweep.chart

        def attempt(bits: int) -> Cell | None:
            with ctx.workprec(bits):
                alpha, theta = (angle - own for angle, own in zip(angles, _zeros(chart), strict=True))
                unit = arb(self.slice_map.rho).sqrt()
                u, t = (theta / 2).tan() / unit, (alpha / 2).tan() / unit
                if not u.is_finite():
                    return None
                beside = Fraction(round(fraction_of(u) * 2**60), 2**60)
                slabs = {self._slab(ball_of(beside), bits), self._slab(u, bits)}
                if None in slabs or len(slabs) > 1:
                    return None
                # the pose moves to the rational line beside it without meeting J = 0
                shift = 2 * (unit * ball_of(beside)).atan() - theta
                shift -= 2 * arb.pi() * ((shift / (2 * arb.pi())).mid() + arb(0.5)).floor()
                length = ball_of(self.length)
                start = angles[0], angles[1], length
                arc = Arc.over([start, (angles[0], angles[1] + shift, length)])
                if not any(prove(self.slice_map, [arc], sign, most_pieces=16) for sign in (1, -1)):
                    return None
                below = 0
                arcs = real_roots(chart.above(beside))
                for root in arcs:
                    ball = root.refined(bits)
                    if ball.overlaps(t) or not t.is_finite():
                        return None
                    below += bool(ball < t)
            [slab] = slabs
            return None if slab is None else (slab, (below - 1) % max(len(arcs), 1))

        message = "a pose is too near the singular curve for its aspect to be decided"
        return decided(attempt, _FIRST_BITS, _MOST_BITS, message)

    def _slab(self, u: arb, bits: int) -> int | None:
        below = 0
        for line in self.sweep.lines:
            ball = line.root.refined(bits)
            if ball.overlaps(u):
                return None
            below += bool(ball < u)
        return (below - 1) % len(self.sweep.slabs)

    @cached_property
    def aspects(self) -> dict[Cell, int]:
        """The number of the aspect of each cell."""
        found: dict[Cell, int] = {}
        cells = [(k, gap) for k, slab in enumerate(self.sweep.slabs) for gap in range(slab.gaps)]
        for number, cell in enumerate(cells):
            if cell not in found:
                found |= dict.fromkeys(self._reached(cell), number)
        return found

    def _reached(self, start: Cell) -> dict[Cell, _Step | None]:
        """All cells that steps lead to, each with the step that leads there."""
        return reached([start], lambda cell: ((step.after, step) for step in self._steps[cell]))

    @cached_property
    def _steps(self) -> dict[Cell, list[_Step]]:
        slabs = self.sweep.slabs
        found: dict[Cell, list[_Step]] = {
            (k, gap): [] for k, slab in enumerate(slabs) for gap in range(slab.gaps)
        }
        for number, line in enumerate(self.sweep.lines):
            for left, right in line.links:
                one, other = ((number - 1) % len(slabs), left), (number, right)
                found[one].append(_Step(one, other, number, True))
                found[other].append(_Step(other, one, number, False))
        return found

    def way(
        self, start: Spot, first: Cell, stop: Spot, last: Cell, *, is_careful: bool = False
    ) -> list[Spot] | None:
        """A polyline from one pose to another through cells; None if they are in different aspects.

        Its last spot is the stop, perhaps some turns further. A careful way is made of lines that are
        proved, as far as halvings lead to them, rather than probed in floats.
        """
        before = self._reached(first)
        if last not in before:
            return None
        steps: list[_Step] = []
        while (step := before[last if not steps else steps[-1].before]) is not None:
            steps.append(step)
        return _Ways(self, is_careful).through(start, steps[::-1], stop, last)


@dataclass(frozen=True)
class _Ways:
    """Ways through cells, in floats; angles are those of the chart."""

    cells: Cells
    is_careful: bool
    _known: dict[tuple[int, float], list[float]] = field(default_factory=dict, init=False, repr=False)

    @property
    def sweep(self) -> Sweep:
        """The sweep of the cells."""
        return self.cells.sweep

    @property
    def _unit(self) -> float:
        """√ρ, in whose reciprocal half tangents are measured."""
        return sqrt(self.cells.slice_map.rho)

    def _angle(self, root: RealRoot) -> float:
        return angle_of(root, self._unit)

    def through(self, start: Spot, steps: Sequence[_Step], stop: Spot, last: Cell) -> list[Spot]:
        """The spots of a way by these steps to the last cell; its ends are not angles of the chart."""
        turn = self.sweep.chart.offsets
        spots = [(start[0] - turn[0], start[1] - turn[1])]
        for step in steps:
            near, far = self._crossing(step, spots[-1][1])
            spots += self._inside(step.before, spots[-1], near[1])
            alpha = self._alpha_in_gap(step.before, spots[-1], near[0])
            spots += (alpha, near[1]), (alpha, far[1])
        low, high = self._range(last[0], spots[-1][1])
        theta = _turned(stop[1] - turn[1], (low + high) / 2)
        spots += self._inside(last, spots[-1], theta)
        spots.append((self._alpha_in_gap(last, spots[-1], stop[0] - turn[0]), theta))
        return [(a + turn[0], t + turn[1]) for a, t in spots]

    def _range(self, slab: int, theta: float) -> Spot:
        """The angles of the lines at the ends of a slab, about an angle inside it."""
        if not self.sweep.lines:
            return theta - pi, theta + pi
        low, high = (self._angle(self.sweep.lines[k].root) for k in (slab, self.sweep.line_after(slab)))
        high += 2 * pi if slab == len(self.sweep.lines) - 1 else 0.0
        turns = 2 * pi * round((theta - (low + high) / 2) / (2 * pi))
        return low + turns, high + turns

    def _alpha_in_gap(self, cell: Cell, spot: Spot, alpha: float) -> float:
        """An angle in the gap of a spot, plus whole turns, so that a line between them stays in it."""
        low, high = _gap_near(self._gap_at(cell, spot[1]), spot[0])
        found = alpha + 2 * pi * ceil((low - alpha) / (2 * pi))
        # floats may have a pose that is close to an arc beyond it, and so at the other end of the gap
        is_beyond = self.is_careful and found - high > low - (found - 2 * pi)
        return found - 2 * pi if is_beyond else found

    def _crossing(self, step: _Step, theta: float) -> tuple[Spot, Spot]:
        """Two spots, before and beyond a line, at one α at which J ≠ 0 between them."""
        own = self.sweep.lines[step.line]
        left, right = (step.before, step.after) if step.rightwards else (step.after, step.before)
        gaps = [
            _gap([self._angle(root) for root in arcs], gap)
            for arcs, (_, gap) in zip(own.sides, (left, right), strict=True)
        ]
        thetas = [whole_angle(u, self._unit) for u in own.around]
        low, high = self._range(step.before[0], theta)
        line = high if step.rightwards else low
        base = 2 * pi * round((line - self._angle(own.root)) / (2 * pi))
        for start, stop in _common(*gaps):
            for level in _LEVELS:
                alpha = start + level * (stop - start)
                if self._is_free([(alpha, theta) for theta in thetas]):
                    one, other = ((alpha, at + base) for at in thetas)
                    return (one, other) if step.rightwards else (other, one)
        raise Unproved("no way through a critical line was found")

    def _is_free(self, spots: Sequence[Spot], signs: Sequence[int] = (1, -1)) -> bool:
        """Whether J is proved to have one of these signs on a straight line."""
        with ctx.workprec(_FIRST_BITS):
            turn, length = self.sweep.chart.offsets, ball_of(self.cells.length)
            points = [(arb(alpha + turn[0]), arb(theta + turn[1]), length) for alpha, theta in spots]
            arc = Arc.over(points)
            return any(prove(self.cells.slice_map, [arc], sign, most_pieces=200) for sign in signs)

    def _inside(self, cell: Cell, start: Spot, stop: float) -> Iterator[Spot]:
        """Spots in the middle of a gap from a spot to a θ, so close that lines between them stay in it."""
        last = self._middle(cell, start[1], start[0])
        yield last
        for k in range(1, _STEPS_IN_A_SLAB + 1):
            theta = start[1] + (stop - start[1]) * k / _STEPS_IN_A_SLAB
            for spot in self._closer(cell, last, self._middle(cell, theta, last[0]), _MOST_HALVINGS):
                last = spot
                yield spot

    def _closer(self, cell: Cell, first: Spot, last: Spot, halvings: int) -> Iterator[Spot]:
        between = self._middle(cell, (first[1] + last[1]) / 2, (first[0] + last[0]) / 2)
        if self.is_careful:
            between = _turned(between[0], first[0]), between[1]
        last = _turned(last[0], between[0]), last[1]
        if halvings and not self._holds(cell, first, last):
            yield from self._closer(cell, first, between, halvings - 1)
            yield from self._closer(cell, between, last, halvings - 1)
        else:
            yield last

    def _holds(self, cell: Cell, first: Spot, last: Spot) -> bool:
        """Whether a gap holds points of a straight line."""
        if self.is_careful:
            return self._is_free([first, last], (self.cells.sign(cell),))
        arcs = self._arcs(cell[0], first[1])
        for k in range(1, _PROBES):
            alpha, theta = (x + k / _PROBES * (y - x) for x, y in zip(first, last, strict=True))
            arcs = self._arcs_beside(cell[0], theta, arcs)
            low, high = _gap_near(_gap(arcs, cell[1]), alpha)
            if not low < alpha < high:
                return False
        return True

    def _middle(self, cell: Cell, theta: float, last: float) -> Spot:
        low, high = _gap_near(self._gap_at(cell, theta), last)
        return (low + high) / 2, theta

    def _gap_at(self, cell: Cell, theta: float) -> Spot:
        return _gap(self._arcs(cell[0], theta), cell[1])

    def _arcs(self, slab: int, theta: float) -> list[float]:
        if (slab, theta) not in self._known:
            self._known[slab, theta] = arcs_at(self.sweep, slab, theta)
        return self._known[slab, theta]

    def _arcs_beside(self, slab: int, theta: float, known: list[float]) -> list[float]:
        """The arcs at a θ, from those at another if possible, which takes a tenth of the time."""
        floats = self._floats
        found = None if floats is None else arcs_beside(floats, self.sweep, slab, theta, known)
        return self._arcs(slab, theta) if found is None else found

    @cached_property
    def _floats(self) -> FloatSlice | None:
        try:
            return FloatSlice.of(self.cells.slice_map, self.cells.length)
        except SolverError:
            return None


def reached(starts: Iterable[N], steps: Callable[[N], Iterable[tuple[N, S]]]) -> dict[N, S | None]:
    """All that steps lead to, the nearest first, each with the step that leads there; None for the starts.

    ``steps`` has those from a node, each after the node to which it leads.
    """
    before: dict[N, S | None] = dict.fromkeys(starts)
    queue = deque(before)
    while queue:
        for other, step in steps(queue.popleft()):
            if other not in before:
                before[other] = step
                queue.append(other)
    return before


def chained(before: Mapping[N, N | None], node: N) -> list[N]:
    """A node, the one before it, and so on, to a start."""
    chain = [node]
    while (last := before[chain[-1]]) is not None:
        chain.append(last)
    return chain


def _zeros(chart: Chart) -> Angles:
    """The article's α and θ where the angles of the chart are 0."""
    root, axes = arb(chart.slice_map.rho).sqrt(), Bridge.of(chart.slice_map).turns(ctx.prec)
    alpha, theta = (
        2 * (root * turn.sin / turn.cos).atan() - axis.arg()
        for turn, axis in zip((chart.alpha, chart.theta), axes, strict=True)
    )
    return alpha, theta


def _gap(arcs: list[float], gap: int) -> Spot:
    """The ends of a gap, of which the last one runs past π."""
    if not arcs:
        return -pi, pi
    return arcs[gap], arcs[gap + 1] if gap + 1 < len(arcs) else arcs[0] + 2 * pi


def _common(first: Spot, second: Spot) -> Iterator[Spot]:
    """The parts that two intervals of angles have in common, the widest first."""
    parts = []
    for turn in (-2 * pi, 0.0, 2 * pi):
        low, high = max(first[0], second[0] + turn), min(first[1], second[1] + turn)
        if low < high:
            parts.append((low, high))
    yield from sorted(parts, key=lambda part: part[0] - part[1])


def _gap_near(gap: Spot, last: float) -> Spot:
    """A gap plus whole turns, so that it holds an angle, or is as near to it as possible."""
    low, high = gap
    turns = 2 * pi * floor((last - low) / (2 * pi))
    if not low + turns < last < high + turns:
        turns = _turned((low + high) / 2, last) - (low + high) / 2
    return low + turns, high + turns


def _turned(angle: float, near: float) -> float:
    """The angle plus whole turns, as near as possible to another."""
    return angle + 2 * pi * round((near - angle) / (2 * pi))
