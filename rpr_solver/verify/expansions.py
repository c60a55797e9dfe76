"""Two polynomials in p, q and r with linear parts near p and q, in integers; bounds of their derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import comb

from rpr_solver.verify.core.intervals import Interval

DEGREE = 6
"""The greatest exponent of p, of q and of r,"""
_SHEARED = 3 * DEGREE
"""and of r once p and q are counted from a line."""
Index = tuple[int, int, int]
"""The exponents of p, q and r."""
P, Q = (1, 0, 0), (0, 1, 0)

_FALLING = ([1] * (_SHEARED + 1), list(range(_SHEARED + 1)), [k * (k - 1) for k in range(_SHEARED + 1)])
"""What differentiating 0, 1 and 2 times multiplies a power by."""


@dataclass(frozen=True)
class Expansion:
    """G = (p, q) + N, in units of 2^−bits; each coefficient is off by at most ``error`` units."""

    forms: tuple[Mapping[Index, int], Mapping[Index, int]]
    error: int
    bits: int

    @classmethod
    def of(
        cls, first: Mapping[Index, int], second: Mapping[Index, int], errors: tuple[int, int], bits: int
    ) -> Expansion | None:
        """A constant matrix times two polynomials of any unit; None if their linear parts are dependent."""
        (a, b), (c, d) = ((form[P], form[Q]) for form in (first, second))
        determinant = a * d - b * c
        if not determinant:
            return None
        rows = ((d, -b), (-c, a))
        one, two = (
            {key: ((m * first[key] + n * second[key]) << bits) // determinant for key in first}
            for m, n in rows
        )
        off = max(
            ((abs(m) * errors[0] + abs(n) * errors[1]) << bits) // abs(determinant) + 2 for m, n in rows
        )
        return cls((one, two), off, bits)

    @cached_property
    def sizes(self) -> list[list[tuple[Index, int]]]:
        """Bounds of the coefficients of N."""
        result = []
        for form, linear in zip(self.forms, (P, Q), strict=True):
            shifted = {**form, linear: form[linear] - (1 << self.bits)}
            result.append([(key, abs(c) + self.error) for key, c in shifted.items()])
        return result

    def coefficient(self, n: int, key: Index) -> Interval:
        """A coefficient of one of the polynomials."""
        c = self.forms[n].get(key, 0)
        return Interval(c - self.error, c + self.error, self.bits)

    def powers(self, *bounds: int) -> list[list[int]]:
        """Powers of bounds of p, q and r, rounded up."""
        result = []
        for x in bounds:
            row = [1 << self.bits]
            for _ in range(_SHEARED):
                row.append((row[-1] * x >> self.bits) + 1)
            result.append(row)
        return result

    def derivative(
        self, sizes: Sequence[tuple[Index, int]], powers: Sequence[Sequence[int]], order: Index
    ) -> int:
        """A bound of a derivative of terms, of orders 0 to 2 in each of p, q and r."""
        total, (a, b, c), (x, y, z) = 0, order, powers
        for (i, j, k), size in sizes:
            if i >= a and j >= b and k >= c:
                factor = _FALLING[a][i] * _FALLING[b][j] * _FALLING[c][k]
                total += factor * size * x[i - a] * y[j - b] * z[k - c]
        return (total >> (3 * self.bits)) + 1

    def about(self, point: Sequence[int], slopes: Sequence[int] = ()) -> Expansion | None:
        """The same about another point, p and q being counted from a line with these slopes, if any.

        None if the point is more than 1 from the origin in p, q or r, or a slope more than 1.
        """
        if max(map(abs, (*point, *slopes))) > 1 << self.bits:
            return None
        forms, error = list(self.forms), self.error
        steps = [(axis, x, False) for axis, x in enumerate(point)]
        for axis, x, sheared in (*steps, *((axis, x, True) for axis, x in enumerate(slopes))):
            powers = [1 << self.bits]
            for _ in range(DEGREE):
                powers.append(powers[-1] * x >> self.bits)
            greatest = max(max(map(abs, form.values())) for form in forms) + error
            forms = [self._shifted(form, axis, powers, sheared=sheared) for form in forms]
            # a sum of C(l, m) xˡ⁻ᵐ over l has at most 2⁶ · 7 in all; the powers are off by at most 6 units
            error = 448 * (error + 1) + (448 * 6 * greatest >> self.bits) + 1
        return Expansion.of(forms[0], forms[1], (error, error), self.bits)

    def _shifted(
        self, form: Mapping[Index, int], axis: int, powers: Sequence[int], *, sheared: bool
    ) -> dict[Index, int]:
        """A form with x + w, or x + r w, in the place of the coordinate x; ``powers`` are those of w."""
        result: dict[Index, int] = {} if sheared else dict.fromkeys(form, 0)
        for key, c in form.items():
            n = key[axis]
            for m in range(n + 1):
                row = list(key)
                row[axis] = m
                row[2] += n - m if sheared else 0
                place = row[0], row[1], row[2]
                result[place] = result.get(place, 0) + comb(n, m) * c * powers[n - m]
        return {key: c >> self.bits for key, c in result.items()}
