"""All cusps of a slice, and all poses of a joint vector, found anew in boxes that cover all poses.

Which zeros are all cusps is in mathematics.md#cusps-by-boxes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import pi

import numpy as np

from rpr_solver.boxes import Box, Boxes, System, Zero, contains, search, sieved, turned
from rpr_solver.verify.equations import ALPHA, THETA, Mechanism, Slice
from rpr_solver.verify.systems import Coalescing, JointVector
from rpr_solver.verify.work import Work

_PARTS = 32
"""The torus is cut in so many parts squared at first."""
_NARROW = 2.0**-18
"""Boxes of this size leave the sieve: smaller ones are seldom decided in doubles."""
_COARSE = 2.0**-14
"""And where three poses nearly coalesce, many of them are left."""
_LEAST = 2.0**-100
"""Boxes of this size are given up: something is degenerate there, or nearly so."""
_SIEVED, _SEARCHED = 30_000, 2_000
"""The most boxes of a slice that are looked at in the sieve, and the most of all systems one by one."""
OF_SIEVE, _OF_SEARCH = 4, 4
"""So many boxes of the sieve take about one unit of work, and a box alone so many units."""

_TURN = (0.0, float(np.nextafter(2 * pi, np.inf)))
TURNED = turned(ALPHA, THETA)
"""Poses are the same after whole turns."""


@dataclass(frozen=True)
class Found:
    """Zeros that are proved, each alone in a box, and boxes in which there may be others.

    There are none elsewhere. Angles are in radians, and may differ by turns.
    """

    zeros: Sequence[Zero]
    open: Sequence[Box]

    def may_hold(self, box: Box) -> bool:
        """Whether one that is not proved may be in a box."""
        return any(
            all(x.overlaps(y) for x, y in zip(TURNED(box, other), other, strict=True)) for other in self.open
        )


def torus(parts: int, *others: tuple[float, float], alpha: tuple[float, float] = _TURN) -> Boxes:
    """All θ and an interval of α, or all, in parts² boxes, each with an interval of the other variables."""
    first, second = (np.linspace(*ends, parts + 1) for ends in (alpha, _TURN))
    i, j = (x.ravel() for x in np.indices((parts, parts)))
    low, high = ([first[i + n], second[j + n]] for n in (0, 1))
    for k, rows in enumerate((low, high)):
        rows += [np.full(parts**2, other[k]) for other in others]
    return Boxes(np.array(low), np.array(high))


def solved(
    system: System,
    start: Boxes,
    most: int,
    work: Work,
    narrow: float = _NARROW,
    known: Sequence[Box] = (),
) -> Found:
    """All zeros in some boxes, and perhaps some beside these, but for those in boxes where all are known.

    Raises:
        Open: there is no work left.
    """
    sieve = sieved(system, start, narrow, most)
    work.spend(sieve.looked // OF_SIEVE)
    if not sieve.ended:
        whole = Boxes(start.low.min(1, keepdims=True), start.high.max(1, keepdims=True))
        return Found((), whole.balls())
    boxes = [x for x in sieve.boxes.balls() if not any(contains(y, TURNED(x, y)) for y in known)]
    found = search(system, boxes, _LEAST, _SEARCHED, TURNED)
    work.spend(_OF_SEARCH * found.looked)
    return Found(found.zeros, found.doubts)


def cusps_of(mechanism: Mechanism, length: Fraction, work: Work) -> Found:
    """All cusps of a slice.

    Raises:
        Open: there is no work left.
    """
    if mechanism.geometry.is_similar_pair:
        return Found((), ())
    return solved(Coalescing(Slice(mechanism, length), 1), torus(_PARTS), _SIEVED, work)


def poses_of(mechanism: Mechanism, length: Fraction, squares: Sequence[Fraction], work: Work) -> Found:
    """All poses in a slice with these squared lengths of the free legs.

    Raises:
        Open: there is no work left.
    """
    return solved(JointVector(Slice(mechanism, length), squares), torus(_PARTS), _SIEVED, work, _COARSE)
