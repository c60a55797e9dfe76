"""The work horse: a forked process that runs chunks one after the other, as it and its worker see it."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import resource
import select
import signal
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from types import FrameType
from typing import Any, Literal

from redis.exceptions import RedisError
from rq.utils import import_attribute

import rpr_solver
from worker.jobs.chunks import Lost
from worker.process.processes import (
    STOP_SIGNALS,
    die_with_parent,
    limit_memory,
    on_stop_signals,
    signal_name,
    signal_of,
    stop_signals_held,
)
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

UNRECORDED = 75
"""The exit status of a work horse that could not record its outcome, because Redis did not take it."""

_WATCHDOG_MARGIN = 15.0
_MAX_CHUNKS = 200
_MAX_GROWTH_BYTES = 32 * 2**20
_MAXRSS_UNIT = 1 if sys.platform == "darwin" else 1024
_STAYS = b"\n"
_LOWEST_PRIORITY = 19  # niceness


def load_solver() -> None:
    """Import all of the solver, and solve a slice: what is kept of it makes the first job as fast as others.

    Its package loads a room only when a name in it is first used.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # no threads: no fork survives them
    for name in dir(rpr_solver):
        getattr(rpr_solver, name)
    for name in ("rpr_solver.figures", "rpr_solver.slices.fast"):
        import_module(name)
    rpr_solver.solve_slice(rpr_solver.eliminate(rpr_solver.EXAMPLES["innocenti"]), "14.98")


@dataclass(frozen=True)
class ExitOutcome:
    """The outcome of a chunk that its work horse could not record.

    Attributes:
        then: the chunk is run `again`; if it was lost too often, its slice or its job fails as described. Or
            the slice or item being processed is `given-up`, or else the job. Or the job has `failed`; with an
            empty kind, nothing is recorded.
        kind: the reason of the failure.
        detail: the same in words.
        lost: what is counted as lost.
    """

    then: Literal["again", "given-up", "failed"]
    kind: str = ""
    detail: str = ""
    lost: Lost = ""


UNANSWERED = ExitOutcome(
    "again", "worker-crashed", "The worker repeatedly ended without an answer.", "horses"
)
"""The outcome of a work horse that ended normally, but left its chunk open."""


def judge_exit(
    status: int, ended_for: str | None, settings: WorkerSettings, *, has_advanced: bool = False
) -> ExitOutcome | None:
    """Returns the outcome for a wait status, or None if the horse ended normally and has recorded everything.

    `ended_for` is the worker's reason for ending the horse, if it did. `has_advanced`: items of a batch were
    done in this attempt, so that the current one has not had all of the time.
    """
    if status == 0:
        return None
    if ended_for in ("shutdown", "silence") or (ended_for == "deadline" and has_advanced):
        return ExitOutcome("again")
    if ended_for == "deadline":
        limit_text = f"The computation was stopped at the time limit of {settings.deadline:g} s."
        return ExitOutcome("failed", "timeout", limit_text)
    if ended_for is not None:
        return ExitOutcome("failed")
    if os.waitstatus_to_exitcode(status) == UNRECORDED:
        return ExitOutcome("again", "worker-lost", "The answer could not be kept repeatedly.", "workers")
    number = signal_of(status)
    if number is None:
        return ExitOutcome("again", "worker-crashed", "The worker crashed repeatedly.", "horses")
    how = f"The worker was terminated by signal {number} ({signal_name(number)})"
    if number == signal.SIGABRT:
        limit = settings.memory_limit_mb
        of = f" of {limit} MiB" if limit else ""
        return ExitOutcome("given-up", "resource-exhausted", f"{how}, most likely at the memory limit{of}.")
    return ExitOutcome("again", "worker-crashed", f"{how}, repeatedly.", "horses")


@dataclass(frozen=True)
class Task:
    """What a horse is to run: the function of an RQ job, which returns whether the horse may run another."""

    id: str
    function: str
    arguments: Mapping[str, Any]


class Horse:
    """A work horse, as its worker sees it.

    It waits for tasks. After each that ends well it stays for another one, until it has run many or its
    memory has grown. Otherwise it exits, so that a corrupted process
    runs no other chunk.
    """

    def __init__(self, settings: WorkerSettings, others: Iterable[Horse] = ()) -> None:
        """Fork the process; call it while stop signals are held.

        Args:
            settings: its limits.
            others: the other horses of the worker, whose pipes it does not keep open.

        Raises:
            OSError: there can be no more processes.
        """
        orders, self._tasks = os.pipe()
        self._ends, answers = os.pipe()
        parent = os.getpid()
        try:
            self.pid = os.fork()
        except OSError:
            for end in (orders, self._tasks, self._ends, answers):
                os.close(end)
            raise
        if self.pid == 0:
            with contextlib.suppress(BaseException):
                die_with_parent(parent)
                os.setpgid(0, 0)
                on_stop_signals(signal.SIG_DFL)
                signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the worker, which decides
                signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
                for horse in (self, *others):
                    horse.close()
                limit_memory(settings.memory_limit_mb)
                os.nice(settings.niceness)  # the API answers known questions meanwhile
                os._exit(_serve(orders, answers, settings.deadline + _WATCHDOG_MARGIN))
            os._exit(1)
        with contextlib.suppress(OSError):
            os.setpgid(self.pid, self.pid)
        os.close(orders)
        os.close(answers)

    def fileno(self) -> int:
        """Returns a file that can be read once the horse has done its task, or has exited."""
        return self._ends

    def run(self, task: Task) -> None:
        """Have the horse run a task; if it has exited, that shows at once."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self._tasks, json.dumps(asdict(task)).encode() + b"\n")

    def has_stayed(self) -> bool:
        """Whether it waits for another task; otherwise it exits. Call it once it can be read."""
        return os.read(self._ends, 1) == _STAYS

    def kill(self) -> None:
        """Kill the horse and its children, if they still run."""
        for kill in (os.killpg, os.kill):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                kill(self.pid, signal.SIGKILL)

    def collect(self) -> int:
        """Wait for its exit; returns the wait status."""
        _, status = os.waitpid(self.pid, 0)
        self.close()
        return status

    def end(self) -> int:
        """Kill it, and wait for its exit; returns the wait status."""
        self.kill()
        return self.collect()

    def close(self) -> None:
        """Close this process's ends of its pipes."""
        os.close(self._tasks)
        os.close(self._ends)

    def lower_priority(self) -> None:
        """Give it only the idle time of the processors."""
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PGRP, self.pid, _LOWEST_PRIORITY)


def _serve(orders: int, answers: int, seconds: float) -> int:
    """Run tasks in this process, a work horse, until one corrupts it; returns its exit status."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    limit = _peak_memory() + _MAX_GROWTH_BYTES
    with os.fdopen(orders, "rb") as lines:
        for count, line in enumerate(lines, 1):
            # without a parent-death signal, this ends an orphan soon after the deadline, in whatever C call
            signal.setitimer(signal.ITIMER_REAL, seconds)
            status, is_sound = _perform(Task(**json.loads(line)))
            signal.setitimer(signal.ITIMER_REAL, 0)
            if status or not is_sound or count == _MAX_CHUNKS or _peak_memory() > limit:
                return status
            os.write(answers, _STAYS)
    return 0  # the worker is gone


def _perform(task: Task) -> tuple[int, bool]:
    """Run a task; returns its exit status, and whether the process may run another."""
    try:
        is_sound = import_attribute(task.function)(**task.arguments)
    except RedisError as error:
        log.warning("the outcome of %s could not be recorded: %s", task.id, error)
        return UNRECORDED, False
    except Exception:
        log.exception("%s failed", task.id)
        return 1, False
    return 0, is_sound is True


def _peak_memory() -> int:
    """Returns the maximum memory that this process has used, in bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _MAXRSS_UNIT


class IdleHorse:
    """The work horse of a worker that waits for a chunk, if there is one."""

    def __init__(self, settings: WorkerSettings) -> None:
        self.settings = settings
        self._horse: Horse | None = None

    def take(self, others: Iterable[Horse]) -> Horse:
        """Returns it, or a new one if there is none or it has exited since its last chunk.

        Raises:
            OSError: there can be no more processes.
        """
        if self._horse is not None and select.select([self._horse], [], [], 0)[0]:
            self.end()
        if self._horse is None:
            with stop_signals_held():  # until it is known here, so that a stop finds it
                self._horse = Horse(self.settings, others)
        horse, self._horse = self._horse, None
        return horse

    def keep(self, horse: Horse) -> None:
        """Let a horse wait for the next chunk, unless another one does."""
        if self._horse is None:
            self._horse = horse
        else:
            horse.end()

    def end(self) -> None:
        """End it."""
        if self._horse is not None:
            self._horse.end()
            self._horse = None


class BeatAlarm:
    """A timer that acts once no heartbeat has succeeded for `seconds`, even while Redis is waited for.

    From then on another worker may run the chunks, and none may run twice at once. Use it in the main thread.
    """

    def __init__(self, seconds: float, act: Callable[[], None]) -> None:
        self._seconds, self._act = seconds, act
        self._before: Any = None

    def set(self) -> None:
        """Start the timer: chunks run from now on."""
        self._before = signal.signal(signal.SIGALRM, self._ring)
        self.reset()

    def reset(self) -> None:
        """Restart the wait, because a heartbeat has succeeded."""
        signal.setitimer(signal.ITIMER_REAL, self._seconds)

    def clear(self) -> None:
        """Stop the timer: no chunk runs any more."""
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self._before)

    def _ring(self, _signum: int, _frame: FrameType | None) -> None:
        self._act()
