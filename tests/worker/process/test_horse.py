"""The work horse: what it runs, when it stays, and what its exit means for its chunk."""

from __future__ import annotations

import os
import select
import signal
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest
from redis import Redis

from tests.support.processes import PATIENCE
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkQueue, ChunkRef
from worker.process import horse as module
from worker.process import runs as runs_module
from worker.process.horse import UNRECORDED, ExitOutcome, Horse, Task, judge_exit
from worker.process.runs import Run, Runs
from worker.settings import WorkerSettings

SETTINGS = WorkerSettings(deadline=60, niceness=0)


@pytest.fixture
def horses() -> Iterator[list[Horse]]:
    """Those that are still to be ended."""
    running: list[Horse] = []
    yield running
    for horse in running:
        horse.kill()
        horse.collect()


def forked(horses: list[Horse], settings: WorkerSettings = SETTINGS) -> Horse:
    horse = Horse(settings)
    horses.append(horse)
    return horse


def stays_after(horse: Horse, name: str) -> bool:
    """Has it run a task; returns whether it waits for another one."""
    horse.run(Task(name, f"tests.support.horse_tasks.{name}", {}))
    assert select.select([horse], [], [], PATIENCE)[0]
    return horse.has_stayed()


def status_of(horse: Horse, horses: list[Horse]) -> int:
    horses.remove(horse)
    return os.waitstatus_to_exitcode(horse.collect())


def test_it_stays_while_all_goes_well(horses: list[Horse]) -> None:
    horse = forked(horses)
    assert [stays_after(horse, "sound") for _ in range(3)] == [True] * 3


@pytest.mark.parametrize(
    ("task", "status"), [("unsound", 0), ("broken", 1), ("large", 0), ("killed", -signal.SIGKILL)]
)
def test_it_leaves_after_anything_else(horses: list[Horse], task: str, status: int) -> None:
    horse = forked(horses)
    assert stays_after(horse, "sound")
    assert not stays_after(horse, task)
    assert status_of(horse, horses) == status


def test_it_leaves_after_many_tasks(horses: list[Horse], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MAX_CHUNKS", 3)
    horse = forked(horses)
    assert [stays_after(horse, "sound") for _ in range(3)] == [True, True, False]
    assert status_of(horse, horses) == 0


def test_one_that_was_ended_between_two_tasks_is_known_to_have_exited(horses: list[Horse]) -> None:
    horse = forked(horses)
    assert stays_after(horse, "sound")
    os.kill(horse.pid, signal.SIGTERM)
    assert select.select([horse], [], [], PATIENCE)[0]
    horse.run(Task("x", "tests.support.horse_tasks.sound", {}))
    assert not horse.has_stayed()
    assert status_of(horse, horses) == -signal.SIGTERM


def test_it_ends_when_nobody_can_give_it_tasks(horses: list[Horse]) -> None:
    """As an orphan does where the kernel does not end it with its worker."""
    horse = forked(horses)
    assert stays_after(horse, "sound")
    os.close(horse._tasks)
    assert select.select([horse], [], [], PATIENCE)[0]
    horse._tasks = os.dup(horse.fileno())
    assert status_of(horse, horses) == 0


def test_a_task_ends_soon_after_the_deadline_even_without_a_worker(
    horses: list[Horse], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_WATCHDOG_MARGIN", 0.1)
    horse = forked(horses, WorkerSettings(deadline=0.1, niceness=0))
    assert stays_after(horse, "sound")
    assert not stays_after(horse, "endless")
    assert status_of(horse, horses) == -signal.SIGALRM


LIMITED = WorkerSettings(deadline=5, memory_limit_mb=100)


def test_a_normal_exit() -> None:
    assert judge_exit(0, None, LIMITED) is None
    assert judge_exit(0, "deadline", LIMITED) is None


@pytest.mark.parametrize(
    ("status", "ended_for", "kind"),
    [
        (signal.SIGKILL, "deadline", "timeout"),
        (signal.SIGKILL, "canceled", ""),
    ],
)
def test_failures(status: int, ended_for: str | None, kind: str) -> None:
    outcome = judge_exit(int(status), ended_for, LIMITED)
    assert outcome is not None
    assert outcome.then == "failed"
    assert outcome.kind == kind


def test_what_is_given_up() -> None:
    outcome = judge_exit(int(signal.SIGABRT), None, LIMITED)
    assert outcome is not None
    assert outcome.then == "given-up"
    assert outcome.kind == "resource-exhausted"
    assert "100 MiB" in outcome.detail


def test_what_is_run_again() -> None:
    for reason in ("shutdown", "silence"):
        assert judge_exit(int(signal.SIGKILL), reason, LIMITED) == ExitOutcome("again")
    for number in (signal.SIGKILL, signal.SIGSEGV):
        killed = judge_exit(int(number), None, LIMITED)
        assert killed is not None
        assert killed.then == "again"
        assert (killed.lost, killed.kind) == ("horses", "worker-crashed")
        assert number.name in killed.detail
    unrecorded = judge_exit(UNRECORDED << 8, None, LIMITED)
    assert unrecorded is not None
    assert unrecorded.then == "again"
    assert unrecorded.lost == "workers"
    exited = judge_exit(1 << 8, None, LIMITED)
    assert exited is not None
    assert exited.then == "again"
    assert exited.lost == "horses"


def test_the_time_that_other_items_took_is_not_held_against_the_one_at_hand() -> None:
    killed = int(signal.SIGKILL)
    assert judge_exit(killed, "deadline", LIMITED, has_advanced=True) == ExitOutcome("again")
    assert judge_exit(killed, "deadline", LIMITED) != ExitOutcome("again")


def test_no_alarm_is_set_by_a_heartbeat_without_a_chunk(
    redis: Redis, settings: WorkerSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last chunk may end just before the heartbeat; nobody would hear the alarm, and the worker died."""
    timers: list[float] = []
    monkeypatch.setattr(signal, "setitimer", lambda _which, seconds: timers.append(seconds))
    Runs(Attempts(redis, settings), ChunkQueue(redis, settings), settings, "w").beat()
    assert timers == []


@pytest.mark.parametrize(
    ("age", "used", "may"), [(0.05, 0.04, False), (0.3, 0.05, False), (0.3, 0.15, True), (0.6, 0.0, True)]
)
def test_a_short_chunk_on_a_busy_machine_stays_alone(
    redis: Redis,
    settings: WorkerSettings,
    monkeypatch: pytest.MonkeyPatch,
    age: float,
    used: float,
    may: bool,
) -> None:
    """Beside another it would only take longer; one that waits, for a lock, holds nobody up."""
    monkeypatch.setattr(runs_module, "processor_seconds", lambda _pid: 7 + used)
    runs = Runs(Attempts(redis, settings), ChunkQueue(redis, settings), settings, "w", is_light=True)
    horse = cast(Horse, SimpleNamespace(pid=1))
    runs.running.append(Run(ChunkRef("job", "run", 0, 0), horse, time.monotonic() - age, 0, 7.0))
    assert runs.may_begin_another == may
