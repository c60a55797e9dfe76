"""The chunks that the work horses of a worker run, each from its start to its outcome.

A worker runs one chunk at a time. With light duty, it runs the next small chunk in parallel to one that takes
longer than most, and gives back a chunk that overruns its estimate.
"""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Collection
from dataclasses import dataclass, field
from math import inf

from redis.exceptions import RedisError

from worker.answers.kinds import is_batch, kind_of_job
from worker.jobs import Lane
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkQueue, ChunkRef, Estimate
from worker.jobs.upkeep import Interruptions
from worker.logs import about
from worker.process.horse import (
    UNANSWERED,
    BeatAlarm,
    ExitOutcome,
    Horse,
    IdleHorse,
    Task,
    judge_exit,
)
from worker.process.processes import processor_seconds
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

SHORT_SECONDS = 0.1
"""Processor time, in seconds, after which a chunk no longer delays the next small one; most take less."""

MAX_RUNNING = 9
"""The maximum number of chunks that run at once on a worker with light duty."""

_WAITING_FACTOR = 5  # a chunk that lasts this many times the floor has overrun, even if it only waits
_CROWDED_FACTOR, _CROWDED_FLOOR = 2.0, 0.5  # in place of the settings while MAX_RUNNING chunks run


@dataclass
class Run:
    """A chunk that a work horse runs.

    Attributes:
        start: the time of its start (`time.monotonic()`).
        items_done: the number of items of a batch that were done before.
        horse_seconds: the processor time that its horse had used before, if the system reports it.
        estimate: its estimate, once it is read.
        has_low_priority: whether chunks that began later go before it.
        has_overrun: whether its overrun has been recorded.
        ended_for: the reason for which the worker ended its horse, if it did.
        next_attempt: the attempt and the lane in which it continues, if it was given back.
    """

    ref: ChunkRef
    horse: Horse
    start: float
    items_done: int
    horse_seconds: float | None
    estimate: Estimate | None = None
    has_low_priority: bool = False
    has_overrun: bool = False
    ended_for: str | None = None
    next_attempt: tuple[ChunkRef, Lane] | None = None

    @property
    def is_share(self) -> bool:
        """Whether it is a share of a computation, which may last for minutes."""
        kind = kind_of_job(self.ref.job_id)
        return kind is not None and kind.shares > 1

    @property
    def age(self) -> float:
        """The time since its start, in seconds."""
        return time.monotonic() - self.start

    @property
    def took(self) -> float:
        """The processor time that it has used; its age where the system does not report this."""
        now = processor_seconds(self.horse.pid)
        return self.age if now is None or self.horse_seconds is None else now - self.horse_seconds

    @property
    def ratio(self) -> float:
        """How many times its estimate it has taken."""
        return self.took / self.estimate.seconds if self.estimate else 0.0

    def has_taken(self, factor: float, floor: float) -> bool:
        """Whether it has taken `factor` times its estimate, and `floor` seconds."""
        if self.estimate is None:
            return False
        bound = max(factor * self.estimate.seconds, floor)
        return self.took > bound or self.age > max(bound, _WAITING_FACTOR * floor)

    def end(self, reason: str) -> None:
        """Kill the horse; the first reason counts."""
        self.ended_for = self.ended_for or reason
        self.horse.kill()

    def read_estimate(self, attempts: Attempts) -> None:
        """Read its estimate, unless that is done or Redis cannot be reached."""
        if self.estimate is None:
            with contextlib.suppress(RedisError):
                self.estimate = attempts.estimate(self.ref) or Estimate(inf)

    def log_subject(self) -> contextlib.AbstractContextManager[None]:
        """Returns a context in which log lines name its job and request."""
        request_id = "" if self.estimate is None else self.estimate.request_id
        return about(job=self.ref.job_id, request_id=request_id)

    def warn(self, what: str) -> None:
        """Log a warning with its running time and its estimate."""
        kind, estimate = kind_of_job(self.ref.job_id), self.estimate
        name = "unknown" if kind is None else kind.name
        estimated = f"{estimate.seconds:.2f} s" if estimate and estimate.seconds < inf else "unknown"
        with self.log_subject():
            log.warning(
                "chunk %d (%s): %s; it has run for %.1f s, the estimate was %s",
                *(self.ref.index, name, what, self.age, estimated),
            )


@dataclass
class Runs:
    """The chunks that a worker runs.

    Attributes:
        worker: its name.
        is_light: whether it has light duty: short chunks only.
    """

    attempts: Attempts
    chunks: ChunkQueue
    settings: WorkerSettings
    worker: str
    is_light: bool = False
    running: list[Run] = field(default_factory=list)

    def __post_init__(self) -> None:
        settings = self.settings
        self._idle = IdleHorse(settings)
        self._interruptions = Interruptions(self.attempts.redis, settings)
        # sooner than another worker may take a chunk over
        self._alarm = BeatAlarm(settings.beat_ttl + settings.lost_grace / 2, lambda: self.end("silence"))

    @property
    def may_begin_another(self) -> bool:
        """Whether another small chunk may be run in parallel, since none of those that run is short.

        On a busy machine a short one takes long, and would only take longer beside another.
        """
        # several in a row promise nothing good
        patience = SHORT_SECONDS if len(self.running) == 1 else SHORT_SECONDS / 2
        last = self.running[-1]
        is_long = last.age >= patience and (last.took >= patience or last.age >= _WAITING_FACTOR * patience)
        return self.is_light and not self.is_full and is_long

    @property
    def is_full(self) -> bool:
        """Whether the maximum number of chunks run."""
        return len(self.running) >= MAX_RUNNING

    def begin(self, ref: ChunkRef, function: str) -> None:
        """Have a work horse run a chunk; those that run already get a lower priority."""
        before = self.attempts.items_done(ref)
        horse = self._idle.take([run.horse for run in self.running])
        for run in self.running:
            run.horse.lower_priority()
            run.has_low_priority = True
        if not self.running:
            self._alarm.set()
        self.running.append(Run(ref, horse, time.monotonic(), before, processor_seconds(horse.pid)))
        horse.run(Task(ref.rq_id, function, vars(ref)))

    def next_look(self, next_beat: float) -> float:
        """Returns the time at which to attend to the chunks again at the latest."""
        if self.is_light:  # to look for small ones
            return min(next_beat, time.monotonic() + SHORT_SECONDS / 4)
        ends = (run.start + self.settings.deadline for run in self.running if run.ended_for is None)
        return min([next_beat, *ends])

    def attend(self, ready: Collection[int], stopped: Collection[str]) -> None:
        """Record the outcomes of the chunks whose horses can be read, and end others whose time is over.

        `stopped`: the RQ ids of chunks that are to be stopped by a command.
        """
        settings = self.settings
        for run in [*self.running]:
            if run.horse.fileno() in ready:
                self._close(run)
            elif run.ended_for is not None:
                continue
            elif run.ref.rq_id in stopped:
                run.end("canceled")
            elif run.age >= settings.deadline:
                run.end("deadline")
            elif not run.has_overrun and run.has_taken(settings.overrun_factor, settings.overrun_floor):
                self._note_overrun(run)
            elif run.age >= SHORT_SECONDS and self.is_light:
                run.read_estimate(self.attempts)

    def beat(self) -> None:
        """Send the heartbeats of all chunks, and end those whose attempt is over.

        Raises:
            RedisError: Redis cannot be reached.
        """
        for run in [*self.running]:
            if not self.attempts.beat(run.ref, self.worker):
                run.end("canceled")
            elif run.ended_for is not None:
                run.horse.kill()
            elif run.has_overrun and self.is_light:  # until now no worker took heavy chunks
                self._note_overrun(run)
            else:
                run.read_estimate(self.attempts)
        if self.running:  # or else the alarm has no handler, and ends this process
            self._alarm.reset()

    def relieve(self) -> None:
        """Give back the chunk that exceeds its estimate most, since small ones wait and no more may run."""
        over = [run for run in self.running if run.has_taken(_CROWDED_FACTOR, _CROWDED_FLOOR)]
        if over and not any(run.ended_for for run in self.running):
            self._note_overrun(max(over, key=lambda run: run.ratio))

    def end(self, reason: str) -> None:
        """End all work horses that run a chunk, for a reason."""
        for run in self.running:
            run.end(reason)

    def abandon(self) -> None:
        """End all work horses without recording anything; the sweeper finds their chunks."""
        for run in self.running:
            run.horse.end()
        if self.running:
            self.running.clear()
            self._alarm.clear()
        self._idle.end()

    def _note_overrun(self, run: Run) -> None:
        is_new, run.has_overrun = not run.has_overrun, True
        try:
            following = self.attempts.note_overrun(run.ref, is_new=is_new, gives_back=self.is_light)
        except RedisError as error:
            log.warning("the overrun of %s could not be recorded: %s", run.ref.rq_id, error)
            run.has_overrun = not is_new
            return
        if following is not None:
            run.next_attempt = following
            run.end("overrun")
        if is_new or following:
            where = f"; given back to the lane {following[1]}" if following else ""
            run.read_estimate(self.attempts)
            run.warn(f"overran{where}")

    # -- the end of a chunk ------------------------------------------------------------------------

    def _close(self, run: Run) -> None:
        """Record the outcome of a chunk whose horse has finished it, or has exited."""
        self.running.remove(run)
        if not self.running:
            self._alarm.clear()
        ended_for = run.ended_for
        status = 0
        if ended_for is not None:
            status = run.horse.end()
        elif not run.horse.has_stayed():
            status = run.horse.collect()
        elif run.has_low_priority:
            run.horse.end()
        else:
            self._idle.keep(run.horse)
        has_advanced = ended_for == "deadline" and self._has_advanced(run)
        outcome = judge_exit(status, ended_for, self.settings, has_advanced=has_advanced)
        if outcome is not None:  # else the horse has logged it
            how = f"stopped ({ended_for})" if ended_for else "lost its work horse"
            run.read_estimate(self.attempts)
            with run.log_subject():
                log.info("chunk %d: %s after %.2f s", run.ref.index, how, run.age)
        self._settle(run, outcome)

    def _has_advanced(self, run: Run) -> bool:
        with contextlib.suppress(RedisError):
            return self.attempts.items_done(run.ref) > run.items_done
        return False

    def _settle(self, run: Run, outcome: ExitOutcome | None) -> None:
        """Record the outcome of a chunk that no work horse runs any more."""
        ref = run.ref
        try:
            if self.attempts.end_beat(ref) and outcome is None:
                outcome = UNANSWERED
            if run.next_attempt is not None:
                self.chunks.put_back(*run.next_attempt, is_first=False)
            elif outcome is not None:
                self._record(run, outcome)
        except RedisError as error:
            log.warning("the outcome of %s could not be recorded: %s", ref.rq_id, error)

    def _record(self, run: Run, outcome: ExitOutcome) -> None:
        if outcome.then == "again":
            self._interruptions.run_again(run.ref, outcome.lost, outcome.kind, outcome.detail)
            return
        if outcome.kind == "timeout":
            run.read_estimate(self.attempts)
            run.warn("timeout")
        if outcome.then == "given-up" or (outcome.kind and is_batch(run.ref.job_id)):
            self._interruptions.give_up(run.ref, outcome.kind, outcome.detail)
        elif outcome.kind:
            self._interruptions.fail(run.ref, outcome.kind, outcome.detail)
