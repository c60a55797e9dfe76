"""Arrays of floats with bounds of their errors: the arithmetic of pose_proofs.py.

Every operation bounds its own rounding error and what the errors of its operands make of it
(mathematics.md#poses-by-floats), as a ball of FLINT does, but for all poses of a block at once.
"""

from __future__ import annotations

from typing import Any

_UP = 1 + 2.0**-48
"""Bounds the roundings within a bound, which has at most ten of them in double precision."""


class Bounded:
    """Numbers within ``error`` of ``value``: scalars or numpy arrays of floats.

    Attributes:
        value: floats that each operation rounds to nearest.
        error: bounds, in double precision.
        unit: bounds the relative error of a rounding.
        size: the absolute values, in double precision.
    """

    __slots__ = ("error", "size", "unit", "value")

    def __init__(self, value: Any, error: Any, unit: float) -> None:
        self.value, self.error, self.unit = value, error, unit
        self.size = abs(value.astype(float))

    def __add__(self, other: Bounded) -> Bounded:
        return self._sum(self.value + other.value, other)

    def __sub__(self, other: Bounded) -> Bounded:
        return self._sum(self.value - other.value, other)

    def _sum(self, value: Any, other: Bounded) -> Bounded:
        result = Bounded(value, 0.0, self.unit)
        result.error = (self.error + other.error + self.unit * result.size) * _UP
        return result

    def __mul__(self, other: Bounded) -> Bounded:
        result = Bounded(self.value * other.value, 0.0, self.unit)
        error = self.size * other.error + self.error * (other.size + other.error)
        result.error = (error + self.unit * result.size) * _UP
        return result

    @property
    def least(self) -> Any:
        """A lower bound of the absolute values."""
        return (self.size - self.error) * (2 - _UP)

    @property
    def greatest(self) -> Any:
        """An upper bound of the absolute values."""
        return (self.size + self.error) * _UP
