"""Poses and the arcs between them: a pose isolated by balls, arcs of a motion, and the exact route of a path.

A regular pose of a joint vector is given by exact legs and a box that holds this pose alone. An arc gives α,
θ and the fixed length as polynomials of one parameter τ, which runs from 0 to 1. It is a Bézier curve over
its control points, so an arc of two points is straight. Along it the squared lengths and J are power series
in τ, by the rules for sines and sums.

A path between two poses is sought in these ways, one after another; whatever finds it, :mod:`proofs` proves
it.

1. ``cells`` and, where the fixed leg may vary, ``joint_paths``: the exact aspects say whether there is a
   path, and give the way, which lines between few of its corners make short. If that is not proved, the lines
   of the way are proved one by one, and then with more decimals.
2. With limits that this path exceeds (``within_limits``): boxes of the slice, which find a path or prove that
   there is none; where they are undecided, and before boxes of a range, a grid in floats. Ends on a limit, or
   just inside it, are left by a short line first.
3. For a clearance (``corridors``): the widest way on the grid (``pose_grid``), beside the path that is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias, TypeVar

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.boxes.newton import Step, alone_near, narrowed, newton_image
from rpr_solver.boxes.systems import Box
from rpr_solver.errors import Unproved
from rpr_solver.exact import precisions
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Gradient, cross, gradient_by_vector
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.slice_map import Leg, SliceMap

T = TypeVar("T")

_FIRST_BITS = 192
"""The precision at which digits of a pose are first sought, unless fewer are wanted."""
_TURN_BITS = 256
"""The precision of angles that are written with more turns, at least; and spare bits of given angles."""

Angles = tuple[arb, arb]
"""α and θ in radians."""
Image = tuple[arb, arb]
"""Half the squared lengths of the free legs, scaled."""
Legs = tuple[Fraction, Fraction, Fraction]
"""The fixed leg and the two others, exact, scaled."""
EndLegs: TypeAlias = tuple[Fraction, Fraction | None, Fraction | None]
"""The same, scaled; None for a free leg whose length is not exact."""
NO_LEGS: EndLegs = (Fraction(0), None, None)
Turns = tuple[int, int]
"""Whole turns of α and of θ."""


def by_leg(fixed_leg: int, lengths: Sequence[T]) -> tuple[T, T, T]:
    """L1, L2 and L3, from the fixed leg's length and those of the free legs.

    >>> by_leg(2, ("fixed", "first", "second"))
    ('first', 'fixed', 'second')
    """
    legs = dict(zip((fixed_leg, *free_legs(fixed_leg)), lengths, strict=True))
    return legs[1], legs[2], legs[3]


def local_map(slice_map: SliceMap, length: arb, angles: Angles, order: int) -> LocalMap[arb]:
    """The slice's map and its derivatives at angles in radians; ``length`` is scaled."""
    (sin_a, cos_a), (sin_t, cos_t) = (angle.sin_cos() for angle in angles)
    omega = omega_ball(slice_map.radicand, ctx.prec)
    return LocalMap.at(slice_map, Pose(cos_a, sin_a, cos_t, sin_t, length, omega), order)


@dataclass(frozen=True)
class IsolatedPose:
    """A pose with J ≠ 0, given by its legs and a box in (α, θ) that contains no other pose of these legs.

    ``angles`` are the box.
    """

    slice_map: SliceMap
    legs: Legs
    angles: Angles

    @classmethod
    def near(cls, slice_map: SliceMap, legs: Legs, start: Angles) -> IsolatedPose | None:
        """The pose to which Newton's method leads; None without a proof (mathematics.md#isolated-poses)."""
        found = alone_near(_step_of(slice_map, legs), start)
        return None if found is None else cls(slice_map, legs, (found.room[0], found.room[1]))

    @property
    def lengths(self) -> Legs:
        """L1, L2 and L3, in the user's unit."""
        return by_leg(self.slice_map.fixed_leg, [length / self.slice_map.scale for length in self.legs])

    def refined(self, bits: int) -> Angles:
        """The angles as balls with about ``bits`` correct bits.

        Raises:
            Unproved: the accuracy cannot be reached within the precision limit.
        """
        box: Box = self.angles
        for work in precisions(min(_FIRST_BITS, bits + 64), GREATEST_BITS, stop_at=bits + 64):
            with ctx.workprec(work):
                box = narrowed(_step_of(self.slice_map, self.legs), box, bits)
            if all(x.rad() < arb(2) ** -bits for x in box):
                return box[0], box[1]
        raise Unproved("the digits of a pose could not be refined")

    def turned(self, turns: Turns) -> IsolatedPose:
        """The same pose, its angles written with so many more turns."""
        with ctx.workprec(max(ctx.prec, _TURN_BITS)):
            alpha, theta = (x + 2 * arb.pi() * n for x, n in zip(self.angles, turns, strict=True))
            return replace(self, angles=(alpha, theta))


@dataclass(frozen=True)
class GivenPose:
    """A pose given by exact angles and an exact length of the fixed leg, at which J ≠ 0.

    Attributes:
        slice_map: of the manipulator and its fixed leg.
        legs: the scaled length of the fixed leg; those of the others are not exact, and None.
        degrees: α and θ.
    """

    slice_map: SliceMap
    legs: tuple[Fraction, None, None]
    degrees: tuple[Fraction, Fraction]

    @property
    def angles(self) -> Angles:
        """α and θ in radians, at the working precision."""
        degree = arb.pi() / 180
        return ball_of(self.degrees[0]) * degree, ball_of(self.degrees[1]) * degree

    def refined(self, bits: int) -> Angles:
        """The angles as balls with about ``bits`` correct bits."""
        with ctx.workprec(bits + _TURN_BITS):
            return self.angles

    def turned(self, turns: Turns) -> GivenPose:
        """The same pose, its angles written with so many more turns."""
        alpha, theta = (x + 360 * n for x, n in zip(self.degrees, turns, strict=True))
        return replace(self, degrees=(alpha, theta))


EndPose: TypeAlias = IsolatedPose | GivenPose
"""A pose at an end of a path."""


def newton_step(slice_map: SliceMap, length: arb, image: Image) -> Step:
    """The interval Newton step in (α, θ) for the poses with this fixed length and this image."""

    def step(point: Box, box: Box) -> Box | None:
        values = local_map(slice_map, length, (point[0], point[1]), 0).squared_lengths()
        wide = local_map(slice_map, length, (box[0], box[1]), 1)
        gaps = [value / 2 - goal for goal, value in zip(image, values, strict=True)]
        return newton_image(point, gaps, [[leg.alpha.value, leg.theta.value] for leg in (wide.f, wide.g)])

    return step


def _step_of(slice_map: SliceMap, legs: Legs) -> Step:
    return newton_step(slice_map, *_goal(legs))


def _goal(legs: Legs) -> tuple[arb, Image]:
    fixed, first, second = (ball_of(leg) for leg in legs)
    return fixed, (first * first / 2, second * second / 2)


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

    def leg(one: Leg) -> tuple[arb_series, Gradient]:
        """Half the squared length, f_α and φ."""
        m, a = one.points(omega)
        x, y = turned = cos_a * m.real - sin_a * m.imag, sin_a * m.real + cos_a * m.imag
        vector = length * cos_t + (x - a.real), length * sin_t + (y - a.imag)
        square = vector[0] * vector[0] + vector[1] * vector[1]
        return square * arb(0.5), gradient_by_vector(vector, turned, (cos_t, sin_t))

    (f, f_slopes), (g, g_slopes) = leg(slice_map.f), leg(slice_map.g)
    return Expansion(f, g, cross(f_slopes, g_slopes))


def bounded(near: arb_series, wide: arb_series, radius: arb) -> arb:
    """All values at a distance of at most ``radius`` from a point: the series there to its slope, and the
    coefficient of order 2 over the whole ball."""
    bend = wide[2] * arb(radius * radius / 2, (radius * radius / 2).abs_upper())
    return near[0] + near[1] * arb(0, radius.abs_upper()) + bend


_SPARE_BITS = 64
"""The working precision of arcs beyond the bits that are wanted."""


@dataclass(frozen=True)
class DecimalPose:
    """A pose in exact decimals: a control point of a Bézier arc, or one near which something is so.

    Attributes:
        alpha_deg: α in degrees, not confined to (−180, 180].
        theta_deg: the fixed leg's angle in degrees, not confined either.
        length: of the fixed leg, in the user's unit.

    >>> DecimalPose(Fraction(25, 2), Fraction(190), Fraction(27)).to_json(1)
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

    def turned(self, turns: Turns) -> DecimalPose:
        """The same place, its angles written with so many more turns."""
        return DecimalPose(self.alpha_deg + 360 * turns[0], self.theta_deg + 360 * turns[1], self.length)

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

    start: EndPose
    stop: EndPose
    arcs: tuple[tuple[DecimalPose | None, ...], ...]

    @property
    def slice_map(self) -> SliceMap:
        """The manipulator with its fixed leg."""
        return self.start.slice_map

    def reversed(self) -> Route:
        """The same path, run backwards."""
        return Route(self.stop, self.start, tuple(arc[::-1] for arc in self.arcs[::-1]))

    def turned(self, turns: Turns) -> Route:
        """The same path, all its angles written with so many more turns."""
        arcs = tuple(tuple(p and p.turned(turns) for p in arc) for arc in self.arcs)
        return Route(self.start.turned(turns), self.stop.turned(turns), arcs)

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
