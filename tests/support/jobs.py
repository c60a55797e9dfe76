"""Jobs of the worker layer: a request to submit, and the wait for a job's end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from typing import Any

from rpr_solver import EXAMPLES, Manipulator, Requirement
from rpr_solver.designs.plan import Plan
from tests.support.processes import until
from worker.answers.designs import DESIGN
from worker.answers.documents import CUSP_CURVES, POSES, SINGULAR_CURVES
from worker.answers.kind import ALL_LENGTHS, JobRequest
from worker.answers.kinds import Item, new_batch
from worker.answers.tables import CUSP_TABLE, StoredTable
from worker.jobs.batches import Batches, Reception, StoredItem
from worker.jobs.chunks import ChunkEntry, ChunkRef
from worker.jobs.queue import JobQueue
from worker.jobs.view import JobView
from worker.process import tasks


def depth(queue: JobQueue) -> int:
    """The number of chunks that wait for a worker."""
    return sum(queue.chunks.depths().values())


def open_chunks(queue: JobQueue) -> dict[ChunkRef, ChunkEntry]:
    """Returns the open chunks of all jobs."""
    by_job = queue.records.open_chunks(queue.records.active())
    return {ref: entry for chunks in by_job.values() for ref, entry in chunks.items()}


def perform(queue: JobQueue, ref: ChunkRef | None = None) -> None:
    """Performs an open chunk here, as a work horse does; all of them, if none is given."""
    tasks.set_context(tasks.Context(queue.redis, queue.settings, is_horse=True))
    for one, entry in open_chunks(queue).items():
        if ref in (None, one):
            tasks.run_chunk(*astuple(one), entry.first, entry.last)


def a_request(*l1: str, digits: int = 30, fixed_leg: int = 1) -> JobRequest:
    geometry = EXAMPLES["innocenti"].to_json()
    content = {"geometry": geometry, "fixed_leg": fixed_leg, "digits": digits, "l1": list(l1)}
    return JobRequest(CUSP_TABLE, content)


def a_document() -> JobRequest:
    return a_pose_table("14.98")


def a_pose_table(l1: str) -> JobRequest:
    content = {"geometry": EXAMPLES["innocenti"].to_json(), "l1": l1, "l2": "15", "l3": "30"}
    return JobRequest(POSES, {**content, "digits": 20})


def a_slice_of_curves() -> JobRequest:
    """A document of 20 ms that is estimated to take more, so that no two workers compute it at once."""
    content = {"geometry": EXAMPLES["innocenti"].to_json(), "fixed_leg": 1, "digits": 15}
    return JobRequest(SINGULAR_CURVES, {**content, "length": "27", "tolerance": "0.01"})


def a_heavy_document(digits: int = 30) -> JobRequest:
    content = {"geometry": EXAMPLES["innocenti"].to_json(), "fixed_leg": 1, "digits": digits}
    return JobRequest(CUSP_CURVES, {**content, "range": ALL_LENGTHS, "lengths": [], "samples": 5})


SMALL = Manipulator(2, 0, 1, 3, 2, 4)
WISH = Requirement(start=1, stop=5, max_cusps=0)
"""No geometry near that one is as wished, so there is no margin to prove, which takes longest."""


def a_design(budget: int = 300) -> JobRequest:
    """A search, which several chunks share."""
    plan = Plan.of(SMALL, "longest-range", WISH, vary="5%", decimals=2, budget=budget)
    head = {"geometry": SMALL.to_json(), "fixed_leg": 1, "digits": 15}
    return JobRequest(DESIGN, {**head, **plan.to_json()})


def table_of(queue: JobQueue, job_id: str) -> dict[str, Any]:
    """Returns the table that a job computed."""
    answer = queue.result(job_id)
    assert isinstance(answer, StoredTable)
    return answer.document()


def ended(queue: JobQueue, job_id: str) -> JobView:
    """Waits for a job; returns it once it has ended."""

    def terminal() -> JobView | None:
        view = queue.get(job_id)
        assert view is not None, "there is no such job"
        return view if view.is_terminal else None

    return until(terminal)


def submit_batch(queue: JobQueue, items: Sequence[Item]) -> JobView:
    """Makes a batch of items, as they are."""
    reception = Reception(queue.redis, queue.settings, new_batch())
    reception.push([item.to_json() for item in items])
    costs = {i: 0.01 for i, item in enumerate(items) if item.request is not None}
    return reception.begin(len(items), costs)


def read_batch(queue: JobQueue, view: JobView) -> list[StoredItem]:
    """Returns the items of a batch as they stand."""
    return Batches(queue.redis, queue.settings).read(view.id, range(view.total))
