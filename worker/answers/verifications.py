"""Verifications of documents, by independent means."""

from __future__ import annotations

from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("verification", "ve-")


def compute(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Verify a document; nothing that is kept is used.

    Raises:
        InputError: it is no document that can be verified.
    """
    document, effort = request.content["document"], request.content.get("effort", 1)
    verification = rpr_solver.verify_document(document, effort=effort, progress=progress)
    return {**request.identity_json(), **verification.to_json()}
