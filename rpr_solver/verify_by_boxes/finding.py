"""All cusps of a slice, all poses of a joint vector: found anew, in boxes that cover all poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import pi

import numpy as np

from rpr_solver.boxes import Box, Boxes, System, Zero, search, sieved, turned
from rpr_solver.verify_by_boxes.equations import ALPHA, THETA, Mechanism, Slice
from rpr_solver.verify_by_boxes.systems import Coalescing, JointVector

_PARTS = 12
"""The torus is cut in so many parts squared."""
_NARROW = 2.0**-12
"""Boxes of this size leave the sieve."""
_LEAST = 2.0**-100
"""A box of this size is given up: something is degenerate there, or nearly so."""
_SIEVED, _LOOKED = 100_000, 5_000
"""The most boxes that are looked at in the sieve, and in balls of FLINT."""


@dataclass(frozen=True)
class Found:
    """Zeros that are proved, each in a box of its own, and boxes in which there may be others.

    There are no others anywhere. Angles are in radians; those of a box may differ by turns from others.
    """

    zeros: Sequence[Zero]
    open: Sequence[Box]

    @property
    def complete(self) -> bool:
        """Whether all are known."""
        return not self.open


def torus(parts: int) -> Boxes:
    """All α and θ, in parts² boxes."""
    ends = np.linspace(0, np.nextafter(2 * pi, np.inf), parts + 1)
    first, second = (x.ravel() for x in np.indices((parts, parts)))
    return Boxes(np.array([ends[first], ends[second]]), np.array([ends[first + 1], ends[second + 1]]))


def solved(system: System, start: Boxes, weights: Sequence[float]) -> Found:
    """All zeros in some boxes, and perhaps some beside these."""
    rest = sieved(system, start, weights, _NARROW, _SIEVED)
    found = search(system, rest.boxes.balls(), _LEAST, _LOOKED, turned(ALPHA, THETA), weights)
    return Found(found.zeros, found.doubts)


def cusps_of(mechanism: Mechanism, length: Fraction) -> Found:
    """All cusps of a slice."""
    return solved(Coalescing(Slice(mechanism, length), 1), torus(_PARTS), (1, 1))


def poses_of(mechanism: Mechanism, length: Fraction, squares: Sequence[Fraction]) -> Found:
    """All poses in a slice with these squared lengths of the free legs, in the order of their numbers."""
    return solved(JointVector(Slice(mechanism, length), squares), torus(_PARTS), (1, 1))
