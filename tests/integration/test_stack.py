"""`serve`: the whole stack, started and stopped as by a user."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
from redis import Redis

from service.stack.data_dir import runtime_dir
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request, ended
from tests.support.processes import (
    PATIENCE,
    completed,
    descendants,
    environment,
    is_running,
    started,
    until,
)
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SLOW = "tests.support.hard_tasks.slow_once"
SERVE = """
import sys
from pathlib import Path
from service.stack.serve import ServeSettings, serve
_, port, workers, data, url = sys.argv
settings = ServeSettings(port=int(port), workers=int(workers), data_dir=Path(data), redis_url=url or None)
sys.exit(serve(settings))
"""


@dataclass
class Stack:
    """A running stack."""

    process: subprocess.Popen[str]
    announcement: str
    data: Path

    @property
    def base(self) -> str:
        address = re.search(r"http://\S+", self.announcement)
        assert address is not None
        return address.group()

    def redis(self) -> Redis:
        return connect(f"unix://{runtime_dir(self.data)}/valkey.sock")

    def parts(self) -> list[int]:
        processes = descendants(self.process.pid)
        assert processes
        return processes

    def workers(self) -> list[int]:
        with self.redis() as redis:
            keys = [f"rq:worker:{name.decode()}" for name in redis.smembers("rq:workers")]
            return [
                int(pid)
                for key in keys
                if (pid := redis.hget(key.replace("rq:worker:rq:worker:", "rq:worker:"), "pid"))
            ]


def command(data: Path, *, port: int = 0, workers: int = 1, url: str = "") -> list[str]:
    return [sys.executable, "-c", SERVE, str(port), str(workers), str(data), url]


@contextmanager
def running(data: Path, *, workers: int = 1, url: str = "", **settings: object) -> Iterator[Stack]:
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    variables = environment(**{"access_log": "off", **settings})
    with started(command(data, workers=workers, url=url), env=variables, **options) as process:
        try:
            yield Stack(process, process.stdout.readline(), data)
        finally:
            process.terminate()
            process.wait(PATIENCE)


def test_from_nothing_to_an_answer_and_back(tmp_path: Path) -> None:
    with running(tmp_path, workers=2) as stack:
        assert re.fullmatch(
            r"rpr-cusps is ready at http://127\.0\.0\.1:\d+ "
            rf"\(2 workers, data in {re.escape(str(tmp_path))}\); Ctrl-C stops it\n",
            stack.announcement,
        )
        parts = stack.parts()
        assert len(parts) == 4  # Valkey, the API and two workers
        assert httpx.get(f"{stack.base}/healthz").status_code == 200
        body = {"geometry": dict(a_request("1").geometry), "l1": "14.98", "digits": 30}
        answer = httpx.post(
            f"{stack.base}/v1/cusp-tables", json=body, headers={"Prefer": "wait=30"}, timeout=PATIENCE
        )
        assert answer.status_code == 200, answer.text
        assert answer.json()["slices"][0]["count"] == 6
        stack.process.send_signal(signal.SIGINT)
        assert stack.process.wait(PATIENCE) == 0
        assert [pid for pid in parts if is_running(pid)] == []
        assert stack.process.stderr is not None
        assert stack.process.stderr.read() == ""
    assert not (tmp_path / "valkey.sock").exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGKILL])
def test_nothing_is_left_running(tmp_path: Path, number: signal.Signals) -> None:
    is_kill = number == signal.SIGKILL
    losses = 1 if is_kill else 0
    with (
        running(tmp_path, workers=2, task=SLOW, max_losses=losses) as stack,
        stack.redis() as redis,
    ):
        queue = JobQueue(redis, WorkerSettings(task=SLOW))
        view = queue.submit(a_request("1"))
        until(lambda: len(stack.parts()) == 5)  # with the work horse
        parts = stack.parts()
        stack.process.send_signal(number)
        assert stack.process.wait(PATIENCE) == (-number if is_kill else 0)
        until(lambda: not any(is_running(pid) for pid in parts))
    # and nothing is lost either
    with running(tmp_path, max_losses=losses) as stack, stack.redis() as redis:
        done = ended(JobQueue(redis), view.id)
        assert (done.run, done.status) == (view.run, "succeeded")


@pytest.mark.slow
def test_queued_jobs_are_resumed(tmp_path: Path) -> None:
    requests = [a_request(str(i)) for i in range(1, 4)]
    with running(tmp_path, workers=0) as stack, stack.redis() as redis:
        for request in requests:
            JobQueue(redis).submit(request)
        stack.process.terminate()
        assert stack.process.wait(PATIENCE) == 0
    with running(tmp_path, workers=2) as stack, stack.redis() as redis:
        for request in requests:
            done = ended(JobQueue(redis), request.job_id)
            assert done.status == "succeeded"


@pytest.mark.slow
def test_a_second_signal_hurries(tmp_path: Path) -> None:
    settings = {"task": "tests.support.hard_tasks.endless", "shutdown_grace": 60}
    with running(tmp_path, **settings) as stack, stack.redis() as redis:
        JobQueue(redis, WorkerSettings(task="tests.support.hard_tasks.endless")).submit(a_request("1"))
        until(lambda: len(stack.parts()) == 4)
        parts = stack.parts()
        until(lambda: stack.process.poll() is not None or stack.process.terminate())
        assert stack.process.returncode == 0
        assert not any(is_running(pid) for pid in parts)


@pytest.mark.slow
def test_a_dead_worker_is_replaced(tmp_path: Path) -> None:
    with running(tmp_path) as stack, stack.redis() as redis:
        (worker,) = stack.workers()
        os.kill(worker, signal.SIGKILL)
        done = JobQueue(redis).submit(a_request("1"))
        result = ended(JobQueue(redis), done.id)
        assert result.status == "succeeded"
        assert not is_running(worker)
        stack.process.terminate()
        stack.process.wait(PATIENCE)
        assert stack.process.stderr is not None
        told = stack.process.stderr.read()
        assert re.fullmatch(
            r"\S+Z rpr_cusps\.serve WARNING a worker died \(SIGKILL\); starting another\n", told
        )


@pytest.mark.slow
def test_a_dead_server_is_replaced(tmp_path: Path) -> None:
    with running(tmp_path) as stack, stack.redis() as redis:
        request = a_request("1")
        ended(JobQueue(redis), JobQueue(redis).submit(request).id)
        redis.waitaof(1, 0, 5000)
        server = int(redis.info("server")["process_id"])
        os.kill(server, signal.SIGKILL)
        until(lambda: not is_running(server))
        until(lambda: (runtime_dir(tmp_path) / "valkey.sock").exists())
        until(lambda: httpx.get(f"{stack.base}/readyz").status_code == 200)
        done = ended(JobQueue(redis), JobQueue(redis).submit(a_request("1", "2")).id)
        assert done.status == "succeeded"


@pytest.mark.slow
def test_with_a_given_server(tmp_path: Path, valkey: EmbeddedValkey, redis: Redis) -> None:
    data = tmp_path / "unused"
    with running(data, url=valkey.url) as stack:
        assert "data in the given Redis" in stack.announcement
        done = ended(JobQueue(redis), JobQueue(redis).submit(a_request("1")).id)
        assert done.status == "succeeded"
        stack.process.terminate()
        assert stack.process.wait(PATIENCE) == 0
    assert valkey.is_alive()
    assert not data.exists()


@pytest.mark.slow
def test_waiting_clients_do_not_delay_the_shutdown(tmp_path: Path) -> None:
    with running(tmp_path, workers=0) as stack, ThreadPoolExecutor(2) as pool:
        with stack.redis() as redis:
            view = JobQueue(redis).submit(a_request("1"))
        body = {"geometry": dict(a_request("1").geometry), "l1": "1", "digits": 30}
        waiting = pool.submit(
            httpx.post,
            f"{stack.base}/v1/cusp-tables",
            json=body,
            headers={"Prefer": "wait=30"},
            timeout=PATIENCE,
        )
        with httpx.stream("GET", f"{stack.base}/v1/jobs/{view.id}/events", timeout=PATIENCE) as events:
            assert next(events.iter_lines())
            stack.process.terminate()
            assert stack.process.wait(PATIENCE) == 0
        wait([waiting], PATIENCE)  # answered or cut off, but not left waiting
        assert stack.process.stderr is not None
        assert stack.process.stderr.read() == ""


def failure(data: Path, settings: dict[str, object] | None = None, status: int = 1, **options: object) -> str:
    done = completed(command(data, **options), environment(**(settings or {})))  # type: ignore[arg-type]
    assert done.returncode == status
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_a_port_that_is_taken(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert f"cannot listen on 127.0.0.1 port {port}: Address already in use" in failure(
            tmp_path, port=port
        )
    assert not (tmp_path / "appendonlydir").exists()


def test_a_data_directory_that_is_taken(tmp_path: Path) -> None:
    with EmbeddedValkey(tmp_path):
        assert f"is in use by process {os.getpid()}" in failure(tmp_path)


def test_a_server_that_does_not_answer(tmp_path: Path) -> None:
    assert "cannot reach Redis" in failure(tmp_path, url=f"unix://{tmp_path}/nothing.sock")
    assert "cannot reach Redis" in failure(tmp_path, url="nonsense://", status=2)


def test_an_invalid_setting(tmp_path: Path) -> None:
    for name, value in {"deadline": -1, "poll_seconds": "soon", "hang_seconds": 0}.items():
        message = failure(tmp_path, {name: value}, status=2)
        assert message.startswith(f"rpr-cusps serve: RPR_CUSPS_{name.upper()}: ")
