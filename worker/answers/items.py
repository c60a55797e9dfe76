"""The items of a batch: what is asked in each, and the computation of its answer."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import rpr_solver
from worker.answers.kinds import (
    KEPT_WHOLE,
    as_kept,
    compute,
    known_document,
    missing_parts,
    request_from_json,
)
from worker.answers.requests import JobRequest
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore, SliceJson, dump
from worker.answers.tables import Group, SliceSolver, eliminant_of, look_up


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
        """Returns the item as it is kept."""
        parts: dict[str, Any] = {} if self.id is None else {"id": self.id}
        if self.kind is not None:
            parts["kind"] = self.kind
        if self.request is not None:
            parts |= {"kind": self.request.kind.name, "content": self.request.content}
        if self.problem is not None:
            parts["problem"] = self.problem
        return json.dumps(parts, separators=(",", ":"))  # ASCII: what it quotes may not be encodable

    def to_texts(self) -> tuple[str, str]:
        """Returns the item as it is kept beside its result, and the whole of it if that is more, or empty."""
        whole = self.to_json()
        if self.request is None or len(whole) <= KEPT_WHOLE:
            return whole, ""
        kept = replace(self, request=as_kept(self.request)).to_json()
        return kept, "" if kept == whole else whole


def item_from_json(text: bytes, version: str = rpr_solver.SOLVER_VERSION) -> Item:
    """The inverse of :meth:`Item.to_json`."""
    parts = json.loads(text)
    request = request_from_json(text, version) if "content" in parts else None
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

    def to_json(self) -> str:
        """Returns the outcome as it is kept; empty if there is nothing to keep."""
        if self.failure is not None:
            return dump({"failure": self.failure})
        return dump({"slices": self.slices}) if self.slices else ""


def outcome_from_json(text: bytes | None) -> Outcome:
    """The inverse of :meth:`Outcome.to_json`; None is an outcome that was not kept."""
    parts = json.loads(text) if text else {}
    return Outcome(parts.get("failure"), parts.get("slices", {}))


class ItemSolver:
    """Answers one question after the other; neighbours about one manipulator share its eliminant."""

    def __init__(self, store: ResultStore) -> None:
        self.store = store
        self._eliminant: tuple[tuple[str, int], rpr_solver.Eliminant] | None = None

    def answer(self, request: JobRequest) -> Outcome:
        """Compute what is not known of an answer, keep it, and renew the lifetime of what is known.

        Raises:
            InputError: the question has no answer.
            SolverError: it could not be decided.
        """
        if request.kind.by_slices:
            return Outcome(slices=self._solve_slices(request))
        if missing_parts(request, self.store):
            self._answer_once(request)
        return Outcome()

    def _answer_once(self, request: JobRequest) -> None:
        """Compute a document, or wait for the worker that does so for a job or another batch."""

        def make() -> dict[str, Any]:
            document = compute(request, self.store, lambda _done, _total: None)
            self.store.put_document(request, document)
            return document

        document = single_flight(
            lambda: known_document(request, self.store), lambda: self.store.answer_lock(request), make
        )
        if not self.store.renew_document(request):  # it follows from another, which may expire before
            self.store.put_document(request, document)

    def _solve_slices(self, request: JobRequest) -> dict[str, Any]:
        absent, errors = look_up(request, self.store)
        if not absent:
            return errors
        solve = SliceSolver(self._eliminant_of(request), request, absent)

        def keep(values: Sequence[tuple[str, SliceJson]]) -> bool:
            self.store.put_slices(request, dict(values))
            return True

        group = Group(keep)
        for l1 in absent:
            value = solve(l1)
            if "error" in value:
                errors[l1] = value
            group.add((l1, value))
        group.close()
        return errors

    def _eliminant_of(self, request: JobRequest) -> rpr_solver.Eliminant:
        of = request.geometry_hash, request.fixed_leg
        if self._eliminant is None or self._eliminant[0] != of:
            self._eliminant = of, eliminant_of(request, self.store)
        return self._eliminant[1]
