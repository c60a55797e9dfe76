"""Assembly modes: whether they can change without a singularity."""

from __future__ import annotations

from dataclasses import replace

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.cost import Sizes, all_events, elimination, one_slice
from worker.answers.requests import Content, Document, JobRequest, Kind, Store

_PAIRS = 1.5
"""Seconds of the proof that no folds meet."""
_SLICES = 3


def compute(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Decide whether two poses of one joint vector are joined, in a slice or in a range.

    Raises:
        SolverError: the slices could not be decided.
    """
    content = request.content
    ends = content.get("range")
    return rpr_solver.assembly_modes(
        request.manipulator,
        content.get("length"),
        between=ends and (ends["from"], ends["to"]),
        limits={leg: (part["min"], part["max"]) for leg, part in content.get("limits", {}).items()},
        fixed_leg=request.fixed_leg,
    ).to_json()


def _measure(content: Content, size: Sizes) -> Sizes:
    return replace(size, censuses=int("range" in content), limited=int("limits" in content))


def _cost(size: Sizes) -> float:
    """A loop round a cusp or the pairs of folds, the regions, and the census of a range."""
    slices = _SLICES * one_slice(size) * (1 + 2 * size.censuses)
    proofs = 0.3 + _PAIRS * (size.censuses + size.limited) + 0.015 * size.nearness
    return elimination(size) + slices + proofs + size.censuses * all_events(size)


MODES = Kind("assembly-modes", "am-", compute, _cost, measure=_measure)
