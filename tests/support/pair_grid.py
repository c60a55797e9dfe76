"""Whether two poses are joined on a grid of poses, in floats and by definition alone: a witness of paths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tests.support.mode_grid import ModeGrid, _labels, _sure
from tests.support.oracle import free_legs_of, singularity

Place = tuple[float, float, float]
"""α and θ in radians, and the length of the fixed leg."""


@dataclass(frozen=True)
class PairGrid(ModeGrid):
    """The same grid, with the component of each pose: poses of one component are joined within the limits,
    since J cannot vanish between its cells. Poses of two may be joined all the same."""

    @cached_property
    def _components(self) -> Any:
        legs = free_legs_of(self.manipulator, self.leg)
        level, theta, alpha = np.meshgrid(self.levels, self.angles, self.angles, indexing="ij")
        j = singularity(legs, level, alpha, theta)
        return _labels(
            np.where(_sure(j) & self._allowed(legs, alpha, theta, level), np.sign(j), 0).astype(int)
        )

    @property
    def levels(self) -> Any:
        low, high = self.span
        return np.array([low]) if low == high else np.linspace(low, high, self.lengths)

    @property
    def angles(self) -> Any:
        return (np.arange(self.size) + 0.37) * (2 * np.pi / self.size)

    def joins(self, start: Place, stop: Place) -> bool:
        """Whether the cells next to both poses are of one component."""
        one, other = (self._component(place) for place in (start, stop))
        return one == other >= 0

    def _component(self, place: Place) -> int:
        alpha, theta, length = place
        level = int(np.argmin(abs(self.levels - length)))
        return int(self._components[level][self._cell(alpha, theta)])
