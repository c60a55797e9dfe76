"""The workers of a machine: started together, replaced, heard of and stopped."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import until
from worker.jobs.installation import Roster
from worker.jobs.keys import Keys
from worker.process import pool
from worker.process.pool import Attendance, WorkerPool
from worker.settings import WorkerSettings


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
        until(lambda: pool.look_after() or said)
        assert said == ["a worker died (SIGKILL); starting another"]
        until(lambda: pool.is_ready() and redis.smembers("rq:workers") != {first})
    finally:
        pool.stop()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("count", "light"), [(1, 0), (2, 1)])
def test_one_of_several_workers_is_kept_for_short_work(
    valkey: EmbeddedValkey, redis: Redis, count: int, light: int
) -> None:
    pool = WorkerPool(count, valkey.url)
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
