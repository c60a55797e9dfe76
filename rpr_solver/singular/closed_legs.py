"""Poses of the singular curve in which a free leg has length 0: corners of the curve in the joint plane."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx, fmpz_poly

from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.factors import ExactRoot
from rpr_solver.exact.precision import TIMES_BEFORE_EXACT, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.classify import PoseKind, cos_sin
from rpr_solver.model.exact_pose import ExactPose
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.model.jets import LocalMap, Pose, R
from rpr_solver.model.joint_points import JointPoint, point_of_pose
from rpr_solver.model.slice_map import Leg
from rpr_solver.singular.charts import Chart, Turn
from rpr_solver.singular.sweep import Sweep
from rpr_solver.singular.vertices import (
    NotPlacedError,
    Place,
    Vertex,
    VertexKind,
    placed,
    point_of_balls,
    turned,
)


def closed_legs(sweep: Sweep, digits: int) -> Iterator[tuple[Vertex, Place]]:
    """The poses in which a free leg has length 0, unless it closes while stretched along its base line.

    Raises:
        NotPlacedError: a pose could not be placed on its arc.
    """
    chart = sweep.chart
    slice_map = chart.slice_map
    powers = chart.theta.powers(2)
    for leg in (slice_map.f, slice_map.g):
        closed = leg.closed(chart.length)
        polynomial = sum((power * closed[k] for k, power in enumerate(powers)), fmpz_poly([]))
        for factor, order in polynomial.factor()[1]:
            for root in real_roots(QuadraticPoly.rational(factor)) if order == 1 else []:
                pose = ClosedPose(chart, leg, root)
                place = placed(sweep, root.refined, pose.half_alpha)
                if place is None:
                    raise NotPlacedError("a pose with a leg of length 0 could not be placed on its arc")
                if isinstance(place, Place):
                    yield Vertex(VertexKind.CLOSED_LEG, pose.point(digits)), place


@dataclass(frozen=True)
class ClosedPose:
    """The pose with a leg closed, at a half tangent u of θ in the chart."""

    chart: Chart
    leg: Leg
    u: RealRoot

    def half_alpha(self, bits: int) -> arb:
        """The half tangent of α in the chart."""
        pose = self._ball(bits)
        turn = self.chart.alpha
        with ctx.workprec(bits):
            cos, sin = turned(Turn(-turn.sin, turn.cos), pose.cos_alpha, pose.sin_alpha)
            half: arb = sin / (1 + cos)
        return half

    def point(self, digits: int) -> JointPoint:
        """Its coordinates in decimals."""

        def attempt(bits: int) -> JointPoint | None:
            with ctx.workprec(bits):
                return point_of_balls(self.chart, self._ball(bits), digits, self.leg)

        start = digit_bits(digits) + 128
        point = decided_or_none(attempt, start, TIMES_BEFORE_EXACT * start)
        return self._exact_point(digits) if point is None else point

    def _ball(self, bits: int) -> Pose[arb]:
        with ctx.workprec(bits):
            angle = HalfTangent(self.u.refined(bits), arb(1)).cos_sin()
            return self._pose(*angle, omega_ball(self.chart.slice_map.radicand, bits), ball_of)

    def _exact_point(self, digits: int) -> JointPoint:
        """The same in a number field, for coordinates that are exact decimals."""
        slice_map = self.chart.slice_map
        u, omega = ExactRoot(self.u, slice_map.radicand, 1, None).in_field()
        pose = self._pose(*cos_sin(u, u.field), omega, u.field)
        return point_of_pose(ExactPose(PoseKind.ORDINARY, LocalMap.at(slice_map, pose, 0)), digits).point

    def _pose(self, cos: R, sin: R, omega: R, number: Callable[[Fraction], R]) -> Pose[R]:
        """R(α) m = a − X, in any ring, from the angle θ in the chart."""
        leg = self.leg
        cos, sin = turned(self.chart.theta, cos, sin)
        length = number(self.chart.length)
        x, y = number(Fraction(leg.ax)) - length * cos, number(Fraction(leg.ay)) - length * sin
        n, share = omega * leg.n, number(Fraction(1, leg.platform2))
        return Pose((x * leg.m + y * n) * share, (y * leg.m - x * n) * share, cos, sin, length, omega)
