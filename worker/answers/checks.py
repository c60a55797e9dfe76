"""Checks: requirements on the number of cusps, proved or refuted."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver import Requirement
from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("check", "ch-")


def compute(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Prove or refute a requirement.

    Raises:
        SolverError: it could not be decided.
    """
    requirement = Requirement.from_json(request.content["requirement"], max_digits=1 << 20)
    return rpr_solver.check(
        request.manipulator, requirement, digits=request.digits, progress=progress
    ).to_json()
