"""Access by unauthorized clients."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from service.stack.embedded_valkey import runtime_dir
from tests.support.processes import PATIENCE, Workers, completed, environment, started, until
from tests.support.service_server import GEOMETRY
from worker.connection import connect


def command(data: Path, *arguments: str) -> list[str]:
    options = ("--port", "0", "--workers", "0", "--data-dir", str(data))
    return [sys.executable, "-m", "service", "serve", *options, *arguments]


@contextmanager
def running(data: Path, *arguments: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A service without workers, with its base address."""
    pipe = subprocess.PIPE
    with started(
        command(data, *arguments), env=environment(), stdout=pipe, stderr=pipe, text=True
    ) as process:
        assert process.stdout is not None
        port = re.search(r":(\d+) ", process.stdout.readline())
        assert port is not None
        yield f"http://127.0.0.1:{port[1]}", process
        process.terminate()
        process.wait(PATIENCE)


@dataclass(frozen=True)
class Local:
    """A service without workers and keys, on an address of this computer."""

    base: str
    redis_url: str
    process: subprocess.Popen[str]


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Local]:
    data = tmp_path_factory.mktemp("local")
    with running(data) as (base, process):
        yield Local(base, f"unix://{runtime_dir(data)}/valkey.sock", process)


def test_other_computers_are_kept_out_without_keys(tmp_path: Path) -> None:
    """`serve` is to listen on an address that other computers reach, and there is no key. It refuses to
    start, and says how to create a key.
    """
    refused = completed(command(tmp_path, "--host", "0.0.0.0"), environment())
    assert (refused.returncode, refused.stdout, refused.stderr.count("\n")) == (1, "", 1)
    assert f"`rpr-cusps keys create NAME --data-dir {tmp_path}`" in refused.stderr
    assert "--insecure" in refused.stderr


def test_with_a_key_other_computers_may_come(tmp_path: Path) -> None:
    """`serve` listens on such an address, and there is a key. Only clients with a key have access."""
    keys = [sys.executable, "-m", "service", "keys", "create", "rig", "--data-dir", str(tmp_path)]
    key = completed(keys, environment()).stdout.strip()
    with running(tmp_path, "--host", "0.0.0.0") as (base, _):
        assert httpx.get(f"{base}/v1/limits").status_code == 401
        assert httpx.get(f"{base}/v1/limits", headers={"Authorization": f"Bearer {key}"}).status_code == 200


def test_without_keys_only_by_the_operators_word(tmp_path: Path) -> None:
    """`serve --insecure` listens on such an address. Everyone has access, and `serve` warns of it."""
    with running(tmp_path, "--host", "0.0.0.0", "--insecure") as (base, process):
        assert httpx.get(f"{base}/v1/limits").status_code == 200
        assert process.stderr is not None
        assert "no keys are required: anyone who reaches 0.0.0.0 port" in process.stderr.readline()


def test_a_name_to_listen_on(tmp_path: Path) -> None:
    """`serve --host NAME` listens on a name. Requests to that name are answered; requests to another name are
    421."""
    with running(tmp_path, "--host", "127.1") as (base, _):
        port = base.rpartition(":")[2]
        for host, status in ((f"127.1:{port}", 200), (f"127.2:{port}", 421)):
            assert httpx.get(f"{base}/v1/version", headers={"Host": host}).status_code == status


def test_a_client_cannot_end_the_job_of_another(local: Local, tmp_path: Path) -> None:
    """One client cancels a job that another one waits for. The job continues, and the other client gets its
    answer."""
    question = {"geometry": GEOMETRY, "l1": 14.98, "digits": 15}
    with httpx.Client(base_url=local.base, timeout=PATIENCE) as client:
        headers = {"Prefer": "respond-async"}
        first = client.post("/v1/cusp-tables", json=question, headers=headers).json()
        with ThreadPoolExecutor(1) as pool:
            waiting = pool.submit(
                client.post, "/v1/cusp-tables", json=question, headers={"Prefer": "wait=30"}
            )
            with connect(local.redis_url) as redis:
                until(lambda: any(entry["cmd"] == "xread" for entry in redis.client_list()))
                for _ in range(3):
                    assert client.delete(first["links"]["self"]).json()["status"] == "queued"
                workers = Workers(local.redis_url, tmp_path / "log")
                workers.start()
                assert waiting.result().json()["slices"][0]["count"] == 6
                workers.stop()
        assert local.process.poll() is None


def test_a_page_of_another_site_cannot_use_a_local_service(local: Local) -> None:
    """The page of another site makes its own name resolve to 127.0.0.1 (DNS rebinding). Its requests are
    refused, 421.
    """
    for name in ("evil.example", "evil.example:8000", "127.0.0.1.evil.example"):
        answer = httpx.get(f"{local.base}/v1/limits", headers={"Host": name})
        assert (answer.status_code, answer.json()["type"]) == (421, "/problems/unknown-host")
    assert httpx.get(f"{local.base}/v1/limits").status_code == 200
