"""`rpr-cusps store`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.cli_process import Run
from worker.connection import connect


@pytest.fixture
def data_dir(tmp_path: Path) -> Path:
    """The data of a service that is not running: a slice with a day left, and an API key."""
    with EmbeddedValkey(tmp_path) as server, connect(server.url) as redis:
        redis.set("cusps:slice:2:ab:1:90:27", "x" * 1000, ex=86400)
        redis.hset("cusps:keys", "a", "b")
    return tmp_path


def test_of_a_data_directory(run_here: Run, data_dir: Path) -> None:
    where = ("--data-dir", str(data_dir))
    table = run_here("store", "status", *where)
    assert [line.split()[:2] for line in table.stdout.splitlines() if "1" in line] == [
        ["slice", "1"],
        ["other", "1"],
        ["all", "2"],
    ]
    status = json.loads(run_here("store", "status", *where, "--format", "json").stdout)
    assert status["slice"]["keys"] == 1
    assert status["slice"]["oldest"] == pytest.approx(6 * 86400, abs=60)
    assert run_here("store", "prune", "--older-than", "7d", *where).stdout == "removed 0 keys, 0 B\n"
    assert run_here("store", "prune", "--max-bytes", "1kB", *where).stdout.startswith("removed 1 keys, 1.")


def test_of_a_running_service(run_here: Run, valkey: EmbeddedValkey) -> None:
    where = ("--data-dir", str(valkey.data_dir))
    assert run_here("store", "status", *where).returncode == 0
    assert valkey.is_alive()
    assert run_here("store", "status", "--redis-url", valkey.url).returncode == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["prune"], "--older-than: or --max-bytes is missing; give one of them, or both"),
        (["prune", "--older-than", "3 weeks"], "'3 weeks' is not an age, such as 90s, 30m, 12h or 30d"),
        (["prune", "--max-bytes", "2TB"], "'2TB' is not a size, such as 500MB, 2GiB or 1000000"),
    ],
)
def test_bad_options(run_here: Run, words: list[str], message: str) -> None:
    done = run_here("store", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr


def test_redis_is_not_there(run_here: Run) -> None:
    done = run_here("store", "status", "--redis-url", "redis://127.0.0.1:1/0")
    assert done.returncode == 3
    assert done.stderr.startswith("rpr-cusps store: cannot reach Redis: ")
