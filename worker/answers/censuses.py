"""Censuses: the whole census is computed and kept, and its parts are cut from it."""

from __future__ import annotations

from dataclasses import replace

import rpr_solver
from rpr_solver.contract import FULL, SHORT, Progress
from worker.answers.cost import Sizes, all_events
from worker.answers.requests import (
    ALL_LENGTHS,
    Content,
    Document,
    JobRequest,
    Kind,
    Store,
    answer,
    content_range,
    known_document,
)

SENSITIVITIES, TOLERANCE = "sensitivities", "tolerance"
"""Members of a question about the same census: for the sensitivities of its events, or all geometries within
a tolerance."""
_BOXES_SECONDS = 6.0


def derive(request: JobRequest, store: Store) -> Document | None:
    """Returns a census that follows from known ones, else None: from the whole one with as many digits or
    more; with sensitivities from the same without them."""
    return _cut(request, store) if _is_plain(request) else _moved(request, store)


def _is_plain(request: JobRequest) -> bool:
    return SENSITIVITIES not in request.content and TOLERANCE not in request.content


def _without(request: JobRequest, member: str) -> JobRequest:
    content = {name: value for name, value in request.content.items() if name != member}
    return replace(request, content=content)


def _moved(request: JobRequest, store: Store) -> Document | None:
    """Returns a census with sensitivities that follows from the same without them, else None."""
    if SENSITIVITIES not in request.content:
        return None
    plain = known_document(_without(request, SENSITIVITIES), store)
    return None if plain is None else rpr_solver.with_sensitivities(plain)


def _with_more(request: JobRequest, store: Store, progress: Progress) -> Document:
    """The same census with sensitivities, or for all geometries within a tolerance."""
    if SENSITIVITIES in request.content:
        return rpr_solver.with_sensitivities(answer(_without(request, SENSITIVITIES), store, progress))
    part = answer(_without(request, TOLERANCE), store, progress)
    whole = answer(_whole(request, request.digits), store, progress)
    return rpr_solver.within_tolerance(whole, part, request.content[TOLERANCE], progress=progress).to_json()


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
    if not _is_plain(request):
        return _with_more(request, store, progress)
    if not store.keeps:
        return solved(request, store, progress)
    whole = store.document(
        _whole(request, request.digits), lambda: solved(_whole(request, request.digits), store, progress)
    )
    store.note_census(_family(request), request.digits)
    if request == _whole(request, request.digits):
        return whole
    part = rpr_solver.restrict_census(whole, *content_range(request.content))
    # None: the decimals do not separate an end of the range from a transition that is very near or equal
    return solved(request, store, progress) if part is None else part


def certified(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute a census with a full certificate.

    Raises:
        SolverError: a transition could not be decided.
    """
    if not _is_plain(request):
        return _with_more(request, store, progress)
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
    """Returns the request for the census of all lengths."""
    of = {"geometry": request.geometry, "fixed_leg": request.fixed_leg}
    return JobRequest(CENSUS, {**of, "digits": digits, "range": ALL_LENGTHS})


def _family(request: JobRequest) -> JobRequest:
    """Returns a request that stands for the census of a manipulator and a leg at any number of digits."""
    return JobRequest(CENSUS, {"geometry": request.geometry, "fixed_leg": request.fixed_leg})


def _measure(content: Content, size: Sizes) -> Sizes:
    return replace(size, censuses=1) if TOLERANCE in content else size


def _cost(size: Sizes) -> float:
    return all_events(size) + (_BOXES_SECONDS if size.censuses else 0)


CENSUS = Kind("census", "ce-", compute, _cost, derive=derive, measure=_measure)
CERTIFIED_CENSUS = Kind(
    "certified-census",
    "cn-",
    certified,
    _cost,
    derive=_moved,
    measure=_measure,
    implied=("certificate", FULL),
)
