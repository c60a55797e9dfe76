"""The worker process: it has chunks run by work horses, which it forks and supervises.

RQ's own worker is not used: it ends on a timeout of Redis, and on any error outside the wait for a job. What
others see of a worker by RQ's means is in `presence`.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
import logging
import os
import random
import secrets
import select
import signal
import socket
import threading
import time
from collections.abc import Sequence
from math import inf
from types import FrameType

from redis import Redis
from redis.exceptions import RedisError
from rq.worker import WorkerStatus

from worker import tracing
from worker.connection import Search, UnreachableError, address, connect, eviction_warning
from worker.jobs import Lane, check_lifetimes, lanes_of
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkQueue
from worker.jobs.upkeep import Sweeper
from worker.logs import set_up
from worker.process.horse import load_solver
from worker.process.presence import Commands, Presence
from worker.process.processes import die_with_parent, on_stop_signals
from worker.process.runs import Runs
from worker.process.tasks import Archivist, Context, set_context
from worker.settings import Duty, WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_QUEUE_WAIT = 1  # seconds to block on empty queues; heartbeats and the sweep need short rounds
_SIGN_OFF_TIMEOUT = 2.0
_TICK = 0.05
_FORCED_STOP_PAUSE = 1.0
_SHORTEST_PAUSE, _LONGEST_PAUSE = 0.1, 10.0


class StopWhileIdle(BaseException):
    """A stop signal came while no chunk runs, so that the worker can end at once."""


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


class Wakeup:
    """A pipe by which signals and other threads end the wait of the worker's loop."""

    def __init__(self) -> None:
        self._reader, self._writer = os.pipe()
        for end in (self._reader, self._writer):
            os.set_blocking(end, False)

    def fileno(self) -> int:
        """Returns the file that can be read once the loop is to wake."""
        return self._reader

    def wake(self) -> None:
        """Wake the loop."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._writer, b"w")

    def drain(self) -> None:
        """Clear the wake-up calls so far."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._reader, 64)


class Worker:
    """A process that takes chunks from the queue, and supervises the work horses that run them. It

    - kills a work horse at the deadline, even inside C code, and records the deadline as the reason,
    - puts its running chunk back in the queue when it stops,
    - with light duty, runs small chunks in parallel to one that takes longer than most,
    - sends heartbeats for its chunks, and searches for chunks that other workers lost,
    - stops a chunk whose attempt is over: the job was canceled, or another worker runs the chunk,
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
        self.redis = redis
        self.settings = settings
        self.name = name or f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(3)}"
        is_light = duty == "light"
        orders = lanes_of(duty)
        self._orders = itertools.cycle(orders)
        self._parent_pid = parent_pid
        self._chunks = ChunkQueue(redis, settings)
        queues = [self._chunks.queues[lane] for lane in orders[0]]
        self._presence = Presence(redis, settings, self.name, queues, is_light=is_light)
        self._wakeup = Wakeup()
        self._commands = Commands(redis, self._presence.channel, self._wakeup.wake)
        self._sweeper = Sweeper(redis, settings)
        self._archivist = Archivist(redis, settings)
        self._runs = Runs(Attempts(redis, settings), self._chunks, settings, self.name, is_light=is_light)
        self._is_announced = self._is_suspended = self._is_busy = False
        self._stop_requested = self._forced_stop = False
        self._next_sign_on = self._next_beat = 0.0
        self._stop_at = inf

    def run(self) -> None:
        """Run chunks until a signal, through any outage of Redis."""
        with contextlib.suppress(StopWhileIdle):
            on_stop_signals(self._request_stop)
            self._loop()
        # neither another signal nor a Redis that hangs may delay the end of the process
        on_stop_signals(signal.SIG_IGN)
        self._runs.abandon()
        self._archivist.end()
        sign_off = threading.Thread(target=self._sign_off, daemon=True)
        sign_off.start()
        sign_off.join(_SIGN_OFF_TIMEOUT)

    def _loop(self) -> None:
        outage = Outage()
        while self._runs.running or not self.is_stopping:
            try:
                self._round()
                outage.end()
            except Exception as error:
                self._runs.abandon()
                self._wait(outage.note(error))

    def _round(self) -> None:
        """Begin a chunk if there is one, or attend to those that run; at every beat, register and search for
        lost chunks before."""
        self._is_busy = bool(self._runs.running)
        if self._is_busy:
            self._attend()
            if self._runs.running and self._runs.is_light and not self.is_stopping:
                self._run_small_chunks()
            return
        if time.monotonic() >= self._next_sign_on:
            self._archivist.look_after()
            self._sign_on()
            self._sweeper.sweep()
            self._next_sign_on = time.monotonic() + self.settings.beat_interval
        if self._is_suspended:
            self._wait(self.settings.beat_interval)
            return
        rq_id = self._chunks.pop(next(self._orders), _QUEUE_WAIT)
        self._is_busy = rq_id is not None  # from now on a signal lets the chunk finish
        if rq_id is not None and (taken := self._chunks.read(rq_id)) is not None:
            self._next_beat = time.monotonic() + self.settings.beat_interval
            self._runs.begin(*taken)

    def _sign_on(self) -> None:
        """Register again, in case Redis was emptied, and listen for commands."""
        self._is_suspended = self._presence.is_suspended()
        self._presence.beat(WorkerStatus.SUSPENDED if self._is_suspended else WorkerStatus.IDLE)
        self._commands.listen()
        if not self._is_announced:
            self._is_announced = True
            self._presence.tidy()
            log.info("worker %s ready on %s", self.name, address(self.redis))

    def _sign_off(self) -> None:
        with contextlib.suppress(RedisError):
            self._presence.leave()
            self._commands.end()

    def _wait(self, seconds: float) -> bool:
        """Wait, unless something wakes the worker; returns whether it did."""
        is_woken = bool(select.select([self._wakeup], [], [], seconds)[0])
        self._wakeup.drain()
        return is_woken

    # -- chunks that run ---------------------------------------------------------------------------

    def _attend(self) -> None:
        """Wait until a chunk that runs needs attention, and give it."""
        settings, runs = self.settings, self._runs
        if self._stop_requested and self._stop_at == inf:
            self._stop_at = time.monotonic() + settings.shutdown_grace
        if self._forced_stop:
            self._stop_at = min(self._stop_at, time.monotonic())
        look = min(runs.next_look(self._next_beat), self._stop_at)
        horses = [run.horse.fileno() for run in runs.running]
        ready, _, _ = select.select(
            [*horses, self._wakeup.fileno()], [], [], max(0.0, look - time.monotonic())
        )
        self._wakeup.drain()
        runs.attend(ready, self._commands.stopped_chunks())
        if time.monotonic() >= self._stop_at:
            runs.end("shutdown")
            self._stop_at, self._forced_stop = time.monotonic() + _FORCED_STOP_PAUSE, False
        if time.monotonic() >= self._next_beat:
            self._next_beat = time.monotonic() + settings.beat_interval
            self._stop_requested = self.is_stopping
            self._send_beats()

    def _send_beats(self) -> None:
        try:
            self._archivist.look_after()
            self._runs.beat()
            self._presence.beat(WorkerStatus.BUSY)
            self._sweeper.sweep()
        except RedisError as error:
            log.warning("heartbeat failed: %s", error)

    def _run_small_chunks(self) -> None:
        """Begin a small chunk in parallel to those that take longer, if one waits.

        Beside shares of a computation alone it may be any short one.
        """
        try:
            if self._runs.may_begin_another:
                are_shares = all(run.is_share for run in self._runs.running)
                beside: Sequence[Lane] = next(self._orders) if are_shares else ["small"]
                rq_id = self._chunks.pop([lane for lane in beside if lane != "shared"])
                taken = None if rq_id is None else self._chunks.read(rq_id)
                if taken is not None:
                    self._runs.begin(*taken)
            elif self._runs.is_full and self._chunks.depths()["small"]:
                self._runs.relieve()
        except (RedisError, OSError) as error:  # no process can be forked, either
            log.warning("cannot start another chunk: %s", error)

    # -- stopping ----------------------------------------------------------------------------------

    @property
    def is_stopping(self) -> bool:
        """Whether the worker is stopping, on a signal or because its parent has ended."""
        return self._stop_requested or self._parent_pid not in (None, os.getppid())

    def _request_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """First signal: finish the chunk or put it back, then end."""
        on_stop_signals(self._force_stop)
        self._stop_requested = True
        self._wakeup.wake()
        if not self._is_busy:
            raise StopWhileIdle

    def _force_stop(self, _signum: int, _frame: FrameType | None) -> None:
        """Second signal: without a grace period."""
        self._forced_stop = True
        self._wakeup.wake()


class WorkerError(Exception):
    """The worker cannot start; the message is for the user."""


def run_worker(
    redis_url: str, *, name: str | None = None, parent_pid: int | None = None, duty: Duty = "all"
) -> int:
    """Run one worker until it is stopped; returns the exit status.

    With light duty it takes short chunks only. With `parent_pid`, it ends at once when that parent process is
    gone. If Redis is not there yet, it waits for it.

    Raises:
        ValidationError, InputError: a setting is invalid.
        WorkerError: Redis cannot be used, and will not be by waiting.
    """
    settings = WorkerSettings()
    check_lifetimes(settings)
    level = (settings.log_level or "INFO").upper()
    set_up(level, settings.log_format)
    tracing.prepare("worker")
    # at INFO, a chunk is one line of ours and several of RQ's
    logging.getLogger("rq.worker").setLevel("WARNING" if level == "INFO" else level)
    if parent_pid is not None:
        die_with_parent(parent_pid)
    try:
        if not _reached(redis_url, parent_pid):
            return 0
        redis = connect(redis_url)
        warning = None if parent_pid else eviction_warning(redis)  # else its parent says so
        worker = Worker(redis, settings, name, parent_pid, duty)
    except UnreachableError as error:
        raise WorkerError(str(error)) from error
    except RedisError as error:
        raise WorkerError(f"lost the connection to Redis: {error}") from error
    if warning is not None:
        log.warning("%s", warning)
    set_context(Context(redis, settings, worker.name))
    load_solver()
    gc.collect()
    gc.freeze()  # the horses share this memory, and a collection would copy it
    worker.run()
    return 0


def _reached(redis_url: str, parent_pid: int | None) -> bool:
    """Wait for Redis; returns False if a stop signal comes, or the parent ends, before it is there.

    Raises:
        UnreachableError: waiting is of no use.
    """
    stop = threading.Event()
    before = on_stop_signals(lambda *_: stop.set())
    try:
        search = Search(
            redis_url, log.warning if parent_pid is None else log.debug
        )  # the parent says so itself
        while not search.is_over:
            if stop.is_set() or parent_pid not in (None, os.getppid()):
                return False
            time.sleep(_TICK)
        if search.problem is not None:
            raise search.problem
        return True
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
