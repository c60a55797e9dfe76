"""What the end of a work horse means for its chunk."""

from __future__ import annotations

import signal
from dataclasses import dataclass

from worker.process.os_limits import signal_name, signal_of
from worker.settings import WorkerSettings

# These end a process from outside (an operator, the kernel short of memory); the same chunk may well succeed
# at another time. Other signals come from the computation itself and would come again.
_FROM_OUTSIDE = frozenset({signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT})


@dataclass(frozen=True)
class Failed:
    """The job fails; an empty kind: there is nothing to record."""

    kind: str
    detail: str


@dataclass(frozen=True)
class RunAgain:
    """The chunk is run again. When it was lost too often already, the job fails as described."""

    lost: bool
    kind: str = ""
    detail: str = ""


Outcome = Failed | RunAgain
"""How a chunk ended that its work horse could not record itself."""


def judge_exit(status: int | None, ended_for: str | None, settings: WorkerSettings) -> Outcome | None:
    """Judge a wait status; `ended_for` is why the worker ended the horse itself, if it did.

    None: the horse came to its end by itself and has recorded everything.
    """
    if status == 0:
        return None
    if ended_for == "deadline":
        return Failed("timeout", f"The computation was stopped after the limit of {settings.deadline:g} s.")
    if ended_for == "shutdown":
        return RunAgain(lost=False)
    if ended_for is not None:
        return Failed("", "")
    number = None if status is None else signal_of(status)
    if number is None:
        return RunAgain(lost=True, kind="worker-crashed", detail="The worker crashed repeatedly.")
    how = f"The worker was ended by signal {number} ({signal_name(number)})"
    if number == signal.SIGABRT:
        limit = settings.memory_limit_mb
        of = f" of {limit} MiB" if limit else ""
        return Failed("resource-exhausted", f"{how}, most likely at the memory limit{of}.")
    if number in _FROM_OUTSIDE:
        return RunAgain(lost=True, kind="worker-crashed", detail=f"{how}, several times.")
    return Failed("worker-crashed", f"{how}.")
