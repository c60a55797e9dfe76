"""The worker process: an RQ worker that has chunks run by work horses, which it forks and supervises."""

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
from rq import Worker, worker_registration
from rq.exceptions import StopRequested
from rq.job import Job
from rq.serializers import JSONSerializer
from rq.utils import now
from rq.worker import WorkerStatus

from worker.connection import address
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkQueue, ChunkRef
from worker.jobs.installation import Roster
from worker.jobs.lanes import Duty, lanes_of
from worker.jobs.recovery import Sweeper
from worker.process.os_limits import on_stop_signals
from worker.process.outage import Outage
from worker.process.runs import Runs
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
    - if it has light duty, does not let a chunk that takes longer than most hold up a small one,
    - sends heartbeats for its chunks, and searches for chunks that other workers lost,
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
        self.attempts = Attempts(redis, settings)
        self.sweeper = Sweeper(redis, settings)
        self.roster = Roster(redis, settings)
        self._runs = Runs(
            *(self.attempts, self.chunks, settings, self.name, self.setup_work_horse_signals),
            is_light=duty == "light",
        )
        self._orders = itertools.cycle(orders)
        self._parent_pid = parent_pid
        self._current: str | None = None
        self._hurry = False
        self._is_announced = False
        self._next_sign_on = self._next_beat = 0.0
        self._stop_at = float("inf")
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
        self._runs.abandon()
        goodbye = threading.Thread(target=self._sign_off, daemon=True)
        goodbye.start()
        goodbye.join(_GOODBYE_PATIENCE)

    def _loop(self) -> None:
        outage = Outage()
        while self._runs.running or not self.is_stopping:
            try:
                self._round()
                outage.end()
            except StopRequested:
                raise
            except Exception as error:
                self._runs.abandon()
                select.select([self._wake_r], [], [], outage.note(error))
                self._calm()

    def _round(self) -> None:
        """Begin a chunk if there is one, or attend to those that run; at every beat, register and search for
        lost chunks before."""
        if self._runs.running:
            self._attend()
            if self._runs.running and self._runs.is_light and not self.is_stopping:
                self._give_way()
            return
        if time.monotonic() >= self._next_sign_on:
            self.check_for_suspension(burst=False)
            self._sign_on()
            self.sweeper.sweep()
            self._next_sign_on = time.monotonic() + self.settings.beat_interval
        taken = self.connection.blpop([queue.key for queue in next(self._orders)], timeout=_QUEUE_PATIENCE)
        if taken is None:
            return
        job = self._job_of_chunk(cast("tuple[bytes, bytes]", taken)[1].decode())
        if job is not None:
            self._next_beat = time.monotonic() + self.settings.beat_interval
            self._begin(job)

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
        self.roster.beat(self.name, is_light=self._runs.is_light)
        with self.connection.pipeline(transaction=False) as pipe:
            self.set_state(state, pipe)
            pipe.hset(self.key, mapping=self.serialize())
            pipe.expire(self.key, _REGISTER_TTL)
            worker_registration.register(self, pipe)
            pipe.execute()

    def kill_horse(self, _sig: signal.Signals = signal.SIGKILL) -> None:
        """Have the work horse of a stopped chunk killed.

        RQ's thread that listens for commands calls this. By the time it does, the horse may run the next
        chunk, so that the loop decides.
        """
        self._wake()

    def get_current_job_id(self, pipeline: Pipeline | None = None) -> str | None:  # noqa: ARG002
        """Returns the RQ id of the chunk begun last; RQ would ask Redis."""
        return self._current

    def _pubsub_exception_handler(
        self, exc: Exception, _pubsub: PubSub, _pubsub_thread: PubSubWorkerThread
    ) -> None:
        """Keep listening for commands; RQ's thread would end on a timeout."""
        log.debug("cannot listen for commands: %s", exc)
        time.sleep(_LISTEN_PAUSE)

    def _is_orphan(self) -> bool:
        return self._parent_pid is not None and os.getppid() != self._parent_pid

    # -- chunks ------------------------------------------------------------------------------------

    def _begin(self, job: Job) -> None:
        self._current = job.id
        self._runs.begin(ChunkRef(**job.kwargs), str(job.func_name), job.kwargs)

    def _attend(self) -> None:
        """Wait until something happens to the chunks that run, and see to it."""
        settings, runs = self.settings, self._runs
        if self._stop_requested and self._stop_at == float("inf"):
            self._stop_at = time.monotonic() + settings.shutdown_grace
        if self._hurry:
            self._stop_at = min(self._stop_at, time.monotonic())
        look = min(runs.next_look(self._next_beat), self._stop_at)
        files = [run.horse.fileno() for run in runs.running]
        ready, _, _ = select.select([*files, self._wake_r], [], [], max(0.0, look - time.monotonic()))
        if self._wake_r in ready:
            self._calm()
        runs.attend(ready, self._stopped_job_id)
        if time.monotonic() >= self._stop_at:
            runs.end("shutdown")
            self._stop_at, self._hurry = time.monotonic() + 1.0, False
        if time.monotonic() >= self._next_beat:
            self._next_beat = time.monotonic() + settings.beat_interval
            self._stop_requested = self._stop_requested or self._is_orphan()
            self._send_beats()

    def _send_beats(self) -> None:
        try:
            self._runs.beat()
            self._register(WorkerStatus.BUSY)
            self.sweeper.sweep()
        except RedisError as error:
            log.warning("heartbeat failed: %s", error)

    def _give_way(self) -> None:
        """Begin a small chunk beside those that take longer, if one waits."""
        small = self.chunks.queues["small"].key
        try:
            if self._runs.may_begin_another:
                taken = cast("bytes | None", self.connection.lpop(small))
                job = taken and self._job_of_chunk(taken.decode())
                if job:
                    self._begin(job)
            elif self._runs.is_full and self.connection.llen(small):
                self._runs.relieve()
        except (RedisError, OSError) as error:  # no process can be forked, either
            log.warning("no other chunk can be begun: %s", error)

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
