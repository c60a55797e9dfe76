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
from rpr_solver.paths.singular_field import SingularField, leg_lengths

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Numbers = NDArray[np.int64]

_PARTS = 180
_LEVELS = 14
"""Halvings of the interval of levels, which is then far narrower than the grid."""
_CELLS = 150
"""Leg lengths are about the same in one of so many parts of their range."""
_APART = 6
"""Nodes between two poses, at least, that are told apart."""
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
    with np.errstate(all="ignore"):  # a leg of length 0 has no derivative, which is not used
        legs = leg_lengths(grid.field, grid.nodes.reshape(-1, 2)).reshape(_PARTS, _PARTS, 2)
    inside = np.ones(rooms.shape, dtype=bool)
    for k, leg in enumerate(free_legs(slice_map.fixed_leg)):
        least, most = bounds.get(leg, NO_BOUNDS)
        own_lengths = legs[..., k] * unit
        inside &= own_lengths > (0 if least is None else double(least))
        inside &= own_lengths < (np.inf if most is None else double(most))
    cells = (legs / legs.max() * _CELLS).astype(np.int64)
    for sign in (1, -1):
        own = np.where(inside, rooms * sign, -1.0)
        low, high, best = 0.0, float(own.max()), None
        # Invariant: ``best`` is what is found at the level ``low``, None if nothing is yet known.
        # It ends after so many halvings.
        for _ in range(_LEVELS if high > 0 else 0):
            level = (low + high) / 2
            found = _pair(own >= level, own, cells)
            low, high, best = (level, high, found) if found else (low, level, best)
        if best is not None:
            places = [np.unravel_index(node, rooms.shape) for node in best]
            one, other = (grid.nodes[place] for place in places)
            joint = [rounded_near(Fraction(float(x) * unit), _DIGITS) for x in legs[places[0]]]
            yield (joint[0], joint[1]), (tuple(one.tolist()), tuple(other.tolist()))


def _pair(allowed: NDArray[np.bool_], rooms: Doubles, cells: Numbers) -> tuple[int, int] | None:
    """Two nodes of one component of those that are allowed, far apart, whose legs are in one cell."""
    labels = components(allowed).ravel()
    nodes = np.flatnonzero(labels >= 0)
    flat = cells.reshape(-1, 2)[nodes]
    keys = (labels[nodes] * (_CELLS + 1) + flat[:, 0]) * (_CELLS + 1) + flat[:, 1]
    order = np.lexsort((-rooms.ravel()[nodes], keys))
    nodes, keys = nodes[order], keys[order]
    _, starts = np.unique(keys, return_index=True)
    first = nodes[np.repeat(starts, np.diff(np.append(starts, len(keys))))]
    size = allowed.shape[0]
    steps = [abs(x - y) for x, y in zip(np.divmod(first, size), np.divmod(nodes, size), strict=True)]
    far = np.maximum(*(np.minimum(step, size - step) for step in steps)) >= _APART
    if not far.any():
        return None
    least = np.minimum(rooms.ravel()[first], rooms.ravel()[nodes])
    best = int(np.where(far, least, -np.inf).argmax())
    return int(first[best]), int(nodes[best])


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
