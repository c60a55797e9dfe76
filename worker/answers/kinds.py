"""The registry of kinds of documents, and what is known of a document of any kind.

A new kind is a module here with its :class:`Kind`, and a line in :data:`KINDS`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from rpr_solver import SOLVER_VERSION
from rpr_solver.contract import Progress
from worker.answers.censuses import CENSUS, CERTIFIED_CENSUS, CHECK, MARGIN
from worker.answers.cost import Sizes
from worker.answers.designs import DESIGN
from worker.answers.documents import (
    ASPECTS,
    CERTIFIED_CURVES,
    CUSP_CURVES,
    POSES,
    SINGULAR_CURVES,
    VERIFICATION,
)
from worker.answers.paths import CONNECTIONS, MODES, PATH
from worker.answers.plots import PLOT
from worker.answers.requests import Document, JobRequest, Kind, Store, known_document
from worker.answers.store import ResultStore
from worker.answers.stored_tables import StoredTable, stored_table
from worker.answers.tables import ARTICLE_TABLE, CERTIFIED_TABLE, CUSP_TABLE, look_up

KINDS: tuple[Kind, ...] = (
    CUSP_TABLE,
    ARTICLE_TABLE,
    POSES,
    CENSUS,
    CHECK,
    CUSP_CURVES,
    PATH,
    SINGULAR_CURVES,
    ASPECTS,
    MODES,
    CONNECTIONS,
    MARGIN,
    DESIGN,
    PLOT,
    CERTIFIED_TABLE,
    CERTIFIED_CENSUS,
    CERTIFIED_CURVES,
    VERIFICATION,
)
"""The kinds of documents."""


def _by_items(_request: JobRequest, _store: Store, _progress: Progress) -> Document:
    raise TypeError("a batch has no document; its items are answered one by one")


def _of_items(_size: Sizes) -> float:
    raise TypeError("a batch costs what its items cost")


BATCH = Kind("batch", "ba-", _by_items, _of_items, unit="items", by_items=True)

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


def as_kept(request: JobRequest) -> JobRequest:
    """Returns what is kept of a question once it is answered, or will never be: what finds its answer.

    That is the question itself if the answer is put together by it, from slices or from another document, and
    if it is short. Of a long one, such as a document to verify, it is the hash.
    """
    if request.kind.is_derived or len(request.to_json()) <= KEPT_WHOLE:
        return request
    return request.cut()


def missing_parts(request: JobRequest, store: ResultStore) -> Sequence[str]:
    """Returns the parts that must be computed, and renews the lifetime of the known ones."""
    if request.kind.by_slices:
        return look_up(request, store)[0]
    return () if store.renew_document(request) else request.parts


def kind_named(name: str) -> Kind:
    """Returns a kind of jobs, of documents or of batches.

    Raises:
        KeyError: there is none of this name.
    """
    return {kind.name: kind for kind in (*KINDS, BATCH)}[name]


def kind_of_job(job_id: str) -> Kind | None:
    """Returns what a job computes, a kind of document or a batch, or None if the id is not a job's."""
    return next((kind for kind in (*KINDS, BATCH) if job_id.startswith(kind.prefix)), None)


def is_batch(job_id: str) -> bool:
    """Whether a job is a batch."""
    return job_id.startswith(BATCH.prefix)


def request_from_json(text: str | bytes, version: str = SOLVER_VERSION) -> JobRequest:
    """The inverse of :meth:`JobRequest.to_json`; it also reads the records of tables of version 0.1.0."""
    record = json.loads(text)
    if "kind" in record:
        return JobRequest(kind_named(record["kind"]), record["content"], version)
    content = {key: record[key] for key in ("geometry", "fixed_leg", "digits", "l1")}
    return JobRequest(CUSP_TABLE, content, version)
