"""The course of the arcs of a sweep, as samples in floats that keep a chord tolerance in both planes.

An arc is parametrised by τ in [0, 1], with θ = θ₀ + (θ₁ − θ₀)(1 − cos πτ)/2, in which it is smooth also where
it ends in a turning point. It is halved until the middle of a piece deviates little enough from its chord,
which is no bound by proof (docs/singular-curves.md says what one would cost). The sign of ∂J/∂α distinguishes
neighbouring arcs; where Newton's iteration fails, the roots of J at a rational u are isolated again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, cmp_to_key
from itertools import pairwise
from math import acos, atan, cos, hypot, pi, sqrt, tan
from typing import NamedTuple

from rpr_solver.errors import SolverError
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.singular.line import Meeting
from rpr_solver.singular.sweep import Sweep
from rpr_solver.singular.vertices import ArcPlace, Vertex

TURN = 2 * pi
_FIRST = (0.25, 0.5, 0.75)
_DEEPEST = 24
_PART = 1 / 30
_MOST_WORK, _ISOLATION = 200_000, 100
"""Points of a picture, the finest of which have about 11,000, and how many of them take as long as the
isolation of all arcs at one θ. Beyond that the roundings of floats are being followed."""
_OFF, _NEAR = 1e-6, 0.3
"""How far at least, and at most, a zero of J is from one isolated at another θ that it replaces. What is
nearer is drawn alike, and keeps the digits of documents that exist."""
_APART, _ALIKE = 1e-6, 2.0**-40
"""Zeros of J at one θ that are closer than this are not told apart by Newton's method."""
_BITS = 64
FINEST = 1e-8
"""Floats do not separate curves that are closer than this part of the picture."""


class Sample(NamedTuple):
    """A point of a singular curve: α and θ in radians, the two free legs in the unit of the float slice."""

    alpha: float
    theta: float
    first: float
    second: float


@dataclass(frozen=True)
class Mark:
    """A point on an arc that must be a sample: a cusp, or a pose with a leg of length 0."""

    place: ArcPlace
    vertex: Vertex


@dataclass(frozen=True)
class Course:
    """The samples of one arc, by ascending θ, and those of its marks by their place in ``samples``."""

    samples: tuple[Sample, ...]
    marks: tuple[tuple[int, Mark], ...]


Node = tuple[float, Sample]
"""A parameter of an arc, and the sample there."""
Point = tuple[float, float]
"""α and θ in degrees."""


class ArcPoints:
    """The points of the arcs of a sweep in floats, by slab, arc and parameter.

    Attributes:
        sweep: the topology.
        floats: the slice.
    """

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        self.floats = FloatSlice.of(sweep.chart.slice_map, sweep.chart.length)
        self._alpha0, self._theta0 = sweep.chart.offsets
        self._root = sqrt(sweep.chart.slice_map.rho)
        self._lines = [angle_of(line.root, self._root) for line in sweep.lines]
        self._roots: dict[tuple[int, float], list[float]] = {}
        self._work = 0

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

    def at_mark(self, mark: Mark) -> Sample:
        """The sample of a mark; a leg of length 0 has it exactly."""
        x = self.at_place(mark.place)
        first, second = (
            0.0 if text == "0" else length
            for text, length in zip(mark.vertex.point.coordinates[2:], (x.first, x.second), strict=True)
        )
        return Sample(x.alpha, x.theta, first, second)

    def at_place(self, place: ArcPlace) -> Sample:
        """The point at a place inside a slab."""
        return self.sample(2 * atan(self._root * place.t), self._angle_in(place.slab, place.u))

    def ends(self, slab: int, arc: int) -> list[Node]:
        """Both ends of an arc."""
        if not self._lines:
            [start] = self._solved(slab, -pi)[arc : arc + 1]
            return [(0.0, self.sample(start, -pi)), (1.0, self.sample(start, pi))]
        ends = []
        for tau, line, side in ((0.0, slab, 1), (1.0, self.sweep.line_after(slab), 0)):
            meeting = next(m for m in self.sweep.lines[line].meetings if arc in (m.left, m.right)[side])
            alpha = self._alpha_at(line, meeting, side, arc)
            ends.append((tau, self.sample(alpha, self._angle(slab, tau))))
        return ends

    def on_arc(self, slab: int, arc: int, tau: float, guess: float | None = None) -> Sample:
        """The point at a parameter, perhaps with an α near it.

        Raises:
            SolverError: far more points are asked for than any picture needs.
        """
        self._work += 1
        if self._work > _MOST_WORK:
            raise SolverError("these lengths differ too much for a drawing in double precision")
        theta = self._angle(slab, tau)
        if guess is not None and not self.sweep.chart.repeated:
            here = self._zero(slab, arc, theta, guess)
            if here is not None:
                return Sample(here, theta + self._theta0, *self.floats.joints(here, theta + self._theta0))
        alpha = self._solved(slab, theta)[arc]  # of another θ, close to a line
        here = self._zero(slab, arc, theta, alpha + self._alpha0)
        closer = None if here is None else here - self._alpha0
        if closer is None or abs(closer - alpha) >= _NEAR:  # intervals beside zeros that nearly meet are wide
            closer = arcs_at(self.sweep, slab, theta, _BITS)[arc]
        return self.sample(closer if abs(closer - alpha) > _OFF else alpha, theta)

    def _zero(self, slab: int, arc: int, theta: float, guess: float) -> float | None:
        """The α at which J is 0, by Newton's iteration; None if its slope there is not that of the arc."""
        j = self.floats.on_line(theta + self._theta0)
        alpha = j.root(guess)
        if alpha is None or not j.value_and_slope(alpha)[1] * self.sweep.slabs[slab].signs[arc] > 0:
            return None
        return alpha

    def parameter(self, slab: int, u: float) -> float:
        """The parameter of a half tangent in a slab."""
        low, high = self._limits(slab)
        part = min(max((self._angle_in(slab, u) - low) / (high - low or 1.0), 0.0), 1.0)
        return acos(1 - 2 * part) / pi if self._lines else part

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
        angle = 2 * atan(self._root * u)
        return angle + TURN if angle < low and high > pi else angle

    def _alpha_at(self, line: int, meeting: Meeting, side: int, arc: int | None = None) -> float:
        """α of the chart at a meeting; at t = ∞ the sign is that of the arc."""
        if meeting.point is not None:
            return 2 * atan(self._root * float(meeting.point.mid()))
        sides = self.sweep.lines[line].sides
        j = self.floats.on_line(self._lines[line] + self._theta0)
        pair = meeting.left if len(meeting.left) == 2 else meeting.right if len(meeting.right) == 2 else None
        if pair is not None:
            a, b = (angle_of(sides[pair is meeting.right][k], self._root) for k in pair)
            middle = (a + b) / 2 if abs(a - b) < pi else (a + b) / 2 + pi
            found = j.turning(middle + self._alpha0)
            return middle if found is None else found - self._alpha0
        assert arc is not None, "a passage is an end of an arc"
        near = angle_of(sides[side][arc], self._root)
        found = j.root(near + self._alpha0)
        return near if found is None else found - self._alpha0

    def _solved(self, slab: int, theta: float) -> list[float]:
        """α of the chart of all arcs at one θ, isolated at a rational u within the slab."""
        if (slab, theta) not in self._roots:
            self._work += _ISOLATION
            self._roots[slab, theta] = arcs_at(self.sweep, slab, theta)
        return self._roots[slab, theta]


class Tracer:
    """Draws the arcs of a sweep.

    Args:
        sweep: the topology.
        tolerance: the largest deviation of a chord, relative to a full turn, and to the extent of the
            picture in the joint plane.
        cusps: cusps, near which the curve is drawn as finely as the distance to the next cusp needs.
    """

    def __init__(self, sweep: Sweep, tolerance: float, cusps: Sequence[ArcPlace] = ()) -> None:
        self.points = ArcPoints(sweep)
        self.tolerance = tolerance
        self._cusps = list(self._focused([self.points.at_place(place) for place in cusps]))

    @cached_property
    def extent(self) -> float:
        """The larger side of the box round the first samples, in the joint plane."""
        points = [x for slab in self._first for arc in slab for _, x in arc]
        if not points:
            return 1.0
        firsts, seconds = [x.first for x in points], [x.second for x in points]
        return max(max(firsts) - min(firsts), max(seconds) - min(seconds)) or 1.0

    def course(self, slab: int, arc: int, marks: Sequence[Mark] = ()) -> Course:
        """The samples of one arc; marks and ends that are alike in floats have one each, in exact order."""

        def order(x: tuple[float, Mark], y: tuple[float, Mark]) -> int:
            near = abs(x[0] - y[0]) < _ALIKE
            exactly = x[1].place.order(y[1].place) if near else 0
            return exactly or (x[0] > y[0]) - (x[0] < y[0])

        by_decimals = sorted(marks, key=lambda mark: Decimal(mark.vertex.point.coordinates[1]))
        pairs = ((self.points.parameter(slab, mark.place.u), mark) for mark in by_decimals)
        ordered = sorted(pairs, key=cmp_to_key(order))
        placed = [
            (tau, self.points.at_mark(mark), mark)
            for tau, (_, mark) in zip(sorted(tau for tau, _ in ordered), ordered, strict=True)
        ]
        first, *inner, last = self._first[slab][arc]
        marked = {id(x) for x in (first[1], *(x for _, x, _ in placed), last[1])}
        own = [first, *sorted([*inner, *((tau, x) for tau, x, _ in placed)], key=lambda x: x[0]), last]
        samples = [own[0][1]]
        for low, high in pairwise(own):
            if high[0] > low[0]:
                samples += self._between((slab, arc), low, high)
                samples.append(high[1])
            elif id(samples[-1]) not in marked:
                samples[-1] = high[1]
            elif id(high[1]) in marked:
                samples.append(high[1])
        places = {id(x): k for k, x in enumerate(samples)}
        found = sorted(((places[id(x)], mark) for _, x, mark in placed), key=lambda y: y[0])
        return Course(tuple(samples), tuple(found))

    @cached_property
    def _first(self) -> list[list[list[Node]]]:
        """By slab and arc: both ends and a few samples between."""
        return [
            [self._first_of(slab, arc) for arc in range(len(part.arcs))]
            for slab, part in enumerate(self.points.sweep.slabs)
        ]

    def _first_of(self, slab: int, arc: int) -> list[Node]:
        inner = ((tau, self.points.on_arc(slab, arc, tau)) for tau in _FIRST)
        return sorted([*self.points.ends(slab, arc), *inner], key=lambda x: x[0])

    def _between(self, arc: tuple[int, int], low: Node, high: Node, depth: int = 0) -> Iterator[Sample]:
        """Yields the samples that are needed between two."""
        (start, first), (stop, last) = low, high
        tau = (start + stop) / 2
        middle = self.points.on_arc(*arc, tau, (first.alpha + last.alpha) / 2)
        is_coarse = depth < _DEEPEST and self._is_coarse(first, middle, last)
        if is_coarse:
            yield from self._between(arc, low, (tau, middle), depth + 1)
        yield middle
        if is_coarse:
            yield from self._between(arc, (tau, middle), high, depth + 1)

    def _is_coarse(self, a: Sample, x: Sample, b: Sample) -> bool:
        """Whether the sample between two others is too far from their chord, in either plane."""
        if _from_chord(a.alpha, a.theta, x.alpha, x.theta, b.alpha, b.theta) > TURN * self.tolerance:
            return True
        return _from_chord(a.first, a.second, x.first, x.second, b.first, b.second) > self._allowed(x)

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


def angle_of(root: RealRoot, unit: float = 1.0) -> float:
    """The angle with this half tangent, measured in 1 over a unit, √ρ."""
    return 2 * atan(unit * float(root.ball.mid()))


def arcs_at(sweep: Sweep, slab: int, theta: float, bits: int = 0) -> list[float]:
    """α of all arcs of a slab at one θ, both of the chart, to this many bits, at a rational u within it."""
    unit = sqrt(sweep.chart.slice_map.rho)
    u = Fraction(tan(theta / 2) / unit)
    if sweep.lines:
        low, high = _sides(sweep, slab)
        if low <= high:
            u = min(max(u, low), high)
        elif high < u < low:
            u = min((low, high), key=lambda end: abs(end - u))
    roots = real_roots(sweep.chart.above(u))
    return [2 * atan(unit * float((root.refined(bits) if bits else root.ball).mid())) for root in roots]


def _sides(sweep: Sweep, slab: int) -> tuple[Fraction, Fraction]:
    """The first and the last u at which the arcs of a slab are known; they descend if u = ∞ is between."""
    return sweep.lines[slab].around[1], sweep.lines[sweep.line_after(slab)].around[0]


def arcs_beside(
    floats: FloatSlice, sweep: Sweep, slab: int, theta: float, known: Sequence[float]
) -> list[float] | None:
    """As :func:`arcs_at`, by Newton's method from the arcs at a θ nearby; None unless it finds them all.

    In a slab there are as many zeros as at any other θ, in the order of the arcs, so that none is mistaken.
    """
    if sweep.lines:
        low, high = (float(u) for u in _sides(sweep, slab))
        u = tan(theta / 2) / sqrt(sweep.chart.slice_map.rho)
        if not (low < u < high or (high < low and not high <= u <= low)):
            return None
    turn, other = sweep.chart.offsets
    j = floats.on_line(theta + other)
    roots = [j.root(alpha + turn) for alpha in known]
    found = [root - turn for root in roots if root is not None]
    apart = all(b - a > _APART for a, b in pairwise([-pi, *found, pi]))
    return found if apart and len(found) == len(known) else None


def _from_chord(ax: float, ay: float, px: float, py: float, bx: float, by: float) -> float:
    """The distance of a point from a line segment."""
    dx, dy, x, y = bx - ax, by - ay, px - ax, py - ay
    square = dx * dx + dy * dy
    if not square:
        return hypot(x, y)
    part = min(max((x * dx + y * dy) / square, 0.0), 1.0)
    return hypot(x - part * dx, y - part * dy)
