"""Cusp tables with full certificates, for those who check them."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("certified-table", "cf-", unit="slices")


def compute(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute a table in one piece."""
    return rpr_solver.table_document(
        request.manipulator,
        request.content["l1"],
        fixed_leg=request.fixed_leg,
        digits=request.digits,
        certificate="full",
        progress=progress,
    )
