"""Documents that are computed in one piece: what each kind of them is made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, cast

import rpr_solver
from rpr_solver import Manipulator, Requirement
from rpr_solver.article.audit import article_document
from worker.answers.censuses import compute_census, known_census
from worker.answers.curves import compute_curves, known_curves
from worker.answers.store import ResultStore
from worker.jobs.requests import DocumentKind, DocumentRequest

Document = dict[str, Any]
Progress = Callable[[int, int], None]
"""Told how many steps of how many are done."""

_Computation = Callable[[DocumentRequest, ResultStore, Progress], Document]


def known_document(request: DocumentRequest, store: ResultStore) -> Document | None:
    """The document if it is in the store, or follows from what is."""
    found = store.get_document(request)
    if found is None and request.kind in _PARTS:
        return _PARTS[request.kind](request, store)
    return found


def compute(request: DocumentRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute a document.

    Raises:
        InputError: there can be no such document.
        SolverError: it could not be decided.
    """
    return _COMPUTATIONS[request.kind](request, store, progress)


def _poses(request: DocumentRequest, _store: ResultStore, _progress: Progress) -> Document:
    wanted = request.content
    lengths = (wanted[f"l{leg}"] for leg in (1, 2, 3))
    return rpr_solver.poses(_manipulator(request), *lengths, digits=wanted["digits"]).to_json()


def _check(request: DocumentRequest, _store: ResultStore, progress: Progress) -> Document:
    wanted = request.content
    requirement = Requirement.from_json(wanted["requirement"])
    report = rpr_solver.check(_manipulator(request), requirement, digits=wanted["digits"], progress=progress)
    return report.to_json()


def _article_table(request: DocumentRequest, _store: ResultStore, progress: Progress) -> Document:
    wanted = request.content
    slices = [Fraction(x) for x in wanted["l1"]]
    return article_document(_manipulator(request), slices, wanted["digits"], progress)


def _manipulator(request: DocumentRequest) -> Manipulator:
    return Manipulator.from_json(cast(Any, request.content["geometry"]))


_PARTS: Mapping[DocumentKind, Callable[[DocumentRequest, ResultStore], Document | None]] = {
    "census": known_census,
    "cusp-curves": known_curves,
}
_COMPUTATIONS: Mapping[DocumentKind, _Computation] = {
    "poses": _poses,
    "census": compute_census,
    "check": _check,
    "cusp-curves": compute_curves,
    "article-table": _article_table,
}
