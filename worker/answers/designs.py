"""Designs: a search whose censuses all workers share, by keeping each in the store.

All chunks of a job run the same search, which is the same for all: it is repeatable, and takes little time
but for its censuses. Of each generation a chunk examines those candidates that nobody else examines, and
waits for the others. So a chunk that begins later, or again after the death of its worker, goes through what
is known, and joins in. The first that is done gives the answer.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from rpr_solver import Manipulator, Requirement
from rpr_solver.contract import MIN_DIGITS, Progress
from rpr_solver.designs.questions import LONGEST_RANGE, Plan
from worker.answers.cost import Sizes, all_events
from worker.answers.requests import Content, Document, JobRequest, Kind, Store

SHARES = 4
"""Chunks of a job, so that as many workers share a search."""
_PROOF_SECONDS = 6.0
_PAUSE = 0.02


def design(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Search for a geometry, together with the other chunks of the job, and prove what it reaches.

    Raises:
        SolverError: the given geometry could not be decided, or the extra `design` is not installed.
    """
    from rpr_solver.designs.design import proved, searched, trace_json

    plan = plan_of(request.manipulator, request.content)
    improved = getattr(progress, "improved", None)
    done = 0

    def examine(asked: Sequence[Manipulator]) -> list[Mapping[str, Any] | None]:
        nonlocal done
        known: dict[str, Document] = {}
        while len(known) < len(asked):
            before = len(known)
            for one in asked:
                if one.geometry_hash not in known and (found := _sample(request, one, store)):
                    known[one.geometry_hash] = found
                    progress(done + len(known), plan.budget)
            if len(known) == before:
                time.sleep(_PAUSE)
        done += len(asked)
        return [known[one.geometry_hash]["document"] for one in asked]

    outcome = searched(plan, examine, lambda one: improved and improved(trace_json(one)))
    return store.document(request, lambda: proved(request.manipulator, plan, outcome).to_json())


def plan_of(manipulator: Manipulator, content: Content) -> Plan:
    """Returns the plan of a search, from the canonical form of its question."""
    return Plan.of(
        manipulator,
        content["objective"],
        Requirement.from_json(content["requirement"]),
        vary={name: (ends["from"], ends["to"]) for name, ends in content["vary"].items()},
        decimals=content["decimals"],
        min_height=content["min_height"],
        family=content["family"],
        ignore_windows=content["ignore_windows"],
        budget=content["budget"]["censuses"],
        seed=content["seed"],
    )


def _sample(request: JobRequest, manipulator: Manipulator, store: Store) -> Document | None:
    """What a search needs of a candidate; None if another chunk examines it now."""
    limits = request.content["requirement"] if request.content["requirement"]["limits"] else None
    content = {"geometry": manipulator.to_json(), "fixed_leg": request.fixed_leg, "requirement": limits}
    own = JobRequest(SAMPLE, {**content, "digits": MIN_DIGITS})
    found = store.get_document(own)
    if found is None:
        with store.answer_lock(own) as held:
            if held:
                found = store.get_document(own) or SAMPLE.compute(own, store, lambda *_: None)
                store.put_document(own, found)
    return found


def _examine(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """The census or the check of a candidate, without a head; None in its place if it failed."""
    from rpr_solver.designs.design import examined
    from rpr_solver.designs.goals import Goal

    asked = request.content["requirement"] or {"min_cusps": 0, "fixed_leg": request.fixed_leg}
    goal = Goal(LONGEST_RANGE, Requirement.from_json(asked), Fraction(0))
    return {"document": examined(request.manipulator, goal)}


def _cost(size: Sizes) -> float:
    """Of each chunk, if all have a worker."""
    each = all_events(replace(size, digits=MIN_DIGITS, count=1))
    return (_PROOF_SECONDS + size.count * each) / SHARES


def _measure(content: Content, size: Sizes) -> Sizes:
    return replace(size, count=content["budget"]["censuses"])


SAMPLE = Kind("design-sample", "ds-", _examine, all_events)
"""What searches need of a candidate. It is kept for others, but nobody asks for it."""
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
