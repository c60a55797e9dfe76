"""The course of the arcs of a sweep, as samples in floats that keep a chord tolerance in both planes.

An arc is parametrised by τ in [0, 1], with θ = θ₀ + (θ₁ − θ₀)(1 − cos πτ)/2, in which it is smooth also where
it ends in a turning point. It is halved until the middle of a piece deviates little enough from its chord,
which is no bound by proof (docs/singular-curves.md says what one would cost).
The sign of ∂J/∂α tells neighbouring arcs apart; where Newton's iteration fails, the roots of J at a rational
u are isolated again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import acos, atan, cos, hypot, pi, tan

from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.sweep import Line, Meeting, Sweep
from rpr_solver.singular.vertices import Place, Vertex

TURN = 2 * pi
_FIRST = (0.25, 0.5, 0.75)
_DEEPEST = 24
_PART = 1 / 30
FINEST = 1e-8
"""Finer than this part of the picture, floats do not tell curves apart."""


@dataclass(frozen=True)
class Sample:
    """A point of a singular curve: α and θ in radians, the two free legs in the unit of the float slice."""

    alpha: float
    theta: float
    first: float
    second: float


@dataclass(frozen=True)
class Mark:
    """A point on an arc that must be a sample: a cusp, or a pose with a leg of length 0."""

    place: Place
    vertex: Vertex


@dataclass(frozen=True)
class Course:
    """The samples of one arc, by ascending θ, and those of its marks by their place in ``samples``."""

    samples: tuple[Sample, ...]
    marks: tuple[tuple[int, Mark], ...]


class Tracer:
    """Draws the arcs of a sweep.

    Args:
        sweep: the topology.
        tolerance: the largest deviation of a chord, relative to a full turn, and to the extent of the
            picture in the joint plane.
        cusps: cusps, near which the curve is drawn as finely as the distance to the next cusp needs.
    """

    def __init__(self, sweep: Sweep, tolerance: float, cusps: Sequence[Place] = ()) -> None:
        self.sweep = sweep
        self.floats = FloatSlice.of(sweep.chart.slice_map, sweep.chart.length)
        self.tolerance = tolerance
        self._alpha0, self._theta0 = sweep.chart.alpha.angle, sweep.chart.theta.angle
        self._lines = [angle_of(line.root) for line in sweep.lines]
        self._roots: dict[tuple[int, float], list[float]] = {}
        self._cusps = list(self._focused([self._at_place(place) for place in cusps]))

    @cached_property
    def extent(self) -> float:
        """The larger side of the box round the first samples, in the joint plane."""
        points = [x for slab in self._first for arc in slab for _, x in arc]
        if not points:
            return 1.0
        firsts, seconds = [x.first for x in points], [x.second for x in points]
        return max(max(firsts) - min(firsts), max(seconds) - min(seconds)) or 1.0

    def course(self, slab: int, arc: int, marks: Sequence[Mark] = ()) -> Course:
        """The samples of one arc."""
        placed = [(self._parameter(slab, mark.place.u), self._at_mark(mark), mark) for mark in marks]
        own = sorted([*self._first[slab][arc], *((tau, x) for tau, x, _ in placed)], key=lambda x: x[0])
        samples = [own[0][1]]
        for (start, first), (stop, last) in pairwise(own):
            if stop > start:
                self._refine(slab, arc, start, first, stop, last, samples, 0)
                samples.append(last)
            else:
                samples[-1] = last
        places = {id(x): k for k, x in enumerate(samples)}
        found = sorted(
            ((places[id(x)], mark) for _, x, mark in placed if id(x) in places), key=lambda y: y[0]
        )
        return Course(tuple(samples), tuple(found))

    def span(self, slab: int) -> tuple[float, float]:
        """θ at the ends of a slab."""
        low, high = self._limits(slab)
        return low + self._theta0, high + self._theta0

    def at_meeting(self, line: int, meeting: Meeting) -> Sample:
        """The point of a meeting that is no passage."""
        return self.sample(self._alpha_at(line, meeting, 0), self._lines[line])

    def sample(self, alpha: float, theta: float) -> Sample:
        """The point with these angles of the chart."""
        alpha, theta = alpha + self._alpha0, theta + self._theta0
        return Sample(alpha, theta, *self.floats.joints(alpha, theta))

    @cached_property
    def _first(self) -> list[list[list[tuple[float, Sample]]]]:
        """By slab and arc: both ends and a few samples between, with their parameters."""
        return [
            [
                sorted(
                    [
                        *self._ends(slab, arc),
                        *((tau, self._on_arc(slab, arc, tau, None)) for tau in _FIRST),
                    ],
                    key=lambda x: x[0],
                )
                for arc in range(len(self.sweep.slabs[slab].arcs))
            ]
            for slab in range(len(self.sweep.slabs))
        ]

    def _limits(self, slab: int) -> tuple[float, float]:
        if not self._lines:
            return -pi, pi
        # two lines may be one in floats; only the last slab holds u = ∞
        last = slab == len(self._lines) - 1
        return self._lines[slab], self._lines[self.sweep.line_after(slab)] + TURN * last

    def _angle(self, slab: int, tau: float) -> float:
        low, high = self._limits(slab)
        return low + (high - low) * ((1 - cos(pi * tau)) / 2 if self._lines else tau)

    def _angle_in(self, slab: int, u: float) -> float:
        """The angle θ of the chart, in the turn of a slab."""
        low, high = self._limits(slab)
        angle = 2 * atan(u)
        return angle + TURN if angle < low and high > pi else angle

    def _parameter(self, slab: int, u: float) -> float:
        low, high = self._limits(slab)
        part = min(max((self._angle_in(slab, u) - low) / (high - low or 1.0), 0.0), 1.0)
        return acos(1 - 2 * part) / pi if self._lines else part

    def _at_place(self, place: Place) -> Sample:
        return self.sample(2 * atan(place.t), self._angle_in(place.slab, place.u))

    def _at_mark(self, mark: Mark) -> Sample:
        """The sample of a mark; a leg of length 0 has it exactly."""
        x = self._at_place(mark.place)
        first, second = (
            0.0 if text == "0" else length
            for text, length in zip(mark.vertex.point.coordinates[2:], (x.first, x.second), strict=True)
        )
        return Sample(x.alpha, x.theta, first, second)

    def _focused(self, cusps: Sequence[Sample]) -> Iterator[tuple[float, float, float]]:
        """The joints of each cusp that is near another one, and its distance from the nearest."""
        for k, x in enumerate(cusps):
            others = (y for i, y in enumerate(cusps) if i != k)
            nearest = min((hypot(x.first - y.first, x.second - y.second) for y in others), default=1.0)
            if nearest * _PART < self.tolerance * self.extent:
                yield x.first, x.second, nearest

    def _allowed(self, x: Sample) -> float:
        """The deviation of a chord that is allowed at a sample, in the joint plane."""
        allowed = self.tolerance * self.extent
        for first, second, nearest in self._cusps:
            allowed = min(allowed, _PART * max(hypot(x.first - first, x.second - second), nearest))
        return max(allowed, FINEST * self.extent)

    def _ends(self, slab: int, arc: int) -> list[tuple[float, Sample]]:
        if not self._lines:
            [start] = self._solved(slab, -pi)[arc : arc + 1]
            return [(0.0, self.sample(start, -pi)), (1.0, self.sample(start, pi))]
        ends = []
        for tau, line, side in ((0.0, slab, 1), (1.0, self.sweep.line_after(slab), 0)):
            meeting = next(m for m in self.sweep.lines[line].meetings if arc in (m.left, m.right)[side])
            alpha = self._alpha_at(line, meeting, side, arc)
            ends.append((tau, self.sample(alpha, self._angle(slab, tau))))
        return ends

    def _alpha_at(self, line: int, meeting: Meeting, side: int, arc: int | None = None) -> float:
        """α of the chart at a meeting; at t = ∞ the sign is that of the arc."""
        if meeting.point is not None:
            return 2 * atan(float(meeting.point.mid()))
        sides = self.sweep.lines[line].sides
        j = self.floats.on_line(self._lines[line] + self._theta0)
        pair = meeting.left if len(meeting.left) == 2 else meeting.right if len(meeting.right) == 2 else None
        if pair is not None:
            a, b = (angle_of(sides[pair is meeting.right][k]) for k in pair)
            middle = (a + b) / 2 if abs(a - b) < pi else (a + b) / 2 + pi
            found = j.turning(middle + self._alpha0)
            return middle if found is None else found - self._alpha0
        assert arc is not None, "a passage is an end of an arc"
        near = angle_of(sides[side][arc])
        found = j.root(near + self._alpha0)
        return near if found is None else found - self._alpha0

    def _on_arc(self, slab: int, arc: int, tau: float, guess: float | None) -> Sample:
        theta = self._angle(slab, tau)
        if guess is not None and not self.sweep.chart.repeated:
            j = self.floats.on_line(theta + self._theta0)
            alpha = j.root(guess)
            if alpha is not None and j.value_and_slope(alpha)[1] * self.sweep.slabs[slab].signs[arc] > 0:
                first, second = self.floats.joints(alpha, theta + self._theta0)
                return Sample(alpha, theta + self._theta0, first, second)
        return self.sample(self._solved(slab, theta)[arc], theta)

    def _solved(self, slab: int, theta: float) -> list[float]:
        """α of the chart of all arcs at one θ, isolated at a rational u within the slab."""
        if (slab, theta) not in self._roots:
            u = Fraction(tan(theta / 2))
            if self.sweep.lines:
                low, high = self.sweep.lines[slab], self.sweep.lines[self.sweep.line_after(slab)]
                u = _clamped(u, low, high, theta)
            self._roots[slab, theta] = [angle_of(root) for root in real_roots(self.sweep.chart.above(u))]
        return self._roots[slab, theta]

    def _refine(
        self,
        slab: int,
        arc: int,
        start: float,
        first: Sample,
        stop: float,
        last: Sample,
        into: list[Sample],
        depth: int,
    ) -> None:
        tau = (start + stop) / 2
        middle = self._on_arc(slab, arc, tau, (first.alpha + last.alpha) / 2)
        if depth < _DEEPEST and self._coarse(first, middle, last):
            self._refine(slab, arc, start, first, tau, middle, into, depth + 1)
            into.append(middle)
            self._refine(slab, arc, tau, middle, stop, last, into, depth + 1)
        else:
            into.append(middle)

    def _coarse(self, a: Sample, x: Sample, b: Sample) -> bool:
        """Whether the sample between two others is too far from their chord, in either plane."""
        if _from_chord(a.alpha, a.theta, x.alpha, x.theta, b.alpha, b.theta) > TURN * self.tolerance:
            return True
        return _from_chord(a.first, a.second, x.first, x.second, b.first, b.second) > self._allowed(x)


def angle_of(root: RealRoot) -> float:
    """The angle with this half tangent."""
    return 2 * atan(float(root.ball.mid()))


def _clamped(u: Fraction, low: Line, high: Line, theta: float) -> Fraction:
    """u, or the nearest rational that is known to lie in the slab between two lines."""
    start, stop = low.around[1], high.around[0]
    if start <= stop:
        return min(max(u, start), stop)
    return u if u >= start or u <= stop else (start if theta > 0 else stop)


def _from_chord(ax: float, ay: float, px: float, py: float, bx: float, by: float) -> float:
    """The distance of a point from a line segment."""
    dx, dy, x, y = bx - ax, by - ay, px - ax, py - ay
    square = dx * dx + dy * dy
    if not square:
        return hypot(x, y)
    part = min(max((x * dx + y * dy) / square, 0.0), 1.0)
    return hypot(x - part * dx, y - part * dy)
