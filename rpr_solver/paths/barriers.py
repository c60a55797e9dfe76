"""Boxes that bar all ways with more than a clearance, by proof.

No path has a clearance above X that must cross boxes each of which lies within X of a pose where J has the
other sign. As J / L is linear in the length of the fixed leg, it has it for all lengths of a range if it has
for the least and for the greatest one (mathematics.md#paths-without-a-singularity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.errors import SolverError
from rpr_solver.paths.boxes import Box, Boxes, Verdict
from rpr_solver.paths.proofs import NO_LIMITS
from rpr_solver.paths.routes import EndPose
from rpr_solver.paths.search import Search
from rpr_solver.paths.singular_field import DEGREE, units
from rpr_solver.paths.wide_grid import RangeGrid

if TYPE_CHECKING:
    from rpr_solver.paths.singular_field import Doubles, Integers, Truths

BEYOND = 0.002
"""The share of the way to the nearest zero of J by which a pose lies beyond it."""
_FINER = (2, 4, 6)
"""Boxes become narrower than the clearance by these powers of two, one after another."""
_FIRST = 6
_CHOSEN = 8
_HALF_DIAGONAL = 0.7072
"""Of a box, by its width; what is to spare is more than the rounding of its middle and of a distance."""
_MORE_BOXES = 2000


def are_barred(grid: RangeGrid, ends: Sequence[EndPose], most: Fraction) -> bool:
    """Whether it is proved that every path between two poses meets a box that lies, for each length, within
    this distance (degrees) of a pose where J has the other sign."""
    first, last = ends
    length = first.legs[0]
    bars = Bars(first.slice_map, grid.field.sign, NO_LIMITS, length, length, grid=grid, most=most)
    try:
        start, stop = ((*pose.angles, length) for pose in (first, last))
        return _BarSearch(bars).outcome(start, stop).is_separated
    except SolverError:
        return False


@dataclass(frozen=True)
class Bars(Boxes):
    """Boxes of (α, θ): out are those in which J has the other sign, and those that lie, for each length,
    within a distance of poses where it has.

    Those that seem to be farther everywhere are in; this is not proved.
    """

    grid: RangeGrid = field(kw_only=True, repr=False)
    most: Fraction = field(kw_only=True)
    seen: dict[Box, tuple[float, Verdict]] = field(default_factory=dict, repr=False)

    def first(self) -> list[Box]:
        """The boxes of a level at which most of them are decided."""
        turn = range(1 << _FIRST)
        boxes = [(_FIRST, i, k, 0) for i in turn for k in turn]
        self.judge(boxes)
        return boxes

    def spots(self, boxes: Sequence[Box]) -> tuple[Doubles, Doubles]:
        """The middles of boxes of any levels, and their widths, in degrees."""
        origin = [float(360 * x) for x in self.middle((0, 0, 0, 0))[:2]]
        width = 360.0 / np.array([1 << box[0] for box in boxes])
        places = np.array([box[1:3] for box in boxes]) + 0.5
        return places * width[:, None] + np.array(origin) - 180, width

    def judge(self, boxes: Sequence[Box]) -> None:
        """Keeps the rooms of boxes of any levels at their best lengths, as floats see them, and the verdicts
        about them."""
        spots, width = self.spots(boxes)
        reach, most = width * _HALF_DIAGONAL, float(self.most)
        rooms, feet = self.grid.seen(spots)
        steps = feet - spots
        away = np.hypot(steps[..., 0], steps[..., 1])
        farthest = np.maximum(most * (1 - 1e-6) - reach, 0.0)
        # the pose itself; the nearest zeros, and some beyond them
        sizes = [np.zeros_like(away), away * (1 + BEYOND), np.broadcast_to(farthest, away.shape)]
        shares = np.concatenate([x / np.maximum(away, 1e-12) for x in sizes])
        others = np.array(units((spots + np.tile(steps, (3, 1, 1)) * shares[..., None]).reshape(-1, 2)))
        others = others.reshape(2, *shares.shape)
        gaps = others / DEGREE - spots.T[:, None]
        is_near = np.hypot(gaps[0], gaps[1]) + reach < most * (1 - 1e-9)
        is_out = np.any(is_near & self._are_other(others[0], others[1], 0.0), axis=0)
        is_out |= self._are_other(*units(spots), reach * DEGREE + 1)
        room = rooms.max(axis=0)
        verdicts = np.where(is_out, Verdict.OUT, np.where(room - reach > most, Verdict.IN, Verdict.UNDECIDED))
        seen = zip(room.tolist(), map(Verdict, verdicts.tolist()), strict=True)
        self.seen.update(zip(boxes, seen, strict=True))

    def _are_other(self, alpha: Integers, theta: Integers, radius: float | Doubles) -> Truths:
        """Whether J is proved to have the other sign in discs, for all lengths."""
        ends = (self.grid.slices[k].field.bounds(alpha, theta, radius) for k in (0, -1))
        return np.logical_and(*(value + slack < 0 for value, slack in ends))

    def verdict(self, box: Box) -> Verdict:
        """Out, if all its poses are near one where J has the other sign."""
        if box not in self.seen:
            self.judge([box])
        return self.seen[box][1]


class _BarSearch(Search):
    """The search for boxes that bar all ways."""

    most_boxes, more_boxes = 0, _MORE_BOXES

    def __init__(self, boxes: Bars) -> None:
        super().__init__(boxes)
        self.bars = boxes
        least = ceil(log2(360 / float(boxes.most)))
        self.levels = [least + n for n in _FINER]

    def chosen(self, boxes: list[Box]) -> list[Box]:
        """The narrowest ones: it is enough to bar each way at one place."""
        chosen = sorted(boxes, key=lambda box: self.bars.seen[box][0])[:_CHOSEN]
        self.bars.judge([part for box in chosen for part in self.bars.parts(box)])
        return chosen
