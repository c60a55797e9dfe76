"""Censuses: the whole one is computed and kept, and every part of it is cut from what is known."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.requests import ALL_LENGTHS, JobRequest, Kind, content_range
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore

KIND = Kind("census", "ce-")

Document = dict[str, Any]


def derive(request: JobRequest, store: ResultStore) -> Document | None:
    """A census that follows from a whole one that is known with as many digits or more."""
    start, stop = content_range(request.content)
    for digits in store.census_digits(_family(request)):
        whole = store.get_document(_whole(request, digits)) if digits >= request.digits else None
        part = whole and rpr_solver.restrict_census(whole, start, stop, request.digits)
        if part:
            return part
    return None


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute a census; the whole one is kept for the sake of other ranges.

    Raises:
        SolverError: a transition could not be decided.
    """
    whole_request = _whole(request, request.digits)
    start, stop = content_range(request.content)

    def solved(start: Fraction, stop: Fraction | None) -> Document:
        return rpr_solver.census(
            request.manipulator,
            fixed_leg=request.fixed_leg,
            digits=request.digits,
            start=start,
            stop=stop,
            progress=progress,
        ).to_json()

    def make() -> Document:
        census = solved(Fraction(0), None)
        store.put_document(whole_request, census)
        store.note_census(_family(request), request.digits)
        return census

    whole = single_flight(
        lambda: store.get_document(whole_request), lambda: store.document_lock(whole_request), make
    )
    part = rpr_solver.restrict_census(whole, start, stop)
    # decimals do not tell an end of the range from a transition that is very near, or the same
    return solved(start, stop) if part is None else part


def _whole(request: JobRequest, digits: int) -> JobRequest:
    return JobRequest(KIND, {**request.content, "digits": digits, "range": ALL_LENGTHS})


def _family(request: JobRequest) -> JobRequest:
    """Stands for the census of one manipulator and one leg at any number of digits."""
    return JobRequest(KIND, {"geometry": request.geometry, "fixed_leg": request.fixed_leg})
