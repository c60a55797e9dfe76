"""The work horse: its fork, what it runs, and its end when nobody can know of it any more."""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import signal
from collections.abc import Callable
from types import FrameType
from typing import Any, Self

from redis.exceptions import RedisError
from rq.job import Job

from worker.process.horse_exit import UNRECORDED
from worker.process.os_limits import STOP_SIGNALS, die_with_parent, limit_memory, on_stop_signals
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_WATCHDOG_MARGIN = 15.0


def forked(
    run: Callable[[], int], set_signals: Callable[[], None], settings: WorkerSettings
) -> tuple[int, int]:
    """Fork a process that exits with what `run` returns; call it while stop signals are held.

    Returns its pid, and the end of a pipe that can be read once it has exited.

    Args:
        run: what the process does.
        set_signals: how it takes signals; they are held until then.
        settings: its limits.

    Raises:
        OSError: there can be no more processes.
    """
    reader, writer = os.pipe()
    parent = os.getpid()
    try:
        pid = os.fork()
    except OSError:
        for end in (reader, writer):
            os.close(end)
        raise
    if pid == 0:
        with contextlib.suppress(BaseException):
            die_with_parent(parent)
            os.setpgid(0, 0)
            on_stop_signals(signal.SIG_DFL)
            set_signals()
            signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
            os.close(reader)
            limit_memory(settings.memory_limit_mb)
            os.nice(settings.niceness)  # the API answers known questions meanwhile
            # without a parent-death signal, this ends an orphan soon after the deadline
            quiet = os.open(os.devnull, os.O_WRONLY)
            faulthandler.dump_traceback_later(settings.deadline + _WATCHDOG_MARGIN, exit=True, file=quiet)
            os._exit(run())
        os._exit(1)
    with contextlib.suppress(OSError):
        os.setpgid(pid, pid)
    os.close(writer)
    return pid, reader


def kill_with_children(pid: int, sig: signal.Signals) -> None:
    """Send a signal to a work horse and its children, if they still run."""
    for kill in (os.killpg, os.kill):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(pid, sig)


def perform(job: Job) -> int:
    """Run a chunk in this process, the work horse; returns its exit status."""
    try:
        job.func(**job.kwargs)
    except RedisError as error:
        log.warning("the outcome of %s could not be recorded: %s", job.id, error)
        return UNRECORDED
    except Exception:
        log.exception("%s failed", job.id)
        return 1
    return 0


class BeatAlarm:
    """Acts once no heartbeat has succeeded for `seconds`, while the main thread may be waiting for Redis.

    From then on another worker may run the chunk, and no two must at once. Use it in the main thread.

    Attributes:
        has_rung: whether it has acted.
    """

    def __init__(self, seconds: float, act: Callable[[], None]) -> None:
        self.has_rung = False
        self._seconds, self._act = seconds, act
        self._before: Any = None

    def __enter__(self) -> Self:
        self._before = signal.signal(signal.SIGALRM, self._ring)
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self._before)

    def reset(self) -> None:
        """Begin to wait anew: a heartbeat has succeeded."""
        signal.setitimer(signal.ITIMER_REAL, self._seconds)

    def _ring(self, _signum: int, _frame: FrameType | None) -> None:
        self.has_rung = True
        self._act()
