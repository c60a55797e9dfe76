"""The proof that no path with a clearance changes the assembly mode in a slice.

Cells of the torus of poses are dropped if a singular pose is nearer than the clearance to all of their poses:
there is one on each edge of a grid between nodes at which J has opposite signs. What is left holds all poses
that keep the clearance, and a path among them stays in one component of it. If no component holds two poses
of one joint vector, the mode cannot change. Pairs of boxes of a component are quartered until their images
are apart, or both lie in a box on which the derivative of both legs is regular: there, one joint vector has
one pose.

All of it may be for all manipulators within a tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import TURN
from rpr_solver.modes.fold_boxes import Boxes, FoldBoxes, Slab
from rpr_solver.modes.wide_pairs import components

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Truths = NDArray[np.bool_]
    Integers = NDArray[np.int64]

_SIZES = 256, 512
"""Cells in a turn, which are tried one after the other; of many manipulators only the first."""
_BLOCKS = 32
"""Blocks of cells in a turn, of which pairs are examined first."""
_FINER = 4
"""Blocks are cut to this part of a cell at most."""
_MOST_PAIRS, _MOST_TESTS = 400_000, 4_000_000
_AT_ONCE = 200_000


@dataclass(frozen=True)
class WideRegions:
    """The poses of a slice that keep a clearance.

    Attributes:
        model: the manipulator, or all within a tolerance, with the limits of the free legs.
        slab: the length of the fixed leg.
        clearance: in degrees.
    """

    model: FoldBoxes
    slab: Slab
    clearance: Fraction

    def tests_apart(self) -> int | None:
        """The number of pairs of boxes that prove that no component holds two poses of one joint vector; None
        if that is not proved."""
        for size in _SIZES if self.model.legs.is_one else _SIZES[:1]:
            if (tests := self._tests_with(size)) is not None:
                return tests
        return None

    def _tests_with(self, size: int) -> int | None:
        """The same with so many cells in a turn."""
        positive, negative = self._signs(size)
        near = self._near(size)
        if near is None:
            return None
        tests = 0
        inside = self._inside(size) & ~near
        for own in (inside & ~negative, inside & ~positive):
            labels = components(own, diagonal=True)
            for label in np.unique(labels[labels >= 0]):
                found = self._pairs_apart(labels == label, _MOST_TESTS - tests)
                if found is None:
                    return None
                tests += found
        return tests

    def _cells(self, size: int) -> Boxes:
        half = TURN // (2 * size)
        middles = (2 * np.arange(size, dtype=np.int64) + 1) * half
        alpha, theta = (x.ravel() for x in np.meshgrid(middles, middles, indexing="ij"))
        return Boxes(alpha, theta, np.full(alpha.shape, half), np.full(alpha.shape, half))

    def _signs(self, size: int) -> tuple[Truths, Truths]:
        """Where J is proved to be positive on a whole cell, and where negative."""
        own = self.model.poses(self._cells(size), self.slab)
        value = own.over(*own.singularity)
        sure = value.excludes_zero.reshape(size, size)
        above = (value.mid > 0).reshape(size, size)
        return sure & above, sure & ~above

    def _inside(self, size: int) -> Truths:
        """The cells that do not exceed a limit everywhere."""
        inside: Truths = self.model.within(self.model.poses(self._cells(size), self.slab))
        return inside.reshape(size, size)

    def _near(self, size: int) -> Truths | None:
        """The cells all of whose poses are nearer than the clearance to a singular pose; None if cells are
        too wide to tell."""
        step = 360 / size
        # from the middle of a cell to its farthest pose, and from the middle of an edge to any of its points
        reach = double(self.clearance) * (1 - 1e-9) - step * (2**-0.5 + 0.5) * (1 + 1e-9)
        if reach <= 0:
            return None
        sign = self._node_signs(size)
        near = np.zeros((size, size), dtype=bool)
        for axis in (0, 1):
            zeros = sign * np.roll(sign, -1, axis) < 0
            # node (i, k) is the lower corner of cell (i, k); a step from an edge's middle to that of a cell
            shift = (0.0, 0.5) if axis == 0 else (0.5, 0.0)
            near |= _dilated(zeros, shift, reach / step)
        return near

    def _node_signs(self, size: int) -> Integers:
        """The proved sign of J at the lower corners of cells; 0 where there is none."""
        cells = self._cells(size)
        half = TURN // (2 * size)
        zero = np.zeros(len(cells), dtype=np.int64)
        own = self.model.poses(Boxes(cells.alpha - half, cells.theta - half, zero, zero), self.slab)
        value = own.over(*own.singularity)
        signs: Integers = np.where(value.excludes_zero, np.sign(value.mid), 0).astype(np.int64)
        return signs.reshape(size, size)

    def _pairs_apart(self, mask: Truths, most_tests: int) -> int | None:
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
            left = np.concatenate([~self._apart(boxes, a, b) for a, b in _parts(first, second)])
            first, second = first[left], second[left]
            places, first, second = _cut(mask, places, blocks, first, second)
            blocks *= 2
        return tests

    def _block_boxes(self, places: Integers, blocks: int) -> Boxes:
        half = TURN // (2 * blocks)
        row, column = np.divmod(places, blocks)
        wide = np.full(places.shape, half)
        return Boxes((2 * row + 1) * half, (2 * column + 1) * half, wide, wide)

    def _apart(self, boxes: Boxes, first: Integers, second: Integers) -> Truths:
        """Which pairs have no two different poses of one joint vector."""
        done = self.model.apart(boxes, self.slab, first, second)
        left = np.flatnonzero(~done)
        if len(left):
            hulls = boxes.hulls(first[left], second[left])
            f, g = self.model.poses(hulls, self.slab).legs
            # means of slopes along the segment between two poses, of each leg its own
            regular = f.rise[0] * g.rise[1] - f.rise[1] * g.rise[0]
            done[left] = regular.excludes_zero
        return done


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
