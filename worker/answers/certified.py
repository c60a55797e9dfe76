"""Documents with full certificates, for those who check them; they are computed in one piece."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver.contract import FULL, Progress
from worker.answers import censuses, curves
from worker.answers.requests import JobRequest, Kind, content_range
from worker.answers.store import ResultStore

KIND = Kind("certified-table", "cf-", unit="slices")
CENSUS = Kind("certified-census", "cn-")
CURVES = Kind("certified-curves", "cv-")
KINDS = (KIND, CENSUS, CURVES)


def compute(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute a table."""
    return rpr_solver.table_document(
        request.manipulator,
        request.content["l1"],
        fixed_leg=request.fixed_leg,
        digits=request.digits,
        certificate=FULL,
        progress=progress,
    )


def compute_census(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute a census.

    Raises:
        SolverError: a transition could not be decided.
    """
    return censuses.solved(request, *content_range(request.content), progress, FULL)


def compute_curves(request: JobRequest, store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute cusp curves; the whole ones are kept without a certificate.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return curves.part(request, store, progress).to_json(certificate=FULL, progress=progress)
