"""The first start, when Redis is not running yet or cannot be used."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey, runtime_dir
from tests.support.jobs import a_request, ended
from tests.support.processes import PATIENCE, completed, environment, started, until
from tests.support.sampling import long
from tests.support.stack import command
from worker.connection import connect
from worker.jobs.queue import JobQueue


@pytest.fixture
def port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@contextmanager
def waiting(words: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A process without its Redis, once it says so."""
    with (
        log.open("wb") as stderr,
        started(words, env=environment(access_log="off"), stderr=stderr) as process,
    ):
        until(lambda: "waiting for it" in log.read_text())
        yield process


def a_worker(url: str) -> list[str]:
    return [sys.executable, "-m", "worker", "--redis-url", url]


def test_redis_comes_after_the_api_and_the_workers(tmp_path: Path, port: int) -> None:
    """The API and workers are started before Redis. They wait for it, each with one line; meanwhile the
    service reports that it is not ready. Once Redis runs, they work.
    """
    data = tmp_path / "data"
    url, logs = f"unix://{runtime_dir(data)}/valkey.sock", [tmp_path / "serve.log", tmp_path / "worker.log"]
    with (
        waiting(command(tmp_path, port=port, url=url), logs[0]) as serve,
        waiting(a_worker(url), logs[1]) as worker,
        httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as api,
    ):
        assert api.get("/healthz").status_code == 200
        assert api.get("/readyz").status_code == 503
        with EmbeddedValkey(data) as valkey, connect(valkey.url) as redis:
            queue = JobQueue(redis)
            until(lambda: queue.workers() == 2)
            assert api.get("/readyz").status_code == 200
            assert ended(queue, queue.submit(a_request("1")).id).status == "succeeded"
            for process in (serve, worker):
                process.terminate()
            assert [process.wait(PATIENCE) for process in (serve, worker)] == [0, 0]
    for log in logs:
        assert log.read_text().count(" WARNING cannot reach Redis: ") == 1


@pytest.mark.parametrize("number", [signal.SIGTERM, long(signal.SIGINT), long(signal.SIGHUP)])
def test_a_signal_while_redis_is_waited_for(tmp_path: Path, number: signal.Signals) -> None:
    """The API or a worker that waits for Redis receives SIGTERM, SIGINT or SIGHUP. It ends at once, with exit
    status 0.
    """
    url = f"unix://{tmp_path}/nothing.sock"
    for words in (a_worker(url), command(tmp_path, url=url)):
        with waiting(words, tmp_path / "log") as process:
            process.send_signal(number)
            assert process.wait(PATIENCE) == 0
        assert (tmp_path / "log").read_text().count("\n") == 1


def test_what_waiting_does_not_mend(tmp_path: Path, redis: Redis, valkey: EmbeddedValkey) -> None:
    """The URL of Redis, or its password, is wrong. The API and a worker end with one line that says so."""
    redis.execute_command("ACL", "SETUSER", "known", "on", ">right", "+@all", "~*")
    asked = valkey.url.replace("unix://", "unix://known:wrong@")
    for url, reason in (("nonsense://", "Redis URL must specify"), (asked, "invalid username-password")):
        for words in (a_worker(url), command(tmp_path, url=url)):
            done = completed(words, environment(redis_url=url))
            assert done.returncode in (1, 2)
            assert "cannot reach Redis: " in done.stderr
            assert reason in done.stderr
            assert done.stderr.count("\n") == 1
