"""When workers were last heard of, whatever becomes of Redis."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import until
from worker.jobs.roster import Roster
from worker.process import attendance
from worker.process.attendance import Attendance
from worker.settings import WorkerSettings


@pytest.fixture
def roster(redis: Redis) -> Roster:
    return Roster(redis, WorkerSettings())


@pytest.fixture
def heard(valkey: EmbeddedValkey, roster: Roster, monkeypatch: pytest.MonkeyPatch) -> Iterator[Attendance]:
    monkeypatch.setattr(attendance, "_PAUSE", 0.1)
    monkeypatch.setattr(attendance, "_OUTAGE", 0.5)
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
