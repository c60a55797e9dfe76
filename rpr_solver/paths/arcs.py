"""Arcs of a motion: α, θ and the fixed length as polynomials of one parameter, and the map along them.

An arc is a Bézier curve over its control points, so an arc of two points is straight. The parameter τ runs
from 0 to 1. Along an arc the squared lengths and J are power series in τ, by the rules for sines and sums.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.slice_map import Leg, SliceMap

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
