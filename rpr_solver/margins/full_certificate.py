"""The full certificate of a margin: how the proof cut its boxes, for a checker that decides each part itself.

    {"cuts": ["0101…20.3..", …], "turn": "…", "length": "…", "rates": {"a2x": "…", …}}

``cuts`` has a text for each problem. It tells what is done with the torus and all lengths that vary, then
with the lower half, then with the upper: a digit cuts a variable in two (0: α, 1: θ, 2: the fixed leg's
length, 3 to 8: a2x, a3x, a3y, d1, d2, d3; angles are from 0 to a turn), a dot stands for a part on which one
of the conditions of mathematics.md#margins holds. ``turn`` is the length from which on the second problem has
inverse lengths; ``length`` and ``rates`` say how the slice of a window moves with the lengths.

The parts are decided by slopes, as the checker decides them, which needs more parts than exclusion.py does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.margins.boxes import ANGLES, MayGoOn, Problem
from rpr_solver.margins.slope_search import SlopeSearch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.slopes import Doubles

    Places = NDArray[np.int64]

_PART = -1
_FIRST_CUTS = 10
"""The torus is cut so often before anything is tried."""
_BATCH = 2048


def cuts(problem: Problem, most_boxes: int, may_go_on: MayGoOn = lambda: True) -> str | None:
    """How a proof that no cusp degenerates cuts a problem; None if none is found with so many boxes."""
    low, high = problem.grid(1)
    search = SlopeSearch(problem)
    names = [*range(ANGLES), *(ANGLES + place for place in problem.rows)]
    levels: list[Places] = []
    boxes = 0
    while low.size:
        boxes += low.shape[1]
        if boxes > most_boxes or not may_go_on():
            return None
        variables = np.full(low.shape[1], len(levels) % ANGLES)
        if len(levels) >= _FIRST_CUTS:
            variables = _undecided(search, low, high)
        levels.append(variables)
        kept = np.flatnonzero(variables != _PART)
        halves = _halves(low[:, kept], high[:, kept], variables[kept])
        if halves is None:
            return None
        low, high = halves
    texts: list[str] = []
    for variables in reversed(levels):
        below = iter(texts)
        texts = ["." if k == _PART else f"{names[k]}{next(below)}{next(below)}" for k in variables]
    return texts[0]


def _undecided(search: SlopeSearch, low: Doubles, high: Doubles) -> Places:
    """For each box the variable along which to cut it."""
    variables = np.full(low.shape[1], _PART)
    with np.errstate(all="ignore"):
        for start in range(0, low.shape[1], _BATCH):
            here = slice(start, start + _BATCH)
            kept, chosen = search.undecided(low[:, here], high[:, here])
            variables[start + kept] = chosen
    return variables


def _halves(low: Doubles, high: Doubles, variables: Places) -> tuple[Doubles, Doubles] | None:
    """The halves of boxes, the lower one of each before the upper; None if one is too small to be cut."""
    every = np.arange(len(variables))
    middle = (low[variables, every] + high[variables, every]) / 2
    if not ((low[variables, every] < middle) & (middle < high[variables, every])).all():
        return None
    low, high = np.repeat(low, 2, axis=1), np.repeat(high, 2, axis=1)
    high[variables, 2 * every] = low[variables, 2 * every + 1] = middle
    return low, high
