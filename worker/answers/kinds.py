"""The registry of kinds of documents, what is known of a document of any kind, and batches: many
questions of any kinds in one job.

A new kind is a module here with its :class:`Kind`, and a line in :data:`KINDS`.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import rpr_solver
from rpr_solver.contract import FEW_SLICES, Progress
from worker.answers.censuses import CENSUS, CHECK, MARGIN
from worker.answers.cost import Sizes, elimination_at_one
from worker.answers.designs import DESIGN
from worker.answers.documents import (
    ASPECTS,
    CUSP_CURVES,
    PLOT,
    POSES,
    SINGULAR_CURVES,
    VERIFICATION,
)
from worker.answers.kind import Document, JobRequest, Kind, SliceJson, Store, answer, known_document
from worker.answers.layout import dump, eliminant_ttl
from worker.answers.paths import CONNECTIONS, MODES, PATH
from worker.answers.store import ResultStore
from worker.answers.tables import (
    ARTICLE_TABLE,
    CUSP_TABLE,
    Group,
    StoredTable,
    look_up,
    solved,
    stored_table,
)
from worker.answers.workspaces import WORKSPACE

KINDS: tuple[Kind, ...] = (
    CUSP_TABLE,
    ARTICLE_TABLE,
    POSES,
    CENSUS,
    CHECK,
    CUSP_CURVES,
    PATH,
    SINGULAR_CURVES,
    WORKSPACE,
    ASPECTS,
    MODES,
    CONNECTIONS,
    MARGIN,
    DESIGN,
    PLOT,
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


def request_from_json(text: str | bytes) -> JobRequest:
    """The inverse of :meth:`JobRequest.to_json`."""
    record = json.loads(text)
    return JobRequest(kind_named(record["kind"]), record["content"], points=record.get("points", {}))


_KNOWN_SECONDS = 0.001  # to find that an answer is known
_LONG = 1.0  # seconds of an elimination that is always charged: slices may have been asked for before
_FEW = 8  # slices of an item that are kept together with those of others


def new_batch() -> str:
    """Returns the token that distinguishes a batch from all others."""
    return secrets.token_hex(16)


def batch_request(token: str, count: int = 0) -> JobRequest:
    """Returns the request for the job of a batch; a batch is one submission, even with equal items."""
    return JobRequest(BATCH, {"batch": token, "count": count})


def seconds_after(request: JobRequest, seen: set[str]) -> float:
    """Returns the estimated seconds of a question after others, of which `seen` has what is computed once.

    Adds what this one computes.
    """
    cost = request.cost
    parts = len(request.parts)
    if request.content_hash in seen:
        return _KNOWN_SECONDS * parts
    once = _once_after(request, cost.once, parts, seen) if cost.once else 0.0
    seen.add(request.content_hash)
    return once + cost.each * parts


def _once_after(request: JobRequest, once: float, slices: int, seen: set[str]) -> float:
    """For the first few slices of a manipulator Q is computed at their lengths alone, then for all."""
    shared = f"{request.geometry_hash} {request.fixed_leg}"
    if shared in seen:
        return 0.0
    asked = f"{shared} few"
    if slices <= FEW_SLICES and once < _LONG and asked not in seen:
        seen.add(asked)
        return slices * elimination_at_one(request.sizes)
    seen.add(shared)
    return once


@dataclass(frozen=True)
class Item:
    """One item: a question, or the problem in the place of one that is not valid.

    Attributes:
        id: the name that its sender gave it.
        request: the question in canonical form.
        problem: a problem document.
        kind: of an item that is not valid, the kind that it names, if it names one.
    """

    id: str | None = None
    request: JobRequest | None = None
    problem: Mapping[str, Any] | None = None
    kind: str | None = None

    def to_json(self) -> str:
        """Returns the item as stored."""
        parts: dict[str, Any] = {} if self.id is None else {"id": self.id}
        if self.kind is not None:
            parts["kind"] = self.kind
        if self.request is not None:
            parts |= self.request.record()
        if self.problem is not None:
            parts["problem"] = self.problem
        return json.dumps(parts, separators=(",", ":"))  # ASCII: what it quotes may not be encodable


def item_from_json(text: bytes) -> Item:
    """The inverse of :meth:`Item.to_json`."""
    parts = json.loads(text)
    request = request_from_json(text) if "content" in parts else None
    kind = parts.get("kind") if request is None else None
    return Item(parts.get("id"), request, parts.get("problem"), kind)


@dataclass(frozen=True)
class Outcome:
    """What an item has beside the results in the store.

    Attributes:
        failure: `type` and `detail`, if it has no answer.
        slices: L1 → error, for single slices of its table without an answer.
    """

    failure: Mapping[str, str] | None = None
    slices: Mapping[str, Any] = field(default_factory=dict)

    @property
    def errors(self) -> Sequence[Mapping[str, str]]:
        """The failure, or those of single slices."""
        of_slices = [value["error"] for value in self.slices.values()]
        return of_slices if self.failure is None else [self.failure, *of_slices]

    def to_json(self) -> str:
        """Returns the outcome as stored; empty if there is nothing to store."""
        if self.failure is not None:
            return dump({"failure": self.failure})
        return dump({"slices": self.slices}) if self.slices else ""


def outcome_from_json(text: bytes | None) -> Outcome:
    """The inverse of :meth:`Outcome.to_json`; None is an outcome that was not kept."""
    parts = json.loads(text) if text else {}
    return Outcome(parts.get("failure"), parts.get("slices", {}))


def new_manipulators(store: ResultStore, requests: Iterable[JobRequest]) -> set[tuple[str, int]]:
    """Returns the hashes and fixed legs of those of which no slice was ever asked for, and none is kept.

    Notes that slices are asked for now.
    """
    found = list(dict.fromkeys((request.geometry_hash, request.fixed_leg) for request in requests))
    ttl = eliminant_ttl(store.settings)
    with store.redis.pipeline(transaction=False) as pipe:
        for of in found:
            pipe.exists(store.keys.eliminant(*of), store.keys.digits(*of))
            pipe.set(store.keys.eliminant_use(*of), 1, nx=True, ex=ttl)
        replies = iter(pipe.execute())
    return {of for of, kept, is_first in zip(found, replies, replies, strict=True) if is_first and not kept}


class ItemSolver:
    """Answers one question after the other; neighbours about one manipulator share its eliminant.

    The manipulators of the questions that are given at first are looked up together: nothing is looked for
    in the store that belongs to one which is new. Slices that are solved can be kept together, too.
    """

    def __init__(self, store: ResultStore, requests: Iterable[JobRequest] = ()) -> None:
        self.store = store
        self._new = new_manipulators(store, (x for x in requests if x.kind.by_slices))
        self._eliminant: tuple[tuple[str, int], rpr_solver.Eliminant] | None = None
        self._solved: list[tuple[JobRequest, dict[str, SliceJson]]] = []
        self._solved_of: set[tuple[str, int]] = set()

    def keep(self) -> None:
        """Keep the slices that :meth:`solve` has left."""
        if self._solved:
            self.store.put_tables(self._solved)
            self._solved.clear()
            self._solved_of.clear()

    def solve(self, request: JobRequest) -> Outcome:
        """Compute what is not known of an answer, keep it, and renew the lifetime of what is known.

        Few slices of a table are left for :meth:`keep`.

        Raises:
            InputError: the question has no answer.
            SolverError: it could not be decided.
        """
        if request.kind.by_slices:
            return Outcome(slices=self._solve_slices(request))
        if missing_parts(request, self.store):
            answer(request, self.store, is_unknown=True)
        return Outcome()

    def _solve_slices(self, request: JobRequest) -> dict[str, Any]:
        of = request.geometry_hash, request.fixed_leg
        is_new = of in self._new
        self._new.discard(of)
        if of in self._solved_of:
            self.keep()
        absent, errors = (list(request.parts), {}) if is_new else look_up(request, self.store)

        def keep(values: Sequence[tuple[str, SliceJson]]) -> bool:
            self._solved.append((request, dict(values)))
            self._solved_of.add(of)
            if len(absent) > _FEW:
                self.keep()
            return True

        group = Group(keep)
        slices = solved(
            request,
            Store(),
            absent,
            eliminant=lambda: self._eliminant_of(request, len(absent), is_new=is_new),
        )
        for l1, value in zip(absent, slices, strict=True):
            if "error" in value:
                errors[l1] = value
            group.add((l1, value))
        group.close()
        return errors

    def _eliminant_of(self, request: JobRequest, slices: int, *, is_new: bool) -> rpr_solver.Eliminant:
        of = request.geometry_hash, request.fixed_leg
        if self._eliminant is None or self._eliminant[0] != of:
            store = Store() if is_new and slices <= FEW_SLICES else self.store
            self._eliminant = of, store.eliminant(request, slices)
        return self._eliminant[1]
