from __future__ import annotations

import os
import signal

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import until
from worker.process.pool import WorkerPool


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
