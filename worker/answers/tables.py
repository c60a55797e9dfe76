"""Cusp tables: each slice is computed, kept and counted separately."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import Eliminant
from rpr_solver.contract import document_head
from worker.answers.requests import JobRequest, Kind
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore, SliceJson

log = logging.getLogger("rpr_cusps.worker")

KIND = Kind("cusp-table", "ct-", unit="slices", by_slices=True)

INTERNAL = "An unexpected error; the worker's log has the details."


def known(
    request: JobRequest, store: ResultStore, errors: Mapping[str, SliceJson] | None = None
) -> dict[str, Any] | None:
    """Returns the table if every slice is known or has an error of the job, else None."""
    errors = errors or {}
    slices = {**store.get_slices(request, [x for x in request.parts if x not in errors]), **errors}
    if len(slices) < len(request.parts):
        return None
    head = document_head(request, request.digits, request.fixed_leg)
    return {**head, "slices": [slices[x] for x in request.parts]}


def missing(request: JobRequest, store: ResultStore) -> Sequence[str]:
    """Returns the slices that are not known, and renews the lifetime of the known ones."""
    slices = store.get_slices(request)
    store.renew_slices(request, slices)
    return [x for x in request.parts if x not in slices]


def eliminant_of(request: JobRequest, store: ResultStore) -> Eliminant:
    """Returns the manipulator's eliminant from the store, or computes it, in one worker at a time."""

    def make() -> Eliminant:
        eliminant = rpr_solver.eliminate(request.manipulator, request.fixed_leg)
        store.put_eliminant(request, eliminant)
        return eliminant

    return single_flight(lambda: store.get_eliminant(request), lambda: store.eliminant_lock(request), make)


def solve(eliminant: Eliminant, l1: str, request: JobRequest) -> SliceJson:
    """Solve a slice. An error is reported in the slice's own entry; other slices are unaffected."""
    try:
        return rpr_solver.slice_json(eliminant, Fraction(l1), request.digits)
    except MemoryError:
        raise
    except Exception:
        log.exception("slice l1=%s of %s failed", l1, request.geometry_hash)
        return error(request, l1, "internal-error", INTERNAL)


def error(request: JobRequest, l1: str, kind: str, detail: str) -> SliceJson:
    """A slice that has no answer."""
    return rpr_solver.slice_error_json(Fraction(l1), request.fixed_leg, kind, detail)
