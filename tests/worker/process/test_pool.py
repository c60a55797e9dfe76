from __future__ import annotations

import os
import signal

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import until
from worker.jobs.keys import Keys
from worker.process.pool import WorkerPool
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
