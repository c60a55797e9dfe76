"""The health check of a worker's container."""

from __future__ import annotations

import subprocess
import sys

from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import completed, environment, until
from worker.jobs.installation import Roster
from worker.settings import WorkerSettings


def health(url: str) -> subprocess.CompletedProcess[str]:
    return completed([sys.executable, "-m", "worker.process.health"], environment(redis_url=url))


def test_a_worker_is_healthy_while_it_is_on_the_roster(valkey: EmbeddedValkey, redis: Redis) -> None:
    assert health(valkey.url).returncode == 1, "there is no worker"
    command = [sys.executable, "-m", "worker", "--redis-url", valkey.url]
    with subprocess.Popen(command, env=environment(log_level="WARNING")) as worker:
        try:
            until(Roster(redis, WorkerSettings()).names)
            assert health(valkey.url).returncode == 0
        finally:
            worker.terminate()
    assert health(valkey.url).returncode == 1, "it has left the roster"


def test_a_worker_is_healthy_while_redis_is_away() -> None:
    assert health("redis://127.0.0.1:1/0").returncode == 0
