"""Angles as integers, parts of a turn, and their cosines and sines in doubles with a proved error.

The functions of boxes of poses, and J of a slice in doubles, are made of these
(mathematics.md#functions-on-boxes).
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Integers = NDArray[np.int64]

TURN = 1 << 31
"""Angles are integers: the number of units in a turn."""
UP = 1 + 2.0**-30
"""Bounds the roundings within a bound, with a wide margin."""
RADIANS = 2 * np.pi / TURN * UP
"""A unit of angles, rounded up."""
_TABLES = ((1 << 11, 1 << 20), (1 << 10, 1 << 10), (1 << 10, 1))
"""Numbers of entries and their steps, in units: an angle is a sum of an entry of each."""


def cos_sin(angle: Integers) -> tuple[Doubles, Doubles]:
    """Cosines and sines of angles in units of a turn over :data:`TURN`, right to 16 units of 2⁻⁵³."""
    angle = angle % TURN
    cos, sin = np.ones(angle.shape), np.zeros(angle.shape)
    for (count, step), (cosines, sines) in zip(_TABLES, _tables(), strict=True):
        place = angle // step % count
        x, y = cosines[place], sines[place]
        cos, sin = cos * x - sin * y, sin * x + cos * y
    return cos, sin


@lru_cache(maxsize=1)
def _tables() -> list[tuple[Doubles, Doubles]]:
    """Cosines and sines, rounded to nearest or nearly so."""
    tables = []
    with ctx.workprec(80):
        for count, step in _TABLES:
            turns = [arb(2 * k * step) / TURN for k in range(count)]
            cosines, sines = zip(*(x.sin_cos_pi()[::-1] for x in turns), strict=True)
            tables.append((np.array([float(x) for x in cosines]), np.array([float(x) for x in sines])))
    return tables
