"""Truncated Taylor series in a few variables, over any kind of balls: automatic differentiation on boxes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import product
from typing import Any, Generic, Protocol, TypeVar

Index = tuple[int, ...]
"""The exponents of a monomial."""


class Ball(Protocol):
    """A number of unknown value: an ``arb``, or an array of :class:`Balls`."""

    def __add__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __neg__(self) -> Any: ...


B = TypeVar("B", bound=Ball)


@cache
def monomials(variables: int, order: int) -> tuple[Index, ...]:
    """All exponents up to a total degree, by degree, so that those of a lower order come first."""
    every = product(range(order + 1), repeat=variables)
    return tuple(sorted((n for n in every if sum(n) <= order), key=lambda n: (sum(n), [-k for k in n])))


@cache
def _places(variables: int, order: int) -> dict[Index, int]:
    return {n: k for k, n in enumerate(monomials(variables, order))}


@cache
def _products(variables: int, order: int) -> tuple[tuple[tuple[int, int], ...], ...]:
    """For each monomial the pairs of places whose monomials have it as product."""
    place = _places(variables, order)

    def rest(n: Index, m: Index) -> Index:
        return tuple(a - b for a, b in zip(n, m, strict=True))

    return tuple(tuple((place[m], place[rest(n, m)]) for m in place if rest(n, m) in place) for n in place)


@cache
def _shifts(variables: int, order: int, variable: int) -> tuple[tuple[int, int], ...]:
    """For each monomial of one order less, the place of the one with a variable more, and its exponent."""
    place = _places(variables, order)
    raised = ((*n[:variable], n[variable] + 1, *n[variable + 1 :]) for n in monomials(variables, order - 1))
    return tuple((place[n], n[variable]) for n in raised)


class Jet(Generic[B]):
    """A function by its Taylor coefficients at a point, or by balls that hold them at each point of a box.

    Attributes:
        variables: how many there are.
        order: the greatest total degree of a term.
        terms: the coefficients, in the order of :func:`monomials`.
    """

    __slots__ = ("order", "terms", "variables")

    def __init__(self, variables: int, order: int, terms: Sequence[B]) -> None:
        self.variables, self.order, self.terms = variables, order, terms

    def __add__(self, other: Jet[B]) -> Jet[B]:
        order = min(self.order, other.order)
        return Jet(self.variables, order, [x + y for x, y in zip(self.terms, other.terms, strict=False)])

    def __sub__(self, other: Jet[B]) -> Jet[B]:
        order = min(self.order, other.order)
        return Jet(self.variables, order, [x - y for x, y in zip(self.terms, other.terms, strict=False)])

    def __neg__(self) -> Jet[B]:
        return Jet(self.variables, self.order, [-x for x in self.terms])

    def __mul__(self, other: Jet[B] | B) -> Jet[B]:
        """The product with a function, or with a number."""
        if not isinstance(other, Jet):
            return Jet(self.variables, self.order, [x * other for x in self.terms])
        order, p, q = min(self.order, other.order), self.terms, other.terms
        terms = []
        for (i, k), *pairs in _products(self.variables, order):
            total = p[i] * q[k]
            for a, b in pairs:
                total = total + p[a] * q[b]
            terms.append(total)
        return Jet(self.variables, order, terms)

    def d(self, variable: int) -> Jet[B]:
        """The partial derivative, of one order less."""
        shifts = _shifts(self.variables, self.order, variable)
        return Jet(
            self.variables,
            self.order - 1,
            [self.terms[k] if n == 1 else self.terms[k] * n for k, n in shifts],
        )

    @property
    def value(self) -> B:
        """The value."""
        return self.terms[0]

    @property
    def gradient(self) -> Sequence[B]:
        """The first derivatives, in the order of the variables."""
        return self.terms[1 : self.variables + 1]
