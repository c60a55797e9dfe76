"""Special points of the singular curves, exactly: turning points, nodes, cusps, and poses with a closed leg.

Turning points, and all points of multiple lines, come with the sweep. Cusps are those of the cusp table;
each is placed on its arc by proof: exactly one arc passes through a small cell round it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from typing import Any

from flint import acb, arb, ctx, fmpz_poly

from rpr_solver.contract import MIN_DIGITS
from rpr_solver.errors import Unproved
from rpr_solver.exact import decided, decided_or_none
from rpr_solver.exact.decimals import digit_bits, round_all
from rpr_solver.exact.factors import ExactRoot, exact_counterparts, exact_roots, norm_factors
from rpr_solver.exact.number_field import Algebraic, adjoin_real_roots, poly_gcd, squarefree_part, trimmed
from rpr_solver.exact.precision import EVENT_BITS, TIMES_BEFORE_EXACT
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import ball_of, fraction_of, roots_below
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, Pose, common_root, direction
from rpr_solver.model.joint_points import (
    ExactPose,
    JointPoint,
    Kind,
    PoseKind,
    cos_sin,
    joint_point,
    point_of_pose,
)
from rpr_solver.model.slice_map import Leg
from rpr_solver.singular.charts import Chart, Turn
from rpr_solver.singular.line import Line, free_of_zeros, position
from rpr_solver.singular.sweep import Sweep

_FIRST_BITS = 64

Ball = Callable[[int], arb]
"""A number as a ball, from the precision in bits."""


class NotPlaced(Unproved):
    """A point could not be placed on its arc; it may be infinite in this chart, and not in another."""


class VertexKind(Kind):
    """The kinds of special points that are not degenerate poses; the others are of :class:`PoseKind`.

    >>> VertexKind.TURNING == "turning"
    True
    """

    TURNING = "turning"
    """The fixed leg's angle has an extremum along the curve: ∂J/∂α = 0."""
    CLOSED_LEG = "closed-leg"
    """A free leg has length 0; its reversal makes a corner in the joint plane."""


@dataclass(frozen=True)
class Vertex:
    """A special point of the singular curves.

    Attributes:
        kind: ``"cusp"``, ``"turning"``, ``"closed-leg"``, or that of a degenerate pose such as ``"node"``.
        point: its coordinates, correctly rounded decimals.
        cusp: the number of a cusp in the cusp table, from 1; None for other points.

    >>> Vertex(PoseKind.CUSP, JointPoint(1, ("-164.316", "1.990", "5.673", "34.945")), 1).to_json()["kind"]
    'cusp'
    """

    kind: PoseKind | VertexKind
    point: JointPoint
    cusp: int | None = None

    def to_json(self) -> dict[str, Any]:
        """The document's vertex object, without its index."""
        number = {} if self.cusp is None else {"cusp": self.cusp}
        return {"kind": self.kind.value, **number, **self.point.to_json()}


@dataclass(frozen=True)
class ArcPlace:
    """A point inside a slab: the slab, the arc, u and t of the chart in floats, and u as a ball."""

    slab: int
    arc: int
    u: float
    t: float
    ball: Ball = field(compare=False, repr=False)

    def order(self, other: ArcPlace) -> int:
        """−1 or 1 if it is before or after another place of its arc, by ascending θ; 0 if that is open."""

        def attempt(bits: int) -> int | None:
            here, there = self.ball(bits), other.ball(bits)
            if abs(self.u) > 1:  # u = ∞ is nothing special on an arc
                here, there = -1 / here, -1 / there
            return -1 if here < there else 1 if here > there else None

        return decided_or_none(attempt, _FIRST_BITS, EVENT_BITS) or 0


def vertices_of_lines(sweep: Sweep, digits: int) -> Iterator[tuple[tuple[int, int], Vertex]]:
    """The turning points and degenerate points, by their lines and meetings.

    Raises:
        Unproved: digits could not be decided.
    """
    for number, line in enumerate(sweep.lines):
        if line.exact is None:
            for cell, meeting in enumerate(line.meetings):
                if not meeting.passes:
                    yield (number, cell), Vertex(VertexKind.TURNING, turning_point(sweep.chart, line, digits))
            continue
        for cell, pose in poses_on_line(sweep, number):
            meeting = line.meetings[cell]
            kind = VertexKind.TURNING if meeting.turns and pose.kind is PoseKind.ORDINARY else pose.kind
            if kind and kind is not PoseKind.CUSP:
                yield (number, cell), Vertex(kind, point_of_pose(pose, digits).point)


def poses_on_line(sweep: Sweep, number: int) -> Iterator[tuple[int, ExactPose]]:
    """The multiple zeros of J on a critical line, classified, by their meetings."""
    line = sweep.lines[number]
    for t, pose in exact_points(sweep.chart, exact_line(sweep.chart, line)):
        if line.exact is None:
            [cell] = (k for k, meeting in enumerate(line.meetings) if not meeting.passes)
        else:
            cell = _cell_of(line, t.ball)
        yield cell, pose


def _cell_of(line: Line, t: Ball) -> int:
    """The meeting of a multiple line at which a point of the curve lies."""

    def attempt(bits: int) -> int | None:
        ball = t(bits)
        near = [k for k, m in enumerate(line.meetings) if m.point is not None and m.point.overlaps(ball)]
        return near[0] if len(near) == 1 else None

    return decided(attempt, _FIRST_BITS, EVENT_BITS, "a degenerate point could not be placed")


def turning_point(chart: Chart, line: Line, digits: int) -> JointPoint:
    """The point at which two arcs meet on a simple line.

    Raises:
        Unproved: its digits could not be decided.
    """
    start = digit_bits(digits) + 128
    slope_rows = range(1, len(chart.rows))

    def attempt(bits: int) -> JointPoint | None:
        u = line.root.refined(bits)
        with ctx.workprec(bits):
            form = [row.ball(bits)(u) for row in chart.rows]
            slope = [form[i] * i for i in slope_rows]
            t = common_root(form, slope) if len(form) > 3 else HalfTangent(-form[1], 2 * form[2])
            if t is None or t.denominator.contains(0):
                return None
            bridge = Bridge.of(chart.slice_map)
            ca, sa = bridge.alpha(chart.alpha.whole(t)).cos_sin()
            ct, st = bridge.theta(chart.theta.whole(HalfTangent(u, arb(1)))).cos_sin()
            pose = Pose(ca, sa, ct, st, ball_of(chart.length), omega_ball(chart.slice_map.radicand, bits))
            return point_of_balls(chart, pose, digits)

    point = decided_or_none(attempt, start, TIMES_BEFORE_EXACT * start)
    if point is not None:
        return point
    [(_, pose)] = exact_points(chart, exact_line(chart, line))
    return point_of_pose(pose, digits).point


def point_of_balls(
    chart: Chart, pose: Pose[arb], digits: int, closed: Leg | None = None
) -> JointPoint | None:
    """A pose in decimals; None if the balls are too wide.

    Args:
        chart: of the slice.
        pose: at the working precision.
        digits: significant digits.
        closed: a free leg whose length is known to be 0.
    """
    slice_map = chart.slice_map
    squares = LocalMap.at(slice_map, pose, 0).squared_lengths()
    lengths = []
    for leg, square in zip((slice_map.f, slice_map.g), squares, strict=True):
        if leg is not closed and not square > 0:
            return None
        lengths.append(arb(0) if leg is closed else square.sqrt() / slice_map.scale_ball())
    angles = direction(pose.cos_alpha, pose.sin_alpha), direction(pose.cos_theta, pose.sin_theta)
    texts = round_all((*angles, *lengths), digits)
    return None if texts is None else joint_point(texts, slice_map.fixed_leg)


def exact_line(chart: Chart, line: Line) -> ExactRoot:
    """The u of a critical line in a number field."""
    if line.exact is not None:
        return line.exact
    [root] = exact_counterparts([line.root], norm_factors(chart.discriminant.polynomial))
    return root


def exact_points(chart: Chart, root: ExactRoot) -> Iterator[tuple[Algebraic, ExactPose]]:
    """The multiple zeros t on a critical line, ascending, with their poses, classified."""
    u, omega = root.in_field()
    form = trimmed([row(u, omega) for row in chart.rows])
    slope = trimmed([c * i for i, c in enumerate(form)][1:])
    multiple = poly_gcd(form, slope)
    if len(multiple) < 2:
        return
    for extension in adjoin_real_roots(omega.field, squarefree_part(multiple)):
        t, at, own_omega = extension.root, extension.lift(u), extension.lift(omega)
        field = t.field
        rho = chart.slice_map.rho
        cos_a, sin_a = turned(chart.alpha, *cos_sin(t, field, rho))
        cos_t, sin_t = turned(chart.theta, *cos_sin(at, field, rho))
        pose = Pose(cos_a, sin_a, cos_t, sin_t, field(chart.length), own_omega)
        yield t, ExactPose.of(chart.slice_map, pose)


def turned(turn: Turn, cos: Algebraic, sin: Algebraic) -> tuple[Algebraic, Algebraic]:
    """The turn by the whole angle, from that by the angle in a chart."""
    p, q, n = turn.rotation
    over = cos.field(Fraction(1, n))
    return (cos * p - sin * q * turn.rho) * over, (sin * p + cos * q) * over


def find_place(sweep: Sweep, u: Ball, t: Ball, most: int = EVENT_BITS) -> ArcPlace | int | None:
    """The place of a point of the curve that is given by balls with this number of bits.

    If these do not decide it, the number of the line on which it may lie, or None where the arc is open.
    """
    line = 0

    def slab_of(bits: int) -> int | None:
        nonlocal line
        at = u(bits)
        below = 0
        for k, ball in enumerate(sweep.line_balls(bits)):
            if ball.overlaps(at):
                line = k
                return None
            below += bool(ball < at)
        return (below - 1) % len(sweep.slabs)

    slab = decided_or_none(slab_of, _FIRST_BITS, most)
    if slab is None:
        return line

    def attempt(bits: int) -> ArcPlace | None:
        at, across = u(bits), t(bits)
        if not (at.is_finite() and across.is_finite()):
            return None
        with ctx.workprec(2 * bits):
            middle = fraction_of(at)
            radius = Fraction(2) ** -(bits // 3) * (1 + fraction_of(abs(across)))
            low, high = fraction_of(across) - radius, fraction_of(across) + radius
            if not across.rad() * 4 < ball_of(radius) or not free_of_zeros(sweep.chart, at, (low, high)):
                return None
        below = roots_below(sweep.chart.above(middle).ball(4 * bits), (low, high), 4 * bits)
        if below is None or below[1] - below[0] != 1:
            return None
        return ArcPlace(slab, below[0], float(middle), float(across.mid()), u)

    return decided_or_none(attempt, _FIRST_BITS, most)


def cusp_place(sweep: Sweep, cusp: JointPoint) -> ArcPlace | int | None:
    """The place of a cusp from its printed coordinates, as :func:`placed` gives it."""
    chart = sweep.chart
    bridge = Bridge.of(chart.slice_map)
    ways = (chart.alpha, bridge.from_alpha), (chart.theta, bridge.from_theta)
    alpha, theta = (_half_of_degrees(text, *way) for text, way in zip(cusp.coordinates, ways, strict=False))
    # an angle of exactly 0 has one digit, and no error
    digits = max(MIN_DIGITS, *(len(Decimal(text).as_tuple().digits) for text in cusp.coordinates))
    return find_place(sweep, theta, alpha, digit_bits(digits))


def _half_of_degrees(text: str, turn: Turn, own: Callable[[HalfTangent], HalfTangent]) -> Ball:
    """The chart's half tangent of a printed angle in degrees."""
    value = Decimal(text)
    _, _, exponent = value.as_tuple()
    half_unit = Fraction(10) ** int(exponent) / 2 if value else Fraction(0)

    def ball(bits: int) -> arb:
        with ctx.workprec(bits + _FIRST_BITS):
            degrees = ball_of(Fraction(value)) + arb(0, ball_of(half_unit).abs_upper())
            half = turn.in_chart(own(HalfTangent(*(degrees * arb.pi() / 360).sin_cos())))
            return half.numerator / half.denominator

    return ball


def closed_legs(sweep: Sweep, digits: int) -> Iterator[tuple[Vertex, ArcPlace | tuple[int, int]]]:
    """The poses in which a free leg has length 0, unless it closes while stretched along its base line.

    Each has its place on an arc, or the numbers of its line and meeting, but for turning points.

    Raises:
        NotPlaced: a pose could not be placed on its arc.
    """
    chart = sweep.chart
    slice_map = chart.slice_map
    powers = chart.theta.powers(2)
    for leg in (slice_map.f, slice_map.g):
        closed = leg.closed(chart.length)
        a, b = (
            sum((power * part[k] for k, power in enumerate(powers)), fmpz_poly([]))
            for part in (closed.a, closed.b)
        )
        for root in exact_roots(norm_factors(QuadraticPoly(a, b, slice_map.radicand))):
            if root.multiplicity > 1:
                continue
            pose = ClosedPose(chart, leg, root)
            place = find_place(sweep, root.root.refined, pose.half_alpha)
            if place is None:
                raise NotPlaced("a pose with a leg of length 0 could not be placed on its arc")
            vertex = Vertex(VertexKind.CLOSED_LEG, pose.point(digits))
            if isinstance(place, ArcPlace):
                yield vertex, place
            elif (line := sweep.lines[place]).exact is not None:
                yield vertex, (place, _cell_of(line, pose.half_alpha))
            elif (cell := _passing_cell(chart, line, pose.half_alpha)) is not None:
                yield vertex, (place, cell)


def _passing_cell(chart: Chart, line: Line, t: Ball) -> int | None:
    """The meeting of a simple line where an arc passes through a point; None if it is the turning point."""
    middle, (low, high) = fraction_of(t(_FIRST_BITS)), line.around
    with ctx.workprec(_FIRST_BITS + 2 * max(low.denominator.bit_length(), high.denominator.bit_length())):
        interval = ball_of(low).union(ball_of(high))
    for bits in range(_FIRST_BITS // 2, 0, -1):
        radius = Fraction(1, 1 << bits) * (1 + abs(middle))
        sides = middle - radius, middle + radius
        if free_of_zeros(chart, interval, sides):
            arcs = tuple(k for k, arc in enumerate(line.sides[0]) if position(arc, sides) == 1)
            return next((k for k, x in enumerate(line.meetings) if x.passes and x.left == arcs), None)
    return None


@dataclass(frozen=True)
class ClosedPose:
    """The pose with a leg closed, at a half tangent u of θ in the chart."""

    chart: Chart
    leg: Leg
    u: ExactRoot

    def half_alpha(self, bits: int) -> arb:
        """The half tangent of α in the chart."""
        pose = self._ball(bits)
        with ctx.workprec(bits):
            half = HalfTangent(pose.sin_alpha, 1 + pose.cos_alpha)
            t = self.chart.alpha.in_chart(Bridge.of(self.chart.slice_map).from_alpha(half))
            return t.numerator / t.denominator

    def point(self, digits: int) -> JointPoint:
        """Its coordinates in decimals."""

        def attempt(bits: int) -> JointPoint | None:
            with ctx.workprec(bits):
                return point_of_balls(self.chart, self._ball(bits), digits, self.leg)

        start = digit_bits(digits) + 128
        point = decided_or_none(attempt, start, TIMES_BEFORE_EXACT * start)
        return self._exact_point(digits) if point is None else point

    def _ball(self, bits: int) -> Pose[arb]:
        """R(α) m = a − X, from the angle θ."""
        slice_map = self.chart.slice_map
        with ctx.workprec(bits):
            u = self.chart.theta.whole(HalfTangent(self.u.root.refined(bits), arb(1)))
            cos, sin = Bridge.of(slice_map).theta(u).cos_sin()
            omega, length = omega_ball(slice_map.radicand, bits), ball_of(self.chart.length)
            m, a = self.leg.points(omega)
            z = (a - acb(cos, sin) * length) / m
            return Pose(z.real, z.imag, cos, sin, length, omega)

    def _exact_point(self, digits: int) -> JointPoint:
        """The same in a number field, for coordinates that are exact decimals."""
        slice_map = self.chart.slice_map
        u, omega = self.u.in_field()
        pose = self._pose(*cos_sin(u, u.field, slice_map.rho), omega)
        return point_of_pose(ExactPose(PoseKind.ORDINARY, LocalMap.at(slice_map, pose, 0)), digits).point

    def _pose(self, cos: Algebraic, sin: Algebraic, omega: Algebraic) -> Pose[Algebraic]:
        """The same in a number field, from the angle θ in the chart."""
        leg, number = self.leg, omega.field
        cos, sin = turned(self.chart.theta, cos, sin)
        length, one = number(self.chart.length), number(1)
        x, y = (z.times(one, omega) - length * w for z, w in zip(leg.base, (cos, sin), strict=True))
        m, n = (z.times(one, omega) for z in leg.platform)
        share = number(Fraction(1, leg.platform2))
        cos_alpha, sin_alpha = (x * m + y * n * leg.rho) * share, (y * m - x * n) * share
        return Pose(cos_alpha, sin_alpha, cos, sin, length, omega)
