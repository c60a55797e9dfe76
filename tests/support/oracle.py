"""The kinematics of a slice in floats, by definition alone: a witness that shares nothing with the solver.

Points are complex numbers, seen from the fixed leg: z = e^{iα} turns the platform, and B = L e^{iθ}.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from rpr_solver import Manipulator
from tests.support.triangle_oracle import corners_of

_ON_CIRCLE, _OFF_CIRCLE, _APART = 1e-7, 1e-4, 1e-3


def free_legs_of(manipulator: Manipulator, leg: int) -> list[tuple[complex, complex]]:
    """For each free leg the vectors from the fixed leg to it, of the platform and of the base."""
    base, platform = (list(map(complex, corners)) for corners in corners_of(manipulator.geometry))
    own, foot = platform.pop(leg - 1), base.pop(leg - 1)
    return [(x - own, a - foot) for x, a in zip(platform, base, strict=True)]


def singularity(legs: list[tuple[complex, complex]], length: float, alpha: Any, theta: Any) -> Any:
    """J / L at angles or arrays of them."""
    along, across = [], []
    for x, a in legs:
        turned = x * np.exp(1j * alpha)
        end = length * np.exp(1j * theta) + turned - a
        along.append((np.conj(end) * 1j * turned).real)
        across.append((np.conj(end) * 1j * np.exp(1j * theta)).real)
    return along[0] * across[1] - along[1] * across[0]


class FloatManipulator:
    """A manipulator with one leg fixed, its lengths divided by the largest."""

    def __init__(self, manipulator: Manipulator, leg: int, length: float) -> None:
        legs = free_legs_of(manipulator, leg)
        self.size = max(length, *(abs(v) for pair in legs for v in pair))
        self.length = length / self.size
        self.legs = [(x / self.size, a / self.size) for x, a in legs]

    def singularity(self, alpha: Any, theta: Any) -> Any:
        """J / L at angles or arrays of them."""
        return singularity(self.legs, self.length, alpha, theta)

    def number_of_poses(self, first: float, second: float) -> int | None:
        """The poses of a joint vector; None if floats do not decide it.

        Both free legs give |B|² + 2 Re(B conj v) + |v|² with v = z x − a, so B solves two linear equations,
        and |B| = L is a polynomial of degree 6 in z: its roots of size 1 are the poses.
        """
        angles = 2 * np.pi * np.arange(16) / 16
        z = np.exp(1j * angles)
        v = [z * x - a for x, a in self.legs]
        c = [
            (length / self.size) ** 2 - self.length**2 - abs(w) ** 2
            for length, w in zip((first, second), v, strict=True)
        ]
        cross = (np.conj(v[0]) * v[1]).imag
        values = abs(c[0] * v[1] - c[1] * v[0]) ** 2 - 4 * self.length**2 * cross**2
        terms = np.fft.fft(values) / 16
        polynomial = [terms[k] for k in (3, 2, 1, 0, -1, -2, -3)]
        if abs(polynomial[0]) < 1e-9 * max(map(abs, polynomial)):
            return None
        roots = list(np.roots(polynomial))
        (x, a), (y, b) = self.legs
        if abs(x) > 0 and abs(abs(a / x) - 1) < 1e-12 and abs(a / x - b / y) < 1e-12:
            # congruent: where both v vanish, both sides of |B| = L do, and B is no solution
            if max(abs(k).min() for k in c) < 1e-6:
                return None
            roots.sort(key=lambda root: abs(root - a / x))
            if abs(roots[1] - a / x) > 1e-4 or abs(roots[2] - a / x) < _APART:
                return None
            del roots[:2]
        count = 0
        for k, root in enumerate(roots):
            off = abs(abs(root) - 1)
            if min((abs(root - other) for i, other in enumerate(roots) if i != k), default=1.0) < _APART:
                return None
            if _ON_CIRCLE < off < _OFF_CIRCLE:
                return None
            count += off <= _ON_CIRCLE
        return count

    def is_narrow(self, size: int) -> bool:
        """Whether J is nearly critical where it is nearly 0, on a grid of size² poses: at a node, or where an
        aspect is narrower than the grid."""
        j, bend = self._grid(size)
        slopes = [abs(np.roll(j, 1, axis) - np.roll(j, -1, axis)) / 2 for axis in (0, 1)]
        return bool(((abs(j) < bend / 2) & (slopes[0] < bend) & (slopes[1] < bend)).any())

    def _grid(self, size: int) -> tuple[Any, float]:
        """J on a grid, and a bound of its second differences."""
        angles = 0.1234567 + np.arange(size) * (2 * np.pi / size)
        j = self.singularity(*np.meshgrid(angles, angles))
        ends = [np.take(j, (0, 1), axis=axis) for axis in (0, 1)]
        return j, max(float(abs(np.diff(j, 2, axis=k, append=end)).max()) for k, end in enumerate(ends))

    def aspects(self, size: int) -> int:
        """The number of components of J ≠ 0 on a grid of size² poses.

        Neighbours are joined only where J is so large that it cannot change its sign between them, so that
        nothing leaks through a node; what is narrower than the grid is lost.
        """
        j, bend = self._grid(size)
        sign = np.where(abs(j) > bend / 4, np.sign(j), 0).astype(int)
        return _components(sign)


def _components(sign: Any) -> int:
    """Of the cells of one sign ≠ 0 on a torus, without specks of a few cells."""
    above: list[int] = []
    cells: list[int] = []

    def root(k: int) -> int:
        while above[k] != k:
            above[k] = above[above[k]]
            k = above[k]
        return k

    rows = []
    size = len(sign)
    for row in sign:
        cuts = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), size]
        runs = []
        for low, high in pairwise(cuts):
            if row[low]:
                above.append(len(above))
                cells.append(high - low)
                runs.append((low, high, int(row[low]), len(above) - 1))
        if len(runs) > 1 and runs[0][0] == 0 and runs[-1][1] == size and runs[0][2] == runs[-1][2]:
            above[root(runs[-1][3])] = root(runs[0][3])
        rows.append(runs)
    for one, other in zip(rows, [*rows[1:], rows[0]], strict=True):
        k = 0
        for low, high, kind, name in one:
            while k and other[k - 1][1] > low:
                k -= 1
            while k < len(other) and other[k][1] <= low:
                k += 1
            i = k
            while i < len(other) and other[i][0] < high:
                if other[i][2] == kind:
                    above[root(name)] = root(other[i][3])
                i += 1
    found: dict[int, int] = {}
    for k, number in enumerate(cells):
        found[root(k)] = found.get(root(k), 0) + number
    return sum(number > 3 for number in found.values())
