"""`rpr-cusps serve`: the supervisor, Valkey, the API and the workers on one machine."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import httpx
import pytest

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request, ended
from tests.support.processes import PATIENCE, environment, is_running, started, until
from tests.support.service_server import GEOMETRY
from tests.support.stack import Stack, command, failure, running
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SLOW = "tests.support.hard_tasks.slow_once"
PARTS = {"api_process": "the API", "valkey-server": "the embedded Valkey", "worker.__main__": "a worker"}


def answers(stack: Stack, l1: str) -> bool:
    """Whether a new question is answered; waits as long as it takes."""

    def ask() -> bool:
        with contextlib.suppress(httpx.HTTPError):
            body = {"geometry": GEOMETRY, "l1": l1, "digits": 15}
            url, wait_for_it = f"{stack.base}/v1/cusp-tables", {"Prefer": "wait=30"}
            return httpx.post(url, json=body, headers=wait_for_it, timeout=PATIENCE).status_code == 200
        return False

    return until(ask)


def kill(stack: Stack, part: str, number: signal.Signals = signal.SIGKILL) -> int:
    """Send a signal to a child; returns its process id."""
    os.kill(pid := stack.part(part), number)
    return pid


def stopped(stack: Stack) -> list[str]:
    """Stop the stack in an orderly way; returns what it complained about."""
    stack.process.terminate()
    assert stack.process.wait(PATIENCE) == 0
    return stack.complaints()


def test_all_children_are_killed(tmp_path: Path) -> None:
    """Valkey, the API and the worker are killed at once. All are replaced, the port stays open meanwhile,
    and accepted jobs are done."""
    with running(tmp_path) as stack:
        with stack.redis() as redis:
            job = JobQueue(redis).submit(a_request(*map(str, range(1, 30))))
            redis.waitaof(1, 0, 5000)
        before = [kill(stack, part) for part in PARTS]
        until(lambda: not any(map(is_running, before)))
        assert httpx.get(f"{stack.base}/healthz", timeout=PATIENCE).status_code == 200
        assert answers(stack, "14.98")
        with stack.redis() as redis:
            assert ended(JobQueue(redis), job.id).status == "succeeded"
        complaints = stopped(stack)
        for name in PARTS.values():
            assert sum(line.endswith(f" {name} died (SIGKILL); starting another") for line in complaints) == 1


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
@pytest.mark.parametrize("part", PARTS)
def test_a_child_is_told_to_end(tmp_path: Path, part: str, number: signal.Signals) -> None:
    """Valkey, the API or the worker receives SIGTERM, SIGINT, SIGHUP or SIGQUIT from another process. It is
    replaced if it ends, and accepted jobs are done."""
    with running(tmp_path) as stack:
        with stack.redis() as redis:
            job = JobQueue(redis).submit(a_request(*map(str, range(1, 30))))
        pid = kill(stack, part, number)
        if (part, number) != ("valkey-server", signal.SIGHUP):  # which ignores it
            until(lambda: not is_running(pid))
        assert answers(stack, "14.98")
        with stack.redis() as redis:
            assert ended(JobQueue(redis), job.id).status == "succeeded"
        stopped(stack)


@pytest.mark.long
def test_idle_connections_use_up_all_files(tmp_path: Path) -> None:
    """More clients connect than the API may have open files, and send nothing. `serve` continues with a few
    log lines, a worker that dies is replaced, and other clients are served once those disconnect."""
    limited = ["sh", "-c", 'ulimit -n 128; exec "$@"', "sh", *command(tmp_path)]
    pipe = subprocess.PIPE
    variables = environment(access_log="off")
    with started(limited, env=variables, stdout=pipe, stderr=pipe, text=True) as process:
        stack = Stack(process, process.stdout.readline(), tmp_path)
        port = httpx.URL(stack.base).port
        with contextlib.ExitStack() as idle:
            for _ in range(160):
                idle.enter_context(socket.create_connection(("127.0.0.1", port or 0)))
            pid = kill(stack, "worker.__main__")
            until(lambda: not is_running(pid))
            time.sleep(1)
            assert process.poll() is None
        assert answers(stack, "14.98")
        assert len(stopped(stack)) < 10


@pytest.mark.long
def test_nobody_reads_what_it_says(tmp_path: Path) -> None:
    """The reader of stderr has ended, or no longer reads. `serve` continues, and replaces processes that
    die."""
    with running(tmp_path) as stack:
        assert stack.process.stderr is not None
        stack.process.stderr.close()
        for _ in range(2):
            pid = kill(stack, "worker.__main__")
            until(lambda pid=pid: not is_running(pid))
            assert answers(stack, "14.98")
        kill(stack, "api_process")
        assert answers(stack, "15")


@pytest.mark.long
def test_the_disk_is_full(small_disk: Path) -> None:
    """The disk of the data and of the log is full, and every child is killed. `serve` continues, refuses new
    questions with 503, replaces the children, and answers again once there is room."""
    data, filler = small_disk / "data", small_disk / "filler"
    variables = environment(access_log="off")
    with (
        open("/dev/full", "w") as log,  # noqa: PTH123
        started(command(data), env=variables, stdout=subprocess.PIPE, stderr=log, text=True) as process,
    ):
        stack = Stack(process, process.stdout.readline(), data)
        assert answers(stack, "14.98")
        with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))
        body = {"geometry": GEOMETRY, "l1": "3", "digits": 15}
        until(lambda: httpx.post(f"{stack.base}/v1/cusp-tables", json=body).status_code == 503)
        killed = [kill(stack, part) for part in PARTS]
        until(lambda: not any(map(is_running, killed)))
        time.sleep(2)
        assert process.poll() is None
        filler.unlink()
        assert answers(stack, "15")
        process.terminate()
        assert process.wait(PATIENCE) == 0


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 4 MiB."""
    mount = ["mount", "-t", "tmpfs", "-o", "size=4m,mode=700", "tmpfs", str(tmp_path)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("a file system can be mounted by root only")
    try:
        yield tmp_path
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


ENDS = [
    signal.SIGTERM,
    pytest.param(signal.SIGKILL, marks=pytest.mark.long),
    pytest.param(signal.SIGINT, marks=pytest.mark.long),
    pytest.param(signal.SIGHUP, marks=pytest.mark.long),
    pytest.param(signal.SIGQUIT, marks=pytest.mark.long),
]


@pytest.mark.slow
@pytest.mark.parametrize("number", ENDS, ids=str)
def test_nothing_is_left_running(tmp_path: Path, number: signal.Signals) -> None:
    """The supervisor receives SIGTERM, SIGINT, SIGHUP, SIGQUIT or SIGKILL, alone or with its process
    group. Everything ends with it, and after the next start the running job is done, without a loss
    counted unless it was killed."""
    is_kill = number == signal.SIGKILL
    with running(tmp_path, workers=2, task=SLOW) as stack, stack.redis() as redis:
        queue = JobQueue(redis, WorkerSettings(task=SLOW))
        view = queue.submit(a_request("1"))
        until(lambda: len(stack.parts()) >= 6)  # two workers, three others and a work horse
        parts = stack.parts()
        os.killpg(stack.process.pid, number)
        assert stack.process.wait(PATIENCE) == (-number if is_kill else 0)
        until(lambda: not any(map(is_running, parts)))
    with running(tmp_path) as stack, stack.redis() as redis:
        done = ended(JobQueue(redis), view.id)
        assert (done.run, done.status) == (view.run, "succeeded")


@pytest.mark.long
def test_everything_is_killed_at_once(tmp_path: Path) -> None:
    """The supervisor and all its children are killed, three times during one job. Each start continues the
    job, and it succeeds."""
    request = a_request(*map(str, range(1, 60)))
    for _ in range(3):
        with running(tmp_path, workers=2) as stack, stack.redis() as redis:
            JobQueue(redis).submit(request)
            parts = [stack.process.pid, *stack.parts()]
            redis.waitaof(1, 0, 5000)
            for pid in parts:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            until(lambda parts=parts: not any(map(is_running, parts)))
    with running(tmp_path, workers=2) as stack, stack.redis() as redis:
        assert ended(JobQueue(redis), request.job_id).status == "succeeded"


@pytest.mark.slow
def test_waiting_clients_do_not_delay_the_shutdown(tmp_path: Path) -> None:
    """`serve` is stopped while clients wait for a job or follow its events. They are answered or disconnected
    at once."""
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
            assert stopped(stack) == []
        wait([waiting], PATIENCE)


def test_a_port_that_is_taken(tmp_path: Path) -> None:
    """The port is taken. `serve` ends with one line and exit status 1, and creates nothing."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        message = failure(tmp_path, port=port)
    assert f"cannot listen on 127.0.0.1 port {port}: Address already in use" in message
    assert list(tmp_path.iterdir()) == []


def test_a_data_directory_that_is_taken(tmp_path: Path) -> None:
    """Another `serve` uses the data directory. This one ends with one line that names the other, and exit
    status 1."""
    with EmbeddedValkey(tmp_path):
        assert f"is in use by process {os.getpid()}" in failure(tmp_path)


def test_padded_documents_do_not_fill_the_store(tmp_path: Path) -> None:
    """Ten padded documents of a megabyte are sent, alone and in a batch, to a store limited to 32 MiB. The
    store never exceeds the limit, and keeps little of them; each is reported as an incomplete document.
    """
    geometry = {name: str(value) for name, value in {**GEOMETRY, "orientation": "ccw"}.items()}
    kind = "/problems/job-input-error"

    def padded(n: int) -> dict[str, object]:
        document = {"geometry": geometry, "slices": [{"error": "x"}], "padding": f"x{n:02}" * 333_000}
        return {"document": document}

    with running(tmp_path, store_max_mb=32) as stack, stack.redis() as redis:
        used: list[int] = []

        def look() -> None:
            used.append(int(redis.info("memory")["used_memory"]))

        with httpx.Client(base_url=stack.base, timeout=PATIENCE) as client:
            for n in range(2):
                answer = client.post(
                    "/v1/verifications", json=padded(n), headers={"Prefer": "wait=30"}
                ).json()
                assert answer["type"] == kind
                assert client.get(answer["job"]).json()["status"] == "failed"
                look()
            items = [{"kind": "verification", "request": padded(2 + k)} for k in range(8)]
            batch = client.post("/v1/batches", json={"items": items})
            assert batch.status_code == 202
            look()
            here = f"/v1/batches/{batch.json()['id']}"
            until(lambda: client.get(here).json()["status"] == "completed")
            look()
            assert used[-1] < 8 << 20
            lines = client.get(f"{here}/results").text.splitlines()
            assert sum(kind in line for line in lines) == len(lines) == 8
        assert max(used) <= 32 << 20
        assert not stopped(stack)
