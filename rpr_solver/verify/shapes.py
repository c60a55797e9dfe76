"""Similar and doubly flat triangles: no slice has a cusp, and what is degenerate in all of them.

Let L e be the fixed leg, and let the other legs go from a and b on the base to m and n on the platform, as
seen from this leg. If m = κ a and n = κ b, or if both triangles are flat, no slice has a cusp
(mathematics.md#special-shapes). All numbers are rational: κ is the quotient of two sides on one line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits
from rpr_solver.verify.kinds import Unclear
from rpr_solver.verify.landmarks import Event, Landmark

_APART_BITS = 512
Side = tuple[int, int]
"""x + i y, scaled."""


@dataclass(frozen=True)
class Throughout:
    """Poses that all slices between two lengths have, or a curve; None is the end of the range."""

    kind: str
    count: int | None = None
    equation: str | None = None
    low: Landmark | None = None
    high: Landmark | None = None


class Shape:
    """Similar or doubly flat triangles: no slice has a cusp.

    Args:
        surface: the equations.
        a, b: the sides of the base.
        ratio: κ; 0 if the triangles are not similar.
    """

    def __init__(self, surface: Surface, a: Side, b: Side, ratio: Fraction) -> None:
        self.surface, self.a, self.b, self.ratio = surface, a, b, ratio
        self.area = a[0] * b[1] - a[1] * b[0]

    def events(self, bits: int) -> list[Event]:
        """All at which the number of cusps changes, and those beside which cusps are."""
        del bits
        return []

    def crossings(self, leg: int, limit: Fraction, bits: int) -> list[Landmark]:
        """The lengths at which a cusp is at a limit of a free leg, the first or the second."""
        del leg, limit, bits
        return []

    def counted(self, length: Fraction, limits: Limits) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, as it is proved; None if it is not told."""
        del length, limits
        return 0, True

    def throughout(self, start: Fraction, stop: Fraction | None, bits: int) -> list[Throughout]:
        """What is degenerate in all slices of a range but those of single lengths.

        Raises:
            Unclear: intervals do not tell.
        """
        found = []
        if self.ratio in (1, -1):
            found.append(Throughout("curve", equation=f"alpha = {0 if self.ratio > 0 else 180} deg"))
        if not self.area:
            shared = 2 * len(found)
            found += [Throughout("higher", shared)] if shared else []
            return [*found, Throughout("quadruple", 4 - shared)]
        sides = (self.a, self.b, (self.a[0] - self.b[0], self.a[1] - self.b[1]))
        first, second, third = (x * x + y * y for x, y in sides)
        # (2 R (κ ± 1))², R being the radius of the circle through the corners of the base
        circle = Fraction(first * second * third, self.area**2)
        squares = sorted(circle * (self.ratio + sign) ** 2 for sign in (1, -1))
        bits = _APART_BITS + 2 * bits
        ends = [Landmark(Interval.of(square, bits).root(), square) for square in squares if square]
        return [*found, *self._runs([*range(2 * len(ends), -1, -2)], ends, start, stop)]

    def _runs(
        self, counts: Sequence[int], ends: Sequence[Landmark], start: Fraction, stop: Fraction | None
    ) -> list[Throughout]:
        """Nodes, their numbers between the ends, in a range."""
        found: list[Throughout] = []
        after = [None if self._side(end, start) <= 0 else end for end in ends]
        for count, low, high in zip(counts, (None, *after), (*ends, None), strict=True):
            if high is not None and self._side(high, start) <= 0:
                continue
            if low is not None and stop is not None and self._side(low, stop) >= 0:
                break
            inside = high is None or stop is None or self._side(high, stop) < 0
            if found and found[-1].count == count:
                low = found.pop().low
            found.append(Throughout("node", count, None, low, high if inside else None))
        return [part for part in found if part.count]

    def _side(self, end: Landmark, length: Fraction) -> int:
        """Whether a length is less or greater than another one, which is in the user's unit."""
        scaled = length * self.surface.unit
        if isinstance(end.square, Fraction):
            return (end.square > scaled**2) - (end.square < scaled**2)
        return told((end.scaled - Interval.of(scaled, end.scaled.bits)).sign)


def told(sign: int) -> int:
    """A sign that is not 0.

    Raises:
        Unclear: it is.
    """
    if not sign:
        raise Unclear
    return sign
