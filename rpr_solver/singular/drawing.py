"""Strands of singular curves, from node to node or closed: chains of arcs, their samples, special points."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import degrees, hypot, radians
from typing import Any

from rpr_solver.model.float_slice import drawn
from rpr_solver.model.joint_points import JointPoint, PoseKind, coordinate_names, point_of_pose
from rpr_solver.notebook import counted
from rpr_solver.singular.arrangement import Point, Polyline
from rpr_solver.singular.aspects import Aspect, UnionFind, drawn_aspects
from rpr_solver.singular.line import Meeting
from rpr_solver.singular.regions import Picture
from rpr_solver.singular.sweep import Sweep
from rpr_solver.singular.tracing import FINEST, TURN, Course, Mark, Sample, Tracer
from rpr_solver.singular.vertices import (
    ArcPlace,
    NotPlaced,
    Vertex,
    VertexKind,
    closed_legs,
    cusp_place,
    poses_on_line,
    vertices_of_lines,
)

MeetingIndex = tuple[int, int]
"""A line and the number of a meeting on it."""


@dataclass(frozen=True)
class Step:
    """An arc of a slab as part of a strand; ``upwards`` if θ increases."""

    slab: int
    arc: int
    upwards: bool


@dataclass(frozen=True)
class Chain:
    """Arcs that continue each other, with J > 0 on their left in the (α, θ) plane.

    Attributes:
        steps: the arcs; none for an isolated point.
        cells: the meetings at its start, between its steps and at its end: one more than ``steps``, the
            last being the first if the chain is closed; none where there are no lines.
        closed: whether it is closed, without a node on it.
    """

    steps: tuple[Step, ...]
    cells: tuple[MeetingIndex, ...]
    closed: bool


def components(sweep: Sweep) -> list[list[Chain]]:
    """The connected components of J = 0, each as its strands; an isolated point is a strand without steps."""
    chains = list(_chains(sweep))
    joined = UnionFind(range(len(chains)))
    at: dict[MeetingIndex, int] = {}
    for number, chain in enumerate(chains):
        for cell in chain.cells:
            joined.join(at.setdefault(cell, number), number)
    return [[chains[k] for k in group] for group in joined.classes()]


def _chains(sweep: Sweep) -> Iterator[Chain]:
    if not sweep.lines:
        yield from (
            Chain((Step(0, arc, _upwards(sweep, 0, arc)),), (), True)
            for arc in range(len(sweep.slabs[0].arcs))
        )
        return
    walked: set[tuple[int, int]] = set()
    arcs = [(slab, arc) for slab, part in enumerate(sweep.slabs) for arc in range(len(part.arcs))]
    starts = sorted(arcs, key=lambda x: _continues(_meeting(sweep, _cells(sweep, *x)[0])))
    for slab, arc in starts:
        if (slab, arc) not in walked:
            yield _walked(sweep, slab, arc, walked)
    for line, part in enumerate(sweep.lines):
        for number, meeting in enumerate(part.meetings):
            if not meeting.left and not meeting.right:
                yield Chain((), ((line, number),), False)


def _walked(sweep: Sweep, slab: int, arc: int, walked: set[tuple[int, int]]) -> Chain:
    """The chain that leaves the first meeting of an arc, in the direction with J > 0 on its left."""
    first = cell = _cells(sweep, slab, arc)[0]
    steps, cells = [], [cell]
    while True:
        walked.add((slab, arc))
        _, cell = _cells(sweep, slab, arc)
        steps.append(Step(slab, arc, _upwards(sweep, slab, arc)))
        cells.append(cell)
        meeting = _meeting(sweep, cell)
        if not _continues(meeting):
            return Chain(tuple(steps), tuple(cells), False)
        here = (0 if steps[-1].upwards else 1, arc)
        [(side, arc)] = [end for end in _ends(meeting) if end != here]
        line = cell[0]
        slab = line if side else (line - 1) % len(sweep.slabs)
        if (slab, arc) in walked:
            return Chain(tuple(steps), tuple(cells), cell == first)


def _ends(meeting: Meeting) -> list[tuple[int, int]]:
    """(0, arc) for the arcs on the left, (1, arc) for those on the right."""
    return [*((0, arc) for arc in meeting.left), *((1, arc) for arc in meeting.right)]


def _continues(meeting: Meeting) -> bool:
    """Whether exactly two arcs meet, so that a strand continues."""
    return len(meeting.left) + len(meeting.right) == 2


def _meeting(sweep: Sweep, cell: MeetingIndex) -> Meeting:
    return sweep.lines[cell[0]].meetings[cell[1]]


def _upwards(sweep: Sweep, slab: int, arc: int) -> bool:
    """Whether J > 0 before the arc, at smaller α."""
    return sweep.slabs[slab].signs[arc - 1] > 0


def _cells(sweep: Sweep, slab: int, arc: int) -> tuple[MeetingIndex, MeetingIndex]:
    """The meetings at the start and the end of an arc in its direction."""

    def cell(line: int, side: int) -> MeetingIndex:
        meetings = sweep.lines[line].meetings
        return line, next(k for k, m in enumerate(meetings) if arc in (m.left, m.right)[side])

    low, high = cell(slab, 1), cell(sweep.line_after(slab), 0)
    return (low, high) if _upwards(sweep, slab, arc) else (high, low)


_MORE_DIGITS = (60, 240, 960, 3840)
"""The digits at which cusps are searched for again if a critical line is too close to separate them."""


@dataclass(frozen=True)
class Strand:
    """A piece of a singular curve from node to node, or a closed curve, as samples and special points.

    J > 0 lies on its left in the (α, θ) plane. Samples are floats for drawing. Their angles run on
    continuously beyond ±180 degrees; ``turns`` is the number of full turns by which the last sample of a
    closed strand, which is its first one again, is ahead of it.

    Attributes:
        closed: whether the strand is a closed curve without a node.
        alpha_deg: the orientation of the platform at each sample.
        theta_deg: the angle of the fixed leg.
        first: the length of the first free leg, in the user's unit.
        second: the length of the second free leg.
        vertices: the special points by the number of their sample, ascending.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> [strand] = singular_curves(EXAMPLES["innocenti"], "14.98").strands
    >>> strand.closed, strand.turns, strand.first[0] == strand.first[-1]
    (True, (0, 0), True)
    >>> sorted({vertex.kind for _, vertex in strand.vertices})
    ['closed-leg', 'cusp', 'turning']
    """

    closed: bool
    alpha_deg: tuple[float, ...]
    theta_deg: tuple[float, ...]
    first: tuple[float, ...]
    second: tuple[float, ...]
    vertices: tuple[tuple[int, Vertex], ...]

    def __repr__(self) -> str:
        points = f"{counted(len(self.alpha_deg), 'sample')}, {len(self.vertices)} of them special"
        return f"<Strand, {'closed' if self.closed else 'open'}: {points}>"

    @property
    def turns(self) -> tuple[int, int]:
        """The full turns of α and θ along a closed strand; (0, 0) for an open one."""
        if not self.closed:
            return 0, 0
        alpha, theta = (round((x[-1] - x[0]) / 360) for x in (self.alpha_deg, self.theta_deg))
        return alpha, theta

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's strand object."""
        names = coordinate_names(fixed_leg)
        columns = self.alpha_deg, self.theta_deg, self.first, self.second
        alpha, theta = self.turns
        return {
            "closed": self.closed,
            "turns": {"alpha": alpha, f"theta{fixed_leg}": theta},
            **{name: drawn(column) for name, column in zip(names, columns, strict=True)},
            "vertices": [{"index": index, **vertex.to_json()} for index, vertex in self.vertices],
        }


class Drawing:
    """The strands of a sweep with their vertices.

    Args:
        topology: the sweep.
        cusps: of the cusp table.
        finer: gives a cusp, by its number from 1, to more digits.
        tolerance: the largest deviation of a chord, relative to the pictures.
        digits: the significant digits of the vertices.

    Raises:
        NotPlaced: a special point could not be placed in the chart of the sweep.
    """

    def __init__(
        self,
        topology: Sweep,
        cusps: Sequence[JointPoint],
        finer: Callable[[int, int], JointPoint],
        tolerance: float,
        digits: int,
    ) -> None:
        self.sweep = topology
        self._at_cells = dict(vertices_of_lines(topology, digits))
        self._marks: dict[tuple[int, int], list[Mark]] = {}
        for number, cusp in enumerate(cusps, 1):
            self._place_cusp(number, cusp, finer, digits)
        places = [mark.place for marks in self._marks.values() for mark in marks]
        for vertex, place in closed_legs(topology, digits):
            if isinstance(place, ArcPlace):
                self._mark(vertex, place)
            else:
                self._at_cells.setdefault(place, vertex)
        self._tracer = Tracer(topology, tolerance, places)
        self._courses: dict[tuple[int, int], Course] = {}

    def course(self, slab: int, arc: int) -> Course:
        """The samples of an arc with its vertices."""
        key = slab, arc
        if key not in self._courses:
            self._courses[key] = self._tracer.course(slab, arc, self._marks.get(key, ()))
        return self._courses[key]

    def _mark(self, vertex: Vertex, place: ArcPlace) -> None:
        self._marks.setdefault((place.slab, place.arc), []).append(Mark(place, vertex))

    def _place_cusp(
        self, number: int, cusp: JointPoint, finer: Callable[[int, int], JointPoint], digits: int
    ) -> None:
        """Puts a cusp on its arc, or on a critical line, where it is also a turning point."""
        vertex = Vertex(PoseKind.CUSP, cusp, number)
        place = cusp_place(self.sweep, cusp)
        for more in _MORE_DIGITS:
            if not isinstance(place, ArcPlace) and more > digits:
                place = cusp_place(self.sweep, finer(number, more))
        if isinstance(place, ArcPlace):
            self._mark(vertex, place)
            return
        here = []
        if place is not None and not all(m.passes for m in self.sweep.lines[place].meetings):
            here = [
                (place, cell)
                for cell, pose in poses_on_line(self.sweep, place)
                if pose.kind is PoseKind.CUSP and point_of_pose(pose, digits).point == cusp
            ]
        if len(here) != 1:
            raise NotPlaced(f"cusp {number} could not be placed on the singular curve")
        self._at_cells[here[0]] = vertex

    @property
    def extent(self) -> float:
        """The extent of the curves in the joint plane, in the user's unit."""
        return self._tracer.extent / self._tracer.points.floats.unit

    def aspects(self) -> list[Aspect]:
        """The aspects of the slice."""
        return drawn_aspects(
            self.sweep, lambda slab, arc: self.course(slab, arc).samples, self._tracer.points.span
        )

    def picture(self, length: Fraction, parts: Sequence[tuple[Chain, Strand]]) -> Picture:
        """The strands in the joint plane; ``length`` is in the user's unit."""
        curves = [
            (
                Polyline(
                    tuple(zip(strand.first, strand.second, strict=True)),
                    number if chain.closed else chain.cells[0],
                    number if chain.closed else chain.cells[-1],
                    tuple(zip(map(radians, strand.alpha_deg), map(radians, strand.theta_deg), strict=True)),
                ),
                [index for index, vertex in strand.vertices if vertex.kind is VertexKind.CLOSED_LEG],
            )
            for number, (chain, strand) in enumerate(parts)
            if chain.steps and self._separates(chain)
        ]
        cusps = [
            (strand.first[index], strand.second[index])
            for _, strand in parts
            for index, vertex in strand.vertices
            if vertex.kind is PoseKind.CUSP
        ]
        return Picture(
            self.sweep.chart.slice_map,
            self._tracer.points.floats,
            length,
            list(_joined(curves, FINEST * self.extent)),
            cusps,
            [place for _, strand in parts for place in _least_regions(strand, FINEST * self.extent)],
            self.extent,
            self._tracer.tolerance,
        )

    def _separates(self, chain: Chain) -> bool:
        """Whether J has different signs on both sides, unlike along a repeated component."""
        step = chain.steps[0]
        signs = self.sweep.slabs[step.slab].signs
        return signs[step.arc - 1] != signs[step.arc]

    def strand(self, chain: Chain) -> Strand:
        """The samples and vertices of a chain."""
        samples: list[Sample] = []
        vertices: list[tuple[int, Vertex]] = []
        if not chain.steps:
            [(line, number)] = chain.cells
            samples.append(self._tracer.points.at_meeting(line, self.sweep.lines[line].meetings[number]))
            vertices += ((0, vertex) for vertex in self._at(chain.cells[0]))
        for k, step in enumerate(chain.steps):
            course = self.course(step.slab, step.arc)
            own, marks = list(course.samples), [(index, mark.vertex) for index, mark in course.marks]
            if not step.upwards:
                own.reverse()
                marks = [(len(own) - 1 - index, vertex) for index, vertex in reversed(marks)]
            start = max(len(samples) - 1, 0)
            if chain.cells:
                vertices += ((start, vertex) for vertex in self._at(chain.cells[k]))
            vertices += ((start + index, vertex) for index, vertex in marks)
            samples += own[1:] if samples else own
        if chain.steps and not chain.closed and chain.cells:
            vertices += ((len(samples) - 1, vertex) for vertex in self._at(chain.cells[-1]))
        return _strand(samples, vertices, self._tracer.points.floats.unit, closed=chain.closed)

    def _at(self, cell: MeetingIndex) -> Iterator[Vertex]:
        if cell in self._at_cells:
            yield self._at_cells[cell]


def _joined(curves: Sequence[tuple[Polyline, Sequence[int]]], finest: float) -> Iterator[Polyline]:
    """The curves, with one junction where several nodes or closed legs have the same image.

    Otherwise rounding would decide whether the regions beside it are joined. Curves, each with the numbers
    of its closed legs, are cut there.
    """
    homes: dict[Hashable, tuple[Hashable, Point]] = {}
    shared = set()
    for number, (curve, legs) in enumerate(curves):
        points = curve.points
        inner = [(("leg", number, k), points[k]) for k in legs if 0 < k < len(points) - 1]
        for name, place in [(curve.start, points[0]), (curve.end, points[-1]), *inner]:
            if name not in homes:
                near = (x for x in homes.values() if hypot(x[1][0] - place[0], x[1][1] - place[1]) <= finest)
                homes[name] = home = next(near, (name, place))
                if home[0] != name:
                    shared.add(home[0])
    for number, (curve, legs) in enumerate(curves):
        cuts = [k for k in legs if homes.get(("leg", number, k), ("", ()))[0] in shared]
        names = [curve.start, *(("leg", number, k) for k in cuts), curve.end]
        for (i, j), ends in zip(pairwise([0, *cuts, len(curve.points) - 1]), pairwise(names), strict=True):
            (start, first), (end, last) = (homes[name] for name in ends)
            yield Polyline((first, *curve.points[i + 1 : j], last), start, end, curve.angles[i : j + 1])


def _least_regions(strand: Strand, finest: float) -> Iterator[Point]:
    """Where a strand runs from cusp to cusp in so little room that it is a point of the drawing.

    Between the two, and where the strand crosses itself beside them, is a region: of lips or a swallowtail.
    """
    points = list(zip(strand.first, strand.second, strict=True))
    cusps = [index for index, vertex in strand.vertices if vertex.kind is PoseKind.CUSP]
    for k, index in enumerate(cusps[: max(len(cusps) - (not strand.closed), 1)] if len(cusps) > 1 else ()):
        after = cusps[(k + 1) % len(cusps)]
        between = points[index : after + 1] if index < after else points[index:] + points[: after + 1]
        if max(hypot(x - points[index][0], y - points[index][1]) for x, y in between) <= finest:
            yield points[index]
            if len(cusps) == 2:
                return


def _strand(
    samples: Sequence[Sample], vertices: Sequence[tuple[int, Vertex]], unit: float, *, closed: bool
) -> Strand:
    """The strand in the user's units, its angles continuous and those of the first sample within a turn."""
    if closed:
        samples = [*samples[:-1], samples[0]]
    alpha, theta = (
        _continuous(column) for column in zip(*((x.alpha, x.theta) for x in samples), strict=True)
    )
    return Strand(
        closed,
        tuple(map(degrees, alpha)),
        tuple(map(degrees, theta)),
        tuple(x.first / unit for x in samples),
        tuple(x.second / unit for x in samples),
        tuple(sorted(vertices, key=lambda x: x[0])),
    )


def _continuous(angles: Sequence[float]) -> list[float]:
    """Each angle by whole turns as near as possible to the one before, the first in (−180°, 180°]."""
    result = [-((-angles[0] + TURN / 2) % TURN - TURN / 2)]
    for angle in angles[1:]:
        result.append(angle - TURN * round((angle - result[-1]) / TURN))
    return result
