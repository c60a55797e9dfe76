"""The proof that no joint vector is met by two folds: by boxes of singular poses, and pairs of boxes.

Boxes that cover the singular poses of a slice, or of a range of the fixed leg, are halved until every pair is
proved to have no two poses of one joint vector. That fails near cusps, where folds cross, and near
degenerate poses; the pairs that are left say where (mathematics.md#folds-apart).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import cos, isqrt, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.turns import RADIANS, TURN
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.fold_boxes import Boxes, FoldBoxes, Slab
from rpr_solver.modes.joined_regions import OpenSpan
from rpr_solver.paths.pose_boxes import LegsInBalls

if TYPE_CHECKING:
    from rpr_solver.modes.fold_boxes import Integers

_PARTS = 32
_SMALLEST = 1 << 7
"""Half widths at which boxes are given up, in units of a turn over 2³¹."""
_MOST_PAIRS = 60_000
MOST_TESTS = 3_000_000
"""Pairs of boxes that are examined in all."""
_CROSSINGS, _DIRECTIONS = 3, 8
_SHARES = (1e-2, 1e-3, 1e-4)


@dataclass(frozen=True)
class OpenPairs:
    """Pairs of boxes that may hold folds of one joint vector.

    Attributes:
        boxes: the boxes.
        slab: the lengths of the fixed leg, in units of ``unit``, a number of scaled lengths.
        first, second: the numbers of the boxes of each pair.
    """

    boxes: Boxes
    slab: Slab
    unit: Fraction
    first: Integers
    second: Integers

    @property
    def size_deg(self) -> float:
        """The width of the widest box."""
        wide = max(self.boxes.wide_alpha.max(), self.boxes.wide_theta.max())
        return float(360 * 2 * wide / TURN)

    @property
    def length(self) -> Fraction:
        """A scaled length in the slab."""
        return Fraction(self.slab.length) * self.unit

    def place(self, pair: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """α and θ in radians in the middles of the boxes of a pair."""
        one, other = (
            (float(self.boxes.alpha[k]) * 2 * np.pi / TURN, float(self.boxes.theta[k]) * 2 * np.pi / TURN)
            for k in (self.first[pair], self.second[pair])
        )
        return one, other

    def joint_vectors(self, floats: FloatSlice) -> Iterator[tuple[str, str]]:
        """The free legs of joint vectors on all sides of crossings of folds: decimals in the user's unit."""
        for pair in _spread(len(self.first), _CROSSINGS):
            ends = [floats.joints(*place) for place in self.place(pair)]
            first, second = ((x + y) / 2 / floats.unit for x, y in zip(*ends, strict=True))
            for share in _SHARES:
                for k in range(_DIRECTIONS):
                    turn = 2 * pi * k / _DIRECTIONS
                    moved = first * (1 + share * cos(turn)), second * (1 + share * sin(turn))
                    yield f"{moved[0]:.12g}", f"{moved[1]:.12g}"


@dataclass(frozen=True)
class FoldProof:
    """What the boxes show.

    Attributes:
        tests: the number of pairs that were examined.
        left: what was not decided; nothing, if no joint vector is met by two folds, and there is no cusp.
    """

    tests: int
    left: tuple[OpenPairs, ...]


def folds_apart(
    slice_map: SliceMap,
    span: tuple[Fraction, Fraction | None],
    bounds: Mapping[int, Bounds],
    *,
    most_tests: int = MOST_TESTS,
    around: tuple[Fraction, LegsInBalls] | None = None,
) -> FoldProof:
    """Looks for the proof, for all scaled lengths of the fixed leg in a closed range, within joint limits.

    A range without an end goes to the unit of the boxes, and from there by inverse lengths, where limits are
    left out of account. It stops at what cannot be decided first, near which there is a cusp or a crossing
    as a rule.

    ``around``: a unit of scaled lengths, and all manipulators for which it is to be proved, not the given one
    alone; ``span`` has an end then.
    """
    low, high = span
    model = FoldBoxes.of(slice_map, bounds, high or low, around)
    todo = [_Batch(model.slab(low, high or model.unit), Boxes.all(_PARTS), None)]
    if high is None:
        todo.append(_Batch(model.beyond(), Boxes.all(_PARTS), None))
    tests = 0
    while todo:
        batch = todo.pop()
        examined, left = _examined(model, batch)
        tests += examined
        if left is None:
            continue
        wide = np.median(np.maximum(left.boxes.wide_alpha, left.boxes.wide_theta))
        if wide < _SMALLEST or len(left.first) > _MOST_PAIRS or tests > most_tests:
            return FoldProof(tests, (left,))
        slabs: tuple[Slab, ...] = (left.slab,)
        if left.slab.half > max(wide * RADIANS * left.slab.scale, 2.0**-48):
            slabs = left.slab.halves()
        boxes, pairs = left.boxes.cut(), _cut_pairs(left)
        todo += (_Batch(slab, boxes, pairs) for slab in slabs)
    return FoldProof(tests, ())


@dataclass(frozen=True)
class _Batch:
    """Boxes of a slab, and the pairs of them that are to be examined; None are all."""

    slab: Slab
    boxes: Boxes
    pairs: tuple[Integers, Integers] | None


def _examined(model: FoldBoxes, batch: _Batch) -> tuple[int, OpenPairs | None]:
    """The number of pairs that were examined, and those that are left."""
    boxes, keep = model.contracted(batch.boxes, batch.slab)
    if batch.pairs is None:
        boxes = boxes[keep]
        first, second = np.triu_indices(len(boxes))
    else:
        first, second = batch.pairs
        both = keep[first] & keep[second]
        first, second = first[both], second[both]
    tests = len(first)
    if tests:
        left = ~model.apart(boxes, batch.slab, first, second)
        first, second = first[left], second[left]
        left = ~model.regular(*boxes.between(first, second), batch.slab)
        first, second = first[left], second[left]
    if not len(first):
        return tests, None
    used, numbers = np.unique(np.concatenate([first, second]), return_inverse=True)
    first, second = numbers[: len(first)], numbers[len(first) :]
    return tests, OpenPairs(boxes[used], batch.slab, model.unit, first, second)


def _cut_pairs(left: OpenPairs) -> tuple[Integers, Integers]:
    """The pairs of halves of boxes, by their numbers in :meth:`Boxes.cut`."""
    count = len(left.boxes)
    parts = []
    for one in (0, count):
        for other in (0, count):
            # of a pair of a box with itself, both orders of the halves are one
            new = (left.first != left.second) | (one <= other)
            parts.append(((left.first + one)[new], (left.second + other)[new]))
    first, second = (np.concatenate(side) for side in zip(*parts, strict=True))
    return first, second


def reached(slice_map: SliceMap, span: OpenSpan, bounds: Mapping[int, Bounds]) -> OpenSpan:
    """The lengths at which some pose may be within limits: a leg is not shorter than the fixed one less what
    the vectors of platform and base add."""
    low, high = span
    if high is not None:
        return low, high
    free = zip(free_legs(slice_map.fixed_leg), vector_sizes(slice_map), strict=True)
    most = [bound + size for leg, size in free if (bound := bounds.get(leg, (None, None))[1]) is not None]
    return low, max(low, min(most)) if most else None


def vector_sizes(slice_map: SliceMap) -> list[Fraction]:
    """For each free leg the lengths of its vectors on platform and base together, or a little more."""
    legs = slice_map.f, slice_map.g
    return [Fraction(isqrt(leg.platform2) + isqrt(leg.base2) + 2) / slice_map.scale for leg in legs]


def _spread(count: int, most: int) -> list[int]:
    """Some numbers below a count, far apart."""
    return sorted({k * (count - 1) // max(most - 1, 1) for k in range(most)})
