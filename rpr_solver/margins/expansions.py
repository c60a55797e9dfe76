"""Functions on boxes, in doubles: expansions to second order at the middles, with bounds of what is left out.

On a box of middles x₀ and half widths w let x = x₀ + w t, |t| ≤ 1. A function is c₀ + Σ cₖ tₖ + Σ cⱼₖ tⱼ tₖ +
Σ dᵢ ηᵢ, up to ``rest`` (mathematics.md#functions-on-boxes). The symbols ηᵢ, |ηᵢ| ≤ 1, are functions of x, the
same ones in all expansions: they stand for what the points of the platform are beside their own expansions.
Many boxes are done at once: arrays have a row for each coefficient and a column for each box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Flags = NDArray[np.bool_]
    Places = NDArray[np.int64]

ANGLES = 2
"""The first variables."""
BY_ANGLES, BY_OTHERS = 1, 2
"""Flags of what a function depends on: on the angles, on the other variables and the symbols."""
UNIT = 2.0**-53
UP = 1 + 2.0**-30
"""Bounds the roundings within a sum of nonnegative numbers, with a wide margin."""
SYMBOLS = 2
_ROUNDED = 16 * UNIT
"""Bounds the rounding errors of an operation, as a share of the sum of the absolute values of its terms."""
_UNDERFLOW = 2.0**-900


@dataclass(frozen=True)
class Layout:
    """Where the coefficients of an expansion are: of 1, of each tₖ, of the ηᵢ, of tⱼ tₖ for j ≤ k, by rows.

    Attributes:
        variables: the number of the tₖ.
    """

    variables: int

    @cached_property
    def slopes(self) -> slice:
        """Rows of the tₖ."""
        return slice(1, 1 + self.variables)

    @cached_property
    def symbols(self) -> slice:
        """Rows of the ηᵢ."""
        return slice(1 + self.variables, 1 + self.variables + SYMBOLS)

    @cached_property
    def bends(self) -> slice:
        """Rows of the tⱼ tₖ."""
        return slice(1 + self.variables + SYMBOLS, None)

    @cached_property
    def pairs(self) -> tuple[Places, Places]:
        """j and k of each row of the tⱼ tₖ."""
        j, k = np.triu_indices(self.variables)
        return j, k

    @cached_property
    def squares(self) -> Places:
        """The places of the tₖ² among the tⱼ tₖ."""
        j, k = self.pairs
        return np.flatnonzero(j == k)

    @cached_property
    def rows(self) -> int:
        """The number of coefficients."""
        return int(self.bends.start + len(self.pairs[0]))

    @cached_property
    def _places(self) -> Places:
        """The place of each tⱼ tₖ among them: a symmetric table."""
        table = np.empty((self.variables, self.variables), dtype=np.int64)
        j, k = self.pairs
        table[j, k] = table[k, j] = np.arange(len(j))
        return table

    @cached_property
    def _partners(self) -> Places:
        """The places of the tⱼ tₖ with each k, tₖ² twice."""
        return np.array([np.insert(row, k, row[k]) for k, row in enumerate(self._places)])

    @cached_property
    def others(self) -> tuple[Places, Places]:
        """The places of the tⱼ tₖ with each k and j ≠ k, and these j."""
        count = np.arange(self.variables)
        others = np.array([np.delete(count, k) for k in count])
        return np.take_along_axis(self._places, others, 1), others

    def per_variable(self, bends: Doubles) -> Doubles:
        """For each k the sum of numbers for tⱼ tₖ, those of tₖ² twice."""
        sums: Doubles = np.add.reduce(bends.take(self._partners, 0), axis=1)
        return sums


layout_of = lru_cache(maxsize=None)(Layout)


class Expansion:
    """A function on boxes.

    Attributes:
        terms: the coefficients.
        rest: bounds of the difference between the function and its expansion, all roundings included.
        layout: where the coefficients are.
        depends: flags of what the function may depend on; other coefficients are 0.
    """

    __slots__ = ("_bound", "_changes", "_parts", "_size", "depends", "layout", "rest", "terms")

    def __init__(
        self,
        terms: Doubles,
        rest: Doubles,
        layout: Layout,
        bound: Doubles | None = None,
        depends: int = BY_ANGLES | BY_OTHERS,
    ) -> None:
        self.terms, self.rest, self.layout, self.depends = terms, rest, layout, depends
        self._parts: Doubles | None = None
        self._bound = bound
        self._size: Doubles | None = None
        self._changes: tuple[Doubles, Doubles] | None = None

    @property
    def parts(self) -> Doubles:
        """Sums of the absolute values of the coefficients of 1, the t, the η and the products; the rest."""
        if self._parts is None:
            sizes, at = abs(self.terms), self.layout
            self._parts = np.empty((5, self.rest.size))
            self._parts[0], self._parts[4] = sizes[0], self.rest
            for row, rows in enumerate((at.slopes, at.symbols, at.bends), 1):
                np.add.reduce(sizes[rows], axis=0, out=self._parts[row])
        return self._parts

    def _sums(self) -> tuple[Doubles, Doubles]:
        """Of the parts of the t and the η, and of these and the products."""
        if self._changes is None:
            _, slopes, symbols, bends, _ = self.parts
            first = slopes + symbols
            self._changes = first, first + bends
        return self._changes

    @property
    def size(self) -> Doubles:
        """Bounds of the absolute values of the function."""
        if self._size is None:
            self._size = np.add.reduce(self.parts, axis=0) * UP
        return self._size

    @property
    def bound(self) -> Doubles:
        """As ``size``, but perhaps greater, if that was cheaper."""
        if self._bound is None:
            self._bound = self.size
        return self._bound

    @property
    def change(self) -> Doubles:
        """Bounds of how far the values are from those of the expansions at the middles."""
        change: Doubles = np.add.reduce(self.parts[1:], axis=0) * UP
        return change

    def of(self, boxes: Places) -> Expansion:
        """The function on some of the boxes."""
        return Expansion(
            self.terms.take(boxes, 1), self.rest[boxes], self.layout, self.bound[boxes], self.depends
        )

    @classmethod
    def joined(cls, parts: Sequence[Expansion]) -> Expansion:
        """A function on the boxes of several."""
        terms, rest = np.concatenate([x.terms for x in parts], 1), np.concatenate([x.rest for x in parts])
        return cls(terms, rest, parts[0].layout)

    def __add__(self, other: Expansion) -> Expansion:
        return self._sum(other, self.terms + other.terms)

    def __sub__(self, other: Expansion) -> Expansion:
        return self._sum(other, self.terms - other.terms)

    def _sum(self, other: Expansion, terms: Doubles) -> Expansion:
        bound = (self.bound + other.bound) * UP
        rest = (self.rest + other.rest + _ROUNDED * bound) * UP
        return Expansion(terms, rest, self.layout, bound, self.depends | other.depends)

    def __neg__(self) -> Expansion:
        negative = Expansion(-self.terms, self.rest, self.layout, self._bound, self.depends)
        negative._parts, negative._size = self._parts, self._size
        return negative

    def __mul__(self, other: Expansion | int) -> Expansion:
        if isinstance(other, int):  # at most 3
            rest = (self.rest + _ROUNDED * self.bound) * other * UP
            whole = self.terms * other
            return self if other == 1 else Expansion(whole, rest, self.layout, depends=self.depends)
        (_, a1, a_symbols, a2, _), (_, _, b_symbols, b2, _) = self.parts, other.parts
        (a_first, _), (b_first, b_changes) = self._sums(), other._sums()
        rest = a_symbols * b_first + a1 * b_symbols
        rest += a_first * b2 + a2 * b_changes
        bound = self.size * other.size * UP
        rest += self.rest * other.size + other.rest * self.size + _ROUNDED * bound
        terms, depends = self._product(other), self.depends | other.depends
        return Expansion(terms, rest * UP + _UNDERFLOW, self.layout, bound, depends)

    def _product(self, other: Expansion) -> Doubles:
        """The coefficients of a product."""
        a, b, at = self.terms, other.terms, self.layout
        if not self.depends or not other.depends:
            scaled: Doubles = a[0] * b if other.depends else b[0] * a
            return scaled
        if not self.depends & other.depends:
            return self._product_apart(other) if self.depends == BY_ANGLES else other._product_apart(self)
        terms: Doubles = a[0] * b
        terms += b[0] * a
        terms[0] *= 0.5  # it holds the product twice
        x, y = a[at.slopes], b[at.slopes]
        first, second = at.pairs
        products, others = x.take(first, 0) * y.take(second, 0), y.take(first, 0) * x.take(second, 0)
        others[at.squares] = 0
        terms[at.bends] += products + others
        return terms

    def _product_apart(self, other: Expansion) -> Doubles:
        """As above, of a function of the angles and one of the other variables."""
        a, b, at = self.terms, other.terms, self.layout
        terms: Doubles = a[0] * b
        angles, others = slice(1, 1 + ANGLES), slice(1 + ANGLES, 1 + at.variables)
        terms[angles] = a[angles] * b[0]
        bends, own = terms[at.bends], a[at.bends]
        # α times each variable, then θ times each but α
        theta, end = at.variables, 2 * at.variables - 1
        for k in (0, 1, theta):
            bends[k] = own[k] * b[0]
        bends[ANGLES:theta], bends[theta + 1 : end] = a[1] * b[others], a[2] * b[others]
        return terms

    def __truediv__(self, other: Expansion | int) -> Expansion:
        if isinstance(other, int):  # 2
            return Expansion(self.terms / other, self.rest / other, self.layout, depends=self.depends)
        x, least = other._positive()
        left_out = other.change**3 / (least * x * x * x)
        return self * other._composed((1 / x, -1 / (x * x), 1 / (x * x * x)), left_out)

    def sqrt(self) -> Expansion:
        """The square root of a positive function; NaN on boxes that are too wide."""
        x, least = self._positive()
        root = x**0.5
        ratio = (least / x) ** 0.5
        left_out = root * (1 - ratio + _ROUNDED) ** 3 * (3 + ratio) / 8
        return self._composed((root, 0.5 / root, -0.125 / (x * root)), left_out)

    def _positive(self) -> tuple[Doubles, Doubles]:
        """The values at the middles and lower bounds of all values, NaN where these are not positive."""
        x = self.terms[0]
        least = (x - self.change) * (2 - UP)
        least[~(least > 0)] = nan
        return x, least

    def _composed(self, factors: tuple[Doubles, Doubles, Doubles], left_out: Doubles) -> Expansion:
        """A function of this one: its Taylor polynomial of degree 2, and a bound of the remainder."""
        value, slope, bend = factors
        terms = self.terms.copy()
        terms[0] = 0
        change = Expansion(terms, self.rest, self.layout, depends=self.depends)
        square = change * change
        terms = slope * terms + bend * square.terms
        terms[0] = value
        rest = abs(slope) * self.rest + abs(bend) * square.rest + left_out
        rest += _ROUNDED * (abs(value) + abs(slope) * change.size + abs(bend) * square.size)
        return Expansion(terms, rest * UP + _UNDERFLOW, self.layout, depends=self.depends)

    def named(self, symbol: int) -> Expansion:
        """The same with a symbol for what the expansion leaves out."""
        terms = self.terms.copy()
        terms[self.layout.symbols.start + symbol] += self.rest * UP
        return Expansion(terms, np.zeros_like(self.rest), self.layout, depends=self.depends | BY_OTHERS)


def where(boxes: Flags, one: Expansion, other: Expansion) -> Expansion:
    """One function on the given boxes, another on the others."""
    rest, bound = (np.where(boxes, getattr(one, of), getattr(other, of)) for of in ("rest", "bound"))
    depends = one.depends | other.depends
    return Expansion(np.where(boxes, one.terms, other.terms), rest, one.layout, bound, depends)


def combined(functions: list[Expansion], factors: Doubles) -> Expansion:
    """Σ factorᵢ functionᵢ, with a factor for each box."""
    terms: Any = sum(factor * function.terms for factor, function in zip(factors, functions, strict=True))
    rest: Any = sum(
        abs(factor) * (function.rest + _ROUNDED * function.size)
        for factor, function in zip(factors, functions, strict=True)
    )
    return Expansion(terms, rest * UP + _UNDERFLOW, functions[0].layout)


def lowest(function: Expansion) -> Doubles:
    """Lower bounds of the absolute values, negative or NaN if it may vanish (mathematics.md#expansions).

    In a variable in which the polynomial is monotonic its minimum is at an end.
    """
    sign = np.where(function.terms[0] < 0, -1.0, 1.0)
    terms, at = function.terms * sign, function.layout
    slopes, bends = terms[at.slopes], terms[at.bends]
    influence = at.per_variable(abs(bends))
    is_monotonic = abs(slopes) >= influence * UP
    ends = np.where(is_monotonic, -np.sign(slopes), 0.0)
    j, k = at.pairs
    mixed = j != k
    least: Doubles = terms[0] + (slopes * ends).sum(axis=0) + (bends * ends[j] * ends[k]).sum(axis=0)
    own = bends[~mixed]
    places, partners = at.others
    moved = bends.take(places, 0) * ends.take(partners, 0)
    left = np.add.reduce(np.concatenate([slopes[:, None], moved], axis=1), axis=1)
    left = np.where(is_monotonic, 0, abs(left))
    inside = (own > 0) & (left < 2 * own)
    own_least = np.where(inside, -left * left / (4 * np.where(inside, own, 1)), own - left)
    least += np.where(is_monotonic, 0, own_least).sum(axis=0)
    free = ~is_monotonic
    least -= (abs(bends[mixed]) * (free[j[mixed]] & free[k[mixed]])).sum(axis=0)
    least -= function.parts[2] + function.rest
    return least - 2.0**-44 * function.size
