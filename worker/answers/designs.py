"""Designs: a search whose censuses all workers share, by keeping each in the store.

All chunks of a job run the same search, which is the same for all: it is repeatable, and takes little time
but for its censuses. Of each generation a chunk examines those candidates that no other chunk examines, and
waits for the others. So a chunk that begins later, or again after the death of its worker, goes through what
is known, and joins in. The first that is done gives the answer.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from rpr_solver import Manipulator, Requirement
from rpr_solver.contract import MIN_DIGITS, Progress, silent
from rpr_solver.designs import Constraints, Goal, Plan, SearchStopped
from rpr_solver.designs.plan import CANCELED, DEADLINE, LONGEST_RANGE, REQUIRED
from worker.answers.cost import Sizes, all_events
from worker.answers.kind import Content, Document, JobRequest, Kind, Store

PLAIN_OPTIONS = (
    *("decimals", "min_height", "family"),
    *("loop", "min_aspects", "max_aspects", "seed"),
)
"""Members of a question that are options of the search as they are."""
SHARES = 4
"""Chunks of a job, so that as many workers share a search."""
_PROOF_SECONDS = 1.6
_SAMPLE = 0.6
"""Of the cost of a census: what a candidate takes, which needs no aspects, with its share of the search."""
_PAUSE, _AGAIN = 0.02, 1.0
"""Seconds between two looks at what others examine, and until one of these is tried again."""


class Observer:
    """Receives the progress of a search; others receive its improvements, too, or end it."""

    def __init__(self, report: Progress) -> None:
        self._report = report

    def __call__(self, done: int, total: int) -> None:
        """Receive the number of candidates that are known."""
        self._report(done, total)

    def improved(self, one: Document) -> None:
        """Receive an improvement."""

    def reason_to_stop(self) -> str | None:
        """Returns why the search is to end now, or None."""
        return None


def design(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Search for a geometry, together with the other chunks of the job, and prove what it reaches.

    Raises:
        SolverError: the given geometry could not be decided, or the extra `design` is not installed.
    """
    from rpr_solver.designs.design import proved, trace_json
    from rpr_solver.designs.search import searched

    plan = plan_of(request.manipulator, request.content)
    observer = progress if isinstance(progress, Observer) else Observer(progress)
    shared = _Shared(plan, store, observer)
    outcome = searched(plan, shared.examine, lambda one: observer.improved(trace_json(one)))
    how = {"stopped": outcome.stopped, "censuses": outcome.censuses}
    return store.document(
        answered(request, how), lambda: proved(request.manipulator, plan, outcome).to_json()
    )


def answered(request: JobRequest, document: Document) -> JobRequest:
    """The question that a document answers: the whole one, or how far a search had come that was stopped."""
    if not was_stopped(document):
        return request
    return replace(request, content={**request.content, **{x: document[x] for x in ("stopped", "censuses")}})


@dataclass
class _Shared:
    """What a chunk knows of the candidates, which it examines together with others.

    Attributes:
        done: how many candidates are known.
    """

    plan: Plan
    store: Store
    observer: Observer
    done: int = 0
    _taken: dict[str, float] = field(default_factory=dict)

    def examine(self, asked: Sequence[Manipulator]) -> list[Mapping[str, Any] | None]:
        """The documents of a generation: those that no other chunk examines are examined here, one at a time.

        Raises:
            SearchStopped: it is to end; not before all that is known has been gone through.
        """
        own = {one.geometry_hash: _sample_of(self.plan, one) for one in asked}
        known: dict[str, Document] = {}
        self._taken.clear()
        while left := [name for name in own if name not in known]:
            found = self.store.get_documents([own[name] for name in left])
            known |= {name: one for name, one in zip(left, found, strict=True) if one is not None}
            if len(known) < len(own):
                self._examine_one({name: own[name] for name in left if name not in known}, known)
            self.observer(self.done + len(known), self.plan.budget)
        self.done += len(asked)
        return [known[one.geometry_hash]["document"] for one in asked]

    def _examine_one(self, own: Mapping[str, JobRequest], known: dict[str, Document]) -> None:
        """Examines one of these candidates, or waits a moment if others examine them all."""
        if (reason := self.observer.reason_to_stop()) is not None:
            raise SearchStopped(reason)
        moment = time.monotonic()
        for name, request in own.items():
            if self._taken.get(name, 0.0) <= moment:
                if (one := _sample(request, self.store)) is not None:
                    known[name] = one
                    return
                self._taken[name] = moment + _AGAIN
        time.sleep(_PAUSE)


def was_stopped(document: Mapping[str, Any]) -> bool:
    """Whether a document is what a search had found when it was stopped from outside."""
    return document.get("stopped") in (DEADLINE, CANCELED)


def plan_of(manipulator: Manipulator, content: Content) -> Plan:
    """Returns the plan of a search, from the canonical form of its question."""
    options: dict[str, Any] = {name: content.get(name) for name in PLAIN_OPTIONS}
    return Plan.of(
        manipulator,
        content["objective"],
        Requirement.from_json(content["requirement"], max_digits=1 << 20),
        vary={name: (ends["from"], ends["to"]) for name, ends in content["vary"].items()},
        budget=content["budget"]["censuses"],
        **options,
    )


def _sample_of(plan: Plan, manipulator: Manipulator) -> JobRequest:
    """The question about a candidate, which other searches may ask, too."""
    requirement, constraints = plan.goal.requirement, plan.goal.constraints
    content: dict[str, Any] = {
        "geometry": manipulator.to_json(),
        "fixed_leg": requirement.fixed_leg,
        "requirement": requirement.ignoring(Fraction(0)).to_json() if requirement.limits else None,
    }
    if constraints.bound_aspects:
        content["aspects"] = True
    if requirement.limits and constraints.loop == REQUIRED:
        content["loop"] = REQUIRED
    return JobRequest(SAMPLE, {**content, "digits": MIN_DIGITS})


def _sample(own: JobRequest, store: Store) -> Document | None:
    """What a search needs of a candidate; None if another chunk examines it now."""
    with store.answer_lock(own) as held:
        if not held:
            return None
        found = store.get_document(own)
        if found is None:
            found = SAMPLE.compute(own, store, silent)
            store.put_document(own, found)
        return found


def _examine(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """The census or the check of a candidate, without a head; None in its place if it failed."""
    from rpr_solver.designs.design import examined

    asked = request.content["requirement"] or {"min_cusps": 0, "fixed_leg": request.fixed_leg}
    constraints = Constraints(request.content.get("loop"), 1 if request.content.get("aspects") else None)
    goal = Goal(LONGEST_RANGE, Requirement.from_json(asked, max_digits=1 << 20), constraints)
    return {"document": examined(request.manipulator, goal)}


def _cost(size: Sizes) -> float:
    """Of each chunk, if all have a worker."""
    each = _SAMPLE * all_events(replace(size, digits=MIN_DIGITS, count=1))
    return (_PROOF_SECONDS + size.count * each) / SHARES


def _measure(content: Content, size: Sizes) -> Sizes:
    return replace(size, count=content["budget"]["censuses"])


SAMPLE = Kind("design-sample", "ds-", _examine, all_events)
"""What searches need of a candidate. It is kept for other searches, and is no kind of question."""
DESIGN = Kind(
    "design",
    "de-",
    design,
    _cost,
    measure=_measure,
    fewer=lambda content, size: {
        "budget.censuses": (replace(size, count=1), f"allow fewer than {content['budget']['censuses']}")
    },
    unit="censuses",
    shares=SHARES,
)
