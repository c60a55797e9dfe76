"""Clearance: how far poses are from all singular poses with their length of the fixed leg, at least
(mathematics.md#clearance-by-boxes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import dist, radians
from typing import Any

import numpy as np
from flint import arb

from rpr_solver.boxes import Boxes, Jet
from rpr_solver.boxes.sieve import Expansion
from rpr_solver.verify.arcs import Controls, along
from rpr_solver.verify.claims import demand
from rpr_solver.verify.equations import Jets, Lengths
from rpr_solver.verify.work import Work

_PARTS, _BATCH, _BOXES_OF_A_UNIT = 8, 4096, 8
_FARTHEST = 360
"""In degrees; no poses of a slice are so far apart."""
_MORE = 1 + 2.0**-40
"""More than all roundings of a distance make of it."""


def bend_bound(space: Lengths, length: arb) -> arb:
    """A bound of the second derivatives of J in directions of length 1 in (α, θ), for a length in units.

    That of a wave Re(c exp(i (j α + k θ))) is at most |c| (j² + k²).
    """
    form, bound = space.mechanism.legs.singular, arb(0)
    for waves, size in ((form.still, arb(1)), (form.moving, abs(length))):
        for (j, k), c in waves.items():
            bound += size * c.abs_upper() * (j * j + k * k)
    return bound


def is_clear(j: Jets, bend: arb, radius: arb) -> bool:
    """Whether J ≠ 0 at all poses that are no farther in (α, θ) from one than a radius in radians.

    |J| ≥ |J₀| − |∇J₀| r − M r² / 2 at the distance r, M being the bound of its second derivatives.
    """
    alpha, theta = j.gradient[:2]
    slope = (alpha * alpha + theta * theta).sqrt()
    return bool(abs(j.value) - slope * radius - bend * radius * radius / 2 > 0)


@dataclass(frozen=True)
class _Beside:
    """J at poses beside an arc, as a function of (x, y, s): at α(τ) + x, θ(τ) + y, L(τ) with τ = s / size."""

    space: Lengths
    controls: Controls
    size: float

    def __call__(self, box: Any, order: int) -> Sequence[Jets]:
        x, y, s = box
        (alpha, theta, length), slopes = along(self.controls, s * (1 / self.size))
        j = self.space.on([alpha + x, theta + y, length], order).singular
        if not order:
            return [j]
        first, second, third = (slope * step for slope, step in zip(j.gradient, slopes, strict=True))
        return [Jet(3, 1, [j.value, *j.gradient[:2], (first + second + third) * (1 / self.size)])]


def keeps_clear(space: Lengths, arcs: Sequence[Controls], sign: int, degrees: Fraction, work: Work) -> str:
    """Proves that J keeps its sign at all poses that are nearer to poses of arcs than an angle.

    Boxes of (x, y, s) are cut until J has the sign on each, or it is farther away. Invariant: each point with
    the other sign, or 0, is in a box of ``todo``. It ends when the work does, at the latest.

    Raises:
        Open: it is not decided with the work that is left.
        Refused: J has the other sign at a pose that is nearer.
    """
    demand(degrees < _FARTHEST, "in each slice a singular pose is nearer, as the mean of J is 0")
    radius = radians(float(degrees))
    first, second, third = (x.ravel() for x in np.indices((_PARTS,) * 3))
    low = np.array([first - _PARTS / 2, second - _PARTS / 2, third]) / _PARTS
    for controls in arcs:
        size = _length(controls)
        scale = np.array([[2 * radius * _MORE], [2 * radius * _MORE], [size * _MORE]])
        beside, todo = _Beside(space, controls, size), [Boxes(low * scale, (low + 1 / _PARTS) * scale)]
        while todo:
            boxes = todo.pop()
            work.spend(1 + len(boxes) // _BOXES_OF_A_UNIT)
            distance = np.hypot(*np.maximum(abs(boxes.middle[:2]) - boxes.radius[:2], 0))
            boxes = boxes[distance <= radius * _MORE]
            expansion = Expansion.of(beside, boxes)
            value, error = expansion.values.mid[0] * sign, expansion.values.rad[0]
            other = (value < -error) & (np.hypot(*boxes.middle[:2]) * _MORE < radius)
            demand(not other.any(), "J has the other sign nearer to it")
            halves = boxes[~(expansion.excluded & (value > 0))].halved()
            todo += [halves[k : k + _BATCH] for k in range(0, len(halves), _BATCH)]
    return "on boxes beside the arcs, by balls in doubles"


def _length(controls: Controls) -> float:
    """About that of the polygon of control points in (α, θ), but no 0."""
    return max(1e-6, sum(dist(*([float(x) for x in p[:2]] for p in pair)) for pair in pairwise(controls)))
