"""Cusp curves: the whole ones are computed and kept; parts and samples of them set out from there."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import CuspCurves
from rpr_solver.contract import Progress
from worker.answers.requests import ALL_LENGTHS, JobRequest, Kind, content_range
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore

KIND = Kind("cusp-curves", "cc-")

Document = dict[str, Any]


def derive(request: JobRequest, store: ResultStore) -> Document | None:
    """A part of curves that are known, without other points."""
    content = request.content
    if content["lengths"] or content["samples"] is not None:
        return None
    whole = store.get_document(_whole(request))
    return None if whole is None else CuspCurves.from_json(whole).within(*content_range(content)).to_json()


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute curves; the whole ones are kept for the sake of other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    content, whole_request = request.content, _whole(request)
    steps = 0

    def on_the_way(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    def make() -> Document:
        curves = rpr_solver.cusp_curves(
            request.manipulator, fixed_leg=request.fixed_leg, digits=request.digits, progress=on_the_way
        ).to_json()
        store.put_document(whole_request, curves)
        return curves

    whole = single_flight(
        lambda: store.get_document(whole_request), lambda: store.document_lock(whole_request), make
    )
    return (
        CuspCurves.from_json(whole)
        .part(
            *content_range(content),
            lengths=[Fraction(x) for x in content["lengths"]],
            samples=content["samples"],
            progress=lambda done, total: progress(steps + done, steps + total),
        )
        .to_json()
    )


def _whole(request: JobRequest) -> JobRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return JobRequest(KIND, content)
