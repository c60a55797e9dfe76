"""What is loaded before the fork: otherwise each work horse would load it anew."""

from __future__ import annotations

import os
from importlib import import_module

import rpr_solver


def load_solver() -> None:
    """Import all of the solver; its package loads a room only when a name in it is first used."""
    for name in dir(rpr_solver):
        getattr(rpr_solver, name)
    import_module("worker.answers.pictures")


def load_numpy() -> None:
    """Import numpy, by which the solver does many slices at once; without threads, which no fork survives."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    import_module("numpy")
