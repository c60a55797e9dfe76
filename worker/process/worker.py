"""The worker process: an RQ worker that forks a work horse for each chunk and supervises it."""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import logging
import os
import secrets
import select
import signal
import socket
import time
from types import FrameType

import flint  # noqa: F401  # loaded before the fork, for all work horses
from redis import Redis
from redis.client import Pipeline
from redis.exceptions import RedisError
from rq import Queue, Worker
from rq.exceptions import StopRequested
from rq.job import Job
from rq.serializers import JSONSerializer
from rq.utils import now
from rq.worker import WorkerStatus

import rpr_solver  # noqa: F401
from worker.answers.store import ResultStore
from worker.connection import connect
from worker.jobs.chunks import ChunkQueue, queue_names
from worker.jobs.interruption import fail, run_again
from worker.jobs.records import ChunkRef, JobRecords
from worker.jobs.sweeper import Sweeper
from worker.process.horse_exit import UNANSWERED, Outcome, RunAgain, judge_exit
from worker.process.os_limits import die_with_parent, limit_memory
from worker.process.tasks import Context, set_context
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_RQ_MAINTENANCE = 60.0
_WATCHDOG_MARGIN = 15.0
_REGISTER_TTL = 15


class WorkerError(Exception):
    """The worker cannot run or continue; the message is for the user."""


class CuspWorker(Worker):
    """A forking RQ worker that

    - kills a work horse at the deadline, even inside C code, and records the deadline as the reason,
    - puts its running chunk back in the queue when it stops,
    - sends heartbeats for its chunk, and searches for chunks that other workers lost,
    - notices by itself that its attempt is over: the job was canceled, or another worker runs the chunk.
    """

    def __init__(
        self,
        redis: Redis,
        settings: WorkerSettings,
        name: str | None = None,
        parent_pid: int | None = None,
    ) -> None:
        super().__init__(
            [Queue(q, connection=redis, serializer=JSONSerializer) for q in queue_names(settings)],
            name=name or f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}",
            connection=redis,
            serializer=JSONSerializer,
            maintenance_interval=1,
            worker_ttl=30,
        )
        self.settings = settings
        self.records = JobRecords(redis, settings)
        self.chunks = ChunkQueue(redis, settings)
        self.sweeper = Sweeper(redis, settings)
        self.log_job_description = False
        self._parent_pid = parent_pid
        self._horse_pipe = -1
        self._hurry = False
        self._cleaned = time.monotonic()
        self._wake_r, self._wake_w = os.pipe()
        for end in (self._wake_r, self._wake_w):
            os.set_blocking(end, False)

    @property
    def dequeue_timeout(self) -> int:
        """Seconds to block on empty queues; the sweep needs shorter rounds than RQ's half minute."""
        return 1

    def run_maintenance_tasks(self) -> None:
        """Between two polls of the queue: search for lost chunks and, once a minute, RQ's own maintenance."""
        # RQ may have caught the exception of a stop, and not every kernel ends an orphan.
        if self.is_stopping:
            raise StopRequested
        self.sweeper.sweep()
        if self.last_cleaned_at is None or time.monotonic() - self._cleaned > _RQ_MAINTENANCE:
            self._cleaned = time.monotonic()
            super().run_maintenance_tasks()  # type: ignore[no-untyped-call]
        self.last_cleaned_at = now()  # type: ignore[assignment]

    def heartbeat(self, timeout: int | None = None, pipeline: Pipeline | None = None) -> None:  # noqa: ARG002
        """Register for seconds only; RQ would list a dead worker for minutes."""
        super().heartbeat(_REGISTER_TTL, pipeline=pipeline)

    def _is_orphan(self) -> bool:
        return self._parent_pid is not None and os.getppid() != self._parent_pid

    # -- one chunk ---------------------------------------------------------------------------------

    def execute_job(self, job: Job, queue: Queue) -> None:
        """Run one chunk in a work horse."""
        ref = ChunkRef(**job.kwargs)
        try:
            self._beat(ref)
            self.prepare_execution(job)
            self.fork_work_horse(job, queue)
        except StopRequested:
            self._settle(ref, job, RunAgain())
            raise
        self.monitor_work_horse(job, queue)
        self.set_state(WorkerStatus.IDLE)

    def fork_work_horse(self, job: Job, queue: Queue) -> None:
        """Fork; the horse holds one end of a pipe, so that the worker notices its exit at once."""
        reader, writer = os.pipe()
        parent = os.getpid()
        signals = {signal.SIGINT, signal.SIGTERM}
        signal.pthread_sigmask(signal.SIG_BLOCK, signals)
        pid = os.fork()
        if pid == 0:
            with contextlib.suppress(BaseException):
                die_with_parent(parent)
                os.setpgid(0, 0)
                self.setup_work_horse_signals()  # type: ignore[no-untyped-call]
                signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)
                os.close(reader)
                limit_memory(self.settings.memory_limit_mb)
                # without a parent-death signal, this ends an orphan soon after the deadline
                quiet = os.open(os.devnull, os.O_WRONLY)
                faulthandler.dump_traceback_later(
                    self.settings.deadline + _WATCHDOG_MARGIN, exit=True, file=quiet
                )
                self.main_work_horse(job, queue)
            os._exit(1)
        with contextlib.suppress(OSError):
            os.setpgid(pid, pid)
        os.close(writer)
        self._horse_pid, self._horse_pipe = pid, reader
        signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)

    def kill_horse(self, sig: signal.Signals = signal.SIGKILL) -> None:
        """Kill the work horse and its children; RQ's method may hit the worker's own process group."""
        pid = self._horse_pid
        if pid <= 0:
            return
        for kill in (os.killpg, os.kill):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                kill(pid, sig)

    def monitor_work_horse(self, job: Job, _queue: Queue) -> None:
        """Wait for the exit of the work horse, and enforce it at the deadline, a stop or a cancel."""
        ref = ChunkRef(**job.kwargs)
        ended_for = self._watch(ref, job)
        _, status, _ = self.wait_for_horse()
        self._horse_pid = 0
        os.close(self._horse_pipe)
        if self._stopped_job_id == job.id:
            self._stopped_job_id, ended_for = None, ended_for or "canceled"
        self._settle(ref, job, judge_exit(status, ended_for, self.settings))

    def _watch(self, ref: ChunkRef, job: Job) -> str | None:
        """Supervise the horse until it exits; returns the reason for ending it, if the worker did."""
        settings = self.settings
        start = time.monotonic()
        deadline, next_beat, stop_at = start + settings.deadline, start + settings.beat_interval, float("inf")
        ended_for: str | None = None
        while True:
            if self._stop_requested and stop_at == float("inf"):
                stop_at = time.monotonic() + settings.shutdown_grace
            if self._hurry:
                stop_at = min(stop_at, time.monotonic())
            pause = max(0.0, min(deadline, next_beat, stop_at) - time.monotonic())
            ready, _, _ = select.select([self._horse_pipe, self._wake_r], [], [], pause)
            if self._wake_r in ready:
                os.read(self._wake_r, 64)
            if self._horse_pipe in ready:
                return ended_for
            moment = time.monotonic()
            if moment >= deadline:
                ended_for, deadline = "deadline", moment + 1.0
            elif moment >= stop_at:
                ended_for, stop_at, self._hurry = ended_for or "shutdown", moment + 1.0, False
            elif moment >= next_beat:
                next_beat = moment + settings.beat_interval
                self._stop_requested = self._stop_requested or self._is_orphan()
                if not self._is_still_open(ref, job):
                    ended_for = ended_for or "canceled"
            if ended_for is not None:
                self.kill_horse()

    def _is_still_open(self, ref: ChunkRef, job: Job) -> bool:
        try:
            self._beat(ref)
            self.maintain_heartbeats(job)
            self.sweeper.sweep()
            return self.records.is_open(ref)
        except RedisError as error:
            log.warning("heartbeat failed: %s", error)
            return True

    def _beat(self, ref: ChunkRef) -> None:
        ttl = int(self.settings.beat_ttl * 1000)
        self.connection.set(self.records.keys.beat(ref.rq_id), self.name, px=ttl)
        ResultStore(self.connection, self.settings, holder=ref.rq_id).renew_locks()

    def _settle(self, ref: ChunkRef, job: Job, outcome: Outcome | None) -> None:
        """Record the outcome of a chunk whose work horse is gone."""
        try:
            if outcome is None and self.records.is_open(ref):
                outcome = UNANSWERED
            if outcome is not None:
                self._discard(ref, job)
                self._record(ref, outcome)
            self.connection.delete(self.records.keys.beat(ref.rq_id))
        except RedisError as error:
            log.warning("the outcome of %s could not be recorded: %s", ref.rq_id, error)

    def _record(self, ref: ChunkRef, outcome: Outcome) -> None:
        if isinstance(outcome, RunAgain):
            run_again(self.records, self.chunks, ref, outcome.lost, outcome.kind, outcome.detail)
        elif outcome.kind:
            fail(self.records, self.chunks, ref, outcome.kind, outcome.detail)

    def _discard(self, ref: ChunkRef, job: Job) -> None:
        with self.connection.pipeline() as pipe:
            self.cleanup_execution(job, pipeline=pipe)
            pipe.execute()
        self.chunks.discard(ref)

    # -- stopping ----------------------------------------------------------------------------------

    def request_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """First signal: finish the chunk or put it back, then end."""
        signal.signal(signal.SIGINT, self.request_force_stop)
        signal.signal(signal.SIGTERM, self.request_force_stop)
        self._stop_requested = True
        self._wake()
        if self.get_state() != WorkerStatus.BUSY:
            raise StopRequested

    def request_force_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """Second signal: the same without a grace period."""
        self._hurry = True
        self._wake()

    @property
    def is_stopping(self) -> bool:
        """Whether the worker is stopping, on a signal or as an orphan."""
        return self._stop_requested or self._is_orphan()

    def unsubscribe(self) -> None:
        """Stop listening for commands, without the extra second of sleep that RQ's order of steps costs."""
        if self.pubsub_thread is not None and self.pubsub is not None:
            self.pubsub_thread.stop()
            self.pubsub.unsubscribe()
            self.pubsub_thread.join(timeout=1)

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self._wake_w, b"s")


def run_worker(redis_url: str, *, name: str | None = None, parent_pid: int | None = None) -> int:
    """Run one worker until it is stopped; returns the exit status.

    With `parent_pid`, the worker ends at once when that parent process is gone.

    Raises:
        ValidationError: a setting is invalid.
        WorkerError: Redis cannot be reached, or the connection is lost.
    """
    settings = WorkerSettings()
    logging.basicConfig(level=settings.log_level, format="%(asctime)s %(name)s %(levelname)s %(message)s")
    if parent_pid is not None:
        die_with_parent(parent_pid)
    try:
        redis = connect(redis_url)
        redis.ping()
    except (RedisError, ValueError) as error:
        raise WorkerError(f"cannot reach Redis: {error}") from error
    set_context(Context(redis, settings))
    try:
        worker = CuspWorker(redis, settings, name, parent_pid)
        gc.collect()
        gc.freeze()  # the horses share this memory, and a collection would copy it
        worker.work(logging_level=settings.log_level)
        if worker.is_stopping:
            # another signal must not interrupt the last steps of the process
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
        # RQ's loop also ends, and logs the reason, on errors
        return 0 if worker.is_stopping else 1
    except KeyboardInterrupt:
        return 130
    except RedisError as error:
        raise WorkerError(f"lost the connection to Redis: {error}") from error
