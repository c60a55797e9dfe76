"""Pairs of poses of one joint vector between which there may be a wide path, on a grid of a slice, in floats.

Nodes of the grid that are as far as some level from J = 0 are joined to their neighbours. The highest level
at which two distant nodes of one component have about the same leg lengths suggests the widest change of
assembly mode. It does not depend on how wide a path is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.decimals import rounded_near
from rpr_solver.exact.numerals import double
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.pose_grid import SliceGrid
from rpr_solver.paths.proofs import NO_BOUNDS
from rpr_solver.paths.singular_field import SingularField, followed, leg_lengths

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Numbers = NDArray[np.int64]

_PARTS = 180
_LEVELS = 14
"""Halvings of the interval of levels, which is then far narrower than the grid."""
_CELLS = 40
"""Poses from which others of the same legs may be found have legs in one of so many parts of their range."""
_EVERY = 2
"""Of the nodes in a row, so many have one of which other poses are sought."""
_APART = 3
"""Nodes between two poses, at least, that are told apart."""
_MOST = 200_000
"""Trials to find another pose."""
_DIGITS = 8

Spots = tuple[tuple[float, float], tuple[float, float]]
"""α and θ in degrees of two poses."""


def wide_pairs(
    slice_map: SliceMap, length: Fraction, bounds: Mapping[int, Bounds]
) -> Iterator[tuple[tuple[Fraction, Fraction], Spots]]:
    """For each sign of J: the free legs of a joint vector, in the user's unit, and two poses near those of
    it; for a scaled length of the fixed leg, within limits."""
    grid = SliceGrid(SingularField.of(slice_map, length, 1), _PARTS)
    rooms, unit = grid.rooms, double(grid.field.unit / slice_map.scale)
    spots = grid.nodes.reshape(-1, 2)
    with np.errstate(all="ignore"):  # a leg of length 0 has no derivative, which is not used
        legs = leg_lengths(grid.field, spots)
    inside = np.ones(len(spots), dtype=bool)
    for k, leg in enumerate(free_legs(slice_map.fixed_leg)):
        least, most = bounds.get(leg, NO_BOUNDS)
        own_lengths = legs[:, k] * unit
        inside &= own_lengths > (0 if least is None else double(least))
        inside &= own_lengths < (np.inf if most is None else double(most))
    for sign in (1, -1):
        own = np.where(inside.reshape(rooms.shape), rooms * sign, -1.0)
        first, second, others = _pairs(grid, legs, own)
        if not len(first):
            continue
        low, high = 0.0, float(own.max())
        best = np.zeros(0, dtype=np.int64)
        # Invariant: ``best`` are the pairs in one component at the level ``low``, none if nothing is yet
        # known. It ends after so many halvings.
        for _ in range(_LEVELS):
            level = (low + high) / 2
            labels = components(own >= level).ravel()
            found = np.flatnonzero((labels[first] >= 0) & (labels[first] == labels[second]))
            low, high, best = (level, high, found) if len(found) else (low, level, best)
        if len(best):
            room = np.minimum(own.ravel()[first[best]], own.ravel()[second[best]])
            widest = best[room.argmax()]
            joint = [rounded_near(Fraction(float(x) * unit), _DIGITS) for x in legs[first[widest]]]
            yield (joint[0], joint[1]), (_spot(spots[first[widest]]), _spot(others[widest]))


def _spot(spot: Doubles) -> tuple[float, float]:
    return float(spot[0]), float(spot[1])


def _pairs(grid: SliceGrid, legs: Doubles, own: Doubles) -> tuple[Numbers, Numbers, Doubles]:
    """Nodes, other poses with the legs of each, and the nodes nearest to those: first nodes, nodes of the
    others, and the others; found by Newton's method from nodes with about the same legs."""
    size, spots = grid.parts, grid.nodes.reshape(-1, 2)
    allowed = np.flatnonzero((own > 0).ravel())
    cells = (legs[allowed] / legs.max() * _CELLS).astype(np.int64)
    keys = cells[:, 0] * (_CELLS + 1) + cells[:, 1]
    order = np.argsort(keys, kind="stable")
    allowed, keys = allowed[order], keys[order]
    firsts = np.flatnonzero((allowed // size % _EVERY == 0) & (allowed % size % _EVERY == 0))
    starts, stops = (np.searchsorted(keys, keys[firsts], side) for side in ("left", "right"))
    counts = stops - starts
    # each first node with all nodes of its cell
    owner = np.repeat(np.arange(len(firsts)), counts)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts) + starts[owner]
    first, second = allowed[firsts[owner]], allowed[place]
    far = _distance(first, second, size) >= _APART
    first, second = first[far], second[far]
    step = len(first) // _MOST + 1
    first, second = first[::step], second[::step]
    others = followed(grid.field, spots[second], legs[first])
    known = np.isfinite(others).all(axis=1)
    first, others = first[known], others[known]
    nodes = np.rint(others / grid.step).astype(np.int64) % size
    second = nodes[:, 0] * size + nodes[:, 1]
    far = _distance(first, second, size) >= _APART
    return first[far], second[far], others[far]


def _distance(first: Numbers, second: Numbers, size: int) -> Numbers:
    """How many steps nodes are apart, in the direction in which these are more."""
    steps = [abs(x - y) for x, y in zip(np.divmod(first, size), np.divmod(second, size), strict=True)]
    found: Numbers = np.maximum(*(np.minimum(step, size - step) for step in steps))
    return found


def components(allowed: NDArray[np.bool_], *, diagonal: bool = False) -> Numbers:
    """The components of nodes that are allowed: numbers, −1 elsewhere; both angles are periodic.

    ``diagonal``: whether nodes across a corner are neighbours.
    """
    numbers = np.arange(allowed.size).reshape(allowed.shape)
    steps = [(1, 0), (0, 1), *([(1, 1), (1, -1)] if diagonal else [])]
    pairs = [
        (numbers[both], np.roll(numbers, step, (0, 1))[both])
        for step in steps
        if (both := allowed & np.roll(allowed, step, (0, 1))).any()
    ]
    root = numbers.ravel().copy()
    nothing = np.zeros(0, dtype=np.int64)
    first, second = (np.concatenate([nothing, *(pair[k] for pair in pairs)]) for k in (0, 1))
    # Invariant: a node and its root are in one component. It ends since roots only grow, until neighbours
    # have one.
    while len(first):
        one, other = root[first], root[second]
        apart = one != other
        first, second, one, other = first[apart], second[apart], one[apart], other[apart]
        np.maximum.at(root, np.minimum(one, other), np.maximum(one, other))
        while (root != (further := root[root])).any():
            root = further
    return np.where(allowed, root.reshape(allowed.shape), -1)
