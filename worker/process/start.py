"""The start of a worker process."""

from __future__ import annotations

import gc
import logging
import os
import signal
import threading

from redis.exceptions import RedisError

from worker import tracing
from worker.connection import UnreachableError, connect, eviction_warning, wait_for
from worker.jobs.lanes import Duty
from worker.logs import set_up
from worker.process.horse import load_solver
from worker.process.os_limits import die_with_parent, on_stop_signals
from worker.process.tasks import Context, set_context
from worker.process.worker import CuspWorker
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")


class WorkerError(Exception):
    """The worker cannot start; the message is for the user."""


def run_worker(
    redis_url: str, *, name: str | None = None, parent_pid: int | None = None, duty: Duty = "all"
) -> int:
    """Run one worker until it is stopped; returns the exit status.

    With light duty it takes short chunks only. With `parent_pid`, it ends at once when that parent process is
    gone. If Redis is not there yet, it waits for it.

    Raises:
        ValidationError: a setting is invalid.
        WorkerError: Redis cannot be used, and will not be by waiting.
    """
    settings = WorkerSettings()
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
        worker = CuspWorker(redis, settings, name, parent_pid, duty)
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
        return wait_for(
            redis_url,
            lambda: not stop.is_set() and parent_pid in (None, os.getppid()),
            log.warning if parent_pid is None else log.debug,  # the parent says so itself
        )
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
