"""The consequence of a work horse's exit for its chunk."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass

from worker.jobs.attempts import Lost
from worker.process.os_limits import signal_name, signal_of
from worker.settings import WorkerSettings


@dataclass(frozen=True)
class Failed:
    """The job fails; with an empty kind there is nothing to record."""

    kind: str
    detail: str


@dataclass(frozen=True)
class GivenUp:
    """The slice at which it was, or else the job, fails as described."""

    kind: str
    detail: str


@dataclass(frozen=True)
class RunAgain:
    """The chunk is run again. If it was lost too often, its slice or its job fails as described."""

    lost: Lost = ""
    kind: str = ""
    detail: str = ""


Outcome = Failed | GivenUp | RunAgain
"""The outcome of a chunk whose work horse could not record it."""

UNRECORDED = 75
"""The exit status of a work horse that could not record its outcome, because Redis did not take it."""

UNANSWERED = RunAgain("horses", "worker-crashed", "The worker repeatedly ended without an answer.")
"""The outcome of a work horse that ended normally, but left its chunk open."""


def judge_exit(
    status: int | None, ended_for: str | None, settings: WorkerSettings, *, has_advanced: bool = False
) -> Outcome | None:
    """Returns the outcome for a wait status, or None if the horse ended normally and has recorded everything.

    `ended_for` is the worker's reason for ending the horse, if it did. `has_advanced`: items of a batch were
    done in this attempt, so that the one at hand has not had the whole time for itself.
    """
    if status == 0:
        return None
    if ended_for == "deadline" and has_advanced:
        return RunAgain()
    if ended_for == "deadline":
        return Failed("timeout", f"The computation was stopped at the time limit of {settings.deadline:g} s.")
    if ended_for in ("shutdown", "silence"):
        return RunAgain()
    if ended_for is not None:
        return Failed("", "")
    if status is not None and os.waitstatus_to_exitcode(status) == UNRECORDED:
        return RunAgain("workers", "worker-lost", "The answer could not be kept repeatedly.")
    number = None if status is None else signal_of(status)
    if number is None:
        return RunAgain("horses", "worker-crashed", "The worker crashed repeatedly.")
    how = f"The worker was terminated by signal {number} ({signal_name(number)})"
    if number == signal.SIGABRT:
        limit = settings.memory_limit_mb
        of = f" of {limit} MiB" if limit else ""
        return GivenUp("resource-exhausted", f"{how}, most likely at the memory limit{of}.")
    return RunAgain("horses", "worker-crashed", f"{how}, repeatedly.")
