"""Boxes of poses in which degenerate cusps are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.turns import TURN
from rpr_solver.margins.expansions import ANGLES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.boxes.sieve import Boxes
    from rpr_solver.margins.expansions import Doubles, Places

    Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Zones:
    """Boxes of poses in which degenerate cusps are known, and how far other boxes are cut.

    Attributes:
        low, high: the ends of α, θ and the length, a column for each zone.
        tests: whose zeros are known there: 0 for (K, E, S), 1 for (K, K_α, K_θ).
        least: boxes with such sides of α, θ and the length are not cut.
        goes_on: whether the search goes on when such a box is left.
    """

    low: Doubles
    high: Doubles
    tests: Places
    least: tuple[float, float, float]
    goes_on: bool

    def known(self, boxes: Boxes) -> Flags:
        """For each test whether boxes are within a zone of it."""
        low, high = (ends[: ANGLES + 1, None] for ends in (boxes.low, boxes.high))
        lows, highs = self.low[:, :, None], self.high[:, :, None]
        turns = np.zeros_like(lows + low)
        turns[:ANGLES] = np.floor((low[:ANGLES] - lows[:ANGLES]) / TURN) * TURN
        inside: Flags = np.all([lows + turns <= low, high <= highs + turns], axis=(0, 1))
        return np.array([inside[self.tests == test].any(axis=0) for test in (0, 1)])

    def small(self, boxes: Boxes) -> Flags:
        """The boxes that are not to be cut."""
        sides = boxes.high[: ANGLES + 1] - boxes.low[: ANGLES + 1]
        flags: Flags = np.all(sides <= np.array(self.least)[:, None], axis=0)
        return flags
