"""The kinds of documents, and the lookup and computation of documents of any kind."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rpr_solver import SOLVER_VERSION
from rpr_solver.contract import Progress
from worker.answers import (
    article,
    aspects,
    batches,
    censuses,
    certified,
    checks,
    curves,
    paths,
    plots,
    poses,
    singular,
    tables,
    verifications,
)
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore
from worker.answers.stored_tables import StoredTable, stored_table

Document = dict[str, Any]


def _nothing(_request: JobRequest, _store: ResultStore) -> Document | None:
    return None


@dataclass(frozen=True)
class Computation:
    """The computation of a document in one piece.

    Attributes:
        compute: computes the document, and may keep others.
        derive: cuts the document from others that are kept, or returns None.
    """

    compute: Callable[[JobRequest, ResultStore, Progress], Document]
    derive: Callable[[JobRequest, ResultStore], Document | None] = _nothing


COMPUTATIONS: Mapping[Kind, Computation] = {
    article.KIND: Computation(article.compute),
    poses.KIND: Computation(poses.compute),
    censuses.KIND: Computation(censuses.compute, censuses.derive),
    checks.KIND: Computation(checks.compute),
    curves.KIND: Computation(curves.compute, curves.derive),
    paths.KIND: Computation(paths.compute),
    singular.KIND: Computation(singular.compute),
    aspects.KIND: Computation(aspects.compute),
    plots.KIND: Computation(plots.compute),
    certified.KIND: Computation(certified.compute),
    certified.CENSUS: Computation(certified.compute_census),
    certified.CURVES: Computation(certified.compute_curves),
    verifications.KIND: Computation(verifications.compute),
}
KINDS = (tables.KIND, *COMPUTATIONS)
"""The kinds of documents."""

_OF_JOBS = (*KINDS, batches.KIND)
_BY_NAME = {kind.name: kind for kind in _OF_JOBS}


KEPT_WHOLE = 1000
"""Characters of a question that are kept in any case."""

Answer = Document | StoredTable
"""What is known: a document in one piece, or a table that is read slice by slice."""


def known_answer(
    request: JobRequest, store: ResultStore, errors: Mapping[str, Any] | None = None
) -> Answer | None:
    """Returns the answer if it is in the store or follows from stored documents, else None.

    Args:
        request: the requested document.
        store: the store of results.
        errors: L1 → error, for the slices of a job without an answer; they become entries of its table.
    """
    if request.kind.by_slices:
        return stored_table(request, store, errors)
    return known_document(request, store)


def known_document(request: JobRequest, store: ResultStore) -> Document | None:
    """Returns a document in one piece if it is in the store or follows from stored documents, else None."""
    if request.version != SOLVER_VERSION:  # another version may cut documents in another way
        return store.get_document(request)
    return store.get_document(request) or COMPUTATIONS[request.kind].derive(request, store)


def as_kept(request: JobRequest) -> JobRequest:
    """Returns what is kept of a question once it is answered, or will never be: what finds its answer.

    That is the question itself if the answer is put together by it, from slices or from another document, and
    if it is short. Of a long one, such as a document to verify, it is the hash.
    """
    is_whole = request.kind not in COMPUTATIONS or COMPUTATIONS[request.kind].derive is not _nothing
    if is_whole or len(request.to_json()) <= KEPT_WHOLE:
        return request
    return request.cut()


def missing_parts(request: JobRequest, store: ResultStore) -> Sequence[str]:
    """Returns the parts that must be computed, and renews the lifetime of the known ones."""
    if request.kind.by_slices:
        return tables.missing(request, store)
    return () if store.renew_document(request) else request.parts


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Compute a document in one piece.

    Raises:
        InputError: the request has no answer.
        SolverError: it could not be decided.
    """
    return COMPUTATIONS[request.kind].compute(request, store, progress)


def kind_of_job(job_id: str) -> Kind | None:
    """Returns what a job computes, a kind of document or a batch, or None if the id is not a job's."""
    return next((kind for kind in _OF_JOBS if job_id.startswith(kind.prefix)), None)


def is_batch(job_id: str) -> bool:
    """Whether a job is a batch."""
    return job_id.startswith(batches.KIND.prefix)


def request_from_json(text: str | bytes, version: str = SOLVER_VERSION) -> JobRequest:
    """The inverse of :meth:`JobRequest.to_json`; it also reads the records of tables of version 0.1.0."""
    record = json.loads(text)
    if "kind" in record:
        return JobRequest(_BY_NAME[record["kind"]], record["content"], version)
    content = {key: record[key] for key in ("geometry", "fixed_leg", "digits", "l1")}
    return JobRequest(tables.KIND, content, version)
