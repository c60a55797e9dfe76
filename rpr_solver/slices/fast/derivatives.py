"""J and E with their gradients at a pose, by closed formulas in any ring: floats, with bounds or without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from rpr_solver.model.slice_map import Leg

R = TypeVar("R")

At = tuple[R, R, R, R, R]
"""A pose: L, and the cosines and sines of α and θ."""
Slopes = tuple[Any, Any, Any, Any, Any, Any]


@dataclass(frozen=True)
class LegPoints(Generic[R]):
    """A free leg seen from the fixed one (:class:`~rpr_solver.model.slice_map.Leg`), ω put in."""

    m: R
    n: R
    ax: R
    ay: R

    @classmethod
    def of(cls, leg: Leg, number: Callable[[int, int], R]) -> LegPoints[R]:
        """``number(a, b)`` is a + b ω in the ring."""
        return cls(number(leg.m, 0), number(0, leg.n), number(leg.ax, 0), number(leg.ay, 0))

    @property
    def numbers(self) -> tuple[R, R, R, R]:
        """All of them."""
        return self.m, self.n, self.ax, self.ay

    def slopes(self, at: At[Any]) -> Slopes:
        """The derivatives f_α, f_θ, f_αα, f_αθ, f_θθ and f_ααθ of f/2; the others of order 3 follow.

        f_αθθ = −f_ααθ, f_ααα = −f_α and f_θθθ = −f_θ, as f is a sum of three sinusoids (jets.py).
        """
        length, ca, sa, ct, st = at
        m: Any = self.m
        x, y = ca * m - sa * self.n, sa * m + ca * self.n
        value, slope = length * (ct * x + st * y), length * (st * x - ct * y)
        alpha = slope - x * self.ay + y * self.ax
        theta = length * (st * self.ax - ct * self.ay) - slope
        aa = x * self.ax + y * self.ay - value
        tt = length * (ct * self.ax + st * self.ay) - value
        return alpha, theta, aa, value, tt, slope


class PoseDerivatives(NamedTuple, Generic[R]):
    """J and E with their gradients, of f/2 and g/2 in scaled lengths."""

    j: R
    j_alpha: R
    j_theta: R
    e: R
    e_alpha: R
    e_theta: R

    @classmethod
    def at(cls, f: LegPoints[Any], g: LegPoints[Any], at: At[Any]) -> PoseDerivatives[Any]:
        """At a pose, by the product rule."""
        slopes = f.slopes(at), g.slopes(at)
        (fa, ft, faa, fat, ftt, faat), (ga, gt, gaa, gat, gtt, gaat) = slopes
        j, ja, jt = _singularity(*slopes)
        p, q = faa * gat - fat * gaa, fat * gtt - ftt * gat
        jaa = p + p + fa * gaat - faat * ga - j
        jat = faat * gt + faa * gtt - fa * gaat + faat * ga - ftt * gaa - ft * gaat
        jtt = q + q - faat * gt + ft * gaat - j
        ea = faa * jt + fa * jat - fat * ja - ft * jaa
        et = fat * jt + fa * jtt - ftt * ja - ft * jat
        return cls(j, ja, jt, fa * jt - ft * ja, ea, et)


def singularity_and_coalescence(f: LegPoints[Any], g: LegPoints[Any], at: At[Any]) -> tuple[Any, Any]:
    """J and E at a pose."""
    slopes = f.slopes(at), g.slopes(at)
    j, ja, jt = _singularity(*slopes)
    return j, slopes[0][0] * jt - slopes[0][1] * ja


def _singularity(f: Slopes, g: Slopes) -> tuple[Any, Any, Any]:
    """J and its gradient."""
    fa, ft, faa, fat, ftt, _ = f
    ga, gt, gaa, gat, gtt, _ = g
    alpha = faa * gt + fa * gat - fat * ga - ft * gaa
    theta = fat * gt + fa * gtt - ftt * ga - ft * gat
    return fa * gt - ft * ga, alpha, theta
