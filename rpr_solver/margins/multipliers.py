"""Multipliers that prove that functions have no common zero on a box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rpr_solver.margins.slopes import UP, Slopes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.slopes import Doubles

    Flags = NDArray[np.bool_]

_ROUNDS = 6
_SMALL = 1e-6
"""Terms below it, relative to their sum, get no more weight."""


@dataclass(frozen=True)
class Multipliers:
    """Numbers l for each box, such that Σ lᵢ Tᵢ is far from 0.

    Attributes:
        values: the greatest change of Σ lᵢ Tᵢ over a box, divided by its absolute value at the middle.
        shares: how much each variable contributes to the change, and would less if its side were halved.
    """

    values: Doubles
    shares: Doubles

    @property
    def proved(self) -> Flags:
        """The boxes without a common zero."""
        return self.values < 1

    def __getitem__(self, boxes: Any) -> Multipliers:
        return Multipliers(self.values[boxes], self.shares[:, boxes])


def multipliers(functions: Sequence[Slopes], half: Doubles, moving: Sequence[int]) -> Multipliers:
    """Good multipliers for two or three functions, by reweighted least squares.

    Args:
        functions: the functions T.
        half: the half widths of the boxes.
        moving: the variables that change the zeros' places, whose first order counts in ``shares``.
    """

    terms = [_Terms.of(function, half) for function in functions]
    best = np.full(half.shape[1], np.inf)
    chosen = np.zeros((len(terms), half.shape[1]))
    weights, own = np.ones_like(half), [np.ones_like(best)] * len(terms)
    for _ in range(_ROUNDS):
        factors = _least_squares(terms, weights, own)
        height = abs(_combined(factors, [term.value for term in terms]))
        slopes = abs(_combined(factors, [term.change for term in terms]))
        parts = [abs(factor) * term.rest for factor, term in zip(factors, terms, strict=True)]
        total = slopes.sum(axis=0) + sum(parts)
        value = total / height * UP
        better = value < best
        best[better] = value[better]
        for row, factor in zip(chosen, factors, strict=True):
            row[better] = (factor / height)[better]
        small = _SMALL * total
        weights, own = 1 / (slopes + small), [1 / (part + small) for part in parts]
    shares = _combined([abs(factor) for factor in chosen], [term.second for term in terms])
    shares[moving] += abs(_combined(list(chosen), [term.change[moving] for term in terms]))
    return Multipliers(best, np.where(np.isnan(shares), np.inf, shares))


@dataclass(frozen=True)
class _Terms:
    """A function on boxes, divided by its size: value, first and second order of each variable, the rest."""

    value: Doubles
    change: Doubles
    second: Doubles
    rest: Doubles

    @classmethod
    def of(cls, function: Slopes, half: Doubles) -> _Terms:
        value, (change, second, error) = function.middle[0], function.expanded(half)
        rest = (0.5 * UP) * second.sum(axis=0) + error
        size = abs(value) + abs(change).sum(axis=0)
        scale = 1 / (size + rest)
        return cls(value * scale, change * scale, second * scale, rest * scale)


def _combined(factors: Sequence[Doubles], parts: Sequence[Doubles]) -> Doubles:
    total = factors[0] * parts[0]
    for factor, part in zip(factors[1:], parts[1:], strict=True):
        total += factor * part
    return total


def _least_squares(terms: Sequence[_Terms], weights: Doubles, own: Sequence[Doubles]) -> list[Doubles]:
    """The multipliers of least weighted squares, up to a common factor."""
    matrix = [
        [(weights * x.change * y.change).sum(axis=0) for y in terms[: k + 1]] for k, x in enumerate(terms)
    ]
    for k, (term, weight) in enumerate(zip(terms, own, strict=True)):
        matrix[k][k] = matrix[k][k] + weight * term.rest**2
    if len(terms) == 2:
        ((a,), (b, c)), (x, y) = matrix, (term.value for term in terms)
        return [c * x - b * y, a * y - b * x]
    ((a,), (b, d), (c, e, f)), (x, y, z) = matrix, (term.value for term in terms)
    xy, xz, yz = c * e - b * f, b * e - c * d, b * c - a * e
    return [
        (d * f - e * e) * x + xy * y + xz * z,
        xy * x + (a * f - c * c) * y + yz * z,
        xz * x + yz * y + (a * d - b * b) * z,
    ]
