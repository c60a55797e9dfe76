"""All poses of one joint vector."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("poses", "po-")


def compute(request: JobRequest, _store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute all poses, which takes milliseconds."""
    lengths = (request.content[leg] for leg in ("l1", "l2", "l3"))
    return rpr_solver.poses(request.manipulator, *lengths, digits=request.digits).to_json()
