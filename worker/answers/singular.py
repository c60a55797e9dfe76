"""The singular curves of a slice, with its regions and aspects."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore
from worker.answers.tables import eliminant_of

KIND = Kind("singular-curves", "sc-")


def compute(request: JobRequest, store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute the curves; the eliminant is kept.

    Raises:
        SolverError: the slice could not be decided, or has a curve that is not supported.
    """
    content = request.content
    eliminant = eliminant_of(request, store)
    return rpr_solver.trace_slice(
        eliminant, content["length"], tolerance=content["tolerance"], digits=request.digits
    ).to_json()
