"""Censuses: the whole one is computed and kept, and every part of it is cut from what is known."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import Manipulator
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore
from worker.jobs.requests import ALL_LENGTHS, DocumentRequest, content_range, scan_content

Document = dict[str, Any]


def census_request(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = 90,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
) -> DocumentRequest:
    """The request for the census of a range of the fixed leg; without an end it is the whole one."""
    return DocumentRequest("census", scan_content(manipulator, fixed_leg, digits, start, stop))


def known_census(request: DocumentRequest, store: ResultStore) -> Document | None:
    """A census that follows from a whole one that is known with as many digits or more."""
    start, stop = content_range(request.content)
    for digits in store.census_digits(_family(request)):
        whole = store.get_document(_whole(request, digits)) if digits >= request.content["digits"] else None
        part = whole and rpr_solver.restrict_census(whole, start, stop, request.content["digits"])
        if part:
            return part
    return None


def compute_census(
    request: DocumentRequest, store: ResultStore, progress: Callable[[int, int], None]
) -> Document:
    """Compute a census; the whole one is kept for the sake of other ranges.

    Raises:
        SolverError: a transition could not be decided.
    """
    content, wanted = request.content, _whole(request, request.content["digits"])
    start, stop = content_range(content)

    def solved(start: Fraction, stop: Fraction | None) -> Document:
        return rpr_solver.census(
            Manipulator.from_json(content["geometry"]),
            fixed_leg=content["fixed_leg"],
            digits=content["digits"],
            start=start,
            stop=stop,
            progress=progress,
        ).to_json()

    def make() -> Document:
        found = solved(Fraction(0), None)
        store.put_document(wanted, found)
        store.note_census(_family(request), content["digits"])
        return found

    whole = single_flight(lambda: store.get_document(wanted), lambda: store.document_lock(wanted), make)
    part = rpr_solver.restrict_census(whole, start, stop)
    # decimals do not tell an end of the range from a transition that is very near, or the same
    return solved(start, stop) if part is None else part


def _whole(request: DocumentRequest, digits: int) -> DocumentRequest:
    return DocumentRequest("census", {**request.content, "digits": digits, "range": ALL_LENGTHS})


def _family(request: DocumentRequest) -> DocumentRequest:
    """Stands for the census of one manipulator and one leg at any number of digits."""
    content = request.content
    return DocumentRequest("census", {"geometry": content["geometry"], "fixed_leg": content["fixed_leg"]})
