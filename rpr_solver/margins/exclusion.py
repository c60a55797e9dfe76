"""Proof that no cusp degenerates for any geometry of a box, or passes a joint limit (mathematics.md#margins).

Boxes of poses and geometries are cut until on each of them either there is no cusp, or none that degenerates:
no common zero of (K, E), or none of (K, E, S) and (K, K_α, K_θ).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.boxes.sieve import Boxes
from rpr_solver.contract import LENGTHS
from rpr_solver.margins.expansions import ANGLES, Expansion, combined, lowest, where
from rpr_solver.margins.options import MayGoOn
from rpr_solver.margins.problems import BoxRing, Problem
from rpr_solver.margins.zones import Zones

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.expansions import Doubles, Places
    from rpr_solver.margins.systems import Systems

    Flags = NDArray[np.bool_]

_PARTS = 32
_BATCH = 1024
_ROUNDS = 6
"""Of reweighting."""
_SMALL = 1e-6
"""Terms below it, relative to their sum, get no more weight."""
_FINEST_ANGLE = 4
_PLATFORM = 1 + LENGTHS.index("d1")
"""The place of the first side of the platform among a problem's spans."""
_WEIGHTS = 0.5, 1.0, 2.0, 3.0
"""What cutting removes of terms of the first and second order, of the symbols and of the rest; measured."""


@dataclass(frozen=True)
class Exclusion:
    """The result of :func:`exclude`.

    Attributes:
        proved: whether no cusp degenerates outside the known zones.
        boxes: the number of boxes that were examined.
        left: boxes on which it was not proved.
    """

    proved: bool
    boxes: int
    left: Boxes


def exclude(
    problem: Problem, most_boxes: int, may_go_on: MayGoOn = lambda: True, zones: Zones | None = None
) -> Exclusion:
    """Tries to prove that all geometries and lengths of a problem have the same number of cusps.

    Args:
        problem: the box.
        most_boxes: the number of boxes after which to give up.
        may_go_on: asked now and then; False to give up.
        zones: where degenerate cusps are known.
    """
    search, examined = _Search(problem, zones), 0
    waiting = [problem.grid(_PARTS)]
    left = [waiting[0][:0]]
    goes_on = zones is not None and zones.goes_on
    following = 0 if goes_on else -1  # breadth first leaves small boxes when the search is cut short
    with np.errstate(all="ignore"):
        while waiting:
            boxes = waiting.pop(following)
            while waiting and len(boxes) + len(waiting[following]) <= _BATCH:
                boxes = Boxes.joined([boxes, waiting.pop(following)])
            if len(boxes) > _BATCH:
                waiting.append(boxes[_BATCH:])
                boxes = boxes[:_BATCH]
            examined += len(boxes)
            kept, shares = search.undecided(boxes)
            boxes = boxes[kept]
            if not len(boxes):
                continue
            fine, variables = _cuts(boxes, shares)
            if zones is not None:
                fine &= ~zones.small(boxes)
            left.append(boxes[~fine])
            if fine.any():
                waiting.append(boxes[fine].halved(variables[fine]))
            if not (goes_on or fine.all()) or examined > most_boxes or not may_go_on():
                return Exclusion(False, examined, Boxes.joined([*left, *waiting]))
    whole = Boxes.joined(left)
    return Exclusion(not len(whole), examined, whole)


def _cuts(boxes: Boxes, shares: Doubles) -> tuple[Flags, Places]:
    """Which boxes can be cut, and across which variable: of those that can, that of the greatest share."""
    wide: Flags = np.logical_and(boxes.low < boxes.middle, boxes.middle < boxes.high)
    wide[:ANGLES] = boxes.high[:ANGLES] - boxes.low[:ANGLES] >= _FINEST_ANGLE
    return np.any(wide, axis=0), np.where(wide, shares, -1).argmax(axis=0)


class _Search:
    """The tests of boxes of one problem."""

    def __init__(self, problem: Problem, zones: Zones | None) -> None:
        self._problem, self._zones = problem, zones
        self._moving = [0, 1, *(row for place, row in problem.rows.items() if place == 0)]
        self._sides = [row for place, row in problem.rows.items() if place >= _PLATFORM]

    def undecided(self, boxes: Boxes) -> tuple[Places, Doubles]:
        """The boxes on which nothing is proved, and how much each variable contributes to that."""
        ring = BoxRing(self._problem, boxes)
        systems = self._problem.systems(ring, 0)
        left = np.flatnonzero(~(lowest(systems.singularity.value) > 0))
        f, g = (sum(x.terms[0, left] ** 2 for x in systems.tangent(leg)) for leg in (0, 1))
        order = np.argsort(f < g, kind="stable")
        left, is_f = left[order], ~(f < g)[order]
        if left.size:
            systems, left, is_f, easy = self._first(systems, left, is_f)
        if not left.size:
            return left, boxes.low[:, left]
        known = None if self._zones is None else self._zones.known(boxes[left])
        return self._second(systems, ring, left, is_f, easy, known)

    def _first(self, whole: Systems, places: Places, is_f: Flags) -> tuple[Systems, Places, Flags, Trial]:
        """The boxes on which (K, E) may vanish, with v that of leg f or g, and what is known of them."""
        systems = whole.mapped(lambda x: x.of(places), 1)
        k = systems.singularity
        easy = self._trial([k.value, systems.along(partial(where, is_f), k).value])
        left = np.flatnonzero(~easy.proved)
        return systems.mapped(lambda x: x.of(left), 2), places[left], is_f[left], easy[left]

    def _second(
        self,
        systems: Systems,
        ring: BoxRing,
        places: Places,
        is_f: Flags,
        easy: Trial,
        known: Flags | None,
    ) -> tuple[Places, Doubles]:
        """As :meth:`undecided`, of the boxes that are left."""
        leg = partial(where, is_f)
        tests = self._problem.tests(systems, leg, lambda x: ring.constant(x).of(places))
        outside = np.zeros(places.shape, dtype=bool)
        for limit, (*_, excess) in zip(self._problem.limits, tests[2:], strict=True):
            outside |= limit.side * excess.terms[0] > excess.change
        joint = self._trial([Expansion.joined(part) for part in zip(*tests, strict=True)])
        values = joint.values.reshape(len(tests), -1)
        several = np.split(joint.shares, len(tests), axis=1)
        if known is not None:
            values[: len(known)][known] = np.inf
        proved = (values > 0).all(axis=0)
        proved &= np.any([abs(x.terms[0]) > x.change for x in systems.tangent(leg)], axis=0)
        shares = np.choose(values.argmin(axis=0), several)
        shares = np.where(easy.values > values.min(axis=0), easy.shares, shares)
        left = ~(proved | outside)
        unknown = np.isnan(shares).any(axis=0)
        shares[:, unknown] = self._widths(ring, places[unknown])
        return places[left], shares[:, left]

    def _trial(self, functions: list[Expansion]) -> Trial:
        return trial(functions, self._moving, self._sides)

    def _widths(self, ring: BoxRing, places: Places) -> Doubles:
        """Shares where the platform may be flat, so that nothing is known: those of the platform's sides."""
        shares = np.zeros((self._problem.size, places.size))
        shares[self._sides] = (ring.half[self._sides] / ring.middle[self._sides])[:, places]
        return shares


@dataclass(frozen=True)
class Trial:
    """An attempt to prove that functions have no common zero.

    Attributes:
        values: lower bounds of a combination of the functions that is 1 at the middle.
        shares: how much each variable contributes to what a combination loses.
    """

    values: Doubles
    shares: Doubles

    @property
    def proved(self) -> Flags:
        """The boxes without a common zero."""
        return self.values > 0

    def __getitem__(self, boxes: Places) -> Trial:
        return Trial(self.values[boxes], self.shares[:, boxes])


def trial(functions: list[Expansion], moving: Sequence[int], sides: Sequence[int]) -> Trial:
    """Tries to combine two or three functions to one that is not zero, on each of many boxes.

    Args:
        functions: the functions T.
        moving: the variables that change the zeros' places, whose first order counts in ``shares``.
        sides: those on which the points of the platform depend.
    """
    factors = multipliers(functions)
    whole = combined(functions, factors)
    least = lowest(whole)
    first, second, third, fourth = _WEIGHTS
    at = whole.layout
    shares = second * at.per_variable(abs(whole.terms[at.bends]))
    for factor, function in zip(factors, functions, strict=True):
        parts = abs(function.terms[at.slopes]) + at.per_variable(abs(function.terms[at.bends]))
        shares += fourth * abs(factor) * function.rest / parts.sum(axis=0) * parts
    if sides:
        shares[sides] += third * whole.parts[2] / len(sides)
    shares[moving] += first * abs(whole.terms[at.slopes][moving])
    return Trial(np.where(np.isnan(least), -np.inf, least), shares)


def multipliers(functions: Sequence[Expansion]) -> Doubles:
    """Good factors for two or three functions, by reweighted least squares; the combination's value is 1.

    They minimise the sum of the absolute values of the other coefficients and the rests, nearly.
    """
    scales = np.array([1 / function.size for function in functions])
    values = np.array([function.terms[0] for function in functions]) * scales
    others = np.array([function.terms[1:] for function in functions]) * scales[:, None]
    rests = np.array([function.rest for function in functions]) * scales
    best = np.full(values[0].shape, np.inf)
    chosen = np.full((len(functions), best.size), np.nan)
    weights, own = np.ones_like(others[0]), np.ones_like(rests)
    for _ in range(_ROUNDS):
        factors = np.array(_solved(_squares(others, rests, weights, own), values))
        factors /= (factors * values).sum(axis=0)
        terms = abs((factors[:, None] * others).sum(axis=0))
        parts = abs(factors) * rests
        total = terms.sum(axis=0) + parts.sum(axis=0)
        better = total < best
        best[better], chosen[:, better] = total[better], factors[:, better]
        small = _SMALL * total
        weights, own = 1 / (terms + small), 1 / (parts + small)
    unscaled: Doubles = chosen * scales
    return unscaled


def _squares(others: Doubles, rests: Doubles, weights: Doubles, own: Doubles) -> list[list[Doubles]]:
    """The lower triangle of the matrix of weighted least squares.

    Args:
        others: the functions' terms beside their values.
        rests: what these leave out.
        weights: of the other terms.
        own: of the rests.
    """
    weighted = weights * others
    matrix = [list((x * others[: k + 1]).sum(axis=1)) for k, x in enumerate(weighted)]
    for k, square in enumerate(own * rests**2):
        matrix[k][k] = matrix[k][k] + square
    return matrix


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
