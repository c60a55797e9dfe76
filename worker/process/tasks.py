"""What a work horse does with a chunk: solve its slices, one by one, and keep each result at once; or compute
a document in one piece."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, cast

from redis import Redis
from redis.exceptions import RedisError

import rpr_solver
from rpr_solver.errors import InputError, SolverError
from worker.answers.documents import Progress, compute, known_document
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore, SliceJson
from worker.jobs.chunks import ChunkQueue
from worker.jobs.records import Chunk, ChunkRef, JobRecords
from worker.jobs.requests import DocumentRequest, TableRequest
from worker.process.os_limits import lift_memory_limit
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

INTERNAL = "The computation failed in an unforeseen way; the worker's log has the details."
EXHAUSTED = "The computation needs more memory than a worker may use."


@dataclass(frozen=True)
class Context:
    """What a task needs besides its arguments; set by the worker process before it forks."""

    redis: Redis
    settings: WorkerSettings


_context: Context | None = None


def set_context(context: Context) -> None:
    """Give the tasks of this process (and of those forked from it) their connection and settings."""
    global _context
    _context = context


def run_chunk(job_id: str, run: str, index: int, attempt: int) -> None:
    """Compute one chunk of a job. A failure that concerns the whole geometry ends the job."""
    assert _context is not None, "the worker process sets the context"
    ref = ChunkRef(job_id, run, index, attempt)
    records = JobRecords(_context.redis, _context.settings)
    chunk = records.start(ref)
    if chunk is None:
        return
    store = ResultStore(_context.redis, _context.settings)
    try:
        if isinstance(chunk, Chunk):
            _compute(ref, chunk, records, store)
        else:
            _compute_document(ref, chunk, records, store)
        return
    except RedisError:
        raise  # nothing can be recorded now; the chunk is found and run again
    except InputError as error:
        kind, detail = "input-error", str(error)
    except SolverError as error:
        kind, detail = "solver-error", str(error)
    except MemoryError:
        lift_memory_limit()
        kind, detail = "resource-exhausted", EXHAUSTED
    except Exception:
        log.exception("job %s failed", job_id)
        kind, detail = "internal-error", INTERNAL
    entries = records.fail(ref, kind, detail)
    others = [entry for entry in entries or [] if entry.ref != ref]
    ChunkQueue(_context.redis, _context.settings).withdraw(others)


def _compute(ref: ChunkRef, chunk: Chunk, records: JobRecords, store: ResultStore) -> None:
    eliminant: rpr_solver.Eliminant | None = None
    for offset, l1 in enumerate(chunk.l1):
        value = store.get_slices(chunk.request, [l1]).get(l1)
        if value is None:
            if eliminant is None:
                eliminant = eliminant_of(chunk.request, store)
            value = solve(eliminant, l1, chunk.request)
        if not records.put_slice(ref, chunk, offset, value):
            return


def _compute_document(
    ref: ChunkRef, request: DocumentRequest, records: JobRecords, store: ResultStore
) -> None:
    progress = Throttle(lambda done, total: records.put_progress(ref, done, total))
    document = known_document(request, store) or compute(request, store, progress)
    records.put_document(ref, request, document)


class Throttle:
    """Passes on how far a computation is, a few times a second at most."""

    def __init__(self, tell: Progress, pause: float = 0.1) -> None:
        self._tell, self._pause = tell, pause
        self._next = 0.0

    def __call__(self, done: int, total: int) -> None:
        """Tell it, unless that was done a moment ago."""
        if (moment := time.monotonic()) >= self._next:
            self._next = moment + self._pause
            self._tell(done, total)


def eliminant_of(request: TableRequest, store: ResultStore) -> rpr_solver.Eliminant:
    """The geometry's eliminant: from the store, or computed while workers in need of the same wait."""

    def make() -> rpr_solver.Eliminant:
        manipulator = rpr_solver.Manipulator.from_json(cast(Any, request.geometry))
        eliminant = rpr_solver.eliminate(manipulator, request.fixed_leg)
        store.put_eliminant(request, eliminant)
        return eliminant

    return single_flight(lambda: store.get_eliminant(request), lambda: store.eliminant_lock(request), make)


def solve(eliminant: rpr_solver.Eliminant, l1: str, request: TableRequest) -> SliceJson:
    """One slice. What goes wrong with it is told in its place and does not spoil its neighbours."""
    value = Fraction(l1)
    try:
        return rpr_solver.solve_slice(eliminant, value, request.digits).to_json()
    except InputError as error:
        kind, detail = "input-error", str(error)
    except SolverError as error:
        kind, detail = "solver-error", str(error)
    except MemoryError:
        raise
    except Exception:
        log.exception("slice l1=%s of %s failed", l1, request.geometry_hash)
        kind, detail = "internal-error", INTERNAL
    return rpr_solver.slice_error_json(value, request.fixed_leg, kind, detail)
