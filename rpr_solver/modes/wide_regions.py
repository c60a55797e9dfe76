"""The proof that no path with a clearance changes the assembly mode in a slice, or in a range.

Cells of the torus of poses are dropped if a singular pose is nearer than the clearance to all of their poses:
there is one on each edge of a grid between nodes at which J has opposite signs. What is left holds all poses
that keep the clearance, and a path among them stays in one component of it. If no component holds two poses
of one joint vector, the mode cannot change. Pairs of boxes of a component are quartered until their images
are apart, or both lie in a box on which the derivative of both legs is regular: there, one joint vector has
one pose (mathematics.md#changes-with-a-clearance).

A range is cut into slabs, each with cells of its own; those of neighbouring slabs with the same poses are
joined. All of it may be for all manipulators within a tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import TURN
from rpr_solver.modes.fold_boxes import Boxes, FoldBoxes, Slab
from rpr_solver.modes.wide_pairs import components
from rpr_solver.singular.aspects import UnionFind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Truths = NDArray[np.bool_]
    Integers = NDArray[np.int64]

_SIZES = 256, 512
"""Cells in a turn, which are tried one after the other."""
_SLAB, _MOST_SLABS = 1 / 40, 24
"""The width of a slab in units, about a cell in radians; and so many at most."""
_WIDEST = 12
"""Nodes between signs of J that are opposite, at most: it may have no sign at some for many manipulators."""
_BLOCKS = 32
"""Blocks of cells in a turn, of which pairs are examined first."""
_FINER = 4
"""Blocks are cut to this part of a cell at most."""
_MOST_PAIRS, _MOST_TESTS = 400_000, 4_000_000
_AT_ONCE = 200_000


@dataclass(frozen=True)
class WideRegions:
    """The poses of a slice or of a range that keep a clearance.

    Attributes:
        model: the manipulator, or all within a tolerance, with the limits of the free legs.
        slabs: the lengths of the fixed leg, ascending; neighbouring ones have an end in common.
        clearance: in degrees.
    """

    model: FoldBoxes
    slabs: tuple[Slab, ...]
    clearance: Fraction

    @classmethod
    def of(cls, model: FoldBoxes, span: tuple[Fraction, Fraction], clearance: Fraction) -> WideRegions | None:
        """Those of a range of scaled lengths, or of a slice; None if it is too wide."""
        low, high = span
        count = max(1, ceil((high - low) / model.unit / _SLAB))
        if count > _MOST_SLABS:
            return None
        ends = [low + (high - low) * k / count for k in range(count + 1)]
        return cls(model, tuple(model.slab(x, y) for x, y in pairwise(ends)), clearance)

    def tests_apart(self, *, is_brief: bool = False) -> int | None:
        """The number of pairs of boxes that prove that no component holds two poses of one joint vector; None
        if that is not proved.

        ``is_brief``: whether the finest cells are not tried.
        """
        for size in _SIZES[:1] if is_brief or len(self.slabs) > 1 else _SIZES:
            if (tests := self._tests_with(size)) is not None:
                return tests
        return None

    def _tests_with(self, size: int) -> int | None:
        """The same with so many cells in a turn."""
        kept = [self._kept(slab, size) for slab in self.slabs]
        tests = 0
        for sign in (0, 1):
            labels = [components(both[sign], diagonal=True) for both in kept]
            for slab, own in zip(self.slabs, _joined(labels), strict=True):
                for label in np.unique(own[own >= 0]):
                    found = self._pairs_apart(slab, own == label, _MOST_TESTS * len(self.slabs) - tests)
                    if found is None:
                        return None
                    tests += found
        return tests

    def _kept(self, slab: Slab, size: int) -> tuple[Truths, Truths]:
        """Cells that may hold poses that keep the clearance and the limits, with J > 0, and with J < 0."""
        positive, negative = self._signs(slab, size)
        inside = self._inside(slab, size) & ~self._near(slab, size)
        return inside & ~negative, inside & ~positive

    def _cells(self, size: int) -> Boxes:
        half = TURN // (2 * size)
        middles = (2 * np.arange(size, dtype=np.int64) + 1) * half
        alpha, theta = (x.ravel() for x in np.meshgrid(middles, middles, indexing="ij"))
        return Boxes(alpha, theta, np.full(alpha.shape, half), np.full(alpha.shape, half))

    def _signs(self, slab: Slab, size: int) -> tuple[Truths, Truths]:
        """Where J is proved to be positive on a whole cell, and where negative."""
        own = self.model.poses(self._cells(size), slab)
        value = own.over(*own.singularity)
        sure = value.excludes_zero.reshape(size, size)
        above = (value.mid > 0).reshape(size, size)
        return sure & above, sure & ~above

    def _inside(self, slab: Slab, size: int) -> Truths:
        """The cells that do not exceed a limit everywhere."""
        inside: Truths = self.model.within(self.model.poses(self._cells(size), slab))
        return inside.reshape(size, size)

    def _near(self, slab: Slab, size: int) -> Truths:
        """Cells all of whose poses are nearer than the clearance to a singular pose, at each length."""
        step = 360 / size
        # from the middle of a cell to its farthest pose
        most = double(self.clearance) * (1 - 1e-9) / step - 2**-0.5
        sign = self._node_signs(slab, size)
        near = np.zeros((size, size), dtype=bool)
        for axis in (0, 1):
            unsure = np.ones((size, size), dtype=bool)
            for wide in range(1, _WIDEST + 1):
                # and from the middle of an edge between nodes so far apart to any of its points
                reach = (most - wide / 2) * (1 - 1e-9)
                if reach <= 0:
                    break
                zeros = unsure & (sign * np.roll(sign, -wide, axis) < 0)
                # node (i, k) is the lower corner of cell (i, k); steps go from edges' middles to cells'
                along = (1 - wide) / 2
                near |= _dilated(zeros, (along, 0.5) if axis == 0 else (0.5, along), reach)
                unsure &= np.roll(sign, -wide, axis) == 0
        return near

    def _node_signs(self, slab: Slab, size: int) -> Integers:
        """The proved sign of J at the lower corners of cells; 0 where there is none."""
        cells = self._cells(size)
        half = TURN // (2 * size)
        zero = np.zeros(len(cells), dtype=np.int64)
        own = self.model.poses(Boxes(cells.alpha - half, cells.theta - half, zero, zero), slab)
        value = own.over(*own.singularity)
        signs: Integers = np.where(value.excludes_zero, np.sign(value.mid), 0).astype(np.int64)
        return signs.reshape(size, size)

    def _pairs_apart(self, slab: Slab, mask: Truths, most_tests: int) -> int | None:
        """The number of pairs that prove it for one component; None if they do not."""
        size, blocks, tests = mask.shape[0], _BLOCKS, 0
        places = np.flatnonzero(_blocks(mask, blocks))
        first, second = (x.astype(np.int64) for x in np.triu_indices(len(places)))
        # Invariant: no joint vector has two poses in the component but in the pairs of blocks that are left.
        # It ends when none is left, when there are too many, or when blocks are small.
        while len(first):
            tests += len(first)
            if len(first) > max(_MOST_PAIRS, _BLOCKS**4) or tests > most_tests or blocks > _FINER * size:
                return None
            boxes = self._block_boxes(places, blocks)
            left = np.concatenate([~self._apart(slab, boxes, a, b) for a, b in _parts(first, second)])
            first, second = first[left], second[left]
            places, first, second = _cut(mask, places, blocks, first, second)
            blocks *= 2
        return tests

    def _block_boxes(self, places: Integers, blocks: int) -> Boxes:
        half = TURN // (2 * blocks)
        row, column = np.divmod(places, blocks)
        wide = np.full(places.shape, half)
        return Boxes((2 * row + 1) * half, (2 * column + 1) * half, wide, wide)

    def _apart(self, slab: Slab, boxes: Boxes, first: Integers, second: Integers) -> Truths:
        """Which pairs have no two different poses of one joint vector."""
        done = self.model.apart(boxes, slab, first, second)
        left = np.flatnonzero(~done)
        if len(left):
            hulls = boxes.hulls(first[left], second[left])
            f, g = self.model.poses(hulls, slab).legs
            # means of slopes along the segment between two poses, of each leg its own
            regular = f.rise[0] * g.rise[1] - f.rise[1] * g.rise[0]
            done[left] = regular.excludes_zero
        return done


def _joined(labels: Sequence[Integers]) -> list[Integers]:
    """Numbers of components of all slabs together, from those of each: −1 where there is none."""
    size = labels[0].size
    most = size * len(labels)
    numbers = [np.where(own >= 0, own + k * size, -1) for k, own in enumerate(labels)]
    classes = UnionFind(int(x) for own in numbers for x in np.unique(own[own >= 0]))
    for one, other in pairwise(numbers):
        both = (one >= 0) & (other >= 0)
        for x, y in zip(*np.divmod(np.unique(one[both] * most + other[both]), most), strict=True):
            classes.join(int(x), int(y))
    found = []
    for own in numbers:
        known, places = np.unique(own, return_inverse=True)
        roots = np.array([-1 if x < 0 else classes.root(int(x)) for x in known], dtype=np.int64)
        found.append(roots[places.reshape(own.shape)])
    return found


def _parts(first: Integers, second: Integers) -> Iterator[tuple[Integers, Integers]]:
    for start in range(0, len(first), _AT_ONCE):
        yield first[start : start + _AT_ONCE], second[start : start + _AT_ONCE]


def _blocks(mask: Truths, blocks: int) -> Truths:
    """Which blocks have a cell of a mask; blocks smaller than cells are parts of them."""
    size = mask.shape[0]
    if blocks > size:
        finer: Truths = np.repeat(np.repeat(mask, blocks // size, 0), blocks // size, 1)
        return finer
    wide = size // blocks
    found: Truths = np.any(mask.reshape(blocks, wide, blocks, wide), axis=(1, 3))
    return found


def _cut(
    mask: Truths, places: Integers, blocks: int, first: Integers, second: Integers
) -> tuple[Integers, Integers, Integers]:
    """The quarters of blocks that are in pairs, and their pairs, each once."""
    used, numbers = np.unique(np.concatenate([first, second]), return_inverse=True)
    row, column = np.divmod(places[used], blocks)
    size = mask.shape[0]
    children = np.stack(
        [(2 * row + x) * (2 * blocks) + 2 * column + y for x in (0, 1) for y in (0, 1)], axis=1
    )
    if 2 * blocks > size:
        wide = 2 * blocks // size
        kept = mask[(children // (2 * blocks)) // wide, (children % (2 * blocks)) // wide]
    else:
        kept = _blocks(mask, 2 * blocks).ravel()[children]
    one, other = numbers[: len(first)], numbers[len(first) :]
    pairs = []
    for a in range(4):
        for b in range(4):
            own = kept[one, a] & kept[other, b] & ((one != other) | (a <= b))
            pairs.append((one[own] * 4 + a, other[own] * 4 + b))
    new_first, new_second = (np.concatenate(side) for side in zip(*pairs, strict=True))
    return children.ravel(), new_first, new_second


def _dilated(marks: Truths, shift: tuple[float, float], radius: float) -> Truths:
    """The places whose middles are nearer than a radius to a mark that is moved by a shift; on a torus.

    Places and marks are numbered alike, and their middles are half a place apart where the shift says so.
    """
    size = marks.shape[0]
    found: Truths = np.zeros_like(marks)
    reach = min(int(radius) + 1, size // 2)
    wrapped = np.concatenate([marks, marks, marks], axis=1)
    sums = np.concatenate([np.zeros((size, 1), dtype=np.int64), np.cumsum(wrapped, axis=1)], axis=1)
    columns = np.arange(size) + size
    for step in range(-reach, reach + 1):
        away = step + shift[0]
        if abs(away) >= radius:
            continue
        width = (radius**2 - away**2) ** 0.5
        # marks at columns c with |column + shift − c| < width
        low = np.floor(columns + shift[1] - width).astype(np.int64) + 1
        high = np.ceil(columns + shift[1] + width).astype(np.int64) - 1
        low, high = np.maximum(low, columns - size), np.minimum(high, columns + size - 1)
        hit: Truths = sums[:, high + 1] > sums[:, low]
        found[np.roll(hit, step, axis=0)] = True
    return found
