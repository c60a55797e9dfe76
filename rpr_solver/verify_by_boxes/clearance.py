"""Clearance: how far poses are from all singular poses with their length of the fixed leg, at least."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import dist, radians

import numpy as np
from flint import arb

from rpr_solver.boxes import Boxes, Jet
from rpr_solver.boxes.sieve import Expansion
from rpr_solver.verify_by_boxes.arcs import Controls, along
from rpr_solver.verify_by_boxes.claims import demand
from rpr_solver.verify_by_boxes.equations import Anywhere, Jets, Lengths
from rpr_solver.verify_by_boxes.work import Work

_PARTS, _BATCH, _BOXES_OF_A_UNIT = 8, 4096, 8
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
    """J at poses beside an arc, as a function of (x, y, τ): at α(τ) + x, θ(τ) + y, L(τ)."""

    space: Lengths
    controls: Controls

    def __call__(self, box: Anywhere, order: int) -> Sequence[Jets]:
        x, y, tau = box
        (alpha, theta, length), slopes = along(self.controls, tau)
        j = self.space.on([alpha + x, theta + y, length], order).singular
        if not order:
            return [j]
        first, second, third = (slope * step for slope, step in zip(j.gradient, slopes, strict=True))
        return [Jet(3, 1, [j.value, *j.gradient[:2], first + second + third])]


def keeps_clear(space: Lengths, arcs: Sequence[Controls], sign: int, degrees: Fraction, work: Work) -> str:
    """Proves that J keeps its sign at all poses that are nearer to poses of arcs than an angle.

    Boxes of (x, y, τ) are cut until J has the sign on each, or it is farther away. Invariant: each point with
    the other sign, or 0, is in a box of ``todo``. It ends when the work does, at the latest.

    Raises:
        OpenError: it is not decided with the work that is left.
        RefusedError: J has the other sign at a pose that is nearer.
    """
    radius = radians(float(degrees))
    first, second, third = (x.ravel() for x in np.indices((_PARTS,) * 3))
    low = np.array([first - _PARTS / 2, second - _PARTS / 2, third]) / _PARTS
    scale = np.array([[2.0 * radius * _MORE], [2.0 * radius * _MORE], [1.0]])
    whole = Boxes(low * scale, (low + 1 / _PARTS) * scale)
    for controls in arcs:
        beside, weights = _Beside(space, controls), np.array([[1.0], [1.0], [_length(controls)]])
        todo = [whole]
        while todo:
            boxes = todo.pop()
            work.spend(1 + len(boxes) // _BOXES_OF_A_UNIT)
            boxes = boxes[
                np.hypot(*np.maximum(abs(boxes.middle[:2]) - boxes.radius[:2], 0)) <= radius * _MORE
            ]
            expansion = Expansion.of(beside, boxes)
            value, error = expansion.values.mid[0] * sign, expansion.values.rad[0]
            other = (value < -error) & (np.hypot(*boxes.middle[:2]) * _MORE < radius)
            demand(not other.any(), "J has the other sign nearer to it")
            rest = boxes[~(expansion.excluded & (value > 0))]
            halves = rest.halves((rest.radius * weights).argmax(0))
            todo += [halves[k : k + _BATCH] for k in range(0, len(halves), _BATCH)]
    return "on boxes beside the arcs, by balls in doubles"


def _length(controls: Controls) -> float:
    """About that of the polygon of control points in (α, θ), but no 0."""
    return max(1e-6, sum(dist(*([float(x) for x in p[:2]] for p in pair)) for pair in pairwise(controls)))
