"""A large cusp table in the store, made of copies of one slice."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import rpr_solver
from rpr_solver import EXAMPLES
from tests.support.jobs import a_request, open_chunks
from worker.answers.store import packed
from worker.jobs.attempts import Attempts
from worker.jobs.queue import JobQueue

DIGITS = 1000


@cache
def _slice() -> dict[str, Any]:
    eliminant = rpr_solver.eliminate(EXAMPLES["innocenti"])
    return rpr_solver.slice_json(eliminant, Fraction("14.98"), DIGITS)


def keep_table(queue: JobQueue, count: int) -> tuple[str, dict[str, Any]]:
    """Put a table of so many slices into the store; returns its job's id and the document."""
    request = a_request(*(str(100 + i) for i in range(count)), digits=DIGITS)
    slices = [{**_slice(), "l1": l1} for l1 in request.parts]
    keys = queue.store.slice_keys(request, request.parts)
    with queue.redis.pipeline(transaction=False) as pipe:
        for key, value in zip(keys, slices, strict=True):
            pipe.set(key, packed(value), ex=600)
        pipe.execute()
    head = rpr_solver.contract.document_head(request, DIGITS, 1)
    return queue.submit(request).id, {**head, "slices": slices}


def run_job(queue: JobQueue, count: int) -> Iterator[str]:
    """Do a job of `count` slices as a worker does; gives its id first, and then once more for each slice."""
    request = a_request(*(str(5000 + i) for i in range(count)), digits=DIGITS)
    yield queue.submit(request).id
    attempts = Attempts(queue.redis, queue.settings, queue.store)
    for ref, entry in open_chunks(queue).items():
        chunk = attempts.start(ref, entry.first, entry.last)
        assert chunk is not None
        for position, l1 in zip(chunk.positions, chunk.parts, strict=True):
            attempts.put_slices(ref, chunk, [position], [{**_slice(), "l1": l1}])
            yield request.job_id
