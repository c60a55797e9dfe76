"""A parameter homotopy in double precision: the 24 solutions of a slice at a complex L1, followed to others.

The numerical peer of :mod:`benchmarks.peers`: Runge and Kutta's predictor and Newton's corrector with steps
of their own for each path, all paths of all slices at once by numpy. The solutions at the start are given to
it, and not counted. Nothing is proved: paths may jump to each other, and rounding decides which ends are
real.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from rpr_solver import Eliminant
from rpr_solver.slices.fast.poses import DoubleMap, float_of, map_exponent

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[Any]

START = 0.43 + 0.71j
"""The generic L1 of the start, in terms of the greatest length."""
TOLERANCE = 1e-9
LARGEST, SMALLEST = 0.1, 1e-7
"""Steps, of a path of length 1."""
ROUNDS = 2000


def forms(table: Numbers, t: Numbers, u: Numbers, length: Numbers) -> tuple[Numbers, ...]:
    """Value of a form and its derivatives by t, u and L, coefficients by powers of t, L and u."""
    powers = [x[:, None] ** np.arange(n) for x, n in zip((t, length, u), table.shape, strict=True)]
    slopes = [np.hstack([0 * p[:, :1], p[:, :-1] * np.arange(1, p.shape[1])]) for p in powers]
    over_u, along_u = np.einsum("ilk,nk->nil", table, powers[2]), np.einsum("ilk,nk->nil", table, slopes[2])

    def value(part: Numbers, first: Numbers, second: Numbers) -> Numbers:
        result: Numbers = np.einsum("nil,ni,nl->n", part, first, second)
        return result

    return (
        value(over_u, powers[0], powers[1]),
        value(over_u, slopes[0], powers[1]),
        value(along_u, powers[0], powers[1]),
        value(over_u, powers[0], slopes[1]),
    )


class Homotopy:
    """The system of one manipulator, and its solutions at the start."""

    def __init__(self, eliminant: Eliminant, lengths: Sequence[Fraction]) -> None:
        slice_map = eliminant.slice_map
        scaled = [x * slice_map.scale for x in lengths]
        self._exponent = map_exponent(slice_map, scaled)
        self._map = DoubleMap.of(slice_map, self._exponent)
        self._ends = np.array([float_of(x, self._exponent) for x in scaled])
        self._start = self._solutions(eliminant)

    def _solutions(self, eliminant: Eliminant) -> tuple[Numbers, Numbers]:
        """t and u at the start, by the eliminant in doubles, and Newton's iteration."""
        omega, unit = float(eliminant.slice_map.radicand) ** 0.5, 2.0**self._exponent
        rows = [
            [(float(x) + omega * float(y)) * unit**k for k, (x, y) in enumerate(zip(*pair, strict=True))]
            for pair in zip(eliminant.a.tolist(), eliminant.b.tolist(), strict=True)
        ]
        q = np.array(rows) @ START ** np.arange(11)
        us = np.roots(q[::-1])
        ts = []
        for u in us:
            j, e = (
                np.einsum(
                    "ilk,l,k->i", table, START ** np.arange(table.shape[1]), u ** np.arange(table.shape[2])
                )
                for table in (self._map.singular, self._map.coalescence)
            )
            roots = np.roots(j[::-1])
            ts.append(min(roots, key=lambda t, e=e: abs(np.polyval(e[::-1], t)) / (1 + abs(t)) ** 6))
        t, u, _ = self._corrected(np.array(ts), us, np.full(len(us), START), 6)
        return t, u

    def _slopes(self, t: Numbers, u: Numbers, length: Numbers, move: Numbers) -> tuple[Numbers, Numbers]:
        """How t and u move with the path."""
        (_, jt, ju, jl), (_, et, eu, el) = (
            forms(table, t, u, length) for table in (self._map.singular, self._map.coalescence)
        )
        whole = jt * eu - ju * et
        return -(jl * eu - ju * el) * move / whole, -(jt * el - jl * et) * move / whole

    def _corrected(
        self, t: Numbers, u: Numbers, length: Numbers, times: int
    ) -> tuple[Numbers, Numbers, Numbers]:
        """Newton's iteration, and the size of the last step."""
        size = np.zeros(len(t))
        for _ in range(times):
            (j, jt, ju, _), (e, et, eu, _) = (
                forms(table, t, u, length) for table in (self._map.singular, self._map.coalescence)
            )
            whole = jt * eu - ju * et
            dt, du = (j * eu - ju * e) / whole, (jt * e - j * et) / whole
            t, u = t - dt, u - du
            size = abs(dt) / (1 + abs(t)) + abs(du) / (1 + abs(u))
        return t, u, size

    def solve(self) -> tuple[float, list[list[tuple[float, float]]], int]:
        """Milliseconds, the real ends (t, u) of each slice, and the number of paths that were given up."""
        begin = time.process_time()
        count = len(self._ends)
        t, u = (np.tile(x, count) for x in self._start)
        move = np.repeat(self._ends, len(self._start[0])) - START
        place, step, good = np.zeros(len(t)), np.full(len(t), 0.05), np.zeros(len(t), dtype=int)
        with np.errstate(all="ignore"):
            for _ in range(ROUNDS):
                rest = np.flatnonzero((place < 1) & (step > SMALLEST))
                if not len(rest):
                    break
                h = np.minimum(step[rest], 1 - place[rest])
                at, by, x, y = START + place[rest] * move[rest], h * move[rest], t[rest], u[rest]
                k1 = self._slopes(x, y, at, by)
                k2 = self._slopes(x + k1[0] / 2, y + k1[1] / 2, at + by / 2, by)
                k3 = self._slopes(x + k2[0] / 2, y + k2[1] / 2, at + by / 2, by)
                k4 = self._slopes(x + k3[0], y + k3[1], at + by, by)
                x, y = (
                    z + (a + 2 * b + 2 * c + d) / 6
                    for z, a, b, c, d in zip((x, y), k1, k2, k3, k4, strict=True)
                )
                x, y, size = self._corrected(x, y, at + by, 2)
                done = size < TOLERANCE
                place[rest] += np.where(done, h, 0)
                t[rest], u[rest] = np.where(done, x, t[rest]), np.where(done, y, u[rest])
                good[rest] = np.where(done, good[rest] + 1, 0)
                step[rest] = np.where(done, np.where(good[rest] % 3 == 0, 2 * h, h), h / 2).clip(0, LARGEST)
            t, u, _ = self._corrected(t, u, START + move, 2)
        shape = count, -1
        ends = zip(*(x.reshape(shape) for x in (t, u, place >= 1)), strict=True)
        found = [
            [
                (a.real, b.real)
                for a, b, is_end in zip(*rows, strict=True)
                if is_end and abs(a.imag) < 1e-7 * (1 + abs(a)) and abs(b.imag) < 1e-7 * (1 + abs(b))
            ]
            for rows in ends
        ]
        return 1000 * (time.process_time() - begin), found, int((place < 1).sum())
