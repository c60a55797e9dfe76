"""The worker: RQ's own, with a horse that stays, deadlines that end C code, and a stop that loses nothing."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import random
import secrets
import select
import signal
import socket
import threading
import time
from dataclasses import astuple
from math import inf
from types import FrameType
from typing import Any

import rq
from redis import Redis
from redis.exceptions import RedisError
from rq import Queue
from rq.exceptions import DequeueTimeout
from rq.executions import Execution
from rq.job import Job, JobStatus
from rq.serializers import JSONSerializer
from rq.suspension import WORKERS_SUSPENDED
from rq.timeouts import BaseDeathPenalty
from rq.worker import WorkerStatus

from rpr_solver.errors import InputError, SolverError
from worker.answers.kinds import is_batch
from worker.connection import address, patient
from worker.jobs.chunks import KEPT_SECONDS, ChunkQueue, ChunkRef, ref_of
from worker.jobs.interruptions import Cause, Interruptions
from worker.jobs.plan import lanes_of
from worker.jobs.sweeper import SWEEP_SECONDS, Sweeper
from worker.logs import about
from worker.process.archivist import Archivist
from worker.process.horse import UNRECORDED, Horse, Stable, set_deadline
from worker.process.processes import on_stop_signals, signal_name, signal_of
from worker.process.tasks import ChunkFailedError, Context, context, set_context
from worker.settings import Duty, WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

BEAT_SECONDS = 0.5
"""Seconds between two heartbeats of a chunk: a job that is canceled ends at the next one."""

_IDLE_SECONDS = 2
"""Seconds that one command waits for a job; whole ones, by RQ."""

_REGISTER_TTL, _REGISTER_SECONDS = 15, 5.0
"""Lifetime of the entry in RQ's register, and when it is renewed: so long a dead worker is counted."""

_PATIENCE = 5.0
"""Seconds that a horse may be late at its own deadline, as a stopped one is; then its worker ends it."""

_SIGN_OFF_TIMEOUT = 2.0
_SHORTEST_PAUSE, _LONGEST_PAUSE = 0.1, 10.0


class StopWhileIdle(BaseException):
    """A stop signal came while no chunk runs, so that the worker can end at once."""


class NoPenalty(BaseDeathPenalty):
    """RQ's limit of time, which cannot end a C call; see `set_deadline`."""

    def setup_death_penalty(self) -> None:
        """Do nothing."""

    def cancel_death_penalty(self) -> None:
        """Do nothing."""


class Outage:
    """A run of errors without any success in between."""

    def __init__(self) -> None:
        self._count = 0
        self._since = 0.0
        self._logged = ""

    def note(self, error: Exception) -> float:
        """Log an error, unless it is the same as the last one; returns how long to wait, in seconds."""
        if self._count == 0:
            self._since = time.monotonic()
        if (text := f"{type(error).__name__}: {error}") != self._logged:
            self._logged = text
            unforeseen = None if isinstance(error, RedisError) else error
            log.warning("cannot work (%s); retrying", text, exc_info=unforeseen)
        pause = min(_LONGEST_PAUSE, _SHORTEST_PAUSE * 2.0 ** min(self._count, 10))
        self._count += 1
        return pause * random.uniform(0.5, 1.0)  # not all workers of a machine at the same time

    def end(self) -> None:
        """Work is possible; log it if it was not before."""
        if self._count:
            log.warning("working again after %.1f s", time.monotonic() - self._since)
            self._count, self._logged = 0, ""


class Worker(rq.Worker):  # type: ignore[misc, unused-ignore]
    """A worker of RQ. Beyond that, it

    - has its jobs performed by a horse that stays, and ends with it,
    - takes chunks of our jobs only, and opens the next attempt at one that is interrupted,
    - gives its chunk back when it stops, and ends it when the job is canceled,
    - searches for chunks that other workers lost,
    - continues after any error; only a signal ends it.

    Args:
        redis: the connection.
        settings: of the workers.
        name: by which RQ knows it; one of its own without it.
        parent_pid: the process without which it ends.
        duty: `light` for small chunks only.
    """

    def __init__(
        self,
        redis: Redis,
        settings: WorkerSettings,
        name: str | None = None,
        parent_pid: int | None = None,
        duty: Duty = "all",
    ) -> None:
        self.settings = settings
        self._parent_pid = parent_pid
        self._interruptions = Interruptions(redis, settings)
        self._attempts = self._interruptions.attempts
        self._sweeper = Sweeper(redis, settings)
        self._stable = Stable(settings, self._perform)
        self._archivist = Archivist(redis, settings)
        self._reader, self._writer = os.pipe()
        for end in (self._reader, self._writer):
            os.set_blocking(end, False)
        self._stop_at = inf
        self._is_busy = self._is_announced = False
        self._next_register = self._next_sweep = 0.0
        queues = ChunkQueue(redis, settings).queues
        super().__init__(
            [queues[lane] for lane in lanes_of(duty)],
            name=name or f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}",
            connection=redis,
            serializer=JSONSerializer,
            log_job_description=False,
        )

    @property
    def connection_timeout(self) -> int:
        """The least time to wait for an answer of Redis: RQ would raise that of the connection to minutes."""
        return 0

    # -- the loop ----------------------------------------------------------------------------------

    def run(self) -> None:
        """Perform jobs until a signal, through any outage of Redis."""
        on_stop_signals(self.request_stop)
        outage = Outage()
        with contextlib.suppress(StopWhileIdle):
            while not self.is_stopping:
                try:
                    self._round()
                    outage.end()
                except Exception as error:
                    self._stable.end()
                    self._is_busy = False
                    self._wait(outage.note(error))
        # neither another signal nor a Redis that hangs may delay the end of the process
        on_stop_signals(signal.SIG_IGN)
        self._stable.end()
        self._archivist.end()
        sign_off = threading.Thread(target=self._sign_off, daemon=True)
        sign_off.start()
        sign_off.join(_SIGN_OFF_TIMEOUT)

    def _round(self) -> None:
        """Perform a job if one comes."""
        if time.monotonic() >= self._next_register:
            self._register()
        self._sweep()
        if self.connection.exists(WORKERS_SUSPENDED):
            self._show(WorkerStatus.SUSPENDED)
            self._wait(1.0)
            return
        self._show(WorkerStatus.IDLE)
        with contextlib.suppress(DequeueTimeout):
            taken = Queue.dequeue_any(
                self.queues, _IDLE_SECONDS, self.connection, self.job_class, self.serializer
            )
            if taken is not None:
                self._is_busy = True  # from now on a signal lets the job finish
                self.execute_job(*taken)
        self._is_busy = False

    def _register(self) -> None:
        """Say that the worker is alive, and everything of it, in case Redis was emptied."""
        self._next_register = time.monotonic() + _REGISTER_SECONDS
        if self.birth_date is None:
            self.birth_date = rq.utils.now()
        with self.connection.pipeline(transaction=False) as pipe:
            self.heartbeat(pipeline=pipe)
            pipe.hset(self.key, mapping=self.serialize() | {"state": self.get_state()})
            rq.worker_registration.register(self, pipe)
            pipe.execute()
        if not self._is_announced:
            self.subscribe()  # type: ignore[no-untyped-call]
            self._is_announced = True
            log.info("worker %s ready on %s", self.name, address(self.connection))

    def heartbeat(self, timeout: int | None = None, pipeline: Any = None) -> None:  # noqa: ARG002 - RQ's
        """Renew the entry in RQ's register, for seconds instead of minutes."""
        super().heartbeat(_REGISTER_TTL, pipeline)

    def _show(self, state: WorkerStatus) -> None:
        if self.get_state() != state:
            self.set_state(state)

    def _sweep(self) -> None:
        if time.monotonic() >= self._next_sweep:
            self._next_sweep = time.monotonic() + SWEEP_SECONDS
            self._archivist.look_after()
            self._sweeper.sweep()
            if self.should_run_maintenance_tasks:
                self.run_maintenance_tasks()  # type: ignore[no-untyped-call]

    def _sign_off(self) -> None:
        with contextlib.suppress(RedisError):
            self.register_death()  # type: ignore[no-untyped-call]
            self.unsubscribe()  # type: ignore[no-untyped-call]

    def _pubsub_exception_handler(self, exc: Exception, *_: Any) -> None:
        """Listen for commands again, whatever has happened; redis-py subscribes by itself."""
        log.debug("cannot listen for commands: %s", exc)
        time.sleep(1.0)

    def _wait(self, seconds: float) -> None:
        """Wait, unless a signal comes."""
        select.select([self._reader], [], [], seconds)

    # -- one job -----------------------------------------------------------------------------------

    def execute_job(self, job: Job, queue: Queue) -> None:
        """Have the horse perform a job, and look after it until its end."""
        try:
            ref = ref_of(job.id)
            is_chunk = tuple(job.args[:4]) == astuple(ref)
        except Exception:
            is_chunk = False
        if not is_chunk:
            self._refuse(job, queue)
            return
        counts = self._attempts.beat(ref, self.name)
        horse = self._stable.take()
        self._horse_pid = horse.pid  # for RQ's commands, which may come as soon as the job is shown
        execution = self._begin(job, queue)
        horse.order(json.dumps([job.id, queue.name, execution.id]))
        self._look_after(job, queue, ref, counts=counts)
        self.execution = None

    def _begin(self, job: Job, queue: Queue) -> Execution:
        """Show a job as started to RQ's tools, in one step; returns its execution.

        Most jobs take milliseconds: RQ's record of the execution is written with its first heartbeat.
        """
        self.execution = execution = Execution(secrets.token_hex(16), job.id, self.connection, self.name)
        self._state = WorkerStatus.BUSY
        with self.connection.pipeline(transaction=False) as pipe:
            job.started_job_registry.add_execution(execution, pipe, ttl=self.get_heartbeat_ttl(job))
            job.prepare_for_execution(self.name, pipe)
            pipe.hset(self.key, mapping={"state": self._state, "current_job": job.id})
            if len(self.queues) == 1:  # then RQ takes jobs by way of another list
                pipe.lrem(queue.intermediate_queue_key, 1, job.id)
            pipe.execute()
        return execution

    def _refuse(self, job: Job, queue: Queue) -> None:
        text = "it is not a chunk of rpr-cusps"
        log.warning("refused the RQ job %r: %s", job.id, text)
        job.started_at = job.ended_at = rq.utils.now()
        self.handle_job_failure(job, queue, exc_string=text)

    def _look_after(self, job: Job, queue: Queue, ref: ChunkRef, *, counts: bool) -> None:
        """Wait for the end of a job; `counts`: whether its attempt was wanted when it began.

        One that was not is of a job that has ended, of which somebody has requeued a chunk.
        """
        horse, start, limit = self._stable.horse, time.monotonic(), _seconds_of(job, ref) + _PATIENCE
        assert horse is not None, "it has an order"
        ended_for, next_beat = "", start + BEAT_SECONDS
        while not self._wait_for(horse, min(next_beat, self._stop_at)):
            self._note_stop()
            reason = ""
            if time.monotonic() >= self._stop_at:
                reason, self._stop_at = "stopped", time.monotonic() + 1.0
            if time.monotonic() >= next_beat:
                next_beat = time.monotonic() + BEAT_SECONDS
                if not self._is_wanted(job, ref) and counts:
                    reason = "canceled"
                elif time.monotonic() - start > limit:
                    reason = "timeout"
            if ended_for := ended_for or reason:
                horse.kill()
        answer = horse.answer()
        if answer is None:
            self._close(job, queue, ref, self._stable.forget(), ended_for, time.monotonic() - start)
        elif not answer:
            self._stable.forget()

    def _wait_for(self, horse: Horse, until: float) -> bool:
        """Wait until the horse can be read, a signal comes or the time has come; returns whether it can."""
        files = [horse.fileno(), self._reader]
        ready, _, _ = select.select(files, [], [], max(0.0, until - time.monotonic()))
        return horse.fileno() in ready

    def _note_stop(self) -> None:
        """Note when the chunk must end, once the worker is to stop."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._reader, 64)
        if self.is_stopping and self._stop_at == inf:
            self._stop_at = time.monotonic() + self.settings.shutdown_grace

    def _is_wanted(self, job: Job, ref: ChunkRef) -> bool:
        """Send the heartbeats of a chunk; returns whether its job still waits for this attempt.

        While Redis does not answer, it goes on: at worst another worker computes the same.
        """
        try:
            if time.monotonic() >= self._next_register:
                self._next_register = time.monotonic() + _REGISTER_SECONDS
                if self.execution is not None:
                    self.execution.save(self.get_heartbeat_ttl(job))
                self.maintain_heartbeats(job)
            is_wanted = self._attempts.beat(ref, self.name)
            self._sweep()
        except RedisError as error:
            log.warning("heartbeat failed: %s", error)
            return True
        return is_wanted

    def _close(
        self, job: Job, queue: Queue, ref: ChunkRef, status: int, ended_for: str, seconds: float
    ) -> None:
        """Record what becomes of a chunk whose horse has died."""
        is_stopped = self._stopped_job_id == job.id  # by a command of RQ
        cause = _cause(status, ended_for, job, self.settings)
        with about(job=ref.job_id):
            log.info("chunk %d: %s after %.2f s", ref.index, ended_for or cause.detail or cause.why, seconds)
            given_up = ""
            if is_stopped:
                self._interruptions.records.cancel(ref.job_id)
                given_up = "stopped by a command of RQ"
            elif ended_for != "canceled":
                given_up = self._interruptions.happened(ref, cause)
            if given_up:
                log.warning("chunk %d: gave up %s", ref.index, given_up)
                job.started_at = job.started_at or rq.utils.now()
                job.ended_at = rq.utils.now()
                self.handle_job_failure(job, queue, exc_string=given_up)
                return
        with self.connection.pipeline() as pipe:
            self.cleanup_execution(job, pipe)
            pipe.execute()
        self._interruptions.chunks.discard([job.id])  # the next attempt is another RQ job, if there is one

    # -- in the horse ------------------------------------------------------------------------------

    def _perform(self, order: str) -> bool:
        """Perform a job in this process, the horse; returns whether it may perform another."""
        if not self._is_horse:
            self._is_horse = True
            self.death_penalty_class = NoPenalty
            self.connection = patient(self.connection)
            set_context(Context(self.connection, self.settings, is_horse=True))
        job_id, queue_name, execution_id = json.loads(order)
        job = Job.fetch(job_id, connection=self.connection, serializer=JSONSerializer)
        self.execution = Execution(execution_id, job_id, self.connection, self.name)
        queue = Queue(queue_name, connection=self.connection, serializer=JSONSerializer)
        set_deadline(job.timeout or 0)
        try:
            return bool(self.perform_job(job, queue)) and context().is_sound
        except RedisError as error:
            log.warning("the outcome of %s could not be recorded: %s", job_id, error)
            os._exit(UNRECORDED)

    def prepare_job_execution(self, *_: Any) -> None:
        """Do nothing: the worker has shown the job as started."""

    def handle_execution_ended(self, job: Job, *_: Any) -> None:
        """Note when a job has ended; what follows records it."""
        job.ended_at = rq.utils.now()

    def handle_job_success(self, job: Job, *_: Any, **__: Any) -> None:
        """Show a job as finished to RQ's tools, in one step: no other waits for it, and it has no result."""
        assert job.started_at is not None, "it was performed"
        assert job.ended_at is not None, "it was performed"
        end: dict[Any, Any] = {"status": JobStatus.FINISHED, "ended_at": rq.utils.utcformat(job.ended_at)}
        with self.connection.pipeline(transaction=False) as pipe:
            self.increment_successful_job_count(pipe)
            self.increment_total_working_time(job.ended_at - job.started_at, pipe)
            pipe.hset(job.key, mapping=end)
            pipe.expire(job.key, KEPT_SECONDS)
            job.finished_job_registry.add(job, KEPT_SECONDS, pipe)
            self.cleanup_execution(job, pipe)
            pipe.execute()

    def handle_exception(self, job: Job, *exc_info: Any) -> None:
        """Log an error, but for those that belong to the question: these are in RQ's record of the job."""
        if not isinstance(exc_info[1], InputError | SolverError | ChunkFailedError):
            super().handle_exception(job, *exc_info)

    # -- stopping ----------------------------------------------------------------------------------

    @property
    def is_stopping(self) -> bool:
        """Whether the worker is stopping, on a signal or because its parent has ended."""
        return self._stop_requested or self._parent_pid not in (None, os.getppid())

    def request_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """First signal: finish the chunk or give it back, then end. Second signal: without waiting for it."""
        if self._stop_requested:
            self._stop_at = min(self._stop_at, time.monotonic())
        self._stop_requested = True
        with contextlib.suppress(BlockingIOError):
            os.write(self._writer, b"w")
        if not self._is_busy:
            raise StopWhileIdle


def _seconds_of(job: Job, ref: ChunkRef) -> float:
    """Returns the seconds that a chunk may take: of a batch, each of its items may take a whole deadline."""
    first, last = job.args[4:]
    return float(job.timeout or 0) * (last + 1 - first if is_batch(ref.job_id) else 1)


def _cause(status: int, ended_for: str, job: Job, settings: WorkerSettings) -> Cause:
    """Returns why a horse has ended, by its wait status and what its worker ended it for."""
    if ended_for == "stopped":
        return Cause("stopped")
    number = signal_of(status)
    if ended_for == "timeout" or number == signal.SIGALRM:
        return Cause("timeout", f"The computation was stopped at the time limit of {job.timeout:g} s.")
    if number is None:
        if os.waitstatus_to_exitcode(status) == UNRECORDED:
            return Cause("lost", "The answer could not be kept repeatedly.")
        return Cause("crashed", "The worker repeatedly ended without an answer.")
    how = f"The worker was terminated by signal {number} ({signal_name(number)})"
    if number == signal.SIGABRT:
        limit = settings.memory_limit_mb
        of = f" of {limit} MiB" if limit else ""
        return Cause("memory", f"{how}, most likely at the memory limit{of}.")
    return Cause("crashed", f"{how}, repeatedly.")
