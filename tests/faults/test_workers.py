"""Workers, when Redis fails or signals come."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_heavy_document, a_request, depth, ended
from tests.support.processes import (
    PATIENCE,
    Workers,
    descendants,
    environment,
    is_running,
    started,
    stopped,
    until,
)
from tests.support.sampling import long
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

ODD = "tests.support.odd_worker"


@pytest.fixture
def own_valkey(tmp_path: Path) -> Iterator[EmbeddedValkey]:
    """A server that the test may kill."""
    with EmbeddedValkey(tmp_path / "data") as server:
        yield server


@pytest.fixture
def own_workers(own_valkey: EmbeddedValkey, tmp_path: Path) -> Iterator[Workers]:
    pool = Workers(own_valkey.url, tmp_path / "own.log")
    yield pool
    pool.stop()


def succeeds(redis: Redis, l1: str = "1") -> bool:
    """Whether a job can be done now."""
    queue = JobQueue(redis)
    return ended(queue, queue.submit(a_request(l1)).id).status == "succeeded"


def test_redis_is_killed_and_comes_back(own_valkey: EmbeddedValkey, own_workers: Workers) -> None:
    """Redis is killed and started again. The worker waits for it and continues."""
    worker = own_workers.start()
    os.kill(own_valkey.pid, signal.SIGKILL)
    until(lambda: "cannot work (ConnectionError" in own_workers.log.read_text())
    until(lambda: not own_valkey.is_alive())
    own_valkey.launch()
    with connect(own_valkey.url) as redis:
        until(lambda: JobQueue(redis).workers() == 1)
        assert succeeds(redis)
    until(lambda: "working again after" in own_workers.log.read_text())
    assert worker.poll() is None


def test_redis_answers_too_late(redis: Redis, workers: Workers) -> None:
    """Redis answers later than the worker waits. The worker retries and continues."""
    worker = workers.start_odd(ODD, "0.7")  # less than it waits for a chunk
    until(lambda: "cannot work (TimeoutError" in workers.log.read_text())
    assert succeeds(redis)
    assert worker.poll() is None
    assert "Traceback" not in workers.log.read_text()


@pytest.mark.parametrize("seconds", [7, long(20)])
def test_redis_hangs_while_a_chunk_runs(
    own_valkey: EmbeddedValkey, own_workers: Workers, seconds: float
) -> None:
    """Redis hangs while a worker computes, longer than a heartbeat lasts. The work horse goes on, and its
    answer is kept as soon as Redis is back.
    """
    worker = own_workers.start(task="tests.support.hard_tasks.gated")
    with connect(own_valkey.url) as redis:
        queue = JobQueue(redis, WorkerSettings(task="tests.support.hard_tasks.gated"))
        view = queue.submit(a_heavy_document())
        until(lambda: redis.llen("begun") == 1)
        (horse,) = descendants(worker.pid)
        with stopped(own_valkey.pid):
            time.sleep(seconds)
            assert is_running(horse)
        redis.set("gate", 1)
        assert ended(queue, view.id).status == "succeeded"
        assert redis.llen("begun") == 1
    assert worker.poll() is None


def test_redis_is_gone_when_the_worker_is_stopped(own_valkey: EmbeddedValkey, own_workers: Workers) -> None:
    """A worker is stopped while Redis is down. It ends at once, with exit status 0."""
    worker = own_workers.start()
    own_valkey.stop()
    until(lambda: "cannot work" in own_workers.log.read_text())
    worker.terminate()
    assert worker.wait(PATIENCE) == 0
    assert "Traceback" not in own_workers.log.read_text()


def test_redis_takes_no_more_data(redis: Redis, workers: Workers) -> None:
    """Redis is out of memory and refuses writes. The worker waits until it accepts them again."""
    worker = workers.start()
    redis.config_set("maxmemory", 1)
    try:
        until(lambda: "cannot work (OutOfMemoryError" in workers.log.read_text())
    finally:
        redis.config_set("maxmemory", 0)
    assert succeeds(redis)
    assert worker.poll() is None


def test_redis_is_emptied(redis: Redis, workers: Workers) -> None:
    """Redis is emptied (FLUSHALL). The workers are registered again within seconds, and new jobs succeed."""
    workers.start()
    redis.flushall()
    until(lambda: JobQueue(redis).workers() == 1)
    until(lambda: redis.scard("rq:workers") == 1)
    assert succeeds(redis)


@pytest.mark.long
def test_a_dead_worker_is_not_counted_for_long(redis: Redis, workers: Workers) -> None:
    """A worker is killed while it is idle. `/readyz` stops counting it within seconds."""
    first = workers.start()
    workers.start()
    assert JobQueue(redis).workers() == 2
    first.kill()
    until(lambda: JobQueue(redis).workers() == 1)
    workers.stop()
    assert JobQueue(redis).workers() == 0


@pytest.mark.long
def test_a_worker_that_hangs_is_counted_again_when_it_goes_on(redis: Redis, workers: Workers) -> None:
    """An idle worker is stopped by SIGSTOP and continued. It is not counted meanwhile, and is counted
    afterwards.
    """
    worker = workers.start()
    worker.send_signal(signal.SIGSTOP)
    until(lambda: JobQueue(redis).workers() == 0)
    worker.send_signal(signal.SIGCONT)
    until(lambda: JobQueue(redis).workers() == 1)


@pytest.mark.parametrize("number", [signal.SIGHUP, long(signal.SIGQUIT)])
def test_a_closed_terminal_is_a_stop(redis: Redis, workers: Workers, number: signal.Signals) -> None:
    """A worker receives SIGHUP or SIGQUIT. It stops as it does on SIGTERM."""
    worker = workers.start(task="tests.support.hard_tasks.slow_once")
    queue = JobQueue(redis, WorkerSettings(task="tests.support.hard_tasks.slow_once"))
    view = queue.submit(a_request("1"))
    until(lambda: (now := queue.get(view.id)) is not None and now.status == "running")
    worker.send_signal(number)
    assert worker.wait(PATIENCE) == 0
    assert depth(queue) == 1
    workers.start()
    assert ended(queue, view.id).status == "succeeded"  # with a loss it would have failed


def test_a_worker_by_itself_tells_what_it_does(valkey: EmbeddedValkey, redis: Redis) -> None:
    """Nothing fails, and a worker runs in a terminal. It logs one line at its start and one for each
    chunk."""
    command = [sys.executable, "-m", "service", "worker", "--redis-url", valkey.url]
    with started(command, env=environment(), stderr=subprocess.PIPE, text=True) as worker:
        assert worker.stderr is not None
        assert re.search(rf" INFO worker \S+ ready on {valkey.url}\?db=0$", worker.stderr.readline().strip())
        view = JobQueue(redis).submit(a_request("1", "2"))
        told = worker.stderr.readline().strip()
        assert re.search(rf" INFO chunk 0 \(2 slices\): done after \d+\.\d\d s job={view.id}$", told)
        worker.terminate()
        assert worker.wait(PATIENCE) == 0
        assert worker.stderr.read() == ""
