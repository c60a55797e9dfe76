"""The tasks of a work horse: solve the slices of a chunk and store each at once, answer the items of a batch,
compute a document, or move answers to the archive.

One worker of an installation at a time has a process that moves answers. It uses the idle time of the
processors, and ends with its worker. A lock in Redis says that somebody moves answers, or has just looked.
"""

from __future__ import annotations

import contextlib
import logging
import select
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from rpr_solver import Eliminant
from rpr_solver.contract import Progress
from rpr_solver.errors import InputError, SolverError
from worker import tracing
from worker.answers import Document, JobRequest, SliceJson, answer
from worker.answers.designs import Observer, answered
from worker.answers.kinds import ItemSolver, Outcome
from worker.answers.layout import ResultKeys
from worker.answers.store import ResultStore
from worker.answers.tables import INTERNAL, Group, solved
from worker.jobs.archiving import keep_moving
from worker.jobs.attempts import Attempts
from worker.jobs.batches import Batches, ItemsLostError
from worker.jobs.chunks import Chunk, ChunkRef
from worker.jobs.records import INCOMPLETE
from worker.jobs.upkeep import Interruptions
from worker.logs import about
from worker.process.horse import Horse, Task
from worker.process.processes import lift_memory_limit, stop_signals_held
from worker.settings import WorkerSettings

T = TypeVar("T")

log = logging.getLogger("rpr_cusps.worker")

ITEMS_SECONDS = 0.25
"""Seconds of work on items that are kept together: the most that is repeated if a work horse dies."""

_PROOF_SECONDS = 20.0  # of a deadline, to prove what a search has found until then
EXHAUSTED = "The computation ran out of memory."


class AttemptOver(Exception):  # noqa: N818 - not an error
    """The attempt is no longer the current one: the chunk was canceled, or given to another worker."""


@dataclass(frozen=True)
class Context:
    """The shared parts of all tasks; set by the worker process before it forks. `worker` is its name."""

    redis: Redis
    settings: WorkerSettings
    worker: str = ""

    @cached_property
    def attempts(self) -> Attempts:
        """The attempts at chunks."""
        return Attempts(self.redis, self.settings)

    @cached_property
    def interruptions(self) -> Interruptions:
        """What becomes of chunks that end before their time."""
        return Interruptions(self.redis, self.settings)


_context: Context | None = None


def set_context(context: Context) -> None:
    """Set the connection and settings of the tasks in this process and in its forks."""
    global _context
    _context = context


def context() -> Context:
    """Returns the shared parts of the tasks in this process."""
    assert _context is not None, "the worker process sets the context"
    return _context


def run_chunk(job_id: str, run: str, index: int, attempt: int) -> bool:
    """Compute one chunk of a job. A failure that concerns the whole geometry ends the job.

    Returns whether all went well, so that this process may run another chunk.
    """
    own = context()
    ref = ChunkRef(job_id, run, index, attempt)
    attempts = own.attempts
    chunk = attempts.start(ref, own.worker)
    if chunk is None:
        return True
    if own.settings.result_ttls:
        attempts = Attempts(own.redis, own.settings.in_lane(attempts.lane(ref)))
    if not tracing.is_on():
        tracing.start()
    attributes = {"job": job_id, "chunk": index, "attempt": attempt, "kind": chunk.request.kind.name}
    if "submitted" in chunk.origin:
        tracing.record("queue wait", chunk.origin, int(chunk.origin["submitted"]), attributes)
    log_subject = {"job": job_id, "request_id": chunk.origin.get("request_id", "")}
    with about(**log_subject), tracing.span("chunk", chunk.origin, attributes):
        is_sound = _run(ref, chunk, attempts)
    tracing.flush()
    return is_sound


def _run(ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> bool:
    store = ResultStore(attempts.redis, attempts.settings, holder=ref.rq_id)
    start, kind, detail, is_sound = time.monotonic(), "", "", False
    try:
        if not chunk.parts:
            raise ItemsLostError(ref.job_id)
        is_sound = _work_of(chunk)(ref, chunk, attempts, store)
    except AttemptOver:
        return False
    except RedisError:
        raise  # nothing can be recorded; the sweeper finds the chunk
    except MemoryError:
        lift_memory_limit()
        kind, detail = "resource-exhausted", EXHAUSTED
    except Exception as error:
        kind, detail = _failure(error, f"chunk {ref.index}")
    if kind:
        interruptions = context().interruptions
        end = interruptions.give_up if kind == "resource-exhausted" else interruptions.fail
        end(ref, kind, detail)
    of = chunk.request.kind
    what = f"{len(chunk.parts)} {of.unit}" if of.by_slices or of.by_items else of.name
    seconds = time.monotonic() - start
    log.info("chunk %d (%s): %s after %.2f s", ref.index, what, kind or "done", seconds)
    return is_sound


def _failure(error: Exception, what: str) -> tuple[str, str]:
    """The kind of a failure and its description; logs one that is unexpected."""
    if isinstance(error, InputError):
        return "input-error", str(error)
    if isinstance(error, SolverError):
        return "solver-error", str(error)
    if isinstance(error, ItemsLostError):
        return "worker-lost", INCOMPLETE
    log.error("%s failed", what, exc_info=error)
    return "internal-error", INTERNAL


def _work_of(chunk: Chunk) -> Callable[[ChunkRef, Chunk, Attempts, ResultStore], bool]:
    """Returns what computes the chunk; it returns whether nothing unforeseen happened."""
    if chunk.request.kind.by_items:
        return _answer_items
    return _solve_slices if chunk.request.kind.by_slices else _compute_document


def _solve_slices(ref: ChunkRef, chunk: Chunk, attempts: Attempts, store: ResultStore) -> bool:
    kept, is_sound = chunk.offset, True

    def keep(values: Sequence[SliceJson]) -> bool:
        nonlocal kept, is_sound
        first, kept = kept, kept + len(values)
        is_sound = is_sound and not any(_is_unforeseen(value.get("error")) for value in values)
        return attempts.put_slices(ref, chunk, first, values)

    group = Group(keep, one_by_one=chunk.has_losses)
    _add_all(group, _slices(ref, chunk, attempts, store), ref, attempts)
    return is_sound


def _add_all(group: Group[T], values: Iterable[T], ref: ChunkRef, attempts: Attempts) -> None:
    """Compute values and keep them, in groups, as long as they are wanted; also those before one that needs
    too much memory."""
    try:
        for value in values:
            if not group.add(value):
                break
        group.close()
    except MemoryError:
        lift_memory_limit()
        if group.close() and attempts.is_ahead(ref):
            attempts.begin_slices(ref, one_by_one=True)  # at the one that needs too much
        raise


def _slices(ref: ChunkRef, chunk: Chunk, attempts: Attempts, store: ResultStore) -> Iterator[SliceJson]:
    """Yields the slices of a chunk that are not done, each solved unless it is known."""
    left = chunk.parts[chunk.offset :]

    def eliminant() -> Eliminant:
        with tracing.span("elimination"):
            eliminant = store.eliminant(chunk.request, len(left))
        if not attempts.begin_slices(ref, one_by_one=chunk.has_losses):
            raise AttemptOver
        return eliminant

    return solved(
        chunk.request,
        store,
        left,
        eliminant=eliminant,
        during=lambda l1: tracing.span("slice", attributes={"l1": l1}),
    )


def _answer_items(ref: ChunkRef, chunk: Chunk, attempts: Attempts, store: ResultStore) -> bool:
    batches = Batches(attempts.redis, attempts.settings)
    items = batches.items_of(ref, chunk)
    left = [item.request for item in items[chunk.offset :] if item.request is not None]
    assert chunk.offset + len(left) == len(items), "what is not valid is not to be done"
    solver, counted, is_sound = ItemSolver(store, left), chunk.offset, True

    def keep(outcomes: Sequence[Outcome]) -> bool:
        nonlocal counted, is_sound
        solver.keep()
        first, counted = counted, counted + len(outcomes)
        errors = [error for outcome in outcomes for error in outcome.errors]
        is_sound = is_sound and not any(map(_is_unforeseen, errors))
        return batches.put_items(ref, chunk, first, outcomes)

    # an item of another lane may take long; and what did not end well is looked at closely
    one_by_one = ref.attempt > 0 or attempts.lane(ref) != "batch"
    if not one_by_one and not attempts.begin_slices(ref, one_by_one=False):
        raise AttemptOver
    group = Group(keep, one_by_one=one_by_one, seconds=ITEMS_SECONDS)
    asked = zip(left, chunk.parts[chunk.offset :], strict=True)
    _add_all(group, (_outcome(solver, request, part) for request, part in asked), ref, attempts)
    return is_sound


def _is_unforeseen(error: Mapping[str, str] | None) -> bool:
    return error is not None and error["type"] == "internal-error"


def _outcome(solver: ItemSolver, request: JobRequest, item: str) -> Outcome:
    """Answer one item; its failure leaves the others unaffected."""
    try:
        return solver.solve(request)
    except (MemoryError, RedisError):
        raise
    except Exception as error:
        kind, detail = _failure(error, f"item {item}")
        return Outcome({"type": kind, "detail": detail})


def _compute_document(ref: ChunkRef, chunk: Chunk, attempts: Attempts, store: ResultStore) -> bool:
    request = chunk.request

    def tell(done: int, total: int) -> None:
        if not attempts.put_progress(ref, done, total):
            raise AttemptOver

    def keep(request: JobRequest, document: Document) -> None:
        attempts.put_document(ref, request, document)

    with tracing.span(request.kind.name):
        if request.kind.shares > 1:  # with other chunks
            document = request.kind.compute(request, store, Reporter(ref, attempts, tell))
            own = answered(request, document)
            attempts.put_document(ref, own, document, is_whole=own is request)
        else:  # or it waits for the worker that does so for a batch
            answer(request, store, Throttle(tell), keep, is_unknown=True)  # it was, when the job was made
    return True


class Throttle:
    """A callback `progress(done, total)` that forwards at most ten calls a second."""

    def __init__(self, report: Progress, pause: float = 0.1) -> None:
        self._report, self._pause = report, pause
        self._next = 0.0

    def __call__(self, done: int, total: int) -> None:
        """Report the progress, unless the last report is recent."""
        if (moment := time.monotonic()) >= self._next:
            self._next = moment + self._pause
            self._report(done, total)


class Reporter(Observer):
    """Forwards the progress of a search, and its improvements at once; and says why it is to end."""

    def __init__(self, ref: ChunkRef, attempts: Attempts, report: Progress) -> None:
        super().__init__(Throttle(report))
        self._ref, self._attempts = ref, attempts
        whole = attempts.settings.deadline
        self._end = time.monotonic() + whole - min(_PROOF_SECONDS, whole / 3)

    def improved(self, one: Document) -> None:
        """Record an improvement."""
        self._attempts.put_improvement(self._ref, one["census"], one)

    def reason_to_stop(self) -> str | None:
        """Returns why the search is to end now: its deadline is near, or it is canceled."""
        if time.monotonic() > self._end:
            return "deadline"
        return self._attempts.reason_to_stop(self._ref, _PROOF_SECONDS)


_ROUND_SECONDS = 5.0  # of one round; a third of the time after which another worker takes over
_MOVING_ROUNDS = 80
_LOOK_PAUSE = 5.0  # until the next look


def move_answers() -> bool:
    """Move answers until none is due; the task of the process. Returns that it may exit."""
    own = context()
    lock = _lock(own.settings)
    for _ in range(_MOVING_ROUNDS):
        has_more = keep_moving(own.redis, own.settings, _ROUND_SECONDS)
        with contextlib.suppress(OutOfMemoryError):
            own.redis.set(lock, 1, px=int(1000 * (3 * _ROUND_SECONDS if has_more else _LOOK_PAUSE)))
        if not has_more:
            break
    return False


def _lock(settings: WorkerSettings) -> str:
    return f"{ResultKeys.of(settings).archive}:moving"


class Archivist:
    """Starts the process that moves answers for a worker, if there is an archive and no other one has."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self._horse: Horse | None = None
        self._next = 0.0

    def look_after(self) -> None:
        """Start the process if it is time to, or note that it has ended; takes no time."""
        if self.settings.archive_url is None or time.monotonic() < self._next:
            return
        if self._horse is not None:
            if select.select([self._horse], [], [], 0)[0]:
                self.end()
            return
        self._next = time.monotonic() + _LOOK_PAUSE
        with contextlib.suppress(RedisError, OSError):  # it is tried again soon
            if self._is_first():
                with stop_signals_held():
                    self._horse = Horse(self.settings)
                self._horse.lower_priority()
                self._horse.run(Task("archive", f"{__name__}.{move_answers.__name__}", {}))

    def _is_first(self) -> bool:
        """Whether no other worker does so; all may if Redis is too full for the lock."""
        try:
            return bool(self.redis.set(_lock(self.settings), 1, nx=True, px=int(3000 * _ROUND_SECONDS)))
        except OutOfMemoryError:
            return True

    def end(self) -> None:
        """End it; what it has not moved stays where it is."""
        if self._horse is not None:
            self._horse.end()
            self._horse = None
