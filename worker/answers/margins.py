"""Margins: how far the lengths of a geometry may change."""

from __future__ import annotations

from dataclasses import replace

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.censuses import CENSUS
from worker.answers.cost import Sizes
from worker.answers.requests import Document, JobRequest, Kind, Store

_CENSUSES = 6
"""Censuses and slices of other geometries, in the search for a counter-example."""
_BOXES_SECONDS = 4.0


def margin(request: JobRequest, _store: Store, progress: Progress) -> Document:
    """Compute the margin of a slice, of a requirement or of a window.

    Raises:
        SolverError: the geometry itself could not be decided.
    """
    content = request.content
    requirement = content.get("requirement")
    return rpr_solver.margin(
        request.manipulator,
        content.get("length"),
        requirement=None if requirement is None else rpr_solver.Requirement.from_json(requirement),
        window=content.get("window"),
        fixed_leg=request.fixed_leg,
        weights=content.get("weights"),
        tolerance=content.get("tolerance"),
        progress=progress,
    ).to_json()


def _cost(size: Sizes) -> float:
    return _BOXES_SECONDS + _CENSUSES * CENSUS.cost(replace(size, digits=max(size.digits, 30)))


MARGIN = Kind("margin", "ma-", margin, _cost, unit="boxes")
