"""The solver, loaded before the fork: otherwise each work horse would load it anew."""

from __future__ import annotations

from importlib import import_module

import rpr_solver


def load_solver() -> None:
    """Import all of the solver; its package loads a room only when a name in it is first used."""
    for name in dir(rpr_solver):
        getattr(rpr_solver, name)
    import_module("worker.answers.pictures")
