"""The resultant of two families of polynomials: Sylvester's determinant at integers, interpolated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import lcm

from rpr_solver.verify.core.surds import ONE, ZERO, Poly, Ring, Surd, trimmed
from rpr_solver.verify.core.work import spend

Family = Callable[[int], Sequence[Surd]]
"""The coefficients in t, of formal degree, at an integer value of the other variable."""


def resultant(ring: Ring, p: Sequence[Surd], q: Sequence[Surd]) -> Surd:
    """Sylvester's determinant for the formal degrees, which are the lengths less 1."""
    m, n = len(p) - 1, len(q) - 1
    rows = [[ZERO] * k + list(reversed(p)) + [ZERO] * (n - 1 - k) for k in range(n)]
    rows += [[ZERO] * k + list(reversed(q)) + [ZERO] * (m - 1 - k) for k in range(m)]
    return determinant(ring, rows)


def determinant(ring: Ring, rows: list[list[Surd]]) -> Surd:
    """A determinant by Bareiss' elimination, which stays within the ring."""
    size, sign, last = len(rows), 1, ONE
    rows = [list(row) for row in rows]
    for k in range(size - 1):
        pivot = next((i for i in range(k, size) if rows[i][k] != ZERO), None)
        if pivot is None:
            return ZERO
        if pivot != k:
            rows[k], rows[pivot], sign = rows[pivot], rows[k], -sign
        head = rows[k]
        spend(8 * (size - k) ** 2, max(map(int.bit_length, head[k])))
        for row in rows[k + 1 :]:
            lead = row[k]
            for j in range(k + 1, size):
                (a, b), (c, d) = ring.times(row[j], head[k]), ring.times(lead, head[j])
                row[j] = ring.over((a - c, b - d), last)
        last = head[k]
    a, b = rows[-1][-1]
    return sign * a, sign * b


def interpolated_resultant(ring: Ring, first: Family, second: Family, degree: int) -> Poly:
    """The resultant as a polynomial of at most this degree, with coefficients in ℤ[ω]."""
    half = degree // 2
    points = range(-half, degree - half + 1)
    values = [resultant(ring, first(u), second(u)) for u in points]
    parts = [interpolated(points, [value[i] for value in values]) for i in (0, 1)]
    return trimmed(list(zip(*parts, strict=True)))


def interpolated(points: Sequence[int], values: Sequence[int]) -> list[int]:
    """The integer coefficients of the polynomial with these values (Newton's divided differences)."""
    if not any(values):
        return [0] * len(points)
    slopes = [Fraction(value) for value in values]
    for k in range(1, len(points)):
        for i in range(len(points) - 1, k - 1, -1):
            slopes[i] = (slopes[i] - slopes[i - 1]) / (points[i] - points[i - k])
    spend(len(points) ** 2, max(map(int.bit_length, values)))
    common = lcm(*(s.denominator for s in slopes))
    result = [0] * len(points)
    for k in reversed(range(len(points))):
        top = int(slopes[k] * common)
        result = [below - points[k] * x for below, x in zip([0, *result], result, strict=False)]
        result[0] += top
    return [Fraction(x, common).numerator if x % common == 0 else _not_integral() for x in result]


def _not_integral() -> int:
    raise ArithmeticError("an interpolated polynomial has no integer coefficients")
