"""What the system limits and tells: memory, cores, wait statuses, and the health of a container's worker."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, completed, environment, started, until
from worker.jobs.queue import JobQueue
from worker.process.processes import STOP_SIGNALS, on_stop_signals, usable_memory


@pytest.mark.parametrize("is_ignored", [True, False])
def test_a_hangup_that_is_ignored_stays_so(is_ignored: bool) -> None:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    try:
        signal.signal(signal.SIGHUP, signal.SIG_IGN if is_ignored else signal.SIG_DFL)

        def handler(*_: object) -> None: ...

        assert (signal.SIGHUP in on_stop_signals(handler)) != is_ignored
        assert signal.getsignal(signal.SIGQUIT) == handler
        assert (signal.getsignal(signal.SIGHUP) == handler) != is_ignored
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def test_as_many_files_as_the_system_allows() -> None:
    program = (
        "import resource as r; from worker.process import raise_file_limit as f; "
        "r.setrlimit(r.RLIMIT_NOFILE, (64, 200)); f(); f(); print(r.getrlimit(r.RLIMIT_NOFILE))"
    )
    assert completed([sys.executable, "-c", program], environment(), in_full=True).stdout == "(200, 200)\n"


@pytest.mark.parametrize(
    ("groups", "files", "megabytes"),
    [
        ("0::/a/b", {"a/b/memory.max": "max", "a/memory.max": 300 << 20, "memory.max": 500 << 20}, 300),
        ("7:cpu:/\n4:memory:/a", {"memory/a/memory.limit_in_bytes": 100 << 20}, 100),
        ("0::/", {"memory.max": "max"}, None),
        ("4:memory:/a", {"memory/a/memory.limit_in_bytes": 1 << 62}, None),
    ],
)
def test_usable_memory(tmp_path: Path, groups: str, files: dict[str, object], megabytes: int | None) -> None:
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    assert usable_memory(tmp_path) == machine, "no control groups"
    for name, text in {
        "proc/self/cgroup": groups,
        **{f"sys/fs/cgroup/{k}": v for k, v in files.items()},
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(f"{text}\n")
    assert usable_memory(tmp_path) == (machine if megabytes is None else megabytes << 20)


def health(url: str) -> subprocess.CompletedProcess[str]:
    return completed([sys.executable, "-m", "worker.process.presence"], environment(redis_url=url))


def test_a_worker_is_healthy_while_it_is_registered(valkey: EmbeddedValkey, redis: Redis) -> None:
    assert health(valkey.url).returncode == 1, "there is no worker"
    command = [sys.executable, "-m", "worker", "--redis-url", valkey.url]
    with started(command, env=environment(log_level="WARNING")) as worker:
        until(JobQueue(redis).workers)
        assert health(valkey.url).returncode == 0
        worker.terminate()
        worker.wait(PATIENCE)
    assert health(valkey.url).returncode == 1, "it has gone"


def test_a_worker_is_healthy_while_redis_is_away() -> None:
    assert health("redis://127.0.0.1:1/0").returncode == 0
