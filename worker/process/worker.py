"""The worker process: an RQ worker that has chunks run by a work horse, which it forks and supervises."""

from __future__ import annotations

import contextlib
import itertools
import logging
import os
import secrets
import select
import signal
import socket
import threading
import time
from types import FrameType
from typing import cast

from redis import Redis
from redis.client import Pipeline, PubSub, PubSubWorkerThread
from redis.exceptions import RedisError
from rq import Queue, Worker, worker_registration
from rq.exceptions import StopRequested
from rq.job import Job
from rq.serializers import JSONSerializer
from rq.utils import now
from rq.worker import WorkerStatus

from worker.answers import tables
from worker.answers.kinds import is_batch, kind_of_job
from worker.connection import address
from worker.jobs.attempts import ChunkRef
from worker.jobs.chunks import ChunkQueue
from worker.jobs.interruption import fail, give_up, place, run_again
from worker.jobs.lanes import Duty, lanes_of
from worker.jobs.records import JobRecords
from worker.jobs.roster import Roster
from worker.jobs.sweeper import Sweeper
from worker.logs import about
from worker.process.horse import BeatAlarm, Horse, Task
from worker.process.horse_exit import UNANSWERED, GivenUp, Outcome, RunAgain, judge_exit
from worker.process.os_limits import on_stop_signals, stop_signals_held
from worker.process.outage import Outage
from worker.process.preload import load_numpy
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_REGISTER_TTL = 15
_QUEUE_PATIENCE = 1  # seconds to block on empty queues; heartbeats and the sweep need short rounds
_GOODBYE_PATIENCE = 2.0
_LISTEN_PAUSE = 1.0


class CuspWorker(Worker):
    """A forking RQ worker that

    - kills a work horse at the deadline, even inside C code, and records the deadline as the reason,
    - puts its running chunk back in the queue when it stops,
    - sends heartbeats for its chunk, and searches for chunks that other workers lost,
    - notices by itself that its attempt is over: the job was canceled, or another worker runs the chunk,
    - continues after any error; only a signal ends it.
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
        self.chunks = ChunkQueue(redis, settings)
        orders = [[self.chunks.queues[lane] for lane in order] for order in lanes_of(duty)]
        super().__init__(
            orders[0],
            name=name or f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}",
            connection=redis,
            serializer=JSONSerializer,
            worker_ttl=_REGISTER_TTL,
        )
        self.records = JobRecords(redis, settings)
        self.sweeper = Sweeper(redis, settings)
        self.roster = Roster(redis, settings)
        self._is_light = duty == "light"
        self._orders = itertools.cycle(orders)
        self._parent_pid = parent_pid
        self._horse: Horse | None = None
        self._place = 0
        self._has_had_tables = False
        self._current: str | None = None
        self._hurry = False
        self._is_announced = False
        self._next_sign_on = 0.0
        self._wake_r, self._wake_w = os.pipe()
        for end in (self._wake_r, self._wake_w):
            os.set_blocking(end, False)

    @property
    def connection_timeout(self) -> int:
        """RQ would raise the limit on the time of an answer to this; ours is longer than any wait here."""
        return 0

    def run(self) -> None:
        """Run chunks until a signal comes, whatever happens to Redis.

        RQ's own loop (`work`) ends on a timeout, and on any error outside the wait for a job.
        """
        self.birth_date = now()
        with contextlib.suppress(StopRequested):
            on_stop_signals(self.request_stop)
            self._loop()
        # neither another signal nor a Redis that hangs must hold up the last steps of the process
        on_stop_signals(signal.SIG_IGN)
        self._end_horse()
        goodbye = threading.Thread(target=self._sign_off, daemon=True)
        goodbye.start()
        goodbye.join(_GOODBYE_PATIENCE)

    def _loop(self) -> None:
        outage = Outage()
        while not self.is_stopping:
            try:
                self._round()
                outage.end()
            except StopRequested:
                raise
            except Exception as error:
                self._end_horse()
                select.select([self._wake_r], [], [], outage.note(error))
                self._calm()

    def _round(self) -> None:
        """Run a chunk if there is one; at every beat, register and search for lost chunks before."""
        if time.monotonic() >= self._next_sign_on:
            self.check_for_suspension(burst=False)
            self._sign_on()
            self.sweeper.sweep()
            self._next_sign_on = time.monotonic() + self.settings.beat_interval
        taken = self.connection.blpop([queue.key for queue in next(self._orders)], timeout=_QUEUE_PATIENCE)
        if taken is None:
            return
        key, rq_id = (raw.decode() for raw in cast("tuple[bytes, bytes]", taken))
        job = self._job_of_chunk(rq_id)
        if job is not None:
            with about(job=ChunkRef(**job.kwargs).job_id):
                self.execute_job(job, next(queue for queue in self.queues if queue.key == key))

    def _sign_on(self) -> None:
        """Register again, in case Redis was emptied, and listen for commands."""
        self._register(WorkerStatus.IDLE)
        if self.pubsub_thread is None:
            self.subscribe()  # type: ignore[no-untyped-call]
        if not self._is_announced:
            self._is_announced = True
            for queue in self.queues:
                worker_registration.clean_worker_registry(queue)
            log.info("worker %s ready on %s", self.name, address(self.connection))

    def _sign_off(self) -> None:
        with contextlib.suppress(RedisError):
            self.roster.leave(self.name)
            self.register_death()  # type: ignore[no-untyped-call]
            self.unsubscribe()

    def _job_of_chunk(self, rq_id: str) -> Job | None:
        """Returns the RQ job of a chunk; None if it is gone, or is not a chunk."""
        with self.connection.pipeline(transaction=False) as pipe:
            self.set_state(WorkerStatus.BUSY, pipe)  # from now on a signal lets the chunk finish
            pipe.hgetall(Job.key_for(rq_id))
            *_, fields = pipe.execute()
        if not fields:
            return None
        try:
            job = Job(rq_id, connection=self.connection, serializer=JSONSerializer)
            job.restore(fields)
            if ChunkRef(**job.kwargs).rq_id == rq_id:
                return job
        except Exception as error:
            log.debug("the RQ job %r cannot be read: %s", rq_id, error)
        log.warning("skipped the RQ job %r, which is not a chunk", rq_id)
        return None

    def _register(self, state: WorkerStatus) -> None:
        """Register here and with RQ: each time, since Redis may have been emptied, and for seconds only."""
        self.last_heartbeat = now()
        self.roster.beat(self.name, is_light=self._is_light)
        with self.connection.pipeline(transaction=False) as pipe:
            self.set_state(state, pipe)
            pipe.hset(self.key, mapping=self.serialize())
            pipe.expire(self.key, _REGISTER_TTL)
            worker_registration.register(self, pipe)
            pipe.execute()

    def get_current_job_id(self, pipeline: Pipeline | None = None) -> str | None:  # noqa: ARG002
        """Returns the RQ id of the running chunk; RQ would ask Redis."""
        return self._current

    def _pubsub_exception_handler(
        self, exc: Exception, _pubsub: PubSub, _pubsub_thread: PubSubWorkerThread
    ) -> None:
        """Keep listening for commands; RQ's thread would end on a timeout."""
        log.debug("cannot listen for commands: %s", exc)
        time.sleep(_LISTEN_PAUSE)

    def _is_orphan(self) -> bool:
        return self._parent_pid is not None and os.getppid() != self._parent_pid

    # -- one chunk ---------------------------------------------------------------------------------

    def execute_job(self, job: Job, _queue: Queue) -> None:
        """Have the work horse run one chunk, and record what becomes of it.

        None of RQ's records of executions are kept: the record of the job and the heartbeat hold the state.
        """
        ref, start = ChunkRef(**job.kwargs), time.monotonic()
        self._current = job.id
        self._place = place(self.records, ref)
        horse = self._ready_horse()
        horse.run(Task(ref.rq_id, str(job.func_name), job.kwargs))
        self._has_had_tables = self._has_had_tables or kind_of_job(ref.job_id) is tables.KIND
        ended_for = self._watch(ref, horse)
        is_left = ended_for is None
        status = 0 if is_left and horse.has_stayed() else self._end_horse(is_ending=is_left)
        has_advanced = ended_for == "deadline" and self._has_advanced(ref)
        outcome = judge_exit(status, ended_for, self.settings, has_advanced=has_advanced)
        if outcome is not None:  # else the horse has logged it
            how = f"stopped ({ended_for})" if ended_for else "lost its work horse"
            seconds = time.monotonic() - start
            with about(request_id=self._origin(ref).get("request_id", "")):
                log.info("chunk %d: %s after %.2f s", ref.index, how, seconds)
        self._settle(ref, outcome)
        self._current = None

    def _ready_horse(self) -> Horse:
        """Returns the work horse, a new one if there is none or it has exited since its last chunk."""
        if self._horse is not None and select.select([self._horse], [], [], 0)[0]:
            self._end_horse()
        if self._horse is None:
            with stop_signals_held():  # until it is known here, so that a stop finds it
                if self._has_had_tables:
                    load_numpy()
                self._horse = Horse(self.setup_work_horse_signals, self.settings)
        return self._horse

    def _end_horse(self, *, is_ending: bool = False) -> int | None:
        """Kill the work horse, unless it ends by itself; returns its wait status, None if there is none."""
        horse, status = self._horse, None
        if horse is not None:
            if not is_ending:
                horse.kill()
            status, self._horse = horse.collect(), None
        return status

    def kill_horse(self, _sig: signal.Signals = signal.SIGKILL) -> None:
        """Have the work horse of a stopped chunk killed.

        RQ's thread that listens for commands calls this. By the time it does, the horse may run the next
        chunk, so that the loop below decides.
        """
        self._wake()

    def _has_advanced(self, ref: ChunkRef) -> bool:
        with contextlib.suppress(RedisError):
            return place(self.records, ref) > self._place
        return False

    def _origin(self, ref: ChunkRef) -> dict[str, str]:
        with contextlib.suppress(RedisError):
            return self.records.origin(ref.job_id)
        return {}

    def _watch(self, ref: ChunkRef, horse: Horse) -> str | None:
        """Supervise the horse until its chunk is done; returns why the worker ended it, if it did."""
        # sooner than another worker may take the chunk over
        patience = self.settings.beat_ttl + self.settings.lost_grace / 2
        with BeatAlarm(patience, horse.kill) as alarm:
            return self._supervise(ref, horse, alarm) or ("silence" if alarm.has_rung else None)

    def _supervise(self, ref: ChunkRef, horse: Horse, alarm: BeatAlarm) -> str | None:
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
            ready, _, _ = select.select([horse.fileno(), self._wake_r], [], [], pause)
            if self._wake_r in ready:
                self._calm()
            if horse.fileno() in ready:
                return ended_for
            moment = time.monotonic()
            if self._stopped_job_id == self._current and ended_for is None:
                ended_for = "canceled"
            elif moment >= deadline:
                ended_for, deadline = "deadline", moment + 1.0
            elif moment >= stop_at:
                ended_for, stop_at, self._hurry = ended_for or "shutdown", moment + 1.0, False
            elif moment >= next_beat:
                next_beat = moment + settings.beat_interval
                self._stop_requested = self._stop_requested or self._is_orphan()
                if not self._is_still_open(ref, alarm):
                    ended_for = ended_for or "canceled"
            if ended_for is not None:
                horse.kill()

    def _is_still_open(self, ref: ChunkRef, alarm: BeatAlarm) -> bool:
        try:
            is_open = self.records.beat(ref, self.name)
            alarm.reset()
            self._register(WorkerStatus.BUSY)
            self.sweeper.sweep()
            return is_open
        except RedisError as error:
            log.warning("heartbeat failed: %s", error)
            return True

    def _settle(self, ref: ChunkRef, outcome: Outcome | None) -> None:
        """Record the outcome of a chunk whose work horse is gone."""
        try:
            if self.records.end_beat(ref) and outcome is None:
                outcome = UNANSWERED
            if outcome is not None:
                self._record(ref, outcome)
        except RedisError as error:
            log.warning("the outcome of %s could not be recorded: %s", ref.rq_id, error)

    def _record(self, ref: ChunkRef, outcome: Outcome) -> None:
        if isinstance(outcome, RunAgain):
            run_again(self.records, self.chunks, ref, outcome.lost, outcome.kind, outcome.detail)
        elif isinstance(outcome, GivenUp) or (outcome.kind and is_batch(ref.job_id)):
            give_up(self.records, self.chunks, ref, outcome.kind, outcome.detail)
        elif outcome.kind:
            fail(self.records, self.chunks, ref, outcome.kind, outcome.detail)

    # -- stopping ----------------------------------------------------------------------------------

    def request_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """First signal: finish the chunk or put it back, then end."""
        on_stop_signals(self.request_force_stop)
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

    def _calm(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.read(self._wake_r, 64)
