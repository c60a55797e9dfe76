"""Censuses: the whole census is computed and kept, and its parts are cut from it."""

from __future__ import annotations

from dataclasses import replace

import rpr_solver
from rpr_solver.contract import FULL, SHORT, Progress
from worker.answers.cost import all_events
from worker.answers.requests import ALL_LENGTHS, Document, JobRequest, Kind, Store, content_range
from worker.answers.store import answer, known_document

SENSITIVITIES = "sensitivities"
"""The member of a question for a census whose events have their sensitivities."""


def derive(request: JobRequest, store: Store) -> Document | None:
    """Returns a census that follows from known ones, else None: from the whole one with as many digits or
    more; with sensitivities from the same without them."""
    return _moved(request, store) if _asks_for_sensitivities(request) else _cut(request, store)


def _asks_for_sensitivities(request: JobRequest) -> bool:
    return SENSITIVITIES in request.content


def _without_sensitivities(request: JobRequest) -> JobRequest:
    content = {name: value for name, value in request.content.items() if name != SENSITIVITIES}
    return replace(request, content=content)


def _moved(request: JobRequest, store: Store) -> Document | None:
    """Returns a census with sensitivities that follows from the same without them, else None."""
    if not _asks_for_sensitivities(request):
        return None
    plain = known_document(_without_sensitivities(request), store)
    return None if plain is None else rpr_solver.with_sensitivities(plain)


def _cut(request: JobRequest, store: Store) -> Document | None:
    start, stop = content_range(request.content)
    for digits in store.census_digits(_family(request)):
        whole = store.get_document(_whole(request, digits)) if digits >= request.digits else None
        part = whole and rpr_solver.restrict_census(whole, start, stop, request.digits)
        if part:
            return part
    return None


def compute(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute a census; the whole one is kept for other ranges.

    Raises:
        SolverError: a transition could not be decided.
    """
    if _asks_for_sensitivities(request):
        return rpr_solver.with_sensitivities(answer(_without_sensitivities(request), store, progress))
    if not store.keeps:
        return solved(request, store, progress)
    whole = store.document(
        _whole(request, request.digits), lambda: solved(_whole(request, request.digits), store, progress)
    )
    store.note_census(_family(request), request.digits)
    part = rpr_solver.restrict_census(whole, *content_range(request.content))
    # None: the decimals do not separate an end of the range from a transition that is very near or equal
    return solved(request, store, progress) if part is None else part


def certified(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute a census with a full certificate.

    Raises:
        SolverError: a transition could not be decided.
    """
    if _asks_for_sensitivities(request):
        return rpr_solver.with_sensitivities(answer(_without_sensitivities(request), store, progress))
    return solved(request, store, progress, FULL)


def solved(request: JobRequest, _store: Store, progress: Progress, certificate: str = SHORT) -> Document:
    """The census of a range, computed from scratch.

    Raises:
        SolverError: a transition could not be decided.
    """
    start, stop = content_range(request.content)
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
    return JobRequest(CENSUS, {**request.content, "digits": digits, "range": ALL_LENGTHS})


def _family(request: JobRequest) -> JobRequest:
    """Returns a request that stands for the census of a manipulator and a leg at any number of digits."""
    return JobRequest(CENSUS, {"geometry": request.geometry, "fixed_leg": request.fixed_leg})


CENSUS = Kind("census", "ce-", compute, all_events, derive=derive)
CERTIFIED_CENSUS = Kind(
    "certified-census",
    "cn-",
    certified,
    all_events,
    derive=_moved,
    implied=("certificate", FULL),
)
