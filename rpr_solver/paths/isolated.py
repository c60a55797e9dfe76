"""A regular pose of a joint vector, isolated by balls: exact legs, and a box that holds this pose alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from flint import arb, arb_mat, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.precision import GREATEST_BITS, precisions
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.slice_map import SliceMap

T = TypeVar("T")

_STEPS = 12
_FIRST_BITS = 192

Angles = tuple[arb, arb]
"""α and θ in radians."""
Image = tuple[arb, arb]
"""Half the squared lengths of the free legs, scaled."""
Legs = tuple[Fraction, Fraction, Fraction]
"""The fixed leg and the two others, exact, scaled."""


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
        goal, angles = _goal(legs), start
        for _ in range(_STEPS):
            step = newton_step(slice_map, *goal, (angles[0].mid(), angles[1].mid()))
            if step is None:
                return None
            angles, size = (step[0].mid(), step[1].mid()), _distance(step, angles)
            if size < arb(2) ** -(ctx.prec // 3):
                break
        last = newton_step(slice_map, *goal, angles)
        if last is None:
            return None
        radius = (2 * _distance(last, angles)).max(arb(2) ** -(ctx.prec - 32)).abs_upper()
        box = arb(angles[0], radius), arb(angles[1], radius)
        inner = newton_step(slice_map, *goal, box)
        proved = inner is not None and all(
            abs(y - x.mid()) < x.rad() for x, y in zip(box, inner, strict=True)
        )
        return cls(slice_map, legs, box) if proved else None

    def refined(self, bits: int) -> Angles:
        """The angles as balls with about ``bits`` correct bits.

        Raises:
            Unproved: the accuracy cannot be reached within the precision limit.
        """
        angles = self.angles
        goal = arb(2) ** -bits
        for work in precisions(min(_FIRST_BITS, bits + 64), GREATEST_BITS, stop_at=bits + 64):
            with ctx.workprec(work):
                for _ in range(_STEPS):
                    if all(x.rad() < goal for x in angles):
                        return angles
                    inner = newton_step(self.slice_map, *_goal(self.legs), angles)
                    if inner is None:
                        break
                    new = angles[0].intersection(inner[0]), angles[1].intersection(inner[1])
                    stuck = all(2 * y.rad() > x.rad() for x, y in zip(angles, new, strict=True))
                    angles = new
                    if stuck:
                        break
        raise Unproved("the digits of a pose could not be refined")


def newton_step(slice_map: SliceMap, length: arb, image: Image, box: Angles) -> Angles | None:
    """One interval Newton step: it contains every pose of the box with this fixed length and this image."""
    middle = box[0].mid(), box[1].mid()
    values = local_map(slice_map, length, middle, 0).squared_lengths()
    wide = local_map(slice_map, length, box, 1)
    jacobian = arb_mat([[leg.alpha.value, leg.theta.value] for leg in (wide.f, wide.g)])
    missing = arb_mat([[goal - value / 2] for goal, value in zip(image, values, strict=True)])
    try:
        move = jacobian.solve(missing)
    except ZeroDivisionError:
        return None
    new = middle[0] + move[0, 0], middle[1] + move[1, 0]
    return new if all(x.is_finite() for x in new) else None


def _goal(legs: Legs) -> tuple[arb, Image]:
    fixed, first, second = (ball_of(leg) for leg in legs)
    return fixed, (first * first / 2, second * second / 2)


def _distance(x: Angles, y: Angles) -> arb:
    return abs(x[0] - y[0]).max(abs(x[1] - y[1]))
