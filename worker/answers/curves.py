"""Cusp curves: the whole curves are computed and kept; their parts and samples start from them."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import ALL_LENGTHS, JobRequest, Kind, content_range
from worker.answers.store import ResultStore

KIND = Kind("cusp-curves", "cc-")

Document = dict[str, Any]


def derive(request: JobRequest, store: ResultStore) -> Document | None:
    """Returns a part of known curves without further points, else None."""
    content = request.content
    if content["lengths"] or content["samples"] is not None:
        return None
    whole = store.get_document(_whole(request))
    return (
        None
        if whole is None
        else rpr_solver.CuspCurves.from_json(whole).within(*content_range(content)).to_json()
    )


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute curves; the whole ones are kept for other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return part(request, store, progress).to_json()


def part(request: JobRequest, store: ResultStore, progress: Progress) -> rpr_solver.CuspCurves:
    """Compute the same, not as a document."""
    content = request.content
    steps = 0

    def follow(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    def solve() -> Document:
        return rpr_solver.cusp_curves(
            request.manipulator, fixed_leg=request.fixed_leg, digits=request.digits, progress=follow
        ).to_json()

    whole = rpr_solver.CuspCurves.from_json(store.document(_whole(request), solve))
    return whole.part(
        *content_range(content),
        lengths=[Fraction(x) for x in content["lengths"]],
        samples=content["samples"],
        progress=lambda done, total: progress(steps + done, steps + total),
    )


def _whole(request: JobRequest) -> JobRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return JobRequest(KIND, content)
