"""Aspects of slices: the sign of J on cells that cover all poses, joined where they touch.

On each cell J has a proved sign, or the cell is undecided. Cells of one sign that touch belong to one aspect;
poses in cells that are not joined by cells which may have the sign are in different aspects. If ∇J ≠ 0 on all
undecided cells, each aspect has a cell of its sign. While the fixed leg varies, aspects are those of the
slices at both ends, joined where J has the sign in both (mathematics.md#aspects-on-cells).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from flint import arb

from rpr_solver.boxes.sieve import Boxes, Expansion
from rpr_solver.verify.claims import Open
from rpr_solver.verify.components import components
from rpr_solver.verify.equations import Slice
from rpr_solver.verify.systems import singular
from rpr_solver.verify.work import Work

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Integers = NDArray[np.int64]
    Truths = NDArray[np.bool_]

SIGNS = (1, -1)
_FIRST, _DEEPEST = 5, 24
"""The torus is cut in 2^5 by 2^5 cells at first; the smallest are those of 2^24 by 2^24."""
_START = np.array([[0.1234], [0.0567]])
"""The lower ends of the first cell, at no special angle, in radians."""
_STEP = 2 * pi * (1 + 2.0**-48) / 2**_DEEPEST
"""The width of the smallest cells, together a little more than a turn."""
_SIDES = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
_CELLS_OF_A_BOX = 8
"""So many cells take about the time of a box in balls."""


@dataclass(frozen=True)
class Cells:
    """Cells that cover the torus, and the sign of J on each.

    Attributes:
        slices: one slice, or those at both ends of a range.
        level: each cell is one of 2^level by 2^level.
        place: its place among these, of shape (2, cells).
        signs: of J, 0 where it is undecided; of shape (slices, cells).
        smooth: where ∇J ≠ 0; of this shape, too.
    """

    slices: Sequence[Slice]
    level: Integers
    place: Integers
    signs: Integers
    smooth: Truths

    @classmethod
    def of(cls, slices: Sequence[Slice], level: Integers, place: Integers) -> Cells:
        """Cells with their signs."""
        shift = _DEEPEST - level
        # the same end of two cells is the same number
        low, high = (_START + _STEP * ((place + k) << shift) for k in (0, 1))
        found = [Expansion.of(partial(singular, own), Boxes(low, high)) for own in slices]
        signs = [np.where(x.excluded, np.sign(x.values.mid[0]), 0).astype(np.int64) for x in found]
        smooth = [x.slopes[0].excludes_zero.any(0) for x in found]
        return cls(slices, level, place, np.array(signs), np.array(smooth))

    @classmethod
    def coarse(cls, slices: Sequence[Slice]) -> Cells:
        """The first ones."""
        place = np.indices((1 << _FIRST, 1 << _FIRST)).reshape(2, -1)
        return cls.of(slices, np.full(place.shape[1], _FIRST), place)

    def cut(self, which: Truths, work: Work) -> Cells:
        """The same with some cells cut in four.

        Raises:
            Open: there is no work left, or a cell is too small.
        """
        if (self.level[which] == _DEEPEST).any():
            raise Open("parts of aspects are too near to each other to be told apart, as at nodes")
        work.spend(len(self.slices) * int(which.sum()) // _CELLS_OF_A_BOX)
        corners = [2 * self.place[:, which] + np.array([[i], [k]]) for i in (0, 1) for k in (0, 1)]
        new = Cells.of(self.slices, np.tile(self.level[which] + 1, 4), np.hstack(corners))
        names = ("level", "place", "signs", "smooth")
        parts = ([getattr(self, name)[..., ~which], getattr(new, name)] for name in names)
        return Cells(self.slices, *map(np.hstack, parts))

    def holding(self, pose: Sequence[arb]) -> int:
        """The number of the cell with a pose.

        Raises:
            Open: the pose may be in two.
        """
        turn, numbers = 2 * arb.pi(), []
        for x, start in zip(pose, _START[:, 0].tolist(), strict=True):
            off = x - turn * ((x - start) / turn).mid().floor() - start
            place = (off / arb(_STEP)).floor().unique_fmpz()
            number = -1 if place is None else int(place)
            ends = [arb(float(start + _STEP * (number + k))) - start for k in (0, 1)]
            if not (off > ends[0] and off < ends[1]):
                raise Open("a pose is on the border of two cells")
            numbers.append(number)
        shift = _DEEPEST - self.level
        [found] = np.flatnonzero((self.place == np.array(numbers)[:, None] >> shift).all(0))
        return int(found)

    @cached_property
    def touching(self) -> Integers:
        """Pairs of cells that touch, at corners too; of shape (2, pairs)."""
        keys = _keys(self.level, self.place)
        order = np.argsort(keys)
        known, pairs = keys[order], []
        for step in _SIDES:
            beside = (self.place + np.array(step)[:, None]) % (1 << self.level)
            # a neighbour is as large, or larger; those that are smaller find this cell
            todo = np.arange(len(self.level))
            for up in range(int(self.level.max()) - _FIRST + 1):
                todo = todo[self.level[todo] - up >= _FIRST]
                sought = _keys(self.level[todo] - up, beside[:, todo] >> up)
                at = np.minimum(np.searchsorted(known, sought), len(known) - 1)
                is_there = known[at] == sought
                pairs.append(np.array([todo[is_there], order[at[is_there]]]))
                todo = todo[~is_there]
        return np.hstack(pairs)


def _keys(level: Integers, place: Integers) -> Integers:
    """A number for each cell."""
    keys: Integers = (level << 50) | (place[0] << 25) | place[1]
    return keys


class Parts:
    """The cells of one sign, and those that may have it, in parts. A node is a cell in one of the slices.

    Attributes:
        sure: the part of each node that has the sign, joined by nodes that have it; −1 for other nodes.
        possible: that of each node that may have it, joined by nodes that may have it; −1 for other nodes.
    """

    def __init__(self, cells: Cells, sign: int) -> None:
        signs, count = cells.signs.ravel(), len(cells.level)
        within = [cells.touching + k * count for k in range(len(cells.slices))]
        across = [np.add.outer([k - count, k], np.arange(count)) for k in range(count, len(signs), count)]
        pairs = np.hstack([*within, *across])
        self._undecided, self._pairs = signs == 0, pairs[:, (signs[pairs] != -sign).all(0)]
        sure = pairs[:, (signs[pairs] == sign).all(0)]
        self.sure = np.where(signs == sign, components(len(signs), sure), -1)
        self.possible = np.where(signs != -sign, components(len(signs), self._pairs), -1)

    @property
    def number(self) -> int:
        """How many parts have the sign."""
        return len(np.unique(self.sure[self.sure >= 0]))

    def doubts(self, *nodes: int) -> Truths:
        """Undecided nodes between two parts that may be one, and those of some nodes.

        If nodes are given, only parts that may be joined with them count. Parts are extended to undecided
        nodes step by step; the nodes where two meet are to be cut. If there are none, each possible part
        holds one that is sure, or none.
        """
        source, target = np.hstack([self._pairs, self._pairs[::-1]])
        nearest = self.sure.copy()
        # ends since each step gives a part to at least one node more
        while (new := (nearest[source] >= 0) & (nearest[target] < 0)).any():
            nearest[target[new]] = nearest[source[new]]
        meet = nearest[source] != nearest[target]
        found = np.zeros(len(nearest), bool)
        found[source[meet]] = True
        if nodes:
            found &= np.isin(self.possible, self.possible[list(nodes)])
            found[list(nodes)] = True
        doubts: Truths = found & self._undecided
        return doubts


def number_of_aspects(slices: Sequence[Slice], work: Work) -> dict[int, int]:
    """How many aspects of each sign there are: of one slice, or of a range between two.

    Raises:
        Open: it is not decided, as at nodes, or with the work that is left.
    """
    cells = Cells.coarse(slices)
    # ends since all cells are cut at most so deep
    while True:
        parts = {sign: Parts(cells, sign) for sign in SIGNS}
        doubts = parts[1].doubts() | parts[-1].doubts()
        cut = (doubts.reshape(cells.signs.shape) | ((cells.signs == 0) & ~cells.smooth)).any(0)
        if not cut.any():
            return {sign: parts[sign].number for sign in SIGNS}
        cells = cells.cut(cut, work)


Node = tuple[int, Sequence[arb]]
"""The number of a slice, and α and θ of a pose at which J has the sign in this slice."""


def are_joined(slices: Sequence[Slice], sign: int, first: Node, second: Node, work: Work) -> bool:
    """Whether two poses are in one aspect of one slice, or of a range between two.

    Raises:
        Open: it is not decided with the work that is left.
    """
    cells = Cells.coarse(slices)
    while True:
        parts = Parts(cells, sign)
        nodes = [layer * len(cells.level) + cells.holding(pose) for layer, pose in (first, second)]
        one, other = nodes
        if parts.possible[one] != parts.possible[other]:
            return False
        if parts.sure[one] == parts.sure[other] >= 0:
            return True
        doubts: Truths = np.any(parts.doubts(*nodes).reshape(cells.signs.shape), axis=0)
        cells = cells.cut(doubts, work)
