"""The search of exclusion.py by slopes, beside zones in which degenerate cusps are known.

Slopes bound how functions change to first order, so that boxes are cut more often than for expansions of the
second order; in exchange boxes round a zero are cut evenly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rpr_solver.exact.turns import TURN
from rpr_solver.margins.problems import ANGLES, BoxRing, Problem
from rpr_solver.margins.slopes import UP, Slopes, moves

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.slopes import Doubles

    Flags = NDArray[np.bool_]
    Places = NDArray[np.int64]

ROUNDS = 6
"""Of reweighting."""
SMALL = 1e-6
"""Terms below it, relative to their sum, get no more weight."""


@dataclass(frozen=True)
class Zones:
    """Boxes of poses in which degenerate cusps are known, and how far other boxes are cut.

    Attributes:
        low, high: the ends of α, θ and the length, a column for each zone.
        tests: whose zeros are known there: 0 for (K, E, S), 1 for (K, K_α, K_θ).
        least: boxes with such sides of α, θ and the length are not cut.
        goes_on: whether the search goes on when such a box is left.
    """

    low: Doubles
    high: Doubles
    tests: Places
    least: tuple[float, float, float]
    goes_on: bool

    def known(self, low: Doubles, high: Doubles) -> Flags:
        """For each test whether boxes are within a zone of it."""
        pose, (lows, highs) = slice(ANGLES + 1), (self.low[:, :, None], self.high[:, :, None])
        turns = np.zeros_like(lows + low[pose, None])
        turns[:ANGLES] = np.floor((low[:ANGLES, None] - lows[:ANGLES]) / TURN) * TURN
        inside: Flags = np.all(
            [lows + turns <= low[pose, None], high[pose, None] <= highs + turns], axis=(0, 1)
        )
        return np.array([inside[self.tests == test].any(axis=0) for test in (0, 1)])

    def small(self, low: Doubles, high: Doubles) -> Flags:
        """The boxes that are not to be cut."""
        sides = high[: ANGLES + 1] - low[: ANGLES + 1]
        flags: Flags = np.all(sides <= np.array(self.least)[:, None], axis=0)
        return flags


class SlopeSearch:
    """The tests of boxes of one problem, by slopes."""

    def __init__(self, problem: Problem, zones: Zones) -> None:
        self._problem, self._zones = problem, zones
        self._moving = [0, 1, *(row for place, row in problem.rows.items() if place == 0)]

    def undecided(self, low: Doubles, high: Doubles) -> tuple[Places, Places]:
        """The boxes on which nothing is proved, and for each the variable along which to cut it."""
        ring = BoxRing(self._problem, low, high)
        systems = self._problem.systems(ring, 0)
        k = systems.singularity.value
        left = np.flatnonzero(~(abs(k.middle[0]) > _change(k, ring.half)))
        f, g = (sum(x.middle[0, left] ** 2 for x in systems.tangent(leg)) for leg in (0, 1))
        found = [self._of_leg(low, high, left[places], leg) for leg, places in ((0, ~(f < g)), (1, f < g))]
        kept, variables = zip(*found, strict=True)
        return np.concatenate(kept), np.concatenate(variables)

    def _of_leg(self, low: Doubles, high: Doubles, places: Places, leg: int) -> tuple[Places, Places]:
        """As :meth:`undecided`, of some boxes, with v that of one leg."""
        if not places.size:
            return places, places
        ring = BoxRing(self._problem, low[:, places], high[:, places])
        systems = self._problem.systems(ring, 1)
        k = systems.singularity
        first = [k.value, systems.along(leg, k).value]
        easy = multipliers(first, ring.half, self._moving)
        left = ~easy.proved
        places, easy = places[left], easy[left]
        if not places.size:
            return places, places
        ring = BoxRing(self._problem, low[:, places], high[:, places])
        systems = self._problem.systems(ring, 2)
        tests = self._problem.tests(systems, leg, ring.constant)
        outside = np.zeros(places.shape, dtype=bool)
        for limit, (*_, excess) in zip(self._problem.limits, tests[2:], strict=True):
            outside |= limit.side * excess.middle[0] > _change(excess, ring.half)
        results = [multipliers(test, ring.half, self._moving) for test in tests]
        values = np.array([result.values for result in results])
        known = self._zones.known(low[:, places], high[:, places])
        values[: len(known)][known] = 0
        proved = (values < 1).all(axis=0)
        proved &= moves(systems, leg)
        shares = np.choose(values.argmax(axis=0), [result.shares for result in results])
        shares = np.where(easy.values < values.max(axis=0), easy.shares, shares)
        left = ~(proved | outside)
        return places[left], shares.argmax(axis=0)[left]


def _change(function: Slopes, half: Doubles) -> Doubles:
    """Bounds of the changes of a function on boxes, errors included."""
    first, second, error = function.expanded(half)
    change: Doubles = (abs(first) + 0.5 * second).sum(axis=0) * UP + error
    return change


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
    values, changes = [term.value for term in terms], [term.change for term in terms]
    rests = [term.rest for term in terms]
    best = np.full(half.shape[1], np.inf)
    chosen = np.zeros((len(terms), half.shape[1]))
    weights, own = np.ones_like(half), [np.ones_like(best)] * len(terms)
    for _ in range(ROUNDS):
        factors = least_squares(values, changes, rests, weights, own)
        height = abs(_combined(factors, values))
        slopes = abs(_combined(factors, changes))
        parts = [abs(factor) * rest for factor, rest in zip(factors, rests, strict=True)]
        total = slopes.sum(axis=0) + sum(parts)
        value = total / height * UP
        better = value < best
        best[better] = value[better]
        for row, factor in zip(chosen, factors, strict=True):
            row[better] = (factor / height)[better]
        small = SMALL * total
        weights, own = 1 / (slopes + small), [1 / (part + small) for part in parts]
    shares = _combined([abs(factor) for factor in chosen], [term.second for term in terms])
    shares[moving] += abs(_combined(list(chosen), [change[moving] for change in changes]))
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


def least_squares(
    values: Sequence[Doubles],
    others: Sequence[Doubles],
    rests: Sequence[Doubles],
    weights: Doubles,
    own: Sequence[Doubles],
) -> list[Doubles]:
    """The multipliers that minimise the weighted squares, up to a common factor.

    Args:
        values: of the functions.
        others: their other terms.
        rests: what these leave out.
        weights: of the other terms.
        own: of the rests.
    """
    weighted = [weights * x for x in others]
    matrix = [[(x * y).sum(axis=0) for y in others[: k + 1]] for k, x in enumerate(weighted)]
    for k, (rest, weight) in enumerate(zip(rests, own, strict=True)):
        matrix[k][k] = matrix[k][k] + weight * rest**2
    return _solved(matrix, values)


def _solved(matrix: Sequence[Sequence[Doubles]], values: Sequence[Doubles]) -> list[Doubles]:
    """Solutions, up to a common factor, of symmetric systems in two or three unknowns for these values.

    A matrix is given by its lower triangle; it and the values have an entry for each box.
    """
    if len(values) == 2:
        ((a,), (b, c)), (x, y) = matrix, values
        return [c * x - b * y, a * y - b * x]
    ((a,), (b, d), (c, e, f)), (x, y, z) = matrix, values
    xy, xz, yz = c * e - b * f, b * e - c * d, b * c - a * e
    return [
        (d * f - e * e) * x + xy * y + xz * z,
        xy * x + (a * f - c * c) * y + yz * z,
        xz * x + yz * y + (a * d - b * b) * z,
    ]
