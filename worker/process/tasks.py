"""The task of an RQ job: to compute the slices of a chunk, the items of a batch, or a document."""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import rq
from redis import Redis
from redis.exceptions import RedisError
from rq.timeouts import JobTimeoutException

from rpr_solver import Eliminant
from rpr_solver.contract import Progress
from rpr_solver.errors import InputError, SolverError
from worker import tracing
from worker.answers import Document, JobRequest, SliceJson, answer
from worker.answers.designs import Observer
from worker.answers.kind import Store
from worker.answers.kinds import ItemSolver, Outcome
from worker.answers.store import ResultStore
from worker.answers.tables import INTERNAL, Group, solved
from worker.jobs.attempts import Attempts, Chunk, ItemsLostError
from worker.jobs.chunks import ChunkRef
from worker.jobs.interruptions import Cause, Interruptions
from worker.jobs.keys import Keys
from worker.logs import about
from worker.process.horse import UNRECORDED, set_deadline
from worker.process.processes import lift_memory_limit
from worker.settings import WorkerSettings

T = TypeVar("T")

log = logging.getLogger("rpr_cusps.worker")

ITEMS_SECONDS = 0.25
"""Seconds of work on items that are kept together: the most that is repeated if a work horse dies."""

_PROOF_SECONDS = 20.0  # of a deadline, to prove what a search has found until then
_EXHAUSTED = "The computation ran out of memory."
_LOST = "The server lost a part of this job's record. Posting the request again computes what is missing."
_STOCK_SECONDS = 60  # after the time limit of a chunk, until a worker of RQ alone is taken for lost


class ChunkFailedError(Exception):
    """A chunk, or a part of it, has no answer; RQ keeps it as a failed job with this message."""


@dataclass
class Context:
    """The shared parts of all tasks of a process.

    Attributes:
        redis: the connection.
        settings: of the workers.
        is_horse: whether the process is one of our work horses, whose worker sends heartbeats, and decides
            what becomes of a chunk if the process ends.
        is_sound: whether the process may perform another job.
    """

    redis: Redis
    settings: WorkerSettings = field(default_factory=WorkerSettings)
    is_horse: bool = False
    is_sound: bool = True


_context: Context | None = None


def set_context(context: Context) -> None:
    """Set the connection and settings of the tasks in this process and in its forks."""
    global _context
    _context = context


def context() -> Context:
    """Returns the shared parts of the tasks in this process.

    A worker of RQ alone (`rq worker`) has not set them; then it is the connection of its job that counts.
    """
    if _context is None:
        job = rq.get_current_job()
        assert job is not None, "a task is performed by a worker"
        set_context(Context(job.connection))
        assert _context is not None
    return _context


def run_chunk(job_id: str, run: str, index: int, attempt: int, first: int, last: int) -> None:
    """Compute the parts of a job from position `first` to `last` that are not done.

    Raises:
        InputError, SolverError: the question has no answer; the job has ended so.
        ChunkFailedError: something else went wrong.
    """
    own, ref = context(), ChunkRef(job_id, run, index, attempt)
    store = ResultStore(own.redis, own.settings, holder=ref.rq_id)
    attempts = Attempts(own.redis, own.settings, store)
    if not own.is_horse:
        _beat_alone(own, ref)
    try:
        chunk = attempts.start(ref, first, last)
        if chunk is None:
            raise ChunkFailedError("the question is not kept any more, or does not wait for this attempt")
        if not tracing.is_on():
            tracing.start()
        attributes = {"job": job_id, "chunk": index, "attempt": attempt, "kind": chunk.request.kind.name}
        if "submitted" in chunk.origin:
            tracing.record("queue wait", chunk.origin, int(chunk.origin["submitted"]), attributes)
        log_subject = {"job": job_id, "request_id": chunk.origin.get("request_id", "")}
        with about(**log_subject), tracing.span("chunk", chunk.origin, attributes):
            _run(own, ref, chunk, attempts)
        tracing.flush()
    except RedisError as error:
        if not own.is_horse:
            raise
        log.warning("the outcome of %s could not be recorded: %s", ref.rq_id, error)
        os._exit(UNRECORDED)


def _beat_alone(own: Context, ref: ChunkRef) -> None:
    """Say that the attempt runs until its time is over, since a worker of RQ alone sends no heartbeats."""
    seconds = int(own.settings.deadline_seconds) + _STOCK_SECONDS
    own.redis.set(Keys.of(own.settings).beat(ref.rq_id), "rq", ex=seconds)


def _run(own: Context, ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> None:
    start, of, outcome = time.monotonic(), chunk.request.kind, "done"
    try:
        work = _answer_items if of.by_items else _solve_slices if of.by_slices else _compute_document
        work(own, ref, chunk, attempts)
        if chunk.counts and chunk.last not in chunk.positions and (of.by_items or of.by_slices):
            attempts.close(ref)
    except RedisError:
        raise  # nothing can be recorded
    except Exception as error:
        outcome = _ended_by(error, own, ref, chunk)
    finally:
        what = f"{len(chunk.positions)} {of.unit}" if of.by_slices or of.by_items else of.name
        log.info("chunk %d (%s): %s after %.2f s", ref.index, what, outcome, time.monotonic() - start)


def _ended_by(error: Exception, own: Context, ref: ChunkRef, chunk: Chunk) -> str:
    """Record that a chunk has ended by an error; returns its kind if another attempt follows.

    Raises:
        Exception: the same, if the job has failed for it; or what was given up.
    """
    interruptions = Interruptions(own.redis, own.settings)
    if isinstance(error, MemoryError | JobTimeoutException):
        lift_memory_limit()
        own.is_sound = False
        is_memory = isinstance(error, MemoryError)
        cause = Cause("memory", _EXHAUSTED) if is_memory else Cause("timeout", str(error))
        if given_up := interruptions.happened(ref, cause):
            raise ChunkFailedError(given_up) from None
        return cause.kind
    kind, detail = _failure(error, f"chunk {ref.index}")
    if chunk.counts:
        interruptions.records.fail(ref.job_id, ref.run, kind, detail)
    raise error


def _failure(error: Exception, what: str) -> tuple[str, str]:
    """The kind of a failure and its description; logs one that is unexpected."""
    if isinstance(error, InputError):
        return "input-error", str(error)
    if isinstance(error, SolverError):
        return "solver-error", str(error)
    if isinstance(error, ItemsLostError):
        return "worker-lost", _LOST
    log.error("%s failed", what, exc_info=error)
    return "internal-error", INTERNAL


def _solve_slices(own: Context, ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> None:
    left = [*chunk.positions]

    def keep(values: Sequence[SliceJson]) -> bool:
        positions = left[: len(values)]
        del left[: len(values)]
        own.is_sound = own.is_sound and not any(_is_unforeseen(value.get("error")) for value in values)
        return attempts.put_slices(ref, chunk, positions, values)

    group = Group(keep, one_by_one=chunk.entry.is_single)
    _add_all(group, _slices(ref, chunk, attempts))


def _add_all(group: Group[T], values: Iterable[T]) -> None:
    """Compute values and keep them, in groups, as long as they are wanted; also those before one that needs
    too much memory."""
    try:
        for value in values:
            if not group.add(value):
                break
        group.close()
    except MemoryError:
        lift_memory_limit()
        group.close()
        raise


def _slices(ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> Iterator[SliceJson]:
    """Yields the slices of a chunk that are not done, each solved unless it is known."""

    def eliminant() -> Eliminant:
        with tracing.span("elimination"):
            eliminant = attempts.store.eliminant(chunk.request, len(chunk.positions))
        if chunk.counts and chunk.entry.is_single:
            attempts.begin_parts(ref)
        return eliminant

    was_missing = chunk.counts and ref.attempt == 0 and len(chunk.request.parts) == 1  # a moment ago
    return solved(
        chunk.request,
        Store() if was_missing else attempts.store,
        chunk.parts,
        eliminant=eliminant,
        during=lambda l1: tracing.span("slice", attributes={"l1": l1}),
    )


def _answer_items(own: Context, ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> None:
    items = attempts.items(ref, chunk)
    asked = {
        position: item.request
        for position, item in items.items()
        if item.request is not None and not item.request.is_cut  # of one that is done, if it is requeued
    }
    solver, left = ItemSolver(attempts.store, asked.values()), [*asked]
    is_single = chunk.entry.is_single

    def keep(outcomes: Sequence[Outcome]) -> bool:
        solver.keep()
        done = dict(zip(left, outcomes, strict=False))
        del left[: len(outcomes)]
        errors = [error for outcome in outcomes for error in outcome.errors]
        own.is_sound = own.is_sound and not any(map(_is_unforeseen, errors))
        return not chunk.counts or attempts.put_items(ref, chunk.last, done, items)

    def outcome_of(position: int, request: JobRequest) -> Outcome:
        if is_single and own.is_horse:
            set_deadline(own.settings.deadline_seconds)  # a whole one for each item
        return _outcome(solver, request, position)

    group = Group(keep, one_by_one=is_single, seconds=ITEMS_SECONDS)
    _add_all(group, (outcome_of(*one) for one in asked.items()))


def _is_unforeseen(error: Mapping[str, str] | None) -> bool:
    return error is not None and error["type"] == "internal-error"


def _outcome(solver: ItemSolver, request: JobRequest, position: int) -> Outcome:
    """Answer one item; its failure leaves the others unaffected."""
    try:
        return solver.solve(request)
    except (MemoryError, RedisError, JobTimeoutException):
        raise
    except Exception as error:
        kind, detail = _failure(error, f"item {position}")
        return Outcome({"type": kind, "detail": detail})


class Unwanted(Exception):  # noqa: N818 - not an error
    """The job has ended."""


def _compute_document(_own: Context, ref: ChunkRef, chunk: Chunk, attempts: Attempts) -> None:
    request = chunk.request

    def tell(done: int, total: int) -> None:
        if chunk.counts and not attempts.put_progress(ref, done, total):
            raise Unwanted

    def keep(request: JobRequest, document: Document) -> None:
        attempts.put_document(ref, request, document)

    with contextlib.suppress(Unwanted), tracing.span(request.kind.name):
        if request.kind.shares > 1:  # with other chunks
            document = request.kind.compute(request, attempts.store, Reporter(ref, attempts, tell))
            attempts.put_document(ref, request, document)
        else:  # or it waits for the worker that does so for a batch
            answer(request, attempts.store, Throttle(tell), keep, is_unknown=True)  # it was, a moment ago


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
        whole = attempts.settings.deadline_seconds
        self._end = time.monotonic() + whole - min(_PROOF_SECONDS, whole / 3)

    def improved(self, one: Document) -> None:
        """Record an improvement."""
        self._attempts.put_improvement(self._ref, one["census"], one)

    def reason_to_stop(self) -> str | None:
        """Returns why the search is to end now: its deadline is near, or it is canceled."""
        if time.monotonic() > self._end:
            return "deadline"
        return self._attempts.reason_to_stop(self._ref, _PROOF_SECONDS)
