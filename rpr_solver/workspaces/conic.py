"""What kind of curve the singular conic is at an orientation, exact, and its lines where it has some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from rpr_solver.workspaces.curves import Line
from rpr_solver.workspaces.tower import Number, Tower


class ConicKind(StrEnum):
    """What J = 0 is at one orientation.

    >>> ConicKind("two lines")
    <ConicKind.CROSSING: 'two lines'>
    """

    ELLIPSE = "ellipse"
    CIRCLE = "circle"
    HYPERBOLA = "hyperbola"
    PARABOLA = "parabola"
    CROSSING = "two lines"
    PARALLEL = "parallel lines"
    DOUBLE = "double line"
    """J has one sign on both sides of the line."""
    LINE = "line"
    POINT = "point"
    PLANE = "plane"
    """J vanishes at every place: all poses of this orientation are singular."""


@dataclass(frozen=True)
class SingularConic:
    """J = 0 at one orientation.

    Attributes:
        kind: what it is.
        coefficients: of x², x y, y², x, y and 1 in J, exact.
        tower: the field of its lines.
        lines: the lines of which it consists, if it does.
    """

    kind: ConicKind
    coefficients: tuple[Number, ...]
    tower: Tower
    lines: tuple[Line, ...] = ()

    @classmethod
    def of(cls, coefficients: Sequence[Number]) -> SingularConic:
        """That of a polynomial."""
        a, b, c, d, e, f = own = tuple(coefficients)
        tower = max((x.tower for x in own), key=lambda x: len(x.squares))
        quadratic_is_zero = a.is_zero and b.is_zero and c.is_zero
        if quadratic_is_zero:
            if d.is_zero and e.is_zero:
                return cls(ConicKind.PLANE, own, tower)
            return cls(ConicKind.LINE, own, tower, (Line((d, e), f),))
        bend = b * b - a * c * 4
        sign = bend.sign
        # 4 times the determinant of the symmetric matrix, of which these are the minors
        flat = (a * c * f * 4 + b * d * e - a * e * e - c * d * d - b * b * f).is_zero
        if not flat:
            if sign:
                is_circle = sign < 0 and b.is_zero and (a - c).is_zero
                ellipse = ConicKind.CIRCLE if is_circle else ConicKind.ELLIPSE
                return cls(ConicKind.HYPERBOLA if sign > 0 else ellipse, own, tower)
            return cls(ConicKind.PARABOLA, own, tower)
        if sign < 0:
            return cls(ConicKind.POINT, own, tower)
        return cls._of_lines(own, bend, sign)

    @classmethod
    def _of_lines(cls, own: tuple[Number, ...], bend: Number, sign: int) -> SingularConic:
        a, b, c, d, e, f = own
        is_level = a.is_zero
        if not sign:
            # w² + 2 k w + 4 l = 0 with w = 2 a x + b y, or with w = 2 c y
            normal, k, rest = ((a * 0, c * 2), e, c * f) if is_level else ((a * 2, b), d, a * f)
            square = k * k - rest * 4
            if square.is_zero:
                return cls(ConicKind.DOUBLE, own, bend.tower, (Line(normal, k),))
            tower, root = square.tower.with_root(square)
            lines = Line(normal, k + root), Line(normal, k - root)
            return cls(ConicKind.PARALLEL, own, tower, lines)
        tower, root = bend.tower.with_root(bend)
        # the node, times the square, and two directions
        x, y = c * d * 2 - b * e, a * e * 2 - b * d
        steep = [(root - b, a * 2), (-root - b, a * 2)]
        directions = [(a * 0 + 1, a * 0), (-c, b)] if is_level else steep
        both = [Line((v * bend, -u * bend), u * y - v * x) for u, v in directions]
        return cls(ConicKind.CROSSING, own, tower, tuple(both))
