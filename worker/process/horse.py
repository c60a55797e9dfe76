"""The work horse: a forked process that performs RQ jobs one after the other, as it and its worker see it.

A fork for each job, as RQ has it, costs several times a small job. A horse stays instead, until a job has not
ended well, its memory has grown, or it has performed many.
"""

from __future__ import annotations

import contextlib
import os
import random
import resource
import select
import signal
import sys
from collections.abc import Callable
from importlib import import_module

import rpr_solver
from worker.process.processes import (
    STOP_SIGNALS,
    die_with_parent,
    limit_memory,
    on_stop_signals,
    stop_signals_held,
)
from worker.settings import WorkerSettings

NICENESS = 10
"""By how much work horses leave the cores to others (nice): the API answers known questions meanwhile."""

UNRECORDED = 75
"""The exit status of a work horse that could not record its outcome, because Redis did not take it."""

_STAYS, _LEAVES = b"\n", b"x"
_MAX_JOBS = 200  # so that a slow leak ends
_MAX_GROWTH_BYTES = 32 << 20  # of the peak, so that each job has the memory limit except for that
_MAXRSS_UNIT = 1 if sys.platform == "darwin" else 1024


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


class Horse:
    """A work horse, as its worker sees it.

    Args:
        settings: its limits.
        perform: what it does with each order, in its own process; returns whether it may do another.

    Raises:
        OSError: there can be no more processes.
    """

    def __init__(self, settings: WorkerSettings, perform: Callable[[str], bool]) -> None:
        orders, self._orders = os.pipe()
        self._ends, ends = os.pipe()
        parent = os.getpid()
        with stop_signals_held():  # until it is known here, so that a stop finds it
            try:
                self.pid = os.fork()
            except OSError:
                for end in (orders, self._orders, self._ends, ends):
                    os.close(end)
                raise
            if self.pid == 0:
                with contextlib.suppress(BaseException):
                    die_with_parent(parent)
                    os.setpgid(0, 0)
                    on_stop_signals(signal.SIG_DFL)
                    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the worker, which decides
                    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
                    self.close()
                    random.seed()
                    limit_memory(settings.memory_limit_mb)
                    os.nice(NICENESS)
                    os._exit(_serve(orders, ends, perform))
                os._exit(1)
        with contextlib.suppress(OSError):
            os.setpgid(self.pid, self.pid)
        os.close(orders)
        os.close(ends)

    def fileno(self) -> int:
        """Returns a file that can be read once the horse has carried out its order, or has exited."""
        return self._ends

    def has_exited(self) -> bool:
        """Whether a horse without an order has exited."""
        return bool(select.select([self], [], [], 0)[0])

    def order(self, text: str) -> None:
        """Have the horse do something; if it has exited, that shows at once."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self._orders, text.encode() + b"\n")

    def answer(self) -> bool | None:
        """Returns whether it waits for another order, once it can be read; None if it died of this one."""
        said = os.read(self._ends, 1)
        return None if not said else said == _STAYS

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
        os.close(self._orders)
        os.close(self._ends)


def _serve(orders: int, ends: int, perform: Callable[[str], bool]) -> int:
    """Carry out orders in this process, a work horse, until one says that it is enough."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    limit = _peak_memory() + _MAX_GROWTH_BYTES
    with os.fdopen(orders) as lines:
        for count, line in enumerate(lines, 1):
            stays = perform(line.rstrip("\n"))
            set_deadline(0)
            if not stays or count == _MAX_JOBS or _peak_memory() > limit:
                os.write(ends, _LEAVES)
                return 0
            os.write(ends, _STAYS)
    return 0  # the worker is gone


def set_deadline(seconds: float) -> None:
    """Have the kernel end this process after some time, in whatever C call it is then; 0 is never.

    A Python handler of signals, as RQ has one, would wait for the end of the call.
    """
    signal.setitimer(signal.ITIMER_REAL, seconds)


def _peak_memory() -> int:
    """Returns the maximum memory that this process has used, in bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _MAXRSS_UNIT


class Stable:
    """The place of the one horse of a worker.

    Args:
        settings: the limits of the horse.
        perform: what it does with each order, in its own process.
    """

    def __init__(self, settings: WorkerSettings, perform: Callable[[str], bool]) -> None:
        self._settings, self._perform = settings, perform
        self.horse: Horse | None = None

    def take(self) -> Horse:
        """Returns the horse, a new one if there is none or it has exited.

        Raises:
            OSError: there can be no more processes.
        """
        if self.horse is not None and self.horse.has_exited():
            self.end()
        if self.horse is None:
            self.horse = Horse(self._settings, self._perform)
        return self.horse

    def forget(self) -> int:
        """Wait for the exit of the horse; returns its wait status."""
        horse, self.horse = self.horse, None
        return 0 if horse is None else horse.collect()

    def end(self) -> None:
        """End the horse, if there is one."""
        if self.horse is not None:
            self.horse.kill()
            self.forget()
