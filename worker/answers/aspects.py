"""The aspects of a manipulator while the length of one leg varies within a range."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rpr_solver
from rpr_solver import Manipulator
from rpr_solver.contract import Progress, document_head
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("aspects", "as-")


def compute(request: JobRequest, _store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute the aspects, which takes a fraction of a second.

    Raises:
        SolverError: the ends of the range could not be compared.
    """
    return document(request.manipulator, request.content)


def document(manipulator: Manipulator, content: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the document that answers a question in canonical form.

    Raises:
        SolverError: the ends of the range could not be compared.
    """
    leg, ends = content["fixed_leg"], content["range"]
    found = rpr_solver.range_aspects(manipulator, ends["from"], ends["to"], fixed_leg=leg)
    return {
        **document_head(manipulator, content["digits"], leg),
        "range": dict(ends),
        "aspects": [aspect.to_json() for aspect in found],
    }
