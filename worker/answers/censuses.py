"""Censuses: the whole census is computed and kept, and its parts are cut from it."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import SHORT, Progress
from worker.answers.requests import ALL_LENGTHS, JobRequest, Kind, content_range
from worker.answers.store import ResultStore

KIND = Kind("census", "ce-")

Document = dict[str, Any]


def derive(request: JobRequest, store: ResultStore) -> Document | None:
    """Returns a census that follows from a known whole one with as many digits or more, else None."""
    start, stop = content_range(request.content)
    for digits in store.census_digits(_family(request)):
        whole = store.get_document(_whole(request, digits)) if digits >= request.digits else None
        part = whole and rpr_solver.restrict_census(whole, start, stop, request.digits)
        if part:
            return part
    return None


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute a census; the whole one is kept for other ranges.

    Raises:
        SolverError: a transition could not be decided.
    """
    start, stop = content_range(request.content)
    whole = store.document(
        _whole(request, request.digits), lambda: solved(request, Fraction(0), None, progress)
    )
    store.note_census(_family(request), request.digits)
    part = rpr_solver.restrict_census(whole, start, stop)
    # None: the decimals do not separate an end of the range from a transition that is very near or equal
    return solved(request, start, stop, progress) if part is None else part


def solved(
    request: JobRequest, start: Fraction, stop: Fraction | None, progress: Progress, certificate: str = SHORT
) -> Document:
    """The census of a range, computed anew.

    Raises:
        SolverError: a transition could not be decided.
    """
    return rpr_solver.census(
        request.manipulator,
        fixed_leg=request.fixed_leg,
        digits=request.digits,
        start=start,
        stop=stop,
        certificate=certificate,
        progress=progress,
    ).to_json()


def _whole(request: JobRequest, digits: int) -> JobRequest:
    return JobRequest(KIND, {**request.content, "digits": digits, "range": ALL_LENGTHS})


def _family(request: JobRequest) -> JobRequest:
    """Returns a request that stands for the census of a manipulator and a leg at any number of digits."""
    return JobRequest(KIND, {"geometry": request.geometry, "fixed_leg": request.fixed_leg})
