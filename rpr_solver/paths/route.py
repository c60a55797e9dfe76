"""The exact description of a path: the poses at its ends, and the control points between them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, ctx

from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.arcs import Arc, Point
from rpr_solver.paths.isolated import IsolatedPose

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
