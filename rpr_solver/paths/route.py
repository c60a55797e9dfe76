"""Routes: arcs of a motion in balls, the map along them, and the exact description of a path.

An arc gives α, θ and the fixed length as polynomials of one parameter τ, which runs from 0 to 1. It is a
Bézier curve over its control points, so an arc of two points is straight. Along it the squared lengths and J
are power series in τ, by the rules for sines and sums.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.paths.isolated import IsolatedPose

Point = tuple[arb, arb, arb]
"""α and θ in radians, and the scaled length of the fixed leg."""


@dataclass(frozen=True)
class Arc:
    """The polynomials α(τ), θ(τ) in radians and L(τ), scaled, for 0 ≤ τ ≤ 1."""

    alpha: arb_poly
    theta: arb_poly
    length: arb_poly

    @classmethod
    def over(cls, points: Sequence[Point]) -> Arc:
        """The Bézier curve of two or three control points."""
        return cls(*(_bezier(coordinates) for coordinates in zip(*points, strict=True)))

    def at(self, tau: arb) -> Point:
        """The point at one parameter."""
        return self.alpha(tau), self.theta(tau), self.length(tau)


def _bezier(coordinates: Sequence[arb]) -> arb_poly:
    if len(coordinates) == 2:
        first, last = coordinates
        return arb_poly([first, last - first])
    first, middle, last = coordinates
    return arb_poly([first, 2 * (middle - first), first - 2 * middle + last])


@dataclass(frozen=True)
class Expansion:
    """Taylor coefficients at one τ, or bounds on them over a ball of τ.

    ``first`` and ``second`` are of half the squared free legs, ``singularity`` of J / L; lengths are scaled.
    """

    first: arb_series
    second: arb_series
    singularity: arb_series


def expanded(slice_map: SliceMap, arc: Arc, tau: arb, order: int) -> Expansion:
    """The expansion along an arc up to the power ``order``."""
    size = order + 1
    shift = arb_poly([tau, 1])
    alpha, theta, length = (
        arb_series(list(p(shift))[:size], prec=size) for p in (arc.alpha, arc.theta, arc.length)
    )
    (sin_a, cos_a), (sin_t, cos_t) = alpha.sin_cos(), theta.sin_cos()
    omega = omega_ball(slice_map.radicand, ctx.prec)

    def leg(one: Leg) -> tuple[Any, Any, Any]:
        """Half the squared length, less a constant of the leg that is added; and its two slopes."""
        x, y = one.rotated(cos_a, sin_a, omega)
        across, along = length * cos_t + (x - one.ax), length * sin_t + (y - one.ay)
        square = (across * across + along * along) * arb(0.5)
        return square, along * x - across * y, along * cos_t - across * sin_t

    f, f_alpha, f_theta = leg(slice_map.f)
    g, g_alpha, g_theta = leg(slice_map.g)
    return Expansion(f, g, f_alpha * g_theta - f_theta * g_alpha)


def bounded(near: arb_series, wide: arb_series, radius: arb) -> arb:
    """All values at a distance of at most ``radius`` from a point: the series there to its slope, and the
    coefficient of order 2 over the whole ball."""
    bend = wide[2] * arb(radius * radius / 2, (radius * radius / 2).abs_upper())
    return near[0] + near[1] * arb(0, radius.abs_upper()) + bend


_SPARE_BITS = 64


@dataclass(frozen=True)
class ControlPoint:
    """A control point of a Bézier arc, exact.

    Attributes:
        alpha_deg: α in degrees, not confined to (−180, 180].
        theta_deg: the fixed leg's angle in degrees, not confined either.
        length: of the fixed leg, in the user's unit.

    >>> ControlPoint(Fraction(25, 2), Fraction(190), Fraction(27)).to_json(1)
    {'alpha_deg': '12.5', 'theta1_deg': '190', 'l1': '27'}
    """

    alpha_deg: Fraction
    theta_deg: Fraction
    length: Fraction

    def to_json(self, fixed_leg: int) -> dict[str, str]:
        """The document's object."""
        names = "alpha_deg", f"theta{fixed_leg}_deg", f"l{fixed_leg}"
        values = self.alpha_deg, self.theta_deg, self.length
        return {name: exact_str(value) for name, value in zip(names, values, strict=True)}

    def point(self, scale: Fraction) -> Point:
        """In radians and scaled, as balls at the working precision."""
        degree = arb.pi() / 180
        alpha, theta = (ball_of(angle) * degree for angle in (self.alpha_deg, self.theta_deg))
        return alpha, theta, ball_of(self.length * scale)


@dataclass(frozen=True)
class Route:
    """A path in (α, θ, L): Bézier arcs that lead from one pose of a joint vector to another.

    Each arc has two or three control points and begins where the one before ends. The first and the last are
    None: they are the start and the stop.
    """

    start: IsolatedPose
    stop: IsolatedPose
    arcs: tuple[tuple[ControlPoint | None, ...], ...]

    @property
    def slice_map(self) -> SliceMap:
        """The manipulator with its fixed leg."""
        return self.start.slice_map

    def reversed(self) -> Route:
        """The same path, run backwards."""
        return Route(self.stop, self.start, tuple(arc[::-1] for arc in self.arcs[::-1]))

    def at(self, bits: int) -> list[Arc]:
        """The arcs as balls, with about this many correct bits.

        Raises:
            Unproved: a pose at an end cannot be refined so far.
        """
        with ctx.workprec(bits + _SPARE_BITS):
            scale = self.slice_map.scale
            start, stop = ((*pose.refined(bits), ball_of(pose.legs[0])) for pose in (self.start, self.stop))
            points = [[start if p is None else p.point(scale) for p in arc] for arc in self.arcs]
            points[-1][-1] = stop
            return [Arc.over(arc) for arc in points]

    def to_json(self) -> list[list[dict[str, str] | str]]:
        """The control points of each arc; the ends are ``"from"`` and ``"to"``."""
        leg = self.slice_map.fixed_leg
        arcs: list[list[Any]] = [["from" if p is None else p.to_json(leg) for p in arc] for arc in self.arcs]
        arcs[-1][-1] = "to"
        return arcs
