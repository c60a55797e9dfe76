"""Changes of assembly mode on a grid of poses, in floats and by definition alone: a witness of the solver.

Cells of the grid are joined where J cannot vanish between them and the joint limits are kept, so that cells
of one component are poses of one aspect. Joint vectors of cells are taken at random; two poses of one of them
in one component show that the mode can change. That none is found proves nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from rpr_solver import Manipulator
from tests.support.oracle import free_legs_of, singularity

Limits = Mapping[int, tuple[float, float]]


@dataclass(frozen=True)
class ModeGrid:
    """A grid of poses of a slice, or of a range of the fixed leg."""

    manipulator: Manipulator
    leg: int
    span: tuple[float, float]
    limits: Limits
    size: int = 180
    lengths: int = 24

    def change(self, trials: int, seed: int) -> tuple[float, float, float] | None:
        """The fixed leg and the free legs of a joint vector with two poses in one component, or None."""
        legs = free_legs_of(self.manipulator, self.leg)
        low, high = self.span
        levels = np.array([low]) if low == high else np.linspace(low, high, self.lengths)
        angles = (np.arange(self.size) + 0.37) * (2 * np.pi / self.size)
        level, theta, alpha = np.meshgrid(levels, angles, angles, indexing="ij")
        j = singularity(legs, level, alpha, theta)
        allowed = self._allowed(legs, alpha, theta, level)
        labels = _labels(np.where(_sure(j) & allowed, np.sign(j), 0).astype(int))
        cells = np.argwhere(labels >= 0)
        if not len(cells):
            return None
        for n in np.random.default_rng(seed).integers(0, len(cells), trials):
            k, row, column = cells[n]
            ends = _free(legs, angles[column], angles[row], levels[k])
            places = [self._cell(alpha, theta) for alpha, theta in poses_of(legs, levels[k], ends)]
            for one, other in combinations(places, 2):
                if one != other and labels[k][one] == labels[k][other] >= 0:
                    return (float(levels[k]), *map(float, ends))
        return None

    def _cell(self, alpha: float, theta: float) -> tuple[int, int]:
        row, column = (round(x * self.size / (2 * np.pi) - 0.37) % self.size for x in (theta, alpha))
        return row, column

    def _allowed(self, legs: Any, alpha: Any, theta: Any, length: Any) -> Any:
        numbers = [leg for leg in (1, 2, 3) if leg != self.leg]
        allowed = np.ones(alpha.shape, dtype=bool)
        for number, value in zip(numbers, _free(legs, alpha, theta, length), strict=True):
            low, high = self.limits.get(number, (0.0, np.inf))
            slack = max(float(abs(np.diff(value, axis=k)).max()) for k in (1, 2))
            allowed &= (value > low + slack) & (value < high - slack)
        return allowed


def _free(legs: Any, alpha: Any, theta: Any, length: Any) -> list[Any]:
    return [abs(length * np.exp(1j * theta) + x * np.exp(1j * alpha) - a) for x, a in legs]


def _sure(j: Any) -> Any:
    """Where J is so large that it keeps its sign half way to the next cells."""
    steps = [abs(np.roll(j, 1, axis) - j) for axis in (1, 2)]
    steps += [abs(np.roll(j, -1, axis) - j) for axis in (1, 2)]
    if len(j) > 1:
        steps.append(np.broadcast_to(abs(np.diff(j, axis=0)).max(axis=0), j.shape))
    return abs(j) > 1.5 * np.maximum.reduce(steps)


def _labels(sign: Any) -> Any:
    """The components of cells of one sign ≠ 0: numbers, −1 elsewhere; two angles are periodic."""
    count = sign.size
    labels = np.where(sign != 0, np.arange(count).reshape(sign.shape), -1)
    while True:
        before = labels.copy()
        for axis in range(3):
            for step in (1, -1):
                other, kind = np.roll(labels, step, axis), np.roll(sign, step, axis)
                same = (kind == sign) & (sign != 0)
                if axis == 0:
                    same[0 if step == 1 else -1] = False
                labels = np.where(same, np.maximum(labels, other), labels)
        flat = labels.ravel()
        inside = flat >= 0
        flat[inside] = flat[flat[inside]]
        if (labels == before).all():
            return labels


def poses_of(legs: Any, length: float, ends: list[float]) -> Iterator[tuple[float, float]]:
    """α and θ of the poses of a joint vector, those that floats tell from others.

    Each free leg gives 2 Re(B conj v) = c with v = z x − a, so B solves two linear equations, and |B| = L is
    a polynomial of degree 6 in z.
    """
    scale = max(length, *(abs(w) for pair in legs for w in pair))
    z = np.exp(2j * np.pi * np.arange(16) / 16)

    def terms(z: Any) -> tuple[Any, Any, Any, Any, Any]:
        v, w = ((z * x - a) / scale for x, a in legs)
        c, d = (
            (end / scale) ** 2 - (length / scale) ** 2 - abs(u) ** 2
            for end, u in zip(ends, (v, w), strict=True)
        )
        return v, w, c, d, (np.conj(v) * w).imag

    v, w, c, d, cross = terms(z)
    values = abs(c * w - d * v) ** 2 - 4 * (length / scale) ** 2 * cross**2
    powers = np.fft.fft(values) / 16
    polynomial = [powers[k] for k in (3, 2, 1, 0, -1, -2, -3)]
    if abs(polynomial[0]) < 1e-9 * max(map(abs, polynomial)):
        return
    for root in np.roots(polynomial):
        if abs(abs(root) - 1) < 1e-8:
            v, w, c, d, cross = terms(root / abs(root))
            if abs(cross) > 1e-9:
                point = 1j * (d * v - c * w) / (2 * cross)
                alpha, theta = float(np.angle(root)), float(np.angle(point))
                near = _free(legs, alpha, theta, length)
                if max(abs(x - y) for x, y in zip(near, ends, strict=True)) < 1e-6 * scale:
                    yield alpha, theta
