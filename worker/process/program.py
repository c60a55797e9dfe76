"""The start of a worker process."""

from __future__ import annotations

import gc
import logging
import os
import signal
import threading
import time

from redis.exceptions import RedisError
from rq.version import VERSION

from worker import tracing
from worker.connection import Search, UnreachableError, connect, eviction_warning
from worker.logs import set_up
from worker.process.horse import load_solver
from worker.process.processes import die_with_parent, on_stop_signals
from worker.process.worker import Worker
from worker.settings import Duty, WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_TICK = 0.05

_RQ = "2.12"
"""The version of RQ whose worker ours is made from: RQ 3 performs a job in another way."""


class WorkerError(Exception):
    """The worker cannot start; the message is for the user."""


def run_worker(
    redis_url: str, *, name: str | None = None, parent_pid: int | None = None, duty: Duty = "all"
) -> int:
    """Run one worker until it is stopped; returns the exit status.

    With light duty it takes small chunks only. With `parent_pid`, it ends at once when that parent process is
    gone. If Redis is not there yet, it waits for it.

    Raises:
        ValidationError: a setting is invalid.
        WorkerError: Redis cannot be used, and will not be by waiting; or RQ is of another version.
    """
    if not VERSION.startswith(f"{_RQ}."):
        raise WorkerError(f"the worker needs RQ {_RQ}, and RQ {VERSION} is installed")
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
        worker = Worker(redis, settings, name, parent_pid, duty)
    except UnreachableError as error:
        raise WorkerError(str(error)) from error
    except RedisError as error:
        raise WorkerError(f"lost the connection to Redis: {error}") from error
    if warning is not None:
        log.warning("%s", warning)
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
