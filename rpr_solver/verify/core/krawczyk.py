"""Krawczyk's test: the proof that a box holds exactly one zero of as many equations as unknowns.

If K(X) = x₀ − Y F(x₀) + (1 − Y F′(X)) (X − x₀) lies in the interior of X, then X holds exactly one zero of
F, it is in K(X), and F′ is invertible there (Krawczyk 1969, Moore 1977).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.work import spend

_STEPS = 12
Matrix = list[list[Interval]]


class Problem(Protocol):
    """Equations, by their values and derivatives in a box."""

    def values(self, box: Sequence[Interval]) -> list[Interval]:
        """The values of the equations."""

    def jacobian(self, box: Sequence[Interval]) -> Matrix:
        """A row of derivatives for each equation."""


def proved_zero(problem: Problem, start: Sequence[Interval], bits: int) -> list[Interval] | None:
    """The zero near ``start``, in a box of some 2^−``bits``; None if none is proved at this precision."""
    work = start[0].bits
    x = [(interval.lower + interval.upper) // 2 for interval in start]
    aim = 1 << (work - bits)
    for _ in range(_STEPS):
        points = [Interval(v, v, work) for v in x]
        inverse = _inverse(problem.jacobian(points))
        if inverse is None:
            return None
        steps = [_middle(step) for step in _times(inverse, problem.values(points))]
        size = max(abs(step) for step in steps)
        if size > 1 << (work - 3):
            return None
        x = [value - step for value, step in zip(x, steps, strict=True)]
        if size < aim:
            radius = 4 * size + (aim >> 2)
            return contracted(problem, [Interval(v - radius, v + radius, work) for v in x])
    return None


def contracted(problem: Problem, wide: Sequence[Interval]) -> list[Interval] | None:
    """K(X) of a given box X if it lies in its interior, so that X holds exactly one zero; else None."""
    work = wide[0].bits
    points = [Interval(_middle(x), _middle(x), work) for x in wide]
    inverse = _inverse(problem.jacobian(points))
    if inverse is None:
        return None
    slopes, shifts = problem.jacobian(wide), _times(inverse, problem.values(points))
    around, result = [x - point for x, point in zip(wide, points, strict=True)], []
    spend(len(wide) ** 3, work)
    for i, row in enumerate(inverse):
        image = points[i] - shifts[i]
        for k in range(len(wide)):
            [product] = _times([row], [slope[k] for slope in slopes])
            image += (Interval.of(int(i == k), work) - product) * around[k]
        if not wide[i].lower < image.lower <= image.upper < wide[i].upper:
            return None
        result.append(image)
    return result


def _times(matrix: Matrix, vector: Sequence[Interval]) -> list[Interval]:
    result = []
    for row in matrix:
        total = Interval(0, 0, row[0].bits)
        for x, y in zip(row, vector, strict=True):
            total += x * y
        result.append(total)
    return result


def _middle(x: Interval) -> int:
    return (x.lower + x.upper) // 2


def _inverse(matrix: Matrix) -> Matrix | None:
    """The inverse of the midpoints, rounded; None if they are dependent."""
    size, work = len(matrix), matrix[0][0].bits
    spend(20 * size**3, 2 * work)
    rows = [
        [x.middle for x in row] + [Fraction(int(i == k)) for k in range(size)] for i, row in enumerate(matrix)
    ]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        if rows[pivot][k] == 0:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [_short(x / rows[k][k], work) for x in rows[k]]
        for i in range(size):
            if i != k and rows[i][k]:
                factor = rows[i][k]
                rows[i] = [_short(x - factor * y, work) for x, y in zip(rows[i], rows[k], strict=True)]
    points = [[int(x * (1 << work)) for x in row[size:]] for row in rows]
    return [[Interval(v, v, work) for v in row] for row in points]


def _short(x: Fraction, work: int) -> Fraction:
    """A number of few bits nearby: an approximate inverse is all that is needed."""
    return Fraction(int(x * (1 << (2 * work))), 1 << (2 * work))
