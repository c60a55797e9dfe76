"""What is sought: cusps, events, poses of a joint vector, as zeros of equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from rpr_solver.boxes import Balls, Box, Functions, Undecided
from rpr_solver.verify.equations import THETA, Anywhere, Jets, Poses, Space
from rpr_solver.verify.numbers import ball


def singular(space: Space, box: Anywhere, order: int) -> Sequence[Jets]:
    """J."""
    return [space.on(box, order).singular]


def along_kernel(space: Space, number: int, legs: Sequence[int], box: Anywhere, order: int) -> Sequence[Jets]:
    """J, and for each leg so many of its derivatives along the kernel: E, W."""
    poses = space.on(box, order + number)
    found = [poses.singular]
    for leg in legs:
        jet = poses.singular
        for _ in range(number):
            jet = poses.along(jet, leg)
            found.append(jet)
    return found


def regular_leg(space: Space, box: Box) -> int:
    """A free leg with (q, p) ≠ 0 on all of a box, whose kernel vector is therefore none of length 0.

    Raises:
        Undecided: neither is known to be one.
    """
    poses = space.on(box, 0)
    for leg in space.mechanism.free:
        if any(not x.value.contains(0) for x in poses.kernel(leg)):
            return leg
    raise Undecided


@dataclass(frozen=True)
class Coalescing:
    """Poses at which ``number`` + 2 poses or more coalesce: J and so many derivatives along the kernel are 0.

    In a slice one, E, is enough: cusps. In all lengths two, E and W: swallowtails.
    """

    space: Space
    number: int

    @property
    def stages(self) -> Sequence[Functions]:
        """Those of both legs, of which one may be stationary; for many, J alone comes first."""
        last = partial(along_kernel, self.space, self.number, self.space.mechanism.free)
        return (last,) if self.number == 1 else (partial(singular, self.space), last)

    def square(self, box: Box) -> Functions:
        """Those of a leg that is not stationary."""
        return partial(along_kernel, self.space, self.number, (regular_leg(self.space, box),))


@dataclass(frozen=True)
class Critical:
    """Poses with J = 0 and ∇J = 0, in all lengths: lips, beak-to-beaks."""

    space: Space

    @property
    def stages(self) -> Sequence[Functions]:
        """J, then its gradient."""
        return partial(singular, self.space), self._functions

    def square(self, _box: Box) -> Functions:
        """J and its gradient."""
        return self._functions

    def _functions(self, box: Anywhere, order: int) -> Sequence[Jets]:
        poses = self.space.on(box, order + 1)
        return poses.singular, poses.turned(poses.singular), poses.singular.d(THETA)


@dataclass(frozen=True)
class AtLimit:
    """Cusps of all lengths at which a free leg has a given length."""

    space: Space
    leg: int
    limit: Fraction

    @property
    def stages(self) -> Sequence[Functions]:
        """J, then all."""
        return partial(singular, self.space), partial(self._functions, self.space.mechanism.free)

    def square(self, box: Box) -> Functions:
        """With E of a leg that is not stationary."""
        return partial(self._functions, (regular_leg(self.space, box),))

    def _functions(self, legs: Sequence[int], box: Anywhere, order: int) -> Sequence[Jets]:
        return [*along_kernel(self.space, 1, legs, box, order), self.excess(self.space.on(box, order))]

    def excess(self, poses: Poses) -> Jets:
        """μ² times the squared length of the leg less that of the limit."""
        return less(poses, self.leg, self.limit**2)


@dataclass(frozen=True)
class JointVector:
    """Poses of a slice with given squared lengths of both free legs."""

    space: Space
    squares: Sequence[Fraction]

    @property
    def stages(self) -> Sequence[Functions]:
        """Both legs."""
        return (self._functions,)

    def square(self, _box: Box) -> Functions:
        """Both legs."""
        return self._functions

    def _functions(self, box: Anywhere, order: int) -> Sequence[Jets]:
        poses = self.space.on(box, order)
        pairs = zip(self.space.mechanism.free, self.squares, strict=True)
        return [less(poses, leg, square) for leg, square in pairs]


def less(poses: Poses, leg: int, square: Fraction) -> Jets:
    """μ² times the squared length of a leg less a number, in units."""
    _, mu = poses.space.ratio(poses.box, poses.order)
    scaled: Any = ball(square / Fraction(4) ** poses.space.mechanism.geometry.size)
    own = Balls.of([scaled]) if isinstance(poses.box[0], Balls) else scaled
    return poses.square(leg) - mu * mu * own
