"""Child processes and the workers of a machine: started, replaced, heard of and stopped."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import is_running, until
from tests.support.sampling import long
from tests.support.template import forked
from worker.jobs.installation import Roster
from worker.jobs.plan import Keys
from worker.process import pool
from worker.process.pool import Attendance, Child, WorkerPool, end_all
from worker.process.programs import Process
from worker.settings import WorkerSettings

SLEEP = [sys.executable, "-c", "import time; time.sleep(600)"]
STUBBORN = [
    sys.executable,
    "-c",
    "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); time.sleep(600)",
]


class Launcher:
    """Starts processes, after some failures."""

    def __init__(self, *failures: Exception, command: list[str] = SLEEP) -> None:
        self.failures, self.command = list(failures), command
        self.processes: list[Process] = []

    def __call__(self) -> Process:
        if self.failures:
            raise self.failures.pop(0)
        self.processes.append(subprocess.Popen(self.command))
        return self.processes[-1]


class Judged(Child):
    """A child whose signs of life are given."""

    given: float | None = 0.0
    lost: str | None = None

    def sign(self) -> float | None:
        return self.given

    def loss(self) -> str | None:
        return self.lost

    def look_after_by(self, sign: float | None) -> None:
        self.given = sign
        self.look_after()


@contextmanager
def kept(launcher: Launcher, patience: float = 60) -> Iterator[tuple[Judged, list[str]]]:
    said: list[str] = []
    kept_child = Judged("a child", launcher, said.append, patience, 1.0)
    try:
        yield kept_child, said
    finally:
        for process in launcher.processes:
            process.kill()
            process.wait()


def test_a_start_that_fails_is_told_once_and_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "_LONGEST_DELAY", 0.2)
    launcher = Launcher(OSError(24, "Too many open files"), OSError(24, "Too many open files"), MemoryError())
    with kept(launcher) as (it, said):
        it.start()
        assert it.process is None
        until(lambda: it.look_after_by(0.0) or it.process)
        text = "cannot start a child: [Errno 24] Too many open files; trying again"
        assert said == [text, "cannot start a child: out of memory; trying again"]


def test_one_that_dies_again_and_again_is_started_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "_LONGEST_DELAY", 0.2)
    launcher = Launcher(command=["false"])
    with kept(launcher) as (it, said):
        it.start()
        start = time.monotonic()
        until(lambda: it.look_after_by(0.0) or len(said) == 4)
        assert said == ["a child died (exit status 1); starting another"] * 4
        assert time.monotonic() - start >= 0.4  # the second and the third were started after a pause


def test_one_without_signs_of_life_is_killed() -> None:
    launcher = Launcher()
    with kept(launcher, patience=0.5) as (it, said):
        it.start()
        sign = time.monotonic()
        until(lambda: it.look_after_by(sign) or len(launcher.processes) == 2)
        assert time.monotonic() - sign >= 0.5
        assert launcher.processes[0].returncode == -signal.SIGKILL
        assert said == ["a child gives no sign of life for 1 s; starting another"]


def test_one_that_nobody_can_judge_lives() -> None:
    launcher = Launcher()
    with kept(launcher, patience=0.1) as (it, said):
        it.start()
        time.sleep(0.2)
        it.look_after_by(None)
        it.look_after_by(0.0)  # it has not yet given a sign, and may still be starting
        assert said == []


def test_whoever_did_not_look_does_not_judge(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "_BLINK", 0.1)
    launcher = Launcher()
    with kept(launcher, patience=0.2) as (it, said):
        it.start()
        sign = time.monotonic()
        time.sleep(0.5)
        it.look_after_by(sign)
        assert said == []


def test_one_that_lost_what_it_needs_is_killed_at_once() -> None:
    launcher = Launcher()
    with kept(launcher) as (it, said):
        it.start()
        it.lost = "lost its socket"
        it.look_after_by(0.0)  # it never had one
        assert said == []
        until(lambda: it.look_after_by(time.monotonic()) or len(launcher.processes) == 2)
        assert said == ["a child lost its socket; starting another"]


def a_stubborn_one() -> Process:
    process = subprocess.Popen(STUBBORN, stdout=subprocess.PIPE)
    assert process.stdout is not None
    with process.stdout as ready:
        ready.readline()
    return process


def test_all_end_together_each_in_its_time() -> None:
    obedient, stopped, stubborn = subprocess.Popen(SLEEP), subprocess.Popen(SLEEP), a_stubborn_one()
    os.kill(stopped.pid, signal.SIGSTOP)
    end_all([(obedient, 60), (stopped, 60), (stubborn, 0.3)])
    codes = [process.returncode for process in (obedient, stopped, stubborn)]
    assert codes == [-signal.SIGTERM, -signal.SIGTERM, -signal.SIGKILL]
    assert not is_running(stubborn.pid)


def test_in_a_hurry_nobody_has_much_time() -> None:
    stubborn = a_stubborn_one()
    end_all([(stubborn, 600)], is_hurried=lambda: True)
    assert stubborn.returncode == -signal.SIGKILL


def test_a_dead_worker_is_reported_and_replaced(
    valkey: EmbeddedValkey, redis: Redis, capfd: pytest.CaptureFixture[str]
) -> None:
    said: list[str] = []
    pool = WorkerPool(1, valkey.url, say=said.append)
    pool.start()
    try:
        until(pool.is_ready)
        [first] = redis.smembers("rq:workers")
        os.kill(int(redis.hget(first, "pid") or 0), signal.SIGKILL)
        until(lambda: pool.members[0].look_after() or said)
        assert said == ["a worker died (SIGKILL); starting another"]
        until(lambda: pool.is_ready() and redis.smembers("rq:workers") != {first})
    finally:
        pool.stop()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("count", "light"), [long(1, 0), (2, 1)])
def test_one_of_several_workers_is_kept_for_short_work(
    valkey: EmbeddedValkey, redis: Redis, count: int, light: int
) -> None:
    pool = WorkerPool(count, valkey.url, start=forked)
    pool.start()
    try:
        until(pool.is_ready)
        workers = Keys(WorkerSettings().key_prefix).workers
        assert (redis.zcard(workers), redis.zcard(f"{workers}:light")) == (count, light)
    finally:
        pool.stop()


@pytest.fixture
def roster(redis: Redis) -> Roster:
    return Roster(redis, WorkerSettings())


@pytest.fixture
def heard(valkey: EmbeddedValkey, roster: Roster, monkeypatch: pytest.MonkeyPatch) -> Iterator[Attendance]:
    monkeypatch.setattr(pool, "_PAUSE", 0.1)
    monkeypatch.setattr(pool, "_OUTAGE", 0.5)
    roster.beat("a")
    reader = Attendance(valkey.url)
    reader.start()
    until(lambda: reader.heard({"a"}))
    yield reader
    reader.stop()


def test_the_last_beat_counts(heard: Attendance, roster: Roster) -> None:
    first = heard.sign("a")
    assert first is not None
    assert 0 <= time.monotonic() - first < 60
    assert not heard.heard({"a", "b"})
    assert heard.sign("b") == 0.0
    time.sleep(0.3)
    assert heard.sign("a") == pytest.approx(first, abs=0.2), "without a beat, time passes"
    roster.beat("a")
    until(lambda: (heard.sign("a") or 0) > first + 0.2)


def test_nobody_is_judged_while_no_beat_is_possible(heard: Attendance, redis: Redis) -> None:
    """Redis answers, but takes no data: so it takes no beats either."""
    redis.config_set("maxmemory", 1)
    try:
        until(lambda: heard.sign("a") is None)
    finally:
        redis.config_set("maxmemory", 0)
    until(lambda: (heard.sign("a") or 0) > time.monotonic())  # they have time to come back
