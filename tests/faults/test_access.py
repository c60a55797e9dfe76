"""Access by unauthorized clients."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from tests.support.processes import PATIENCE, completed, environment, started


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


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a service without workers and keys."""
    with running(tmp_path_factory.mktemp("local")) as (base, _):
        yield base


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


def test_a_page_of_another_site_cannot_use_a_local_service(local: str) -> None:
    """The page of another site makes its own name resolve to 127.0.0.1 (DNS rebinding). Its requests are
    refused, 421.
    """
    for name in ("evil.example", "evil.example:8000", "127.0.0.1.evil.example"):
        answer = httpx.get(f"{local}/v1/limits", headers={"Host": name})
        assert (answer.status_code, answer.json()["type"]) == (421, "/problems/unknown-host")
    assert httpx.get(f"{local}/v1/limits").status_code == 200
