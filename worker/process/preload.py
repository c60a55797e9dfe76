"""What is loaded before the fork, else each work horse would load it anew; numpy only if it is wanted."""

from __future__ import annotations

import os
from importlib import import_module

import rpr_solver

_FEWEST_FOR_NUMPY = 64


def load_solver() -> None:
    """Import all of the solver; its package loads a room only when a name in it is first used."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # no threads: no fork survives them
    for name in dir(rpr_solver):
        getattr(rpr_solver, name)
    import_module("worker.answers.pictures")


def load_numpy() -> None:
    """Import numpy, by which the solver does many slices at once: a tenth of a second, and 13 MB."""
    import_module("numpy")


class ExpectedSlices:
    """Counts the slices that a work horse is asked for, in whatever tables, until they repay numpy."""

    def __init__(self) -> None:
        self._count = 0

    def add(self, count: int) -> None:
        """Load numpy once they are many."""
        if self._count < _FEWEST_FOR_NUMPY <= self._count + count:
            load_numpy()
        self._count += count
