"""The cusps of a slice within joint limits, counted independently."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import atan2, degrees

from rpr_solver.verify.core.boxes import Box, Equations, direction, zero_near
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.manipulator import Geometry
from rpr_solver.verify.core.roots import Root, real_roots, refined
from rpr_solver.verify.core.surds import Indivisible
from rpr_solver.verify.core.system import System, at_half_tangent
from rpr_solver.verify.counts import count_of
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.points import Points

_BITS, _LINE_BITS, _START_BITS = 80, 96, 40
Bounds = tuple[Fraction | None, Fraction | None]


@dataclass(frozen=True)
class Limits:
    """Open joint limits of the free legs, in the user's unit; None is no limit."""

    of_legs: Mapping[int, Bounds]

    @property
    def bounded(self) -> bool:
        """Whether there is any limit."""
        return any(bound is not None for bounds in self.of_legs.values() for bound in bounds)

    def admit(self, lengths: Mapping[int, Interval]) -> bool | None:
        """Whether lengths are strictly within the limits; None if intervals do not decide it."""
        sides = [side for leg, bounds in self.of_legs.items() for side in _sides(lengths[leg], bounds)]
        if False in sides:
            return False
        return None if None in sides else True

    def counted(self, geometry: Geometry, fixed: int, length: Fraction) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, and whether it is proved; None if it is open.

        Where all roots of Q are simple, one cusp lies above each (mathematics.md#simple-roots), and a box of
        it gives its lengths.
        """
        system = System.of(geometry, fixed, length)
        if not self.bounded:
            return count_of(system)
        try:
            eliminant = Eliminant.of(system)
        except Indivisible:
            return None
        if not eliminant.generic:
            return None
        points, boxes = Points(system), _boxes(system, eliminant)
        if None in boxes:
            return None
        found = [box for box in boxes if box is not None]
        if any(x.meets(y) for n, x in enumerate(found) for y in found[:n]):
            return None
        sides = [self.admit({leg.number: points.length(leg, box) for leg in system.legs}) for box in found]
        return None if None in sides else (sides.count(True), True)


def _sides(x: Interval, bounds: Bounds) -> list[bool | None]:
    low, high = bounds
    sides: list[bool | None] = []
    if low is not None:
        sides.append((x - Interval.of(low, x.bits)).sign > 0 or _unless(x, low))
    if high is not None:
        sides.append((x - Interval.of(high, x.bits)).sign < 0 or _unless(x, high))
    return sides


def _unless(x: Interval, bound: Fraction) -> bool | None:
    """None if an interval may hold a bound, else False."""
    return None if x.contains(bound) else False


def _boxes(system: System, eliminant: Eliminant) -> list[Box | None]:
    """A box of the cusp above each simple real root; None where none is proved."""
    ring, boxes = system.ring, []
    equations = [Equations.of(system.singular, leg.kernel, ring.radicand) for leg in system.legs]
    for root in eliminant.single_roots:
        narrow = refined(ring, eliminant.single, root, Fraction(1, 1 << _LINE_BITS))
        line = direction(ring, eliminant.single, narrow, _LINE_BITS)
        theta = Fraction(degrees(atan2(float(line[1].middle), float(line[0].middle))))
        # floats are where Newton's method starts; a box is proved, and proved to be on the line
        found = (
            zero_near(pair, alpha, theta, _BITS) for alpha in _starts(system, narrow) for pair in equations
        )
        boxes.append(next((box for box in found if box is not None and _on(box, line)), None))
    return boxes


def _starts(system: System, root: Root) -> Iterator[Fraction]:
    """Angles α in degrees near which J is 0 on a line."""
    x = (root.lower + root.upper) / 2
    u = 1 / x if root.inverted and x else x
    form = at_half_tangent(system.singular, 2, 2, u)
    for t in real_roots(system.ring, form):
        near = refined(system.ring, form, t, Fraction(1, 1 << _START_BITS))
        y = float((near.lower + near.upper) / 2)
        yield Fraction(degrees(2 * (atan2(1, y) if near.inverted else atan2(y, 1))))


def _on(box: Box, line: tuple[Interval, Interval]) -> bool:
    return all(x.meets(y) for x, y in zip(box.directions.theta, line, strict=True))
