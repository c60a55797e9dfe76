"""Two polynomials about a point, as p and q plus small terms: what Krawczyk's test is made of.

``G = A (J, E) = (p, q) + N`` with a constant matrix A, in integers: coefficients are in units of 2^−bits, and
all bounds are sums of absolute values, rounded up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import comb
from operator import mul

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import spend

DEGREE = 6
"""The greatest exponent of p, of q and of r,"""
_SHEARED = 3 * DEGREE
"""and of r once p and q are counted from a line."""
Index = tuple[int, int, int]
"""The exponents of p, q and r."""
Sizes = dict[tuple[int, int], list[int]]
"""Bounds of coefficients, by the exponents of p and q, in the order of the exponents of r."""
Moved = tuple[list[Mapping[Index, int]], int]
"""Two forms, and what their coefficients may be off."""
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
    def sizes(self) -> list[Sizes]:
        """Bounds of the coefficients of N."""
        result = []
        for form, linear in zip(self.forms, (P, Q), strict=True):
            rows: Sizes = {}
            for (i, j, k), c in {**form, linear: form[linear] - (1 << self.bits)}.items():
                rows.setdefault((i, j), [0] * (_SHEARED + 1))[k] = abs(c) + self.error
            result.append(rows)
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

    def derivative(self, sizes: Sizes, powers: Sequence[Sequence[int]], order: Index) -> int:
        """A bound of a derivative of terms, of orders 0 to 2 in each of p, q and r."""
        total, (a, b, c), (x, y, z) = 0, order, powers
        last = list(map(mul, _FALLING[c][c:], z))
        for (i, j), row in sizes.items():
            if i >= a and j >= b:
                factor = _FALLING[a][i] * _FALLING[b][j] * x[i - a] * y[j - b]
                total += factor * sum(map(mul, row[c:], last))
        return (total >> (3 * self.bits)) + 1

    def about(self, point: Sequence[int], slopes: Sequence[int] = ()) -> Expansion | None:
        """The same about another point, p and q being counted from a line with these slopes, if any.

        None if the point is more than 1 from the origin in p, q or r, or a slope more than 1.
        """
        if max(map(abs, (*point, *slopes))) > 1 << self.bits:
            return None
        here = tuple(point)
        if here not in self._known:
            self._known[here] = self._moved((list(self.forms), self.error), here, sheared=False)
        forms, error = self._moved(self._known[here], slopes, sheared=True)
        return Expansion.of(forms[0], forms[1], (error, error), self.bits)

    @cached_property
    def _known(self) -> dict[tuple[int, ...], Moved]:
        """The forms about the points that were asked for."""
        return {}

    def _moved(self, start: Moved, steps: Sequence[int], *, sheared: bool) -> Moved:
        """The forms with p, q and r moved by these steps, or p and q along such slopes."""
        forms, error = start
        for axis, x in enumerate(steps):
            spend(5 * len(forms[0]), self.bits)
            powers = [1 << self.bits]
            for _ in range(DEGREE):
                powers.append(powers[-1] * x >> self.bits)
            greatest = max(max(map(abs, form.values())) for form in forms) + error
            forms = [self._shifted(form, axis, powers, sheared=sheared) for form in forms]
            # a sum of C(l, m) xˡ⁻ᵐ over l has at most 2⁶ · 7 in all; the powers are off by at most 6 units
            error = 448 * (error + 1) + (448 * 6 * greatest >> self.bits) + 1
        return forms, error

    def _shifted(
        self, form: Mapping[Index, int], axis: int, powers: Sequence[int], *, sheared: bool
    ) -> dict[Index, int]:
        """A form with x + w, or x + r w, in the place of the coordinate x; ``powers`` are those of w."""
        values = list(form.values())
        weights = [[comb(n, m) * powers[n - m] for m in range(n + 1)] for n in range(DEGREE + 1)]
        return {
            key: sum([values[place] * weights[n][m] for place, n, m in terms]) >> self.bits
            for key, terms in _terms(tuple(form), axis, sheared)
        }


@cache
def _terms(keys: tuple[Index, ...], axis: int, sheared: bool) -> list[tuple[Index, list[Index]]]:
    """Of what each coefficient of a shifted form is a sum: places of coefficients, and of weights."""
    result: dict[Index, list[Index]] = {} if sheared else {key: [] for key in keys}
    for place, key in enumerate(keys):
        n = key[axis]
        for m in range(n + 1):
            row = list(key)
            row[axis] = m
            row[2] += n - m if sheared else 0
            result.setdefault((row[0], row[1], row[2]), []).append((place, n, m))
    return list(result.items())
